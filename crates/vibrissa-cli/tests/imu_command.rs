//! `--headings` and `--yaw-rates`: what an inertial measurement unit in a recording is worth to the commands.

#![cfg(feature = "mcap")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::path::Path;
use vibrissa::flow::sensor_log::{LogRow, SensorLog};
use vibrissa::io::recording::parts::add_readings;
use vibrissa::io::ros::{BagWriter, Header, ImuReading, Kind, Stamp, encode_imu, encode_odometry};
use vibrissa::plane::{Pose2, Twist2, wrap_angle};
use vibrissa::tasks::demo;

/// How far the wheels are off over the sweep (rad).
const DRIFT: f64 = 0.25;

/// The demo's sweep as a recording: wheels that drift to the left, a unit that measures right. Gives the last true pose.
fn recorded(path: &Path) -> Pose2 {
    let sweep = demo::sweep(1).unwrap();
    let truth: Vec<Pose2> = sweep.truth.iter().map(|stamped| stamped.map_from_robot).collect();
    let (rows, count) = (&sweep.log.rows, sweep.log.rows.len() as f64);
    let mut bag = BagWriter::default();
    let odom = bag.topic("/odom", Kind::Odometry, false);
    let unit = bag.topic("/imu/data", Kind::Imu, false);
    let mut wheels = Pose2::IDENTITY;
    let mut wrong: Vec<LogRow> = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        let header = Header { stamp: Stamp::from_seconds(row.t), frame: "base_link" };
        // The turn at a row is the mean of those before and after it.
        let [from, to] = [k.saturating_sub(1), (k + 1).min(rows.len() - 1)];
        let yaw_rate = wrap_angle(truth[to].theta - truth[from].theta) / (rows[to].t - rows[from].t);
        if k > 0 {
            let step = truth[k - 1].between(truth[k]).log();
            wheels = wheels.compose(Pose2::exp(Twist2 { theta: step.theta + DRIFT / count, ..step }));
        }
        bag.push(odom, header.stamp, encode_odometry(header, "base_link", wheels));
        let measured = ImuReading { heading: Some(truth[k].theta), yaw_rate: Some(yaw_rate) };
        bag.push(unit, header.stamp, encode_imu(header, measured));
        wrong.push(LogRow { odom_from_robot: wheels, ..row.clone() });
    }
    add_readings(&mut bag, &SensorLog { rows: wrong, ..sweep.log.clone() });
    std::fs::write(path, bag.finish().unwrap()).unwrap();
    truth[truth.len() - 1]
}

#[test]
fn a_unit_makes_good_for_wheels_that_drift() {
    let here = folder("imu");
    let path = |name: &str| here.join(name).to_str().unwrap().to_owned();
    let truth = recorded(Path::new(&path("log.mcap")));
    std::fs::write(path("map.svg"), demo::ARENA_SVG).unwrap();
    let localize = |more: &[&str]| {
        let (log, map) = (path("log.mcap"), path("map.svg"));
        let args = [&["localize", &log, "--map", &map, "--json"], more].concat();
        let found = vibrissa(&args);
        assert_eq!(found.code, Some(0), "{more:?}: {}", found.stderr);
        let value: serde_json::Value = serde_json::from_str(&found.stdout).unwrap();
        let at = |key: &str| value["estimate"][key].as_f64().unwrap_or(f64::INFINITY);
        let off = (at("x") - truth.x).hypot(at("y") - truth.y);
        (value["status"].as_str().unwrap().to_owned(), off, found.stderr)
    };
    let (status, off, warnings) = localize(&[]);
    assert!(status != "localized" || off > 5e-3, "the drift is to be seen: {status}, {off} m");
    assert!(warnings.contains("/imu/data") && warnings.contains("--yaw-rates"), "{warnings}");
    for more in [
        ["--yaw-rates", "/imu/data"].as_slice(),
        &["--yaw-rates", "/imu/data", "--headings", "/imu/data"],
        &["--yaw-rates", "/imu/data", "--headings", "/imu/data", "--method", "possibilistic"],
    ] {
        let (status, off, warnings) = localize(more);
        println!("{more:?}: {status}, {off} m");
        assert!(status == "localized" && off < 2e-3, "{more:?}: {status}, {off} m");
        assert!(!warnings.contains("/imu/data"), "{warnings}");
    }
}

#[test]
fn topics_that_are_not_there_and_files_without_topics_are_told() {
    let here = folder("imu-wrong");
    let path = |name: &str| here.join(name).to_str().unwrap().to_owned();
    recorded(Path::new(&path("log.mcap")));
    std::fs::write(path("map.svg"), demo::ARENA_SVG).unwrap();
    std::fs::write(path("log.csv"), "t,x,y,theta,moment\n0,0,0,0,0\n1,0,0,0,0\n").unwrap();
    let tell = |log: &str, more: &[&str]| {
        let (log, map) = (path(log), path("map.svg"));
        vibrissa(&[&["localize", &log, "--map", &map], more].concat())
    };
    for flag in ["--headings", "--yaw-rates"] {
        let told = tell("log.mcap", &[flag, "/imu"]);
        assert!(told.code == Some(1) && told.stderr.contains("log.mcap: "), "{}", told.stderr);
        // The topic that is there is named.
        assert!(told.stderr.contains("/imu/data") && told.stderr.contains("help: "), "{}", told.stderr);
        let told = tell("log.csv", &[flag, "/imu/data"]);
        assert!(told.code == Some(2) && told.stderr.contains("a .mcap file"), "{}", told.stderr);
        assert!(told.stderr.contains("the column `heading`"), "{}", told.stderr);
        let told = tell("log.csv", &[flag, "/imu/data", "--format", "csv"]);
        assert!(told.code == Some(2) && told.stderr.contains("--format"), "{}", told.stderr);
    }
    // `profile` reads the same.
    let log = path("log.mcap");
    let told = vibrissa(&["profile", &log, "--yaw-rates", "/nowhere"]);
    assert!(told.code == Some(1) && told.stderr.contains("/imu/data"), "{}", told.stderr);
}
