//! What `localize` leaves behind, whatever its verdict.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use serde_json::Value;
use std::fs;
use std::path::Path;

const MAP: &str = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"role": "arena"},
"geometry": {"type": "Polygon", "coordinates": [[[0, 0], [0.4, 0], [0.3, 0.3], [0, 0.2], [0, 0]]]}}]}"#;

const LOG: &str = "t,x,y,theta,moment\n0,0,0,0,0\n0.01,0.001,0,0,0.0010\n0.02,0.002,0,0,0.0012\n";

const TRUTH: &str = "0 0.1 0.1 0 0 0 0 1\n0.01 0.101 0.1 0 0 0 0 1\n0.02 0.102 0.1 0 0 0 0 1\n";

const FILES: [&str; 5] = ["localization.svg", "result.json", "states.csv", "steps.csv", "trajectory.tum"];

fn localize(folder: &Path, more: &[&str]) -> common::Outcome {
    let put = |name: &str, text: &str| {
        fs::write(folder.join(name), text).unwrap();
        folder.join(name).to_str().unwrap().to_owned()
    };
    let (log, map, truth) = (put("log.csv", LOG), put("map.geojson", MAP), put("truth.tum", TRUTH));
    let args: Vec<&str> =
        ["localize", &log, "--map", &map, "--truth", &truth].into_iter().chain(more.iter().copied()).collect();
    let outcome = vibrissa(&args);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    outcome
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn check_result(result: &Value) {
    assert!(["localized", "ambiguous", "inconsistent", "no_contact"].contains(&result["status"].as_str().unwrap()));
    assert_eq!(result["method"], "probabilistic");
    assert_eq!(keys(&result["runtime"]), ["p50_us", "p99_us", "total_s", "updates"]);
    assert!(result["runtime"]["total_s"].as_f64().unwrap() >= 0.0);
    for hypothesis in result["hypotheses"].as_array().unwrap() {
        let bounds = ["theta", "theta_max", "theta_min", "weight", "x", "x_max", "x_min", "y", "y_max", "y_min"];
        assert_eq!(keys(hypothesis), bounds);
        for axis in ["x", "y"] {
            let number = |key: &str| hypothesis[key].as_f64().unwrap();
            assert!(number(&format!("{axis}_min")) <= number(axis) && number(axis) <= number(&format!("{axis}_max")));
        }
    }
    for event in result["events"].as_array().unwrap() {
        assert_eq!(keys(event), ["detail", "kind", "t"]);
    }
}

#[test]
fn the_folder_holds_the_promised_files_and_nothing_else() {
    let inputs = folder("outputs");
    let out = inputs.join("made/here");
    // Twice: the second run replaces the first one's files.
    for _ in 0..2 {
        let outcome = localize(&inputs, &["--out", out.to_str().unwrap()]);
        assert!(outcome.stdout.contains("localization.svg"), "{}", outcome.stdout);
        assert_eq!(names(&out), FILES);
    }
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    let result: Value = serde_json::from_str(&read("result.json")).unwrap();
    let promised =
        ["consistency", "estimate", "events", "hypotheses", "method", "nuisances", "runtime", "status", "unsure"];
    assert_eq!(keys(&result), promised);
    check_result(&result);
    assert!(read("states.csv").starts_with("x_min,x_max,y_min,y_max,theta_min,theta_max\n"));
    assert!(read("steps.csv").starts_with("t,components,area_m2,volume\n"));
    assert!(read("localization.svg").starts_with("<svg ") && read("localization.svg").ends_with("</svg>\n"));
    for line in read("trajectory.tum").lines() {
        assert_eq!(line.split(' ').filter(|field| field.parse::<f64>().unwrap().is_finite()).count(), 8, "{line}");
    }
}

#[test]
fn json_is_the_result_alone_on_standard_output() {
    let outcome = localize(&folder("outputs-json"), &["--json"]);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    check_result(&result);
    assert!(outcome.stderr.is_empty(), "{}", outcome.stderr);
}

#[test]
fn people_read_the_verdict_first_and_where_files_would_go() {
    let inputs = folder("outputs-words");
    let outcome = localize(&inputs, &[]);
    let verdict = outcome.stdout.lines().next().unwrap();
    assert!(["localized: ", "ambiguous: ", "inconsistent: ", "no contact: "].iter().any(|w| verdict.starts_with(w)));
    assert!(outcome.stdout.contains("3 rows") && outcome.stdout.contains("--out DIR"), "{}", outcome.stdout);
    assert_eq!(names(&inputs), ["log.csv", "map.geojson", "truth.tum"], "nothing is written without --out");
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let inputs = folder("outputs-blocked");
    let file = inputs.join("file");
    fs::write(&file, "in the way").unwrap();
    let put = |name: &str, text: &str| fs::write(inputs.join(name), text).unwrap();
    put("log.csv", LOG);
    put("map.geojson", MAP);
    let path = |name: &str| inputs.join(name).to_str().unwrap().to_owned();
    let outcome = vibrissa(&["localize", &path("log.csv"), "--map", &path("map.geojson"), "--out", &path("file")]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains(&path("file")) && outcome.stderr.contains("help: "), "{}", outcome.stderr);
}
