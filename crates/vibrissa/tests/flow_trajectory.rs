//! Trajectory files and errors, against numbers worked out by hand and against rotation matrices.

#[path = "data/shared.rs"]
mod shared;

use shared::shared;
use std::f64::consts::{FRAC_PI_2, PI};
use vibrissa::flow::pose::StampedPose;
use vibrissa::flow::trajectory::{pose_at, trajectory_error};
use vibrissa::io::{format_tum, parse_tum, read_tum};
use vibrissa::plane::{Pose2, wrap_angle};

fn row(t: f64, x: f64, y: f64, theta: f64) -> StampedPose {
    StampedPose { t, map_from_robot: Pose2::new(x, y, theta) }
}

/// The heading of a quaternion by the rotation matrix: where the forward axis points.
fn heading_by_matrix(q: [f64; 4]) -> f64 {
    let [x, y, z, w] = q;
    let forward = [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)];
    forward[1].atan2(forward[0])
}

#[test]
fn quaternions_mean_the_heading_of_the_rotation_matrix() {
    let raw = [
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, -0.6, 0.8],
        [0.0, 0.0, 0.6, -0.8],
        [0.02, -0.03, 0.7, -0.71],
        [0.0, 0.0, -0.883_428_31, 0.468_566_34],
    ];
    for quaternion in raw {
        let length = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
        let unit = quaternion.map(|part| part / length);
        let [x, y, z, w] = unit;
        let poses = parse_tum(&format!("# comment\n\n 1.5\t-2 3e-1 9 {x} {y} {z} {w}\r\n")).unwrap();
        let pose = poses[0].map_from_robot;
        assert!((pose.x + 2.0).abs() < 1e-15 && (pose.y - 0.3).abs() < 1e-15);
        assert!(wrap_angle(pose.theta - heading_by_matrix(unit)).abs() < 1e-12, "{quaternion:?}");
    }
}

#[test]
fn what_is_written_reads_back_to_the_stated_digits() {
    let poses: Vec<StampedPose> = (-40..40)
        .map(|i| {
            let s = f64::from(i);
            row(1e3 + 0.003_333 * s, 12.3 * s.sin(), -0.004 * s, 0.0785 * s)
        })
        .chain([row(1e4, -1e-7, 1e5, PI), row(1e4 + 1.0, 0.0, 0.0, -FRAC_PI_2)])
        .collect();
    let back = parse_tum(&format_tum(&poses)).unwrap();
    assert_eq!(back.len(), poses.len());
    for (a, b) in poses.iter().zip(&back) {
        let (p, q) = (a.map_from_robot, b.map_from_robot);
        assert!((a.t - b.t).abs() <= 5.1e-7);
        assert!(p.position().distance(q.position()) <= 1e-9 && wrap_angle(p.theta - q.theta).abs() <= 4e-9);
    }
    let line = format_tum(&[row(0.003_333_3, 0.1, -0.2, FRAC_PI_2)]);
    assert_eq!(line, "0.003333 0.100000000 -0.200000000 0 0 0 0.707106781 0.707106781\n");
}

#[test]
fn poses_that_are_not_finite_are_left_out() {
    let mut bad = row(1.0, 0.0, 0.0, 0.0);
    bad.map_from_robot.x = f64::NAN;
    assert_eq!(format_tum(&[bad]), "");
}

#[test]
fn faults_name_line_value_and_remedy() {
    let good = "0 0 0 0 0 0 0 1\n";
    let cases = [
        ("1 2 3\n".into(), "line 1: ", "3"),
        (format!("{good}1 0 0 0 0 0 0 1 7\n"), "line 2: ", "more than 8"),
        (format!("# c\n{good}1 0 zero 0 0 0 0 1\n"), "line 3: ", "zero"),
        (format!("{good}1 0 nan 0 0 0 0 1\n"), "line 2: ", "nan"),
        (format!("{good}{good}"), "line 2: ", "does not increase"),
        ("0 0 0 0 1 0 0 1\n".into(), "line 1: ", "1.41"),
        ("0 0 0 0 0 0 0 0\n".into(), "line 1: ", "qx qy qz qw"),
        ("# nothing\n".into(), "line 1: ", "no pose"),
        (String::new(), "line 1: ", "no pose"),
    ];
    for (text, place, value) in cases {
        let error = parse_tum(&text).unwrap_err();
        let message = error.to_string();
        assert!(error.is_data() && message.starts_with(place) && message.contains(value), "{text:?}: {message}");
        assert!(message.contains("\n  help: "), "{message}");
    }
    let error = read_tum("no/such.tum").unwrap_err();
    assert!(error.to_string().starts_with("no/such.tum: "), "{error}");
}

#[test]
fn between_rows_the_pose_follows_a_circle() {
    // A quarter turn on a circle of radius 1 around the origin, passed at constant speed.
    let truth = [row(0.0, 1.0, 0.0, FRAC_PI_2), row(1.0, 0.0, 1.0, PI)];
    for step in 0..=10 {
        let t = f64::from(step) / 10.0;
        let pose = pose_at(&truth, t).unwrap();
        let angle = FRAC_PI_2 * t;
        assert!((pose.x - angle.cos()).abs() < 1e-12 && (pose.y - angle.sin()).abs() < 1e-12, "{t}");
        assert!(wrap_angle(pose.theta - FRAC_PI_2 - angle).abs() < 1e-12);
    }
    assert_eq!(pose_at(&truth, -0.1), None);
    assert_eq!(pose_at(&truth, 1.1), None);
    assert_eq!(pose_at(&truth, f64::NAN), None);
    assert_eq!(pose_at(&[], 0.0), None);
}

#[test]
fn errors_are_the_distances_by_hand() {
    let truth = [row(0.0, 0.0, 0.0, PI), row(1.0, 1.0, 0.0, PI)];
    // 3-4-5 triangle at t = 0.5; at t = 1 only the heading is off, across the half turn.
    let estimate = [row(-1.0, 9.0, 9.0, 0.0), row(0.5, 0.503, 0.004, PI), row(1.0, 1.0, 0.0, -PI + 0.2)];
    let error = trajectory_error(&estimate, &truth).unwrap();
    assert_eq!(error.rows, 2);
    assert!(error.final_position.abs() < 1e-12 && (error.final_heading - 0.2).abs() < 1e-12);
    assert!((error.mean_position - 0.0025).abs() < 1e-12 && (error.mean_heading - 0.1).abs() < 1e-12);
    assert_eq!(trajectory_error(&estimate[..1], &truth), None);
    assert_eq!(trajectory_error(&[], &truth), None);
}

#[test]
fn the_shared_truths_are_read() {
    let Some(sweeps) = shared("sweeps") else { return };
    let folder = std::fs::read_dir(sweeps).unwrap();
    let truths = folder.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some_and(|e| e == "tum"));
    let mut count = 0;
    for path in truths {
        let poses = read_tum(&path).unwrap();
        assert!(poses.len() > 50 && poses.iter().all(|pose| pose.map_from_robot.position().norm() < 1.0));
        count += 1;
    }
    assert!(count > 0);
}
