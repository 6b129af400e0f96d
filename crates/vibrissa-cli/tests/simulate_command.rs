//! `vibrissa simulate` through the real binary.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use serde_json::Value;
use std::path::Path;

fn scenario(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name).display().to_string()
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

fn header(text: &str) -> &str {
    text.lines().next().unwrap()
}

#[test]
fn a_scenario_leaves_its_files_and_they_are_localized() {
    for name in ["arena_convex", "square"] {
        let folder = folder(&format!("simulate-{name}"));
        let out = folder.display().to_string();
        let outcome = vibrissa(&["simulate", &scenario(&format!("{name}.toml")), "--out", &out]);
        assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
        for word in ["rows in contact", "onset", "mN m", "simulate.svg", "vibrissa localize"] {
            assert!(outcome.stdout.contains(word), "{word}:\n{}", outcome.stdout);
        }
        let rows = read(&folder, "log.csv").lines().count() - 1;
        assert_eq!(header(&read(&folder, "log.csv")), "t,x,y,theta,moment");
        assert_eq!(read(&folder, "truth.tum").lines().count(), rows);
        assert_eq!(header(&read(&folder, "contacts.csv")), "t,x,y,s_a,part,grip");
        let figure = read(&folder, "simulate.svg");
        assert!(figure.starts_with("<svg") && figure.contains("moment at the base, mN m") && !figure.contains("NaN"));

        // The command that the summary proposes, as it stands.
        let command = outcome.stdout.lines().find(|line| line.trim().starts_with("vibrissa localize")).unwrap();
        let mut words: Vec<&str> = command.split_whitespace().skip(1).collect();
        // Its robot is what its file says.
        words.extend(["--undeclared", "none"]);
        if name == "square" {
            words.extend(["--method", "probabilistic"]);
            let told = vibrissa(&words);
            assert_eq!(told.stdout.matches("; along ").count(), 4, "{told:?}");
        }
        words.push("--json");
        let answer = vibrissa(&words);
        assert_eq!((answer.code, answer.stderr.as_str()), (Some(0), ""), "{answer:?}");
        let answer: Value = serde_json::from_str(&answer.stdout).unwrap();
        if name == "square" {
            assert_eq!(answer["status"], "ambiguous");
            let places = answer["hypotheses"].as_array().unwrap();
            assert_eq!(places.len(), 4, "one place on each wall");
            for place in places {
                let ridge = place["ridge"].as_array().unwrap();
                assert!(ridge.len() > 5 && ridge.iter().all(|pose| pose.as_array().unwrap().len() == 3), "{place}");
            }
        } else {
            assert_eq!(answer["status"], "localized");
            assert!(answer["hypotheses"][0].get("ridge").is_none(), "{answer}");
            assert!(answer["truth"]["final_position_m"].as_f64().unwrap() < 1e-3, "{answer}");
        }
    }
}

#[test]
fn the_dump_holds_shapes_and_exact_moments() {
    let folder = folder("simulate-dump");
    let out = folder.display().to_string();
    let outcome = vibrissa(&["simulate", &scenario("pipe.toml"), "--out", &out, "--dump", "--json"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let summary: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let rows = summary["rows"].as_u64().unwrap() as usize;
    assert_eq!(summary["recorded_rows"], summary["rows"]);
    assert_eq!(summary["whiskers"][1]["name"], "inner");
    assert!(summary["whiskers"][1]["strongest_moment"].as_f64().unwrap() < -1e-3);
    let shapes = read(&folder, "shapes.csv");
    assert_eq!(header(&shapes), "t,whisker,s,x,y");
    assert_eq!(shapes.lines().count(), 1 + rows * 2 * 17, "17 points of two whiskers a row");
    let last: Vec<&str> = shapes.lines().last().unwrap().split(',').collect();
    assert_eq!((last[1], last[2]), ("inner", "0.075"));
    let exact = read(&folder, "exact.csv");
    assert_eq!((header(&exact), exact.lines().count()), ("t,outer.moment,inner.moment", rows + 1));
    assert_eq!(header(&read(&folder, "log.csv")), "t,x,y,theta,outer.moment,inner.moment");
    assert_eq!(header(&read(&folder, "contacts.csv")), "t,x,y,whisker,s_a,part,grip");
}

#[test]
fn the_seed_decides_the_noise_and_nothing_else() {
    let runs: Vec<(String, String)> = ["3", "3", "4"]
        .iter()
        .enumerate()
        .map(|(index, seed)| {
            let folder = folder(&format!("simulate-seed-{index}"));
            let out = folder.display().to_string();
            let outcome = vibrissa(&["simulate", &scenario("arena_straight.toml"), "--out", &out, "--seed", seed]);
            assert_eq!(outcome.code, Some(0), "{outcome:?}");
            (read(&folder, "log.csv"), read(&folder, "truth.tum"))
        })
        .collect();
    assert_eq!(runs[0], runs[1]);
    assert_ne!(runs[0].0, runs[2].0);
    assert_eq!(runs[0].1, runs[2].1);
}

#[test]
fn counts_and_a_serial_line_are_written_where_asked() {
    let folder = folder("simulate-serial");
    let text = "map = { arena = [[0, 0], [0.6, 0], [0.6, 0.4], [0, 0.4]] }\n[[whisker]]\nmount = [0, 0, \"128 deg\"]\n\
                [sensing]\ncolumns = [\"flux\", \"counts\"]\nserial = \"single\"\n\
                [path]\nwaypoints = [[0.15, 0.335, 0], [0.2, 0.355, 0], [0.25, 0.355, 0]]\n";
    let file = folder.join("scenario.toml");
    std::fs::write(&file, text).unwrap();
    let out = folder.join("out");
    let outcome = vibrissa(&["simulate", &file.display().to_string(), "--out", &out.display().to_string()]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(!outcome.stdout.contains("vibrissa localize"), "there are no moments to localize by");
    let (log, serial) = (read(&out, "log.csv"), read(&out, "serial.txt"));
    assert_eq!(header(&log), "t,x,y,theta,bx,by,bz,ax,ay,az");
    assert_eq!(serial.lines().count(), log.lines().count() - 1);
    assert!(read(&out, "map.geojson").contains("[0.6, 0.4]"));
    assert!(read(&out, "simulate.svg").contains("chip"), "the figure shows the field");
}

#[test]
fn faults_are_told_with_their_place_and_the_right_exit_code() {
    let folder = folder("simulate-faults");
    let file = folder.join("scenario.toml");
    let path = file.display().to_string();
    let map = "map = { arena = [[0, 0], [0.6, 0], [0.6, 0.4], [0, 0.4]] }\n";
    for (text, words) in [
        (
            "[path]\nwaypoints = [[0.3, 0.2], [0.7, 0.2]]\n",
            ["scenario.toml:3", "through a wall", "t = 2.000 s", "0.6000"],
        ),
        (
            "[path]\nrate = 1e9\nwaypoints = [[0.3, 0.2], [0.4, 0.2]]\n",
            ["scenario.toml:4", "rows", "2000000", "help: "],
        ),
        ("[path]\nspeed = -1\nwaypoints = [[0.3, 0.2], [0.4, 0.2]]\n", ["scenario.toml:3", "-1", "above 0", "help: "]),
    ] {
        std::fs::write(&file, format!("{map}{text}")).unwrap();
        let outcome = vibrissa(&["simulate", &path, "--out", &folder.join("out").display().to_string()]);
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        for word in words {
            assert!(outcome.stderr.contains(word), "{word}:\n{}", outcome.stderr);
        }
        assert!(!folder.join("out").exists(), "nothing is written");
    }
    let missing = vibrissa(&["simulate", "no-such.toml"]);
    assert_eq!(missing.code, Some(1));
    assert!(missing.stderr.contains("no-such.toml") && missing.stderr.contains("help: "), "{}", missing.stderr);
    assert_eq!(vibrissa(&["simulate"]).code, Some(2));
    assert_eq!(vibrissa(&["simulate", &path, "--seed", "many"]).code, Some(2));
    assert_eq!(vibrissa(&["simulate", &path, "--dump"]).code, Some(2), "a dump needs a folder");
}

const SENSES: &str = r#"
[map]
arena = [[0, -0.02], [0.2, -0.02], [0.25, 0], [0.4, 0], [0.4, 0.13], [0.25, 0.13], [0.2, 0.15], [0, 0.15]]

[[whisker]]
name = "left"
mount = [0, "10 mm", "115 deg"]

[path]
start = ["140 mm", "65 mm"]

[[path.leg]]
kind = "line"
to = ["300 mm", "65 mm"]
speed = "250 mm/s"

[sensing]
columns = ["force", "slope", "strip"]
strip_cell = "5 mm"
"#;

#[test]
fn other_virtual_sensors_are_logged_filtered_and_localized() {
    let folder = folder("simulate-senses");
    let (out, scenario) = (folder.display().to_string(), folder.join("senses.toml"));
    std::fs::write(&scenario, SENSES).unwrap();
    let simulated = vibrissa(&["simulate", scenario.to_str().unwrap(), "--out", &out]);
    assert_eq!((simulated.code, simulated.stderr.as_str()), (Some(0), ""), "{simulated:?}");
    assert_eq!(header(&read(&folder, "log.csv")), "t,x,y,theta,force,slope,strip_lo,strip_hi");
    let file = |name: &str| folder.join(name).display().to_string();
    let (log, map, robot) = (file("log.csv"), file("map.geojson"), file("robot.toml"));
    let filtered = vibrissa(&["contact", &log, "--robot", &robot, "--filter", "--json"]);
    assert_eq!(filtered.code, Some(0), "{filtered:?}");
    let told: Value = serde_json::from_str(&filtered.stdout).unwrap();
    assert!(told["contacts"].as_array().unwrap().len() > 3, "{told}");
    let found =
        vibrissa(&["localize", &log, "--map", &map, "--robot", &robot, "--truth", &file("truth.tum"), "--json"]);
    assert_eq!(found.code, Some(0), "{found:?}");
    let found: Value = serde_json::from_str(&found.stdout).unwrap();
    assert!(found["status"] == "localized" || found["status"] == "ambiguous", "{found}");
}
