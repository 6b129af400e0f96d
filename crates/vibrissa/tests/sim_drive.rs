//! A steered robot feels what the same robot feels on the same path when it is simulated as a whole.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::Robot;
use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::Pose2;
use vibrissa::sim::recorder::TrueErrors;
use vibrissa::sim::{Drive, SimulateOptions, Stage, SweepNoise, simulate};
use vibrissa::tasks::demo;

#[test]
fn the_same_poses_give_the_same_moments_touches_and_odometry() {
    let (map, path, robot) = (demo::arena().unwrap(), demo::path().unwrap(), Robot::default());
    let (noise, options) = (SweepNoise::none(), SimulateOptions::default());
    let sweep = simulate(&map, &robot, &path, &noise, &options).unwrap();
    let stage = Stage::new(map, robot, options).unwrap();
    let mut drive = Drive::start(&stage, path[0], &noise).unwrap();
    assert_eq!(stage.channels(), sweep.log.channels);
    let mut touches = 0;
    for (row, pose) in path.iter().enumerate() {
        let felt = drive.advance(*pose, &TrueErrors::default(), 0.0).unwrap();
        assert_eq!(drive.moments(), sweep.exact_moments[row]);
        assert_eq!(felt.readings, sweep.log.rows[row].readings);
        let expected = sweep.log.rows[row].odom_from_robot;
        assert!(felt.odom_from_robot.position().distance(expected.position()) < 1e-12);
        touches += drive.touches().len();
    }
    assert_eq!(touches, sweep.contacts.len());
    assert_eq!(drive.events(), sweep.events);
    assert!(drive.events().is_empty(), "told once");
    assert!(touches > 300 && drive.shapes(20)[0].len() >= 20);
}

#[test]
fn offset_gain_and_slip_befall_what_is_recorded() {
    let (map, path, robot) = (demo::arena().unwrap(), demo::path().unwrap(), Robot::default());
    let stage = Stage::new(map, robot, SimulateOptions::default()).unwrap();
    let mut drive = Drive::start(&stage, path[0], &SweepNoise::none()).unwrap();
    let errors = TrueErrors { zero: 3e-4, gain: 0.2, ..TrueErrors::default() };
    let mut last = None;
    for pose in &path {
        last = Some(drive.advance(*pose, &errors, 0.1).unwrap());
    }
    let (last, exact) = (last.unwrap(), drive.moments()[0]);
    assert!(exact > 1e-4 && (last.readings[0] - (1.2 * exact + 3e-4)).abs() < 1e-15);
    let way: f64 =
        path.windows(2).map(|pair| pair[0].map_from_robot.position().distance(pair[1].map_from_robot.position())).sum();
    let ends = path[0].map_from_robot.between(path[path.len() - 1].map_from_robot).position().norm();
    let counted = last.odom_from_robot.position().norm();
    assert!((counted - 1.1 * ends).abs() < 1e-9 && way >= ends, "{counted} of {ends}");
}

#[test]
fn a_start_in_contact_is_refused() {
    let stage = Stage::new(demo::arena().unwrap(), Robot::default(), SimulateOptions::default()).unwrap();
    let at = StampedPose { t: 0.0, map_from_robot: Pose2::new(0.211, 0.273, 2.0) };
    let refused = Drive::start(&stage, at, &SweepNoise::none()).err().unwrap().to_string();
    assert!(refused.contains("does not start in free space"), "{refused}");
}

/// Where the whiskers first touch is looked for along the way, and a way of light years would never end.
#[test]
fn poses_that_no_robot_drives_to_are_refused_at_once() {
    let map = demo::arena().unwrap();
    let first = demo::path().unwrap()[0];
    let stage = Stage::new(map, Robot::default(), SimulateOptions::default()).unwrap();
    let mut drive = Drive::start(&stage, first, &SweepNoise::none()).unwrap();
    let at = first.map_from_robot;
    for pose in [
        Pose2 { x: 9_007_199_254_740_993.0, ..at },
        Pose2 { y: f64::NEG_INFINITY, ..at },
        Pose2 { x: f64::NAN, ..at },
        Pose2 { theta: 1e9, ..at },
        Pose2 { theta: f64::NAN, ..at },
    ] {
        let to = StampedPose { t: first.t + 0.1, map_from_robot: pose };
        let refused = drive.advance(to, &TrueErrors::default(), 0.0).unwrap_err();
        assert!(refused.is_usage() && refused.to_string().contains("allowed: up to"), "{refused}");
    }
    assert_eq!(drive.pose(), first);
    let on = StampedPose { t: first.t + 0.1, map_from_robot: Pose2 { x: at.x + 1e-3, ..at } };
    drive.advance(on, &TrueErrors::default(), 0.0).unwrap();
}
