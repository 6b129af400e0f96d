//! Maps, robots and sweeps after the paper's description.

use vibrissa::Result;
use vibrissa::figure::{Geometry, Layer, Outline};
use vibrissa::flow::pose::StampedPose;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sim::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::world::{Map, MountedWhisker, Robot};

/// An arena (SVG, mm) whose upper wall has straight, concave, convex and symmetric sections.
pub const ARENA_SVG: &str = include_str!("../data/paper_arena.svg");
/// A rounded obstacle (SVG, mm), no two stretches of its outline alike.
pub const OBSTACLE_SVG: &str = include_str!("../data/obstacle.svg");

/// How far a drawn boundary may be from the map's (m).
const DRAWING_TOLERANCE: f64 = 2e-4;
/// How the stage turns the whisker against its own axes (deg): trailing, aslant to the wall.
const MOUNT: f64 = 128.0;
/// Speed of the stage (m/s) and rows a second of the sensor (Hz): half a millimetre a row, the paper's sensor rate.
pub(super) const PACE: Pace = Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 };

/// One sweep of the localization table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepPlan {
    /// The paper's number of the sweep.
    pub id: usize,
    /// Where it goes.
    pub what: &'static str,
    /// Places of the stage, map frame (mm); its heading stays.
    pub way: &'static [[f64; 2]],
}

/// Five sweeps along the arena's upper wall from five known starts, as the paper's table has them; which walls the
/// paper's sweeps ran along is not told.
pub const SWEEPS: [SweepPlan; 5] = [
    SweepPlan {
        id: 1,
        what: "through the concave bay",
        way: &[[160.0, 172.0], [200.0, 192.0], [260.0, 192.0], [308.0, 214.0], [355.0, 194.0], [400.0, 190.0]],
    },
    SweepPlan {
        id: 2,
        what: "over the convex bump",
        way: &[[340.0, 172.0], [375.0, 188.0], [420.0, 184.0], [457.0, 168.0], [500.0, 184.0], [545.0, 192.0]],
    },
    SweepPlan {
        id: 3,
        what: "through the first of two equal bays",
        way: &[[500.0, 172.0], [530.0, 192.0], [548.0, 192.0], [588.0, 203.0], [635.0, 192.0]],
    },
    SweepPlan {
        id: 4,
        what: "through the second of two equal bays",
        way: &[[620.0, 172.0], [650.0, 192.0], [668.0, 192.0], [708.0, 203.0], [755.0, 192.0]],
    },
    SweepPlan {
        id: 5,
        what: "along the straight wall to the bay's edge",
        way: &[[130.0, 172.0], [165.0, 192.0], [240.0, 192.0], [275.0, 203.0]],
    },
];

pub(super) fn arena() -> Result<Map> {
    vibrissa::io::map::from_svg(ARENA_SVG, "the built-in arena")
}

pub(super) fn obstacle() -> Result<Map> {
    vibrissa::io::map::from_svg(OBSTACLE_SVG, "the built-in obstacle")
}

/// The paper's whisker on its stage, trailing to the left of its way (`side` 1) or to the right (`side` -1).
pub(super) fn robot(side: f64) -> Robot {
    let robot_from_whisker = Pose2::new(0.0, 0.0, side * MOUNT.to_radians());
    Robot { whiskers: vec![MountedWhisker { robot_from_whisker, ..MountedWhisker::default() }], ..Robot::default() }
}

/// The stage's true way through places (mm).
pub(super) fn path(way: &[[f64; 2]]) -> Result<Vec<StampedPose>> {
    let waypoints: Vec<Pose2> = way.iter().map(|[x, y]| Pose2::new(1e-3 * x, 1e-3 * y, 0.0)).collect();
    path_through(&waypoints, &PACE)
}

/// A sweep along the arena's upper wall.
pub(super) fn arena_sweep(map: &Map, way: &[[f64; 2]], noise: &SweepNoise) -> Result<Sweep> {
    simulate_tip_sweep(map, &robot(1.0), &path(way)?, noise)
}

/// A map's boundaries as lines to draw.
pub(super) fn outlines(map: &Map) -> Vec<Outline> {
    vibrissa::tasks::outlines(map, DRAWING_TOLERANCE)
}

/// A layer in the frame of the picture.
pub(super) fn layer(geometry: Geometry, class: &'static str, label: &str) -> Layer {
    Layer { geometry, class, label: label.to_owned(), framed: true }
}

/// At most so many of them, evenly picked.
pub(super) fn thinned<T: Copy>(all: &[T], most: usize) -> Vec<T> {
    all.iter().step_by(all.len().div_ceil(most.max(1)).max(1)).copied().collect()
}

/// The way as points (m).
pub(super) fn positions(path: &[StampedPose]) -> Vec<Vec2> {
    path.iter().map(|row| row.map_from_robot.position()).collect()
}

/// The rows of a log from the first touch on, one each time the base has gone this far (m).
pub(super) fn spaced(log: &SensorLog, touching: f64, spacing: f64) -> SensorLog {
    let mut rows = Vec::new();
    let mut last: Option<Vec2> = None;
    for row in &log.rows {
        let here = row.odom_from_robot.position();
        let touches = row.readings.first().is_some_and(|moment| moment.abs() > touching);
        if touches && last.is_none_or(|last| here.distance(last) >= spacing) {
            rows.push(row.clone());
            last = Some(here);
        }
    }
    SensorLog { rows, ..log.clone() }
}

/// Indices of the rows at which the base has gone another `step` (m), from the first of `from` on.
pub(super) fn rows_by_step(path: &[StampedPose], from: impl Iterator<Item = usize>, step: f64) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    for row in from {
        let base = |row: usize| path[row].map_from_robot.position();
        if found.last().is_none_or(|&last| base(last).distance(base(row)) >= step * (1.0 - 1e-9)) {
            found.push(row);
        }
    }
    found
}

/// Mean and standard deviation (of the sample); not numbers where there are too few.
pub(super) fn mean_and_std(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let others = if values.len() > 1 { count - 1.0 } else { f64::NAN };
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, (square / others).sqrt())
}
