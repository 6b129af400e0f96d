//! `vibrissa plan` and `vibrissa explore` through the real binary.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use serde_json::Value;
use std::path::Path;

/// A short touch in the demo's arena, which leaves two places.
fn short_log(out: &Path) {
    let demo = vibrissa(&["demo", "--out", out.to_str().unwrap()]);
    assert_eq!(demo.code, Some(0), "{demo:?}");
    let log = std::fs::read_to_string(out.join("log.csv")).unwrap();
    let lines: Vec<&str> = log.lines().take(150).collect();
    std::fs::write(out.join("short.csv"), lines.join("\n") + "\n").unwrap();
}

#[test]
fn a_motion_is_told_from_a_log_and_from_its_result() {
    let out = folder("plan");
    short_log(&out);
    let path = |name: &str| out.join(name).display().to_string();
    let (log, map) = (path("short.csv"), path("map.svg"));
    let ran = vibrissa(&["plan", &log, "--map", &map, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    for words in ["parts 2 places into", "waypoints", "stop          where a whisker feels 4.62 mN m", "bit"] {
        assert!(ran.stdout.contains(words), "{words}: {}", ran.stdout);
    }
    let json: Value = serde_json::from_str(&std::fs::read_to_string(out.join("plan.json")).unwrap()).unwrap();
    assert_eq!((json["verdict"].as_str(), json["places"].as_u64()), (Some("parts"), Some(2)));
    let way = json["next"]["way"].as_f64().unwrap();
    assert!(way > 0.01 && way < 0.4, "{way}");
    // The file has the same waypoints, the first where the robot is.
    let csv = std::fs::read_to_string(out.join("motion.csv")).unwrap();
    assert!(csv.starts_with("x,y,theta\n0,0,0\n"), "{csv}");
    assert_eq!(csv.lines().count() - 1, json["next"]["waypoints"].as_array().unwrap().len());
    let figure = std::fs::read_to_string(out.join("plan.svg")).unwrap();
    as_in_localizations(&figure);
    for words in ["the next motion, from each place", "states that are left", "a place that explains the log"] {
        assert!(figure.contains(words), "{words}");
    }
    assert_eq!(figure.matches("class=\"badge-text\"").count(), 2);
    // From the result of a localization: the same places.
    assert_eq!(vibrissa(&["localize", &log, "--map", &map, "--out", out.to_str().unwrap()]).code, Some(0));
    let again = vibrissa(&["plan", &path("result.json"), "--map", &map, "--json"]);
    let again: Value = serde_json::from_str(&again.stdout).unwrap();
    assert_eq!((again["places"].as_u64(), &again["verdict"]), (Some(2), &json["verdict"]));
    // A budget is kept.
    let poor = vibrissa(&["plan", &log, "--map", &map, "--json", "--budget", "800"]);
    let poor: Value = serde_json::from_str(&poor.stdout).unwrap();
    assert!(poor["readings"].as_u64().unwrap() <= 800, "{poor}");
}

#[test]
fn what_cannot_be_planned_is_said() {
    let out = folder("plan-faults");
    let path = |name: &str, text: &str| {
        std::fs::write(out.join(name), text).unwrap();
        out.join(name).display().to_string()
    };
    let map = path("map.svg", vibrissa_arena());
    let empty = path("empty.json", r#"{"hypotheses": []}"#);
    let other = path("other.json", r#"{"places": 3}"#);
    let free = path("free.csv", "t,x,y,theta,moment\n0,0,0,0,0\n1,0.01,0,0,0\n");
    for (args, code, words) in [
        (vec!["plan", &empty, "--map", &map], 1, "tells no place"),
        (vec!["plan", &other, "--map", &map], 1, "no result of a localization"),
        (vec!["plan", &free, "--map", &map], 1, "tells no place"),
        (vec!["plan", &free, "--map", &map, "--longest", "0"], 2, "longest"),
        (vec!["plan", &free, "--map", &map, "--largest-moment", "-1"], 2, "moment"),
        (vec!["explore", "none.toml"], 1, "none.toml"),
    ] {
        let ran = vibrissa(&args);
        assert_eq!(ran.code, Some(code), "{args:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(words), "{args:?}: {}", ran.stderr);
    }
}

fn vibrissa_arena() -> &'static str {
    vibrissa::tasks::demo::ARENA_SVG
}

#[test]
fn a_simulated_robot_finds_out_that_its_room_is_symmetric() {
    let out = folder("explore");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/square.toml");
    let ran = vibrissa(&["explore", file.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(
        ran.stdout.starts_with("4 places left after ") && ran.stdout.contains("the map is symmetric"),
        "{}",
        ran.stdout
    );
    assert!(ran.stdout.contains("the 4 places"), "{}", ran.stdout);
    let json: Value = serde_json::from_str(&std::fs::read_to_string(out.join("explore.json")).unwrap()).unwrap();
    assert_eq!((json["ended"].as_str(), json["collided"].as_bool()), (Some("symmetric"), Some(false)));
    // It goes on from where it began to where it is.
    let rows = |name: &str| std::fs::read_to_string(out.join(name)).unwrap().lines().count();
    assert_eq!(rows("log.csv") - 1, rows("truth.tum"));
    assert!(json["way"].as_f64().unwrap() > 0.02 && json["motions"].as_array().unwrap()[0]["places"] == 4);
    let figure = std::fs::read_to_string(out.join("explore.svg")).unwrap();
    as_in_localizations(&figure);
    for words in
        ["where the robot chose a motion", "true path", "true pose at the end", "a place that explains the log"]
    {
        assert!(figure.contains(words), "{words}");
    }
    assert_eq!(figure.matches("class=\"badge-text\"").count(), 4);
}

/// The map of a figure is that of `localize`: the outside is shaded, and the legend names free space.
fn as_in_localizations(figure: &str) {
    let (ground, arena) = (figure.find("class=\"solid\""), figure.find("class=\"arena\""));
    assert!(ground.is_some() && ground < arena && figure.contains(">free space</text>"), "{ground:?} {arena:?}");
}

#[test]
fn an_interrupted_exploration_leaves_what_is_known_and_marks_it() {
    // What takes seconds: the search for places that explain a touch of many boundaries.
    let here = folder("explore-interrupted");
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/cluttered_room.toml");
    let out = here.join("out");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_vibrissa"));
    command.args(["explore", scenario.to_str().unwrap(), "--begin", "150 mm", "--out", out.to_str().unwrap()]);
    let child = command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    if output.status.code() == Some(0) {
        return println!("skipped: this machine was done before the interrupt");
    }
    assert_eq!(output.status.code(), Some(130), "{told}");
    assert!(told.contains("interrupted: the results are what was known by then"), "{told}");
    let json: Value = serde_json::from_str(&std::fs::read_to_string(out.join("explore.json")).unwrap()).unwrap();
    assert_eq!((json["ended"].as_str(), json["interrupted"].as_bool()), (Some("interrupted"), Some(true)));
    assert!(std::fs::read_to_string(out.join("explore.svg")).unwrap().contains("interrupted after"));
    let rows = |name: &str| std::fs::read_to_string(out.join(name)).unwrap().lines().count();
    assert!(rows("truth.tum") > 1 && rows("log.csv") - 1 == rows("truth.tum"));
}
