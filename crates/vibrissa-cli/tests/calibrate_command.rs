//! `vibrissa calibrate` and `vibrissa contact --taps`, run as people run them.

#![allow(clippy::unwrap_used, reason = "a test helper that fails fails its test")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Small-deflection response of a cone of length 180 mm, tip ratio 1/3, with `EI / k_base` of 12 mm, to a turning base.
fn slope(distance: f64) -> f64 {
    8400.0 / (distance / (3.0 * (1.0 - distance / 0.27)) + 0.012)
}

/// Four taps at `distance`, 798 Hz, in the form of `format`.
fn recording(distance: f64, format: &str) -> String {
    let mut text = String::from(if format == "csv" { "t,ax\n" } else { "" });
    for i in 0..3192u32 {
        let t = f64::from(i) / 798.0;
        let since = t.rem_euclid(1.0) - 0.4;
        let ramp = slope(distance) * since.clamp(0.0, 0.05);
        let release = 1.0 - ((since - 0.08) / 0.02).clamp(0.0, 1.0);
        let noise = f64::from((i * 7919) % 17) - 8.0;
        let count = (33_000.0 + ramp * release + noise).round();
        let _ = match format {
            "csv" => writeln!(text, "{t},{count}"),
            _ => writeln!(text, "2024-04-17_11:48:{:09.6},{count},32768", t + f64::from(i * 37 % 11) * 6e-5),
        };
    }
    text
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[test]
fn taps_are_calibrated_and_found_again_with_either_format() {
    for format in ["csv", "ratatouille"] {
        let dir = folder(&format!("calibrate-taps-{format}"));
        let mut args = vec!["calibrate".to_owned(), "--taps".to_owned()];
        for mm in [60, 90, 120, 150] {
            let file = dir.join(format!("tap-{mm}.csv"));
            fs::write(&file, recording(f64::from(mm) * 1e-3, format)).unwrap();
            args.push(format!("{mm}mm={}", text(&file)));
        }
        args.extend(["--out".to_owned(), text(&dir.join("out")), "--json".to_owned()]);
        let outcome = vibrissa(&args.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let json: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
        assert!((json["distance"]["base_compliance"].as_f64().unwrap() - 0.012).abs() < 3e-4, "{json}");
        assert!(json["report"]["leave_one_out"]["max"].as_f64().unwrap() < 1.5e-3, "{json}");
        assert!(fs::read_to_string(dir.join("out/calibration.svg")).unwrap().contains("</svg>"));
        let (cal, unknown) = (text(&dir.join("out/cal.json")), text(&dir.join("unknown.csv")));
        fs::write(&unknown, recording(0.105, format)).unwrap();
        let outcome = vibrissa(&["contact", &unknown, "--taps", "--calibration", &cal, "--json"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let json: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
        let taps = json["taps"].as_array().unwrap();
        assert_eq!(taps.len(), 4, "{json}");
        for (index, tap) in taps.iter().enumerate() {
            assert!((tap["distance"].as_f64().unwrap() - 0.105).abs() < 8e-4, "{tap}");
            assert!((tap["t"].as_f64().unwrap() - 0.4 - index as f64).abs() < 3e-3, "{tap}");
        }
        let words = vibrissa(&["contact", &unknown, "--taps", "--calibration", &cal]).stdout;
        assert!(words.starts_with("4 taps") && words.contains("distance mm"), "{words}");
    }
}

#[test]
fn labelled_contacts_give_a_file_that_localize_could_read() {
    let dir = folder("calibrate-contacts");
    let mut log = String::from("x,y,ay\n");
    for i in 0..60 {
        // Small deflections of the paper's whisker: M = 3 EI y / x².
        let (x, y) = (0.05 + 0.0003 * f64::from(i), 0.0002 * f64::from(i % 20 - 10));
        let moment = 3.0 * 2.8886e-4 * y / (x * x);
        let _ = writeln!(log, "{x},{y},{}", 32_768.0 + 1e6 * moment);
    }
    log.push_str("0.05,0.001");
    fs::write(dir.join("log.csv"), log).unwrap();
    let (log, out) = (text(&dir.join("log.csv")), text(&dir.join("out")));
    let outcome = vibrissa(&["calibrate", &log, "--out", &out]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("lines without a reading, dropped: 1"), "{}", outcome.stderr);
    assert!(outcome.stdout.contains("moment from ay") && outcome.stdout.contains("bound"), "{}", outcome.stdout);
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(dir.join("out/cal.json")).unwrap()).unwrap();
    let half = json["moment"]["range"][1].as_f64().unwrap();
    let gain =
        json["moment"]["coefficients"][1].as_f64().unwrap() / half * json["moment"]["direction"][0].as_f64().unwrap();
    assert!((gain / 1e-6 - 1.0).abs() < 5e-3, "{gain}");
    assert_eq!(json["data"][0]["rows"], 60);
}

#[test]
fn contacts_in_space_calibrate_both_axes_of_the_chip() {
    let dir = folder("calibrate-plane");
    let mut log = String::from("x,y,z,ax,ay\n");
    for i in 0..96 {
        // Small deflections in sixteen directions; each moment moves both counts.
        let (x, r) = (0.06, 0.0006 * f64::from(1 + i / 16));
        let (sin, cos) = (f64::from(i % 16) * core::f64::consts::TAU / 16.0).sin_cos();
        let moment = 3.0 * 2.8886e-4 * r / (x * x);
        let counts = [100.0 + 1e6 * moment * cos - 3e5 * moment * sin, 2e5 * moment * cos + 9e5 * moment * sin];
        let _ = writeln!(log, "{x},{},{},{},{}", r * cos, r * sin, counts[0], counts[1]);
    }
    fs::write(dir.join("log.csv"), log).unwrap();
    let (log, out) = (text(&dir.join("log.csv")), text(&dir.join("out")));
    let outcome = vibrissa(&["calibrate", &log, "--out", &out]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let words = &outcome.stdout;
    assert!(words.contains("both transverse axes from ax,ay") && words.contains("in the plane x-y"), "{words}");
    let json: serde_json::Value = serde_json::from_str(&fs::read_to_string(dir.join("out/cal.json")).unwrap()).unwrap();
    assert!(json["moment"].is_null(), "{json}");
    assert!((json["plane"]["rest"][0].as_f64().unwrap() - 100.0).abs() < 5.0, "{json}");
    // The inverse of the cross-talk.
    let determinant = 1e6 * 9e5 + 3e5 * 2e5;
    for (k, expected) in [[9e5, 3e5], [-2e5, 1e6]].iter().enumerate() {
        for (j, expected) in expected.iter().enumerate() {
            let found = json["plane"]["directions"][k][j].as_f64().unwrap();
            assert!((found * determinant / 1e6 - expected / 1e6).abs() < 2e-2, "{found} {expected}");
        }
    }
    assert!(fs::read_to_string(dir.join("out/calibration.svg")).unwrap().contains("across it"));
}

#[test]
fn faulty_calls_and_data_say_what_to_do() {
    let dir = folder("calibrate-faults");
    let (flat, plain) = (dir.join("flat.csv"), dir.join("plain.csv"));
    fs::write(&flat, "t,ax\n0.0,5\n0.1,5\n0.2,5\n").unwrap();
    fs::write(&plain, "x,y\n0.05,0.01\n").unwrap();
    fs::write(dir.join("cal.json"), "{\"format\": \"vibrissa calibration\", \"version\": 1}").unwrap();
    let (flat, plain, cal) = (text(&flat), text(&plain), text(&dir.join("cal.json")));
    let cases: [(&[&str], i32, &str); 8] = [
        (&["calibrate"], 2, "required"),
        (&["calibrate", "--taps", "nonsense"], 2, "DISTANCE=FILE"),
        (&["calibrate", "--taps", &format!("900mm={flat}")], 2, "off the shaft"),
        (&["calibrate", "--taps", &format!("60mm={flat}")], 1, "too few known distances"),
        (&["calibrate", &plain], 1, "no readings"),
        (&["calibrate", &plain, "--format", "serail"], 2, "did you mean `serial`?"),
        (&["contact", &flat, "--calibration", &cal], 2, "--taps"),
        (&["contact", &flat, "--taps", "--calibration", &cal], 1, "does not tell distances"),
    ];
    for (args, code, words) in cases {
        let outcome = vibrissa(args);
        assert_eq!(outcome.code, Some(code), "{args:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(words), "{args:?}: {}", outcome.stderr);
    }
}

#[test]
fn an_echo_of_odometry_and_wrench_is_localized_like_our_own_log() {
    let dir = folder("calibrate-rostopic");
    let demo = text(&dir);
    assert_eq!(vibrissa(&["demo", "--out", &demo, "--json"]).code, Some(0));
    let log = fs::read_to_string(dir.join("log.csv")).unwrap();
    let mut lines = log.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|n| n.rsplit('.').next() == Some(name)).unwrap();
    let [t, x, y, theta, moment] = ["t", "x", "y", "theta", "moment"].map(column);
    let mut echo = String::new();
    for line in lines {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (secs, nsecs) = (cells[t].floor(), (cells[t].fract() * 1e9).round());
        let header = format!("header: \n  seq: 1\n  stamp: \n    secs: {secs}\n    nsecs: {nsecs}\n  frame_id: ''\n");
        let (z, w) = (0.5 * cells[theta]).sin_cos();
        let _ = write!(
            echo,
            "{header}child_frame_id: ''\npose: \n  pose: \n    position: \n      x: {}\n      y: {}\n      z: 0.0\n    \
             orientation: \n      x: 0.0\n      y: 0.0\n      z: {z}\n      w: {w}\n---\n\
             {header}wrench: \n  force: \n    x: 0.0\n    y: 0.0\n    z: 0.0\n  torque: \n    x: 0.0\n    y: 0.0\n    z: {}\n---\n",
            cells[x], cells[y], cells[moment]
        );
    }
    fs::write(dir.join("echo.txt"), echo).unwrap();
    let (map, truth, echo) = (text(&dir.join("map.svg")), text(&dir.join("truth.tum")), text(&dir.join("echo.txt")));
    let outcome = vibrissa(&["localize", &echo, "--format", "rostopic", "--map", &map, "--truth", &truth, "--json"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let json: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
    let ours: serde_json::Value = serde_json::from_str(&fs::read_to_string(dir.join("result.json")).unwrap()).unwrap();
    assert_eq!(json["status"], "localized");
    for key in ["x", "y", "theta"] {
        let difference = json["estimate"][key].as_f64().unwrap() - ours["estimate"][key].as_f64().unwrap();
        assert!(difference.abs() < 1e-6, "{key}: {difference}");
    }
}
