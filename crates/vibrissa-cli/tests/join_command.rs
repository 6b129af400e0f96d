//! `vibrissa join`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

mod common;

use common::{folder, vibrissa};
use vibrissa::tasks::demo;

#[test]
fn the_papers_serial_output_becomes_a_log() {
    let here = folder("join");
    let sweep = demo::sweep(1).unwrap();
    let serial: String =
        sweep.log.rows.iter().map(|row| format!("{:.2},0.00,12.00\r\n", 1e5 * row.readings[0])).collect();
    std::fs::write(here.join("serial.txt"), format!("Sensor ready\r\n{serial}12.3")).unwrap();
    let pose = |row: &vibrissa::flow::sensor_log::LogRow| {
        let pose = row.odom_from_robot;
        format!("{},{},{},{}\n", row.t, pose.x, pose.y, pose.theta)
    };
    let odometry: String = sweep.log.rows.iter().step_by(5).map(pose).collect();
    std::fs::write(here.join("odometry.csv"), format!("t,x,y,theta\n{odometry}")).unwrap();
    let path = |name: &str| here.join(name).to_str().unwrap().to_owned();
    for out in ["log.csv", "log.mcap"] {
        let joined = vibrissa(&[
            "join",
            &path("serial.txt"),
            &path("odometry.csv"),
            "--delay",
            "0 s",
            "--whisker",
            "w0",
            "--out",
            &path(out),
            "--json",
        ]);
        assert_eq!(joined.code, Some(0), "{}", joined.stderr);
        assert!(joined.stderr.contains("lines without a reading"), "{}", joined.stderr);
        let value: serde_json::Value = serde_json::from_str(&joined.stdout).unwrap();
        assert!(value["rows"].as_u64().unwrap() > 500 && value["estimate"].is_null(), "{value}");
        let log = vibrissa::read_log(path(out)).unwrap();
        assert!(log.channels.iter().any(|channel| channel.column() == "w0.bx"), "{:?}", log.channels);
        let (found, truth) = (&log.rows[300], &sweep.log.rows[300]);
        assert!((found.t - truth.t).abs() < 1e-6 && (found.odom_from_robot.x - truth.odom_from_robot.x).abs() < 1e-6);
        let bx = log.channels.iter().position(|channel| channel.column() == "w0.bx").unwrap();
        assert!((found.readings[bx] - 0.1 * truth.readings[0]).abs() < 1e-8);
    }
    let missing = vibrissa(&["join", &path("serial.txt"), &path("nowhere.csv")]);
    assert!(missing.code == Some(1) && missing.stderr.contains("no such file"), "{}", missing.stderr);
    let none = vibrissa(&["join", &path("odometry.csv"), &path("odometry.csv")]);
    assert!(none.code == Some(1) && none.stderr.contains("holds no readings"), "{}", none.stderr);
}
