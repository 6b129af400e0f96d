//! A log of raw flux and the calibration that the robot names: the same answer as from the moments.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::path::PathBuf;
use vibrissa::flow::pose::Status;
use vibrissa::flow::sensor_log::{Channel, Quantity, SensorLog};
use vibrissa::io::calibrated;
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::world::calibration::{Calibration, MomentCurve};
use vibrissa::{Method, localize};

/// A sensor whose flux is `0.8 M` along y and `-0.6 M` along x, from 1 µT at rest; the calibration's file.
fn cal_file(name: &str, bound: f64) -> PathBuf {
    let curve = MomentCurve {
        inputs: vec!["bx".into(), "by".into()],
        rest: vec![1e-6, 1e-6],
        direction: vec![-0.6, 0.8],
        range: [0.0, 0.02],
        coefficients: vec![0.0, 0.02],
        residual_rms: 0.0,
        hysteresis: 0.0,
        bound,
        samples: 100,
    };
    let calibration = Calibration { moment: Some(curve), ..Calibration::default() };
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, vibrissa::io::calibration::to_json(&calibration).to_string()).unwrap();
    path
}

fn raw(log: &SensorLog) -> SensorLog {
    let mut raw = log.clone();
    raw.channels = [Quantity::FluxX, Quantity::FluxY]
        .map(|quantity| Channel { whisker: log.channels[0].whisker.clone(), quantity })
        .to_vec();
    for row in &mut raw.rows {
        let moment = row.readings[0];
        row.readings = vec![1e-6 - 0.6 * moment, 1e-6 + 0.8 * moment];
    }
    raw
}

#[test]
fn flux_and_moments_give_the_same_place() {
    let (arena, sweep) = (demo::arena().unwrap(), demo::sweep(1).unwrap());
    let mut robot = Robot::default();
    robot.whiskers[0].calibration = Some(cal_file("cal-exact.json", 0.0));
    let run = |log: &SensorLog| {
        localize(log, &arena, &robot, &Method::Deterministic(Default::default()), &mut |_| {}).unwrap()
    };
    let (direct, through) = (run(&sweep.log), run(&raw(&sweep.log)));
    assert_eq!((direct.status, through.status), (Status::Localized, Status::Localized));
    let [a, b] = [direct, through].map(|answer| answer.estimate.unwrap());
    assert!(a.position().distance(b.position()) < 1e-9 && (a.theta - b.theta).abs() < 1e-9);
}

#[test]
fn the_bound_is_added_and_faults_name_file_and_line() {
    let sweep = demo::sweep(1).unwrap();
    let mut log = raw(&sweep.log);
    let mut robot = Robot::default();
    let declared = robot.whiskers[0].noise.moment_absolute;
    let error =
        localize(&log, &demo::arena().unwrap(), &robot, &Method::Deterministic(Default::default()), &mut |_| {})
            .unwrap_err();
    assert!(error.to_string().contains("calibration"), "{error}");
    robot.whiskers[0].calibration = Some(cal_file("cal-bound.json", 3e-5));
    let (converted, wider) = calibrated(&log, &robot).unwrap();
    assert!((wider.whiskers[0].noise.moment_absolute - declared - 3e-5).abs() < 1e-15);
    let channel = converted.moment_channel("w0").unwrap();
    for (row, original) in converted.rows.iter().zip(&sweep.log.rows) {
        assert!((row.readings[channel] - original.readings[0]).abs() < 1e-15);
    }
    // A log with moments is left alone, calibration or not.
    let (same, robot_same) = calibrated(&sweep.log, &robot).unwrap();
    assert!(matches!((same, robot_same), (std::borrow::Cow::Borrowed(_), std::borrow::Cow::Borrowed(_))));
    log.rows[3].readings[1] = 1.0;
    log.rows[3].line = 5;
    log.source = Some("flux.csv".into());
    let error = calibrated(&log, &robot).unwrap_err().to_string();
    assert!(error.starts_with("flux.csv:5: bx,by beyond the calibrated range"), "{error}");
    robot.whiskers[0].calibration = Some("/no/such/cal.json".into());
    assert!(calibrated(&log, &robot).unwrap_err().is_data());
}
