//! The motion on the map, from each place that is left.

use vibrissa::figure::{Geometry, Layer, Outline, map_figure};
use vibrissa::flow::pose::{Hypothesis, ShapeRecord};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::plan::{Plan, remaining};
use vibrissa::world::{MountedWhisker, Robot};

/// Poses of a place that the motion is drawn from.
const DRAWN: usize = 40;
/// Words of a caption's line.
const CHARACTERS: usize = 104;

/// A layer that the picture is made large enough for.
pub(in crate::commands) fn named(geometry: Geometry, class: &'static str, label: impl Into<String>) -> Layer {
    Layer { geometry, class, label: label.into(), framed: true }
}

/// The robot's whiskers, robot frame: those that touch now as they are bent by these shapes, the others straight.
fn whiskers(robot: &Robot, shapes: &[ShapeRecord]) -> Vec<Vec<Vec2>> {
    let straight = |whisker: &MountedWhisker| {
        let base = whisker.robot_from_whisker;
        vec![base.position(), base.transform_point(Vec2::new(whisker.beam.length, 0.0))]
    };
    let bent = |index: usize| shapes.iter().find(|shape| shape.whisker == index).map(|shape| shape.points.clone());
    robot.whiskers.iter().enumerate().map(|(index, own)| bent(index).unwrap_or_else(|| straight(own))).collect()
}

/// The figure as SVG text; `shapes` are of the whiskers that touch now, which all places bend about alike, as they read the same.
pub(super) fn plan_figure(
    map: &[Outline],
    (robot, shapes): (&Robot, &[ShapeRecord]),
    hypotheses: &[Hypothesis],
    plan: &Plan,
) -> String {
    let states = remaining(hypotheses, DRAWN);
    let whiskers = whiskers(robot, shapes);
    let ridges = hypotheses.iter().filter(|h| h.ridge.len() > 1);
    let ridges: Vec<Vec<Vec2>> = ridges.map(|h| h.ridge.iter().map(|p| p.position()).collect()).collect();
    let mut layers = vec![named(Geometry::Lines(ridges), "ridge", "where along a place the robot may be")];
    let begins: Vec<Pose2> = states.iter().map(|s| s.pose).collect();
    let way = plan.next.as_ref().map(|next| next.motion.waypoints());
    let places: Vec<Pose2> = hypotheses.iter().map(|h| h.pose).collect();
    let ways: Vec<Vec<Vec2>> = way.map_or_else(Vec::new, |way| {
        places.iter().map(|begin| way.iter().map(|p| begin.compose(*p).position()).collect()).collect()
    });
    let ends: Vec<Pose2> =
        way.map_or_else(Vec::new, |way| places.iter().filter_map(|begin| Some(begin.compose(*way.last()?))).collect());
    let placed = |pose: &Pose2| -> Vec<Vec<Vec2>> {
        whiskers.iter().map(|line| line.iter().map(|&point| pose.transform_point(point)).collect()).collect()
    };
    let drawn = if shapes.is_empty() { "the whiskers there, straight" } else { "the whiskers there" };
    layers.extend([
        named(Geometry::Lines(places.iter().flat_map(placed).collect()), "whisker", drawn),
        named(Geometry::Lines(ways), "motion", "the next motion, from each place"),
        named(Geometry::States(ends), "motion-end", "where it ends"),
    ]);
    let states = named(Geometry::States(begins), "survivor", "states that are left");
    if let [place] = places[..] {
        // Its marker is the larger one.
        layers.extend([named(Geometry::Arrow(place), "estimate", "estimate and heading"), states]);
    } else {
        layers.extend([states, named(Geometry::Places(places), "badge", "a place that explains the log")]);
    }
    let captions = vibrissa::figure::wrapped(&plan.words(), CHARACTERS);
    map_figure("The next motion", &captions, "map frame", map, &layers)
}
