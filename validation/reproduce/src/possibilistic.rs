//! Possibilistic localization, stage by stage.

use super::Section;
use super::ground::{self, SWEEPS, layer};
use vibrissa::Result;
use vibrissa::config::PossibilisticOptions;
use vibrissa::figure::{Geometry, Layer, MapPlate, Outline, map_plate};
use vibrissa::flow::trajectory::pose_at;
use vibrissa::localizer::{Estimator, PossibilisticEstimator};
use vibrissa::plane::{Pose2, Vec2, wrap_angle};
use vibrissa::sets::{Interval, StateBox};
use vibrissa::sim::SweepNoise;
use vibrissa::world::Map;

/// Travel between two measurements (m).
const BETWEEN: f64 = 10e-3;
/// Readings above this are contact (N m).
const TOUCHING: f64 = 1e-3;
/// Halving is worth more when there are three measurements only.
const WORK: usize = 4_000_000;
const MOST_CELLS: usize = 250_000;
/// Beyond every place and heading (m, rad).
const EVERYWHERE: f64 = 1e3;
/// Side of the cells in which places are counted and drawn (m).
const CELL: f64 = 1e-3;

/// What is left after a measurement.
/// The area of a map's free space (m²), cell by cell.
pub(super) fn free_area(map: &Map) -> f64 {
    let all = Interval::new(-EVERYWHERE, EVERYWHERE);
    Places::new(map, &[StateBox { x: all, y: all, theta: all }]).area()
}

struct Stage {
    boxes: Vec<StateBox>,
    truth: Option<Pose2>,
    places: Places,
    volume: f64,
}

/// The places of a set of boxes that lie in free space: the whisker's base, which is the robot's origin, cannot be elsewhere.
struct Places {
    min: Vec2,
    columns: usize,
    /// Row by row.
    cells: Vec<bool>,
}

impl Places {
    fn new(map: &Map, boxes: &[StateBox]) -> Self {
        let bounds = map.bounds();
        let size = bounds.size();
        let count = |length: f64| (length / CELL).ceil().max(1.0) as usize;
        let (columns, rows) = (count(size.x), count(size.y));
        let mut cells = vec![false; columns * rows];
        // Cells whose middles lie in a box.
        let range = |lo: f64, hi: f64, most: usize| {
            let first = (lo / CELL - 0.5).ceil().max(0.0) as usize;
            first..((hi / CELL + 0.5).floor().max(0.0) as usize).min(most)
        };
        for b in boxes {
            for row in range(b.y.lo() - bounds.min.y, b.y.hi() - bounds.min.y, rows) {
                for column in range(b.x.lo() - bounds.min.x, b.x.hi() - bounds.min.x, columns) {
                    cells[row * columns + column] = true;
                }
            }
        }
        let mut places = Self { min: bounds.min, columns, cells };
        for index in 0..places.cells.len() {
            places.cells[index] &= map.is_free(places.middle(index));
        }
        places
    }

    fn middle(&self, index: usize) -> Vec2 {
        let (row, column) = (index / self.columns, index % self.columns);
        self.min + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * CELL
    }

    fn area(&self) -> f64 {
        CELL * CELL * self.cells.iter().filter(|cell| **cell).count() as f64
    }

    /// Neighbouring cells of a row as one rectangle.
    fn rings(&self) -> Vec<Vec<Vec2>> {
        let mut rings = Vec::new();
        for (row, cells) in self.cells.chunks(self.columns).enumerate() {
            let mut column = 0;
            while column < cells.len() {
                let run = cells[column..].iter().take_while(|cell| **cell).count();
                if run > 0 {
                    let corner = self.min + Vec2::new(column as f64, row as f64) * CELL;
                    let (x, y) = (Vec2::new(run as f64 * CELL, 0.0), Vec2::new(0.0, CELL));
                    rings.push(vec![corner, corner + x, corner + x + y, corner + y]);
                }
                column += run + 1;
            }
        }
        rings
    }
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
        let ((_, volume), boxes) = (localizer.set().size(), localizer.set().boxes());
        let places = Places::new(&map, &boxes);
        stages.push(Stage { boxes, truth: pose_at(&sweep.truth, row.t), places, volume });
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
             long as the bounds hold; of their places those in free space are drawn.",
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
        section.tell(&format!("{name}.area"), stage.map_or(f64::NAN, |s| 1e4 * s.places.area()), 1, "cm²");
        section.tell(&format!("{name}.boxes"), stage.map_or(f64::NAN, |s| s.boxes.len() as f64), 0, "");
    }
    section.tell("arena", 1e4 * free_area(&map), 1, "cm²");
    section.say(
        "Of {possibilistic.arena} cm² of free space two measurements leave {possibilistic.second.area} cm², three \
         {possibilistic.third.area} cm², eight {possibilistic.eighth.area} cm². A place counts that has at least one heading left.",
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
        let mut layers: Vec<Layer> = vec![Layer {
            framed: false,
            ..layer(Geometry::Rings(self.places.rings()), "slice", "places of every possible state")
        }];
        layers
            .extend(self.truth.map(|pose| layer(Geometry::Circles(vec![pose.position()]), "truth-mark", "true state")));
        map_plate(&MapPlate { title, map, layers: &layers, window: None, frame: "map frame" })
    }
}
