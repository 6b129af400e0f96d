//! `vibrissa join`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
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

/// A row of odometry that cannot be right is named by file, line and value; it was dropped without a word before.
#[test]
fn bad_rows_of_odometry_are_named() {
    let here = folder("join-bad");
    let path = |name: &str| here.join(name).to_str().unwrap().to_owned();
    let readings: String =
        (0..200).map(|i| format!("{},{}\n", f64::from(i) * 0.01, 1e-3 + 1e-6 * f64::from(i))).collect();
    std::fs::write(path("readings.csv"), format!("t,moment\n{readings}")).unwrap();
    let good: Vec<String> =
        (0..60).map(|i| format!("{},{},0.2,0.1", f64::from(i) * 0.05, 0.01 * f64::from(i))).collect();
    let join = |name: &str| vibrissa(&["join", &path("readings.csv"), &path(name), "--delay", "0 s", "--json"]);
    let write = |name: &str, header: &str, rows: &[String]| {
        std::fs::write(path(name), format!("{header}{}\n", rows.join("\n"))).unwrap();
    };
    write("good.csv", "# from the base\n\nt, x, y, theta\n", &good);
    let whole = join("good.csv");
    assert_eq!(whole.code, Some(0), "{}", whole.stderr);
    for (row, words) in [
        ("2.05,0.41,oops,0.1", vec!["y is not a number", "\"oops\""]),
        ("2.05,0.41,,0.1", vec!["y is empty", "a number"]),
        ("2.05,nan,0.2,0.1", vec!["x is not a finite number", "\"nan\""]),
        ("2.05,0.41,0.2,inf", vec!["theta is not a finite number", "\"inf\""]),
        ("2.05,4e9,0.2,0.1", vec!["x is out of range", "-1e8 to 1e8 m"]),
        ("2.05,0.41,0.2", vec!["another number of fields", "3", "4, as the header names"]),
        ("2.0,0.41,0.2,0.1", vec!["t does not increase", "2 s after 2 s", "above 2 s"]),
        ("2.05,\"0.41,0.2,0.1", vec!["quote"]),
    ] {
        let mut rows = good.clone();
        row.clone_into(&mut rows[41]);
        write("bad.csv", "t,x,y,theta\n", &rows);
        let told = join("bad.csv");
        assert_eq!(told.code, Some(1), "{row}: {}", told.stderr);
        assert!(told.stderr.contains("bad.csv:43: "), "{row}: {}", told.stderr);
        assert!(words.iter().all(|word| told.stderr.contains(word)), "{row}: {}", told.stderr);
        assert!(told.stderr.contains("help: "), "{row}: {}", told.stderr);
    }
    write("nameless.csv", "t,x,y,heading\n", &good);
    let told = join("nameless.csv");
    assert!(told.code == Some(1) && told.stderr.contains("no column `theta`"), "{}", told.stderr);
    // A trajectory names its lines, too.
    let poses: Vec<String> = (0..60)
        .map(|i| format!("{} {} 0.2 0 0 0 0 {}", f64::from(i) * 0.05, 0.01 * f64::from(i), if i == 40 { 7 } else { 1 }))
        .collect();
    write("bad.tum", "", &poses);
    let told = join("bad.tum");
    assert!(told.code == Some(1) && told.stderr.contains("bad.tum:41: "), "{}", told.stderr);
}
