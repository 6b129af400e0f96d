//! Faulty files through the real binary: exit code, and a message with file, line, value and the next step.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{Outcome, folder, vibrissa};
use std::path::Path;

const MAP: &str = r#"{"type": "FeatureCollection", "features": [
{"type": "Feature", "properties": {"role": "arena"}, "geometry": {"type": "Polygon", "coordinates":
[[[0.0, 0.0], [0.4, 0.0], [0.4, 0.3], [0.0, 0.3], [0.0, 0.0]]]}}
]}
"#;

const LOG: &str = "t,x,y,theta,moment\n\
0.000,0.000,0.0,0.0,0.0\n\
0.010,0.001,0.0,0.0,0.0002\n\
0.020,0.002,0.0,0.0,0.0003\n\
0.030,0.003,0.0,0.0,0.0004\n";

const ROBOT: &str = "[[whisker]]\nlength = 0.075\nflexural_rigidity = 2.8886e-4\n";

/// One faulty call: what differs from the good files, and what the message must hold.
struct Case {
    name: &'static str,
    map: (&'static str, Option<String>),
    log: Option<String>,
    robot: String,
    method: &'static str,
    code: i32,
    words: &'static [&'static str],
}

impl Default for Case {
    fn default() -> Self {
        Self {
            name: "",
            map: ("map.geojson", Some(MAP.into())),
            log: Some(LOG.into()),
            robot: ROBOT.into(),
            method: "probabilistic",
            code: 1,
            words: &[],
        }
    }
}

fn put(folder: &Path, name: &str, content: Option<&str>) -> String {
    let path = folder.join(name);
    if let Some(content) = content {
        std::fs::write(&path, content).unwrap();
    }
    path.to_str().unwrap().to_owned()
}

fn run(case: &Case) -> Outcome {
    let folder = folder(&format!("bad-input-{}", case.name));
    let map = put(&folder, case.map.0, case.map.1.as_deref());
    let log = put(&folder, "log.csv", case.log.as_deref());
    let robot = put(&folder, "robot.toml", Some(&case.robot));
    vibrissa(&["localize", &log, "--map", &map, "--robot", &robot, "--method", case.method])
}

fn check(case: &Case) {
    let outcome = run(case);
    assert_eq!(outcome.code, Some(case.code), "{}: {outcome:?}", case.name);
    for word in case.words {
        assert!(outcome.stderr.contains(word), "{}: `{word}` is missing in:\n{}", case.name, outcome.stderr);
    }
    if case.code == 1 {
        assert!(outcome.stderr.contains("error: "), "{}: {}", case.name, outcome.stderr);
        assert!(outcome.stderr.contains("help: "), "{}: {}", case.name, outcome.stderr);
        assert!(outcome.stdout.is_empty(), "{}: {}", case.name, outcome.stdout);
    }
}

fn log(from: &str, to: &str) -> Option<String> {
    assert!(LOG.contains(from), "{from}");
    Some(LOG.replacen(from, to, 1))
}

#[test]
fn a_missing_log_is_named() {
    check(&Case { name: "missing-log", log: None, words: &["log.csv"], ..Case::default() });
}

#[test]
fn a_missing_map_is_named() {
    check(&Case { name: "missing-map", map: ("map.geojson", None), words: &["map.geojson"], ..Case::default() });
}

#[test]
fn a_line_cut_in_the_middle_is_named() {
    let cut = log("0.010,0.001,0.0,0.0,0.0002", "0.010,0.001,0.0");
    check(&Case { name: "cut-line", log: cut, words: &["log.csv:3", "3"], ..Case::default() });
}

#[test]
fn not_a_number_is_named() {
    for (name, value) in [("nan", "NaN"), ("inf", "inf"), ("word", "wall")] {
        let words: &[&str] = match name {
            "nan" => &["log.csv:4", "NaN", "moment"],
            "inf" => &["log.csv:4", "inf", "moment"],
            _ => &["log.csv:4", "wall", "moment"],
        };
        check(&Case { name, log: log("0.0003", value), words, ..Case::default() });
    }
}

#[test]
fn a_clock_that_stands_or_runs_back_is_named() {
    let back = log("0.020,", "0.005,");
    check(&Case { name: "clock-back", log: back, words: &["log.csv:4", "0.005", "0.01"], ..Case::default() });
    let stands = log("0.020,", "0.010,");
    check(&Case { name: "clock-stands", log: stands, words: &["log.csv:4", "0.01"], ..Case::default() });
}

#[test]
fn degrees_where_radians_are_due_draw_a_warning() {
    let degrees = Some(LOG.replace("0.020,0.002,0.0,0.0", "0.020,0.002,0.0,90.0"));
    let outcome = run(&Case { name: "degrees", log: degrees, ..Case::default() });
    for word in ["warning: ", "4", "90", "rad"] {
        assert!(outcome.stderr.contains(word), "`{word}` is missing in:\n{}", outcome.stderr);
    }
}

#[test]
fn a_moment_beyond_any_shape_is_named() {
    let strong = log("0.0003", "0.5");
    // The probabilistic method takes single ones for false readings.
    let method = "deterministic";
    check(&Case { name: "strong", method, log: strong, words: &["log.csv:4", "0.5", "allowed: "], ..Case::default() });
}

#[test]
fn a_polygon_that_crosses_itself_is_named() {
    let bow = MAP.replace("[0.4, 0.0], [0.4, 0.3]", "[0.4, 0.3], [0.4, 0.0]");
    let map = ("map.geojson", Some(bow));
    check(&Case { name: "crossing", map, words: &["map.geojson:", "cross", "0.2"], ..Case::default() });
}

#[test]
fn an_empty_map_is_named() {
    let map = ("map.geojson", Some(r#"{"type": "FeatureCollection", "features": []}"#.into()));
    check(&Case { name: "empty-map", map, words: &["map.geojson", "no features"], ..Case::default() });
}

#[test]
fn a_map_that_is_no_json_is_named_with_its_line() {
    let map = ("map.geojson", Some(MAP.replace("\"geometry\":", "\"geometry\"")));
    check(&Case { name: "no-json", map, words: &["map.geojson:2"], ..Case::default() });
}

#[test]
fn an_svg_without_roles_is_named_with_how_to_set_them() {
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"400mm\" height=\"300mm\" viewBox=\"0 0 400 300\">\n\
               <rect id=\"rect42\" width=\"400\" height=\"300\"/>\n</svg>\n";
    let map = ("map.svg", Some(svg.into()));
    check(&Case { name: "svg-roles", map, words: &["map.svg", "rect42", "arena", "class"], ..Case::default() });
}

#[test]
fn an_unknown_key_is_named_with_the_nearest_one() {
    let robot = ROBOT.replace("length", "lenght");
    check(&Case { name: "unknown-key", robot, words: &["robot.toml:2", "lenght", "length"], ..Case::default() });
}

#[test]
fn a_robot_value_out_of_range_is_named_with_the_range() {
    let robot = ROBOT.replace("length = 0.075", "length = -0.075");
    let words = &["robot.toml:2", "-0.075", "allowed: "];
    check(&Case { name: "robot-range", robot, words, ..Case::default() });
}

#[test]
fn a_column_without_its_whisker_is_warned_about() {
    let text = LOG.replace("moment", "w0.moment,w9.moment").replace("0.0\n", "0.0,0\n");
    let text = ["0.0002", "0.0003", "0.0004"].iter().fold(text, |t, v| t.replace(v, &format!("{v},0")));
    let outcome = run(&Case { name: "stray-column", log: Some(text), ..Case::default() });
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("`w9.moment` is not used"), "{}", outcome.stderr);
}

#[test]
fn a_map_of_kilometres_is_refused_with_a_spacing() {
    let map = ("map.geojson", Some(MAP.replace("0.4", "400.0").replace("0.3", "300.0")));
    for (method, words) in
        [("deterministic", &["1400", "--boundary-spacing"]), ("probabilistic", &["1400", "--within"])]
    {
        check(&Case { name: "kilometres", map: map.clone(), method, words, ..Case::default() });
    }
}
