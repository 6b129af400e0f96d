//! Recordings and grid maps on the command line.

#![cfg(all(feature = "mcap", feature = "ros-map"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use serde_json::Value;

fn scenario(name: &str) -> String {
    format!("{}/../../scenarios/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_recorded_sweep_is_localized_as_its_csv_and_the_answer_is_recorded() {
    let folder = folder("mcap_command");
    let path = |name: &str| folder.join(name).display().to_string();
    let out = folder.display().to_string();
    let made = vibrissa(&["simulate", &scenario("arena_concave.toml"), "--mcap", "--out", &out]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    assert!(made.stdout.contains("log.mcap"), "{}", made.stdout);
    let map = scenario("maps/paper_arena.svg");
    let localized = |log: &str, more: &[&str]| {
        let (log, robot) = (path(log), path("robot.toml"));
        let call = [&["localize", &log, "--map", &map, "--robot", &robot, "--json"], more].concat();
        let outcome = vibrissa(&call);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        serde_json::from_str::<Value>(&outcome.stdout).unwrap()
    };
    let (one, other) = (localized("log.csv", &[]), localized("log.mcap", &["--mcap", "--out", &out]));
    assert_eq!(one["status"], other["status"]);
    for key in ["x", "y", "theta"] {
        let [a, b] = [&one, &other].map(|v| v["estimate"][key].as_f64().unwrap());
        assert!((a - b).abs() < 1e-6, "{key}: {a} and {b}");
    }
    let recording = std::fs::read(folder.join("localization.mcap")).unwrap();
    assert!(recording.starts_with(b"\x89MCAP0\r\n") && recording.ends_with(b"\x89MCAP0\r\n"));
    assert!(recording.len() < 8_000_000, "{}", recording.len());
}

#[test]
fn recordings_need_a_folder_and_other_containers_are_told_apart() {
    let usage = vibrissa(&["localize", "log.mcap", "--map", "map.yaml", "--mcap"]);
    assert_eq!(usage.code, Some(2), "{}", usage.stderr);
    let folder = folder("mcap_command_faults");
    let path = |name: &str| folder.join(name).display().to_string();
    std::fs::write(folder.join("map.yaml"), "image: lost.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n").unwrap();
    std::fs::write(folder.join("log.db3"), "SQLite format 3").unwrap();
    std::fs::write(folder.join("log.mcap"), "SQLite format 3").unwrap();
    for (log, map, words) in [
        ("log.mcap", path("map.yaml"), ["lost.pgm", "no such file"]),
        ("log.mcap", scenario("maps/pipe.svg"), ["log.mcap", "not an MCAP recording"]),
        ("log.db3", scenario("maps/pipe.svg"), ["log.db3", "ros2 bag convert"]),
        ("log.mcap", path("log.mcap"), ["log.mcap", "not an MCAP recording"]),
        ("log.mcap", path("room.pgm"), ["room.pgm", ".yaml file beside it"]),
    ] {
        let outcome = vibrissa(&["localize", &path(log), "--map", &map]);
        println!("{}", outcome.stderr);
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        assert!(words.iter().all(|word| outcome.stderr.contains(word)), "{}", outcome.stderr);
        assert!(outcome.stderr.contains("help:"), "{}", outcome.stderr);
    }
}
