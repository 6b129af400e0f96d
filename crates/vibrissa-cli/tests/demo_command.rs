//! `vibrissa demo` through the real binary, and its files through `vibrissa localize`.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn the_demo_localizes_and_its_files_give_the_same_answer() {
    let folder = folder("demo-files");
    let place = |name: &str| folder.join(name).display().to_string();
    let demo = vibrissa(&["demo", "--seed", "4", "--out", &folder.display().to_string()]);
    assert_eq!(demo.code, Some(0), "{}", demo.stderr);
    for word in ["localized", "error against the truth", "mm", "vibrissa localize", "log.csv", "localization.svg"] {
        assert!(demo.stdout.contains(word), "{word}:\n{}", demo.stdout);
    }
    for name in ["contacts.csv", "trajectory.tum", "states.csv", "steps.csv", "localization.svg"] {
        assert!(folder.join(name).metadata().unwrap().len() > 100, "{name}");
    }
    let first = json(&std::fs::read_to_string(folder.join("result.json")).unwrap());
    let (log, map, truth) = (place("log.csv"), place("map.svg"), place("truth.tum"));
    let again = vibrissa(&["localize", &log, "--map", &map, "--truth", &truth, "--json"]);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert_eq!(again.stderr, "", "files of our own raise no doubt");
    let second = json(&again.stdout);
    assert_eq!(first["status"], "localized");
    assert_eq!(first["estimate"], second["estimate"]);
    assert!(second["truth"]["final_position_m"].as_f64().unwrap() < 2e-3, "{second}");
    assert!(second["truth"]["final_heading_rad"].as_f64().unwrap() < 1.0_f64.to_radians(), "{second}");
}

#[test]
fn a_seed_must_be_a_number() {
    let outcome = vibrissa(&["demo", "--seed", "many"]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("many"), "{}", outcome.stderr);
}
