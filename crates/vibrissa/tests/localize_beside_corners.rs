//! A whisker that slides off a corner: in a cell of the search it does so earlier or later than in truth, and beside the true place along a
//! wall, too. Some readings are far off there, and no derivative tells why.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot go on must fail")]

#[path = "data/nearest.rs"]
mod nearest;

use nearest::{RIGHT, nearest};
use vibrissa::flow::pose::{Hypothesis, StampedPose};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::recorder::TrueErrors;
use vibrissa::sim::{Drive, Pace, Scenario, SimulateOptions, Stage, SweepNoise, path_through};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};
use vibrissa::{Method, localize};

const ROOM: &str = r#"
seed = 2
[map]
arena = [[0, 0], [1.045, 0], [1.045, 0.511], [0.56, 0.511], [0.56, 1.048], [0, 1.048]]
obstacle = [[0.191, 0.143], [0.261, 0.283], [0.311, 0.183]]
[noise]
law = "LAW"
[sensing]
columns = ["moment"]
[path]
"#;

/// Four presses against one corner of the triangle (mm, mm, degrees).
const WAY: [[f64; 3]; 13] = [
    [383.0, 229.0, -117.69],
    [365.0, 219.5, -117.69],
    [351.0, 216.5, -117.69],
    [335.7, 249.0, -117.69],
    [345.4, 258.3, -117.69],
    [350.0, 260.7, -124.9],
    [334.5, 257.5, -124.9],
    [320.0, 268.0, -124.9],
    [339.2, 282.0, -124.9],
    [329.2, 277.0, -110.15],
    [315.0, 274.4, -110.15],
    [303.4, 303.5, -110.15],
    [311.7, 312.0, -110.15],
];

/// Readings of that, so many millimetres to the side.
fn presses(law: &str, aside: f64) -> String {
    let pose = |[x, y, heading]: [f64; 3]| (x + aside, y, heading);
    let (x, y, heading) = pose(WAY[0]);
    let mut text = ROOM.replace("LAW", law) + &format!("start = [\"{x} mm\", \"{y} mm\", \"{heading} deg\"]\n");
    for next in &WAY[1..] {
        let (x, y, heading) = pose(*next);
        text += &format!("[[path.leg]]\nkind = \"line\"\nto = [\"{x} mm\", \"{y} mm\"]\nheading = \"{heading} deg\"\n");
    }
    text
}

#[test]
fn readings_beside_a_corner_do_not_lose_the_true_place() {
    for law in ["none", "uniform"] {
        for aside in [-2.0, -1.0, 0.0, 2.0] {
            let scenario = Scenario::from_toml(&presses(law, aside), "presses.toml", ".").unwrap();
            let made = scenario.simulate().unwrap();
            let truth = made.sweep.truth.last().unwrap().map_from_robot.position();
            let what = format!("{law}, {aside} mm aside");
            let found = nearest(&scenario, &made.recording.log, truth, &what);
            assert!(found < RIGHT, "{what}: {found} m");
        }
    }
}

/// A whisker that leans is dragged along a block and off its corner.
const DRAG: &str = r#"
seed = SEED
[map]
arena = [[0, 0], [0.9, 0], [0.9, 0.5], [0.55, 0.5], [0.55, 0.85], [0, 0.85]]
obstacle = [[0.25, 0.3], [0.4, 0.3], [0.4, 0.4], [0.25, 0.4]]
[noise]
law = "LAW"
[sensing]
columns = ["moment"]
[path]
start = ["330 mm", "222 mm", "115 deg"]
[[path.leg]]
kind = "line"
to = ["340 mm", "240 mm"]
heading = "keep"
[[path.leg]]
kind = "line"
to = ["460 mm", "240 mm"]
heading = "keep"
"#;

#[test]
fn the_place_along_a_wall_is_where_the_whisker_slides_off_its_end() {
    for (law, seed) in [("none", 1), ("uniform", 2), ("ar1", 3)] {
        let text = DRAG.replace("LAW", law).replace("SEED", &seed.to_string());
        let scenario = Scenario::from_toml(&text, "drag.toml", ".").unwrap();
        let made = scenario.simulate().unwrap();
        let truth = made.sweep.truth.last().unwrap().map_from_robot.position();
        let found = nearest(&scenario, &made.recording.log, truth, law);
        assert!(found < RIGHT, "{law}: {found} m");
    }
}

/// A robot that touches a wall, goes on a little, and meets something else. Rows are 4 mm or 0.04 rad apart: few of them tell where a contact begins.
struct Way {
    room: &'static [(f64, f64)],
    thing: &'static [(f64, f64)],
    length: f64,
    mount: [f64; 3],
    /// Waypoints (m, m, degrees).
    waypoints: &'static [[f64; 3]],
}

/// A drag along the wall of a room with a block in it, and a turn that ends it and meets the block.
const WAY_AND_TURN: Way = Way {
    room: &[
        (0.0, 0.0),
        (0.00253, 0.14719),
        (0.02208, 0.14686),
        (0.02307, 0.20426),
        (0.00351, 0.2046),
        (0.00437, 0.25469),
        (-0.28932, 0.25973),
        (-0.2937, 0.00504),
    ],
    thing: &[(-0.1054, 0.08855), (-0.18075, 0.08984), (-0.17993, 0.13731), (-0.10459, 0.13602)],
    length: 0.067984,
    mount: [0.007875, 0.009306, 0.993254],
    waypoints: &[[-0.22272, 0.10434, 89.016], [-0.23072, 0.17992, 89.016], [-0.23072, 0.17992, -34.743]],
};

fn polygon(role: Role, points: &[(f64, f64)]) -> Boundary {
    let points: Vec<Vec2> = points.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    Boundary::new(role, Curve::polyline(&points, true).unwrap(), None).unwrap()
}

/// What the robot records on the way, and where it was.
fn driven(way: &Way, seed: u64) -> (SensorLog, Map, Robot, Vec<StampedPose>) {
    let mut boundaries = vec![polygon(Role::Arena, way.room)];
    boundaries.extend((!way.thing.is_empty()).then(|| polygon(Role::Obstacle, way.thing)));
    let [x, y, theta] = way.mount;
    let mut whisker = MountedWhisker { robot_from_whisker: Pose2::new(x, y, theta), ..MountedWhisker::default() };
    whisker.beam.length = way.length;
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let (map, options) = (Map::new(boundaries).unwrap(), SimulateOptions { links: 30, ..SimulateOptions::default() });
    let stage = Stage::new(map.clone(), robot.clone(), options).unwrap();
    let waypoints: Vec<Pose2> = way.waypoints.iter().map(|&[x, y, turn]| Pose2::new(x, y, turn.to_radians())).collect();
    let path = path_through(&waypoints, &Pace { speed: 0.1, turn_rate: 1.0, rate: 25.0 }).unwrap();
    let mut drive = Drive::start(&stage, path[0], &SweepNoise::seeded(seed)).unwrap();
    let mut log = SensorLog { channels: stage.channels(), ..SensorLog::default() };
    log.rows.extend(path.iter().map(|&pose| drive.advance(pose, &TrueErrors::default(), 0.0).unwrap()));
    (log, map, robot, path)
}

#[test]
fn what_begins_or_ends_between_two_rows_does_not_lose_the_true_place() {
    for seed in [1, 2, 3, 4, 5] {
        let (log, map, robot, path) = driven(&WAY_AND_TURN, seed);
        let truth = path[path.len() - 1].map_from_robot.position();
        let answer = localize(&log, &map, &robot, &Method::default(), &mut |_| {}).unwrap();
        let off = |h: &Hypothesis| h.pose.position().distance(truth);
        let nearest = answer.hypotheses.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("no place is told");
        let told = (off(nearest), nearest.weight);
        assert!(told.0 < 2e-3 && told.1 > 0.05, "seed {seed}: {}, {told:?}", answer.status);
    }
}
