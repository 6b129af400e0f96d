//! Robots that follow walls by touch in the simulator: laps, gentle whiskers, and what they say of what they do.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::control::{FollowOptions, FollowState, Side, WallFollower};
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::{Curve, Pose2, Twist2, Vec2};
use vibrissa::sim::recorder::TrueErrors;
use vibrissa::sim::{Drive, SimulateOptions, Stage, SweepNoise};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};

/// `EI / L` of the whiskers here (N m).
const UNIT: f64 = 2.8886e-4 / 0.075;

fn ring(role: Role, corners: &[(f64, f64)]) -> Boundary {
    let corners: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    Boundary::new(role, Curve::polyline(&corners, true).unwrap(), None).unwrap()
}

/// An L: five inner corners and an outer one.
fn room() -> Map {
    Map::new(vec![ring(Role::Arena, &[(0.0, 0.0), (0.8, 0.0), (0.8, 0.4), (0.4, 0.4), (0.4, 0.8), (0.0, 0.8)])])
        .unwrap()
}

/// A block in the middle of a room: outer corners.
fn block() -> Map {
    let walls = ring(Role::Arena, &[(0.0, 0.0), (1.2, 0.0), (1.2, 1.2), (0.0, 1.2)]);
    Map::new(vec![walls, ring(Role::Obstacle, &[(0.45, 0.5), (0.75, 0.5), (0.75, 0.7), (0.45, 0.7)])]).unwrap()
}

fn robot(angles: &[f64]) -> Robot {
    let whisker = |(k, &angle): (usize, &f64)| MountedWhisker {
        name: format!("w{k}"),
        robot_from_whisker: Pose2::new(0.005, 0.0, angle),
        ..MountedWhisker::default()
    };
    Robot { whiskers: angles.iter().enumerate().map(whisker).collect(), ..Robot::default() }
}

/// What a run showed.
struct Run {
    states: Vec<FollowState>,
    /// Share of the rows that follow in which the first whisker's moment is within the band.
    kept: f64,
    hardest: f64,
    nearest: f64,
    /// Way around the boundary that was followed, over its length.
    laps: f64,
    way: f64,
}

/// Follows for so long (s), with errors of readings and wheels.
fn run(map: Map, robot: &Robot, options: &FollowOptions, begin: Pose2, seconds: f64, errors: &TrueErrors) -> Run {
    let boundary = map.boundaries().len() - 1;
    let length = map.boundaries()[boundary].curve().length();
    let stage = Stage::new(map, robot.clone(), SimulateOptions { links: 30, ..SimulateOptions::default() }).unwrap();
    let mut follower = WallFollower::new(robot, options).unwrap();
    let mut drive =
        Drive::start(&stage, StampedPose { t: 0.0, map_from_robot: begin }, &SweepNoise::seeded(5)).unwrap();
    let dt = 0.02;
    let (mut readings, mut last) = (vec![0.0; robot.whiskers.len()], None);
    let mut found = Run { states: Vec::new(), kept: 0.0, hardest: 0.0, nearest: f64::INFINITY, laps: 0.0, way: 0.0 };
    let (mut within, mut rows) = (0, 0);
    for k in 1..=(seconds / dt) as usize {
        let t = k as f64 * dt;
        let told = follower.step(t, &readings);
        if found.states.last() != Some(&told.state) {
            found.states.push(told.state);
        }
        let Twist2 { x, y, theta } = told.twist;
        assert!(x.hypot(y) <= 1.12 * options.speed && theta.abs() <= options.turn_rate + 1e-9, "{told:?}");
        assert!(options.sideways || y == 0.0, "{told:?}");
        // Wheels that slip, and a robot that veers.
        let moved = Twist2 { x: 1.02 * x * dt, y: 1.02 * y * dt, theta: (theta + 0.3 * x) * dt };
        let to = drive.pose().map_from_robot.compose(Pose2::exp(moved));
        readings = drive.advance(StampedPose { t, map_from_robot: to }, errors, 0.0).unwrap().readings;
        found.way += moved.x.hypot(moved.y);
        found.hardest = drive.moments().iter().fold(found.hardest, |most, m| most.max(m.abs() / UNIT));
        let near = stage.map().nearest(to.position()).unwrap();
        assert!(stage.map().is_free(to.position()));
        found.nearest = found.nearest.min(near.distance);
        if told.state == FollowState::Following {
            rows += 1;
            within += u32::from((0.3..=0.9).contains(&(drive.moments()[0].abs() / UNIT)));
        }
        let at = (near.boundary == boundary).then_some(near.arc_length);
        if let Some((before, now)) = last.zip(at) {
            let step: f64 = now - before;
            found.laps += (step - length * (step / length).round()) / length;
        }
        last = at;
    }
    found.kept = f64::from(within) / f64::from(rows.max(1_u32));
    found
}

/// A zero that is shifted, and a gain that is wrong.
fn errors() -> TrueErrors {
    TrueErrors { zero: 0.05 * UNIT, gain: -0.08, ..TrueErrors::default() }
}

#[test]
fn a_room_is_gone_around_by_either_drive() {
    for sideways in [false, true] {
        let options = FollowOptions { sideways, footprint: 0.02, ..FollowOptions::default() };
        let found = run(room(), &robot(&[-0.8, 0.8]), &options, Pose2::new(0.2, 0.2, 0.4), 100.0, &errors());
        let told = format!("sideways {sideways} laps {} kept {} {:?}", found.laps, found.kept, found.states);
        // The boundary runs with free space on its left: with the wall on the right.
        assert!(found.laps > 0.95, "{told}");
        assert!(found.hardest < 2.0 && found.nearest > options.footprint, "{} {told}", found.hardest);
        assert!(found.kept > 0.75, "{told}");
        for state in [FollowState::Searching, FollowState::Following, FollowState::TurningInnerCorner] {
            assert!(found.states.contains(&state), "{state:?}: {told}");
        }
        assert!(!found.states.contains(&FollowState::Blocked), "{told}");
    }
}

#[test]
fn the_left_is_the_mirror_of_the_right() {
    let options = FollowOptions { sideways: true, ..FollowOptions::default() };
    let mut right = WallFollower::new(&robot(&[-0.8, 0.8]), &options).unwrap();
    let mut left = WallFollower::new(&robot(&[0.8, -0.8]), &options).unwrap();
    let mut states = Vec::new();
    for k in 0..2000 {
        let t = f64::from(k) * 0.02;
        // Touched, pressed, caught, free, and the other side.
        let (first, other) = ((0.7 * t).sin() + 0.6 * (2.3 * t).sin(), 0.5 * (0.31 * t).sin().min(0.0));
        let (a, b) = (right.step(t, &[first * UNIT, other * UNIT]), left.step(t, &[-first * UNIT, -other * UNIT]));
        assert_eq!(a.state, b.state, "{t}");
        let off = (a.twist.x - b.twist.x).abs() + (a.twist.y + b.twist.y).abs() + (a.twist.theta + b.twist.theta).abs();
        assert!(off < 1e-9, "{t}: {a:?} {b:?}");
        if states.last() != Some(&a.state) {
            states.push(a.state);
        }
    }
    assert!(
        states.contains(&FollowState::Following) && states.contains(&FollowState::TurningInnerCorner),
        "{states:?}"
    );
}

#[test]
fn a_block_is_gone_around_by_its_outer_corners() {
    let options = FollowOptions { footprint: 0.02, ..FollowOptions::default() };
    let begin = Pose2::new(0.7, 0.432, core::f64::consts::PI - 0.2);
    // With the block on the right the way along its lower side leads to lower x.
    let found = run(block(), &robot(&[-0.8, 0.8]), &options, begin, 45.0, &errors());
    let told = format!("laps {} kept {} {:?}", found.laps, found.kept, found.states);
    assert!(found.laps.abs() > 1.0, "{told}");
    assert!(found.states.contains(&FollowState::TurningOuterCorner), "{told}");
    assert!(found.hardest < 2.0 && found.nearest > options.footprint, "{told}");
}

#[test]
fn a_robot_that_is_shut_in_says_so_and_presses_gently() {
    let map = Map::new(vec![ring(Role::Arena, &[(0.0, 0.0), (0.16, 0.0), (0.16, 0.12), (0.0, 0.12)])]).unwrap();
    let options = FollowOptions { footprint: 0.01, ..FollowOptions::default() };
    let robot = robot(&[-0.8, 0.8]);
    let found = run(map, &robot, &options, Pose2::new(0.05, 0.06, 0.0), 120.0, &TrueErrors::default());
    assert!(found.hardest < 2.0, "{}", found.hardest);
    assert!(found.states.contains(&FollowState::Blocked) || found.laps.abs() > 1.0, "{:?}", found.states);
}

#[test]
fn readings_that_are_none_stop_the_robot_and_slow_sensors_slow_it() {
    let robot = robot(&[-0.8]);
    let mut follower = WallFollower::new(&robot, &FollowOptions::default()).unwrap();
    assert!(follower.step(0.0, &[0.0]).twist.x > 0.0);
    for (t, readings) in [(0.1, &[f64::NAN][..]), (0.1, &[]), (f64::NAN, &[0.0]), (-1.0, &[0.0])] {
        assert_eq!(follower.step(t, readings).twist, Twist2::default(), "{t} {readings:?}");
    }
    let mut speeds = [0.01, 0.1, 0.5].map(|dt| {
        let mut follower = WallFollower::new(&robot, &FollowOptions::default()).unwrap();
        let _ = follower.step(0.0, &[0.0]);
        follower.step(dt, &[0.0]).twist.x * dt
    });
    speeds.sort_by(f64::total_cmp);
    assert!(speeds[2] <= 2.5e-3 + 1e-12, "{speeds:?}");
}

#[test]
fn robots_that_cannot_follow_are_refused() {
    let refused = |angles: &[f64], options: FollowOptions| {
        WallFollower::new(&robot(angles), &options).err().map(|error| error.to_string()).unwrap_or_default()
    };
    let options = FollowOptions::default();
    assert!(refused(&[0.0], options).contains("points 12 to 78 deg off"));
    assert!(refused(&[-0.8], FollowOptions { side: Some(Side::Left), ..options }).contains("other side"));
    assert!(refused(&[-0.8], FollowOptions { footprint: 0.07, ..options }).contains("footprint"));
    assert!(refused(&[-0.8], FollowOptions { speed: 0.0, ..options }).contains("speed"));
    assert!(refused(&[-0.8], FollowOptions { turn_rate: f64::NAN, ..options }).contains("turning rate"));
    assert!(refused(&[-0.8], FollowOptions { band: Some([2e-3, 1e-3]), ..options }).contains("band"));
    assert_eq!(refused(&[-0.8], options), "");
}
