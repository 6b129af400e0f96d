//! The motion on the map, from each place that is left.

use vibrissa::figure::{Geometry, Layer, Outline, OutlineRole, scene_figure};
use vibrissa::flow::pose::Hypothesis;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::plan::{Plan, remaining};
use vibrissa::world::Robot;

/// Poses of a place that the motion is drawn from.
const DRAWN: usize = 40;
/// Words of a caption's line.
const CHARACTERS: usize = 104;

/// A layer that the picture is made large enough for.
pub(in crate::commands) fn named(geometry: Geometry, class: &'static str, label: impl Into<String>) -> Layer {
    Layer { geometry, class, label: label.into(), framed: true }
}

/// The map as lines.
pub(in crate::commands) fn map_lines(map: &[Outline]) -> Vec<Layer> {
    let lines = |role: OutlineRole| -> Vec<Vec<Vec2>> {
        let closed = |o: &Outline| o.points.iter().chain(o.points.first().filter(|_| o.closed)).copied().collect();
        map.iter().filter(|o| o.role == role).map(closed).collect()
    };
    vec![
        named(Geometry::Rings(lines(OutlineRole::Arena)), "arena", "free space"),
        named(Geometry::Rings(lines(OutlineRole::Obstacle)), "obstacle", "obstacle"),
        named(Geometry::Lines(lines(OutlineRole::Wall)), "wall", "wall"),
    ]
}

/// The figure as SVG text.
pub(super) fn plan_figure(map: &[Outline], robot: &Robot, hypotheses: &[Hypothesis], plan: &Plan) -> String {
    let states = remaining(hypotheses, DRAWN);
    let whisker = |pose: &Pose2| -> Vec<Vec<Vec2>> {
        let line = |w: &vibrissa::world::MountedWhisker| {
            let base = pose.compose(w.robot_from_whisker);
            vec![base.position(), base.transform_point(Vec2::new(w.beam.length, 0.0))]
        };
        robot.whiskers.iter().map(line).collect()
    };
    let ridges = hypotheses.iter().filter(|h| h.ridge.len() > 1);
    let ridges: Vec<Vec<Vec2>> = ridges.map(|h| h.ridge.iter().map(|p| p.position()).collect()).collect();
    let mut layers = map_lines(map);
    layers.push(named(Geometry::Lines(ridges), "ridge", "where readings leave a place open"));
    let begins: Vec<Pose2> = states.iter().map(|s| s.pose).collect();
    let way = plan.next.as_ref().map(|next| next.motion.waypoints());
    let places: Vec<Pose2> = hypotheses.iter().map(|h| h.pose).collect();
    let ways: Vec<Vec<Vec2>> = way.map_or_else(Vec::new, |way| {
        places.iter().map(|begin| way.iter().map(|p| begin.compose(*p).position()).collect()).collect()
    });
    let ends: Vec<Pose2> =
        way.map_or_else(Vec::new, |way| places.iter().filter_map(|begin| Some(begin.compose(*way.last()?))).collect());
    let whiskers = places.iter().flat_map(whisker).collect();
    layers.extend([
        named(Geometry::Lines(whiskers), "whisker", "the whiskers there, straight"),
        named(Geometry::States(begins), "candidate", "states that are left"),
        named(Geometry::Lines(ways), "path", "the motion, from each place"),
        named(Geometry::States(ends), "survivor", "where it ends"),
    ]);
    layers.extend(places.first().map(|pose| named(Geometry::Arrow(*pose), "estimate", "the likeliest place")));
    let captions = vibrissa::figure::wrapped(&plan.words(), CHARACTERS);
    scene_figure("The next motion", &captions, "map frame", &layers)
}
