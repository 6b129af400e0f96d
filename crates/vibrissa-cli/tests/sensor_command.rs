//! `vibrissa sensor` through the real binary.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};

#[test]
fn a_design_is_told_in_words_as_json_and_drawn() {
    let out = folder("sensor-design");
    let ran = vibrissa(&["sensor", "design", "--distance", "5 mm", "--out", out.to_str().unwrap()]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(
        ran.stdout.contains("5.0 mm from the magnet") && ran.stdout.contains("sensor-design.svg"),
        "{}",
        ran.stdout
    );
    assert!(std::fs::read_to_string(out.join("sensor-design.svg")).unwrap().contains("1.86 uN m a count"));
    let json: serde_json::Value =
        serde_json::from_str(&vibrissa(&["sensor", "design", "--chip", "tle493d", "--json"]).stdout).unwrap();
    assert!(json["share"].as_f64().unwrap() < 0.1, "{json}");
}

#[cfg(all(unix, feature = "live"))]
#[test]
fn heads_that_are_not_there_and_calibrations_that_do_not_fit_are_told() {
    let dir = folder("sensor-head");
    let file = dir.join("cal.json");
    std::fs::write(&file, r#"{"format": "vibrissa calibration", "version": 1}"#).unwrap();
    let cal = file.to_str().unwrap();
    let cases: [(&[&str], i32, &str); 5] = [
        (&["sensor", "head", "/dev/no-such-port"], 1, "cannot open the port"),
        (&["sensor", "head", "/dev/no-such-port", "--load", cal], 1, "does not turn readings into moments"),
        (&["sensor", "head", "/dev/no-such-port", "--load", "none.json"], 1, "none.json"),
        (&["sensor", "head", "/dev/no-such-port", "--tare", "0"], 2, "--tare"),
        (&["sensor", "head", "/dev/no-such-port", "--load", cal, "--unload"], 2, "--unload"),
    ];
    for (args, code, words) in cases {
        let ran = vibrissa(args);
        assert_eq!(ran.code, Some(code), "{args:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(words), "{args:?}: {}", ran.stderr);
    }
}
