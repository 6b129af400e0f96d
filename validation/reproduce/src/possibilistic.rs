//! Possibilistic localization, stage by stage.

use super::Section;
use super::ground::{self, SWEEPS, layer};
use vibrissa::Result;
use vibrissa::config::PossibilisticOptions;
use vibrissa::figure::{Geometry, Layer, MapPlate, Outline, map_plate};
use vibrissa::flow::trajectory::pose_at;
use vibrissa::localizer::{Estimator, PossibilisticEstimator};
use vibrissa::plane::{Pose2, Vec2, wrap_angle};
use vibrissa::sets::StateBox;
use vibrissa::sim::SweepNoise;

/// Travel between two measurements (m).
const BETWEEN: f64 = 10e-3;
/// Readings above this are contact (N m).
const TOUCHING: f64 = 1e-3;
/// Halving is worth more when there are three measurements only.
const WORK: usize = 4_000_000;
const MOST_CELLS: usize = 250_000;
/// At most this many boxes are drawn.
const DRAWN: usize = 4000;

/// What is left after a measurement.
struct Stage {
    boxes: Vec<StateBox>,
    truth: Option<Pose2>,
    area: f64,
    volume: f64,
}

pub(super) fn section() -> Result<Section> {
    let mut section = Section::new("possibilistic", "Possibilistic localization in two stages");
    let (map, robot) = (ground::arena()?, ground::robot(1.0));
    let sweep = ground::arena_sweep(&map, SWEEPS[0].way, &SweepNoise::seeded(1))?;
    let log = ground::spaced(&sweep.log, TOUCHING, BETWEEN);
    let options = PossibilisticOptions { work: WORK, most_cells: MOST_CELLS, ..PossibilisticOptions::default() };
    let mut localizer = PossibilisticEstimator::new(&map, &robot, &log.channels, options)?;
    let mut stages = Vec::new();
    for row in log.rows.iter().take(LAST) {
        localizer.step(row)?;
        let (area, volume) = localizer.set().size();
        stages.push(Stage { boxes: localizer.set().boxes(), truth: pose_at(&sweep.truth, row.t), area, volume });
    }
    let outlines = ground::outlines(&map);
    let picture = |title: &str, index: usize| stages.get(index).map(|stage| stage.plate(title, &outlines));
    section.show(
        "stages",
        [
            "Figure “possibilisticLocalization”: (a) the preimage of the second measurement, (b) the subsets that the third \
             leaves. Readings are within 5 %.",
            "Boxes that hold every state which explains the measurements so far, 10 mm apart, with the same 5 % and 20 µN m, and what is \
             left after eight.",
            "The paper draws regions of the plane by sampling. Ours are boxes in place and heading that keep the true state as \
             long as the bounds hold; after few measurements they are coarse and reach beyond the walls.",
        ],
        [
            ("(a) After the second measurement", 1),
            ("(b) After the third measurement", 2),
            ("(c) After the eighth measurement", LAST - 1),
        ]
            .into_iter()
            .filter_map(|(title, index)| picture(title, index))
            .collect(),
    );
    for (name, index) in [("second", 1), ("third", 2), ("eighth", LAST - 1)] {
        let stage = stages.get(index);
        section.tell(&format!("{name}.area"), stage.map_or(f64::NAN, |s| 1e4 * s.area), 1, "cm²");
        section.tell(&format!("{name}.boxes"), stage.map_or(f64::NAN, |s| s.boxes.len() as f64), 0, "");
    }
    let size = map.bounds().size();
    section.tell("arena", 1e4 * size.x * size.y, 0, "cm²");
    section.say(
        "Two measurements leave {possibilistic.second.area} cm² of places, three {possibilistic.third.area} cm², eight \
         {possibilistic.eighth.area} cm²; the arena has {possibilistic.arena} cm². After few measurements the boxes are coarse: \
         they reach beyond the walls, and states of different headings lie over each other.",
    );
    let held = stages.iter().filter(|stage| stage.holds_truth()).count();
    section.find(
        "Measurements, of eight, after which the true state is in the set",
        "held",
        "implied by its bound",
        (held as f64, 0, ""),
        "A guarantee, as long as the declared bounds hold.",
    );
    let share = match (stages.get(1), stages.get(2)) {
        (Some(before), Some(after)) => after.volume / before.volume,
        _ => f64::NAN,
    };
    section.find(
        "Volume of the set after the third measurement over that after the second",
        "share",
        "“refined subsets”",
        (share, 3, ""),
        "The set can only shrink. Its area in the plane may grow meanwhile: states of different headings go apart as the robot moves.",
    );
    Ok(section)
}

/// How many measurements are taken.
const LAST: usize = 8;

impl Stage {
    fn holds_truth(&self) -> bool {
        let Some(truth) = self.truth else { return false };
        self.boxes.iter().any(|b| {
            let middle = 0.5 * (b.theta.lo() + b.theta.hi());
            let turn = wrap_angle(truth.theta - middle).abs();
            b.x.contains(truth.x) && b.y.contains(truth.y) && turn <= 0.5 * b.theta.width() + 1e-12
        })
    }

    fn plate(&self, title: &str, map: &[Outline]) -> String {
        let ring = |b: &StateBox| {
            let (x, y) = (b.x, b.y);
            vec![
                Vec2::new(x.lo(), y.lo()),
                Vec2::new(x.hi(), y.lo()),
                Vec2::new(x.hi(), y.hi()),
                Vec2::new(x.lo(), y.hi()),
            ]
        };
        let rings: Vec<Vec<Vec2>> = self.boxes.iter().map(ring).collect();
        let thin: Vec<&Vec<Vec2>> = ground::thinned(&rings.iter().collect::<Vec<_>>(), DRAWN);
        let boxes = thin.into_iter().cloned().collect();
        let mut layers: Vec<Layer> =
            vec![Layer { framed: false, ..layer(Geometry::Rings(boxes), "slice", "every possible state") }];
        layers
            .extend(self.truth.map(|pose| layer(Geometry::Circles(vec![pose.position()]), "truth-mark", "true state")));
        map_plate(&MapPlate { title, map, layers: &layers, window: None, frame: "map frame" })
    }
}
