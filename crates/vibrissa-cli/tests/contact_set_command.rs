//! `vibrissa contact-set` and `vibrissa preimage`, run as people run them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::fs;

fn json(args: &[&str]) -> serde_json::Value {
    let outcome = vibrissa(args);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    serde_json::from_str(&outcome.stdout).unwrap()
}

#[test]
fn readings_combine_to_the_contact_that_beam_force_gives() {
    let beam = json(&["beam", "force", "--force", "0.1", "--s-a", "60 mm", "--json"]);
    let found = json(&[
        "contact-set",
        "--sensor",
        "load",
        "--value",
        "100 mN",
        "--sensor",
        "strip",
        "--value",
        "6 cm",
        "--json",
    ]);
    let meeting = &found["meetings"][0];
    for key in ["x", "y"] {
        let (ours, theirs) = (meeting[key].as_f64().unwrap(), beam["solutions"][0][key].as_f64().unwrap());
        assert!((ours - theirs).abs() < 1e-10, "{key}: {ours} {theirs}");
    }
    assert_eq!(meeting["one_shape"], true);
    assert_eq!(found["region"]["components"], 1);
}

#[test]
fn files_are_written_and_numbers_stand_in_them() {
    let out = folder("contact-set");
    let outcome = vibrissa(&[
        "contact-set",
        "--sensor",
        "moment",
        "--value",
        "-5 mN m",
        "--tolerance",
        "5 %",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let table = fs::read_to_string(out.join("contact-set.csv")).unwrap();
    assert!(table.starts_with("set,branch,x,y,s_a,phi_a,force,moment,radius\nregion,0,"), "{table:.200}");
    assert!(fs::read_to_string(out.join("contact-set.svg")).unwrap().contains("moment -5.25 to -4.75 mN m"));
    let map = out.join("map.geojson");
    fs::write(&map, r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"role":"arena"},"geometry":{"type":"Polygon","coordinates":[[[0,0],[0.3,0],[0.3,0.2],[0,0.2],[0,0]]]}}]}"#).unwrap();
    let call = [
        "preimage",
        "--map",
        map.to_str().unwrap(),
        "--sensor",
        "load",
        "--value",
        "0.1 N",
        "--cell",
        "2 mm",
        "--heading-step",
        "2 deg",
    ];
    let found = json(&[&call[..], &["--out", out.to_str().unwrap(), "--heading", "0.6", "--json"]].concat());
    let area = found["area"].as_f64().unwrap();
    assert!(area > 0.01 && area < 0.3 * 0.2 * 1.1, "{area}");
    let boxes = fs::read_to_string(out.join("preimage.csv")).unwrap();
    assert!(boxes.starts_with("x_min,x_max,y_min,y_max,theta_min,theta_max\n"));
    let volume: f64 = boxes
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|c| c.parse().unwrap()).collect::<Vec<f64>>())
        .map(|b| (b[1] - b[0]) * (b[3] - b[2]) * (b[5] - b[4]))
        .sum();
    assert!((volume / found["volume"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    assert!(fs::read_to_string(out.join("preimage.svg")).unwrap().contains("<svg"));
}

#[test]
fn nothing_is_an_answer_and_faults_are_told() {
    let none = vibrissa(&["contact-set", "--sensor", "strip", "--value", "80 mm"]);
    assert_eq!(none.code, Some(0));
    assert!(none.stderr.contains("no contact explains"), "{}", none.stderr);
    for (args, word) in [
        (vec!["contact-set", "--sensor", "weight", "--value", "1"], "load, strip, slope, moment"),
        (vec!["contact-set", "--sensor", "load", "--value", "1 mm"], "--value"),
        (vec!["contact-set", "--sensor", "load", "--value", "2..1"], "lo not above hi"),
        (vec!["contact-set", "--sensor", "load", "--value", "inf"], "finite"),
        (vec!["contact-set", "--sensor", "load", "--sensor", "strip", "--value", "1"], "pairs"),
        (vec!["contact-set", "--sensor", "load", "--value", "1", "--tolerance=-1"], "--tolerance"),
        (vec!["contact-set", "--sensor", "load", "--value", "1", "--whisker", "w9"], "w0"),
        (vec!["preimage", "--map", "x.geojson", "--sensor", "load", "--value", "1", "--cell", "0"], "1e-5"),
    ] {
        let outcome = vibrissa(&args);
        assert_eq!(outcome.code, Some(2), "{args:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(word), "{args:?}: {}", outcome.stderr);
    }
    let missing = vibrissa(&["preimage", "--map", "missing.geojson", "--sensor", "load", "--value", "1"]);
    assert_eq!(missing.code, Some(1), "{}", missing.stderr);
}
