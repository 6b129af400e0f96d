//! `vibrissa contact` and `vibrissa profile` through the real binary.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::fmt::Write;
use std::path::Path;
use vibrissa::beam::{Load, Whisker, point_mode};
use vibrissa::plane::Vec2;

/// A base that moves across the whisker past a peg at (50, 2) mm: 8 mm of contact.
fn peg_log() -> String {
    let mut text = String::from("t,x,y,theta,moment\n");
    for i in 0..200 {
        let y = 4e-3 - 5e-5 * f64::from(i);
        let local = Vec2::new(0.05, 2e-3 - y);
        let bends = point_mode(&Whisker::default(), local, Load::Normal).unwrap();
        let moment = if local.y > 0.0 { bends.first().map_or(0.0, |b| b.moment) } else { 0.0 };
        writeln!(text, "{},0,{y},0,{moment}", f64::from(i) / 300.0).unwrap();
    }
    text
}

fn put(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_peg_is_found_and_written() {
    let folder = folder("contact_peg");
    let log = put(&folder, "log.csv", &peg_log());
    let out = folder.join("out");
    let ran = vibrissa(&["contact", &log, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.stdout.contains("side contact at (50.0"), "{}", ran.stdout);
    let table = std::fs::read_to_string(out.join("contacts.csv")).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    for line in table.lines().skip(1).filter(|line| line.contains(",side,")) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |name: &str| cells[column(name)].parse::<f64>().unwrap();
        assert!((number("x_odom") - 0.05).abs() < 1e-4 && (number("y_odom") - 0.002).abs() < 1e-4, "{line}");
        assert!(number("distance_min") <= number("distance") && number("distance") <= number("distance_max"));
        // The onset is known to a row or two: early on that is much of the base's motion.
        assert!(number("y") < 2e-3 || (number("solomon") - 0.05).abs() < 3e-3, "{line}");
        assert_eq!(cells.len(), header.len());
    }
    assert!(std::fs::read_to_string(out.join("contacts.svg")).unwrap().starts_with("<svg"));
    let ran = vibrissa(&["contact", &log, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    assert!(json["side"].as_u64().unwrap() > 40 && json["events"][0]["kind"] == "contact", "{}", ran.stdout);
}

/// A base that moves past a point at (50, 3, -2) mm, then a tip that slides around.
fn space_log() -> String {
    let mut text = String::from("t,x,y,theta,moment,across\n");
    for i in 0..90 {
        let y = -1e-4 * f64::from(i);
        let (left, up) = (3e-3 - y, -2e-3);
        let r = left.hypot(up);
        let moment = point_mode(&Whisker::default(), Vec2::new(0.05, r), Load::Normal).unwrap()[0].moment;
        writeln!(text, "{},0,{y},0,{},{}", f64::from(i) / 100.0, moment * left / r, moment * up / r).unwrap();
    }
    for i in 0..90 {
        let t = f64::from(i);
        let moments = if i < 9 { [0.0; 2] } else { [5e-3 * (0.02 * t).cos(), 5e-3 * (0.02 * t).sin()] };
        writeln!(text, "{},{},0,0,{},{}", 1.0 + t / 100.0, 1e-4 * t, moments[0], moments[1]).unwrap();
    }
    text
}

#[test]
fn contacts_in_space_are_found_written_and_warned_of() {
    let folder = folder("contact_space");
    let log = put(&folder, "log.csv", &space_log());
    let out = folder.join("out");
    let ran = vibrissa(&["contact", &log, "--space", "--out", out.to_str().unwrap()]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.stdout.contains("(50.0") && ran.stdout.contains("slides_around"), "{}", ran.stdout);
    assert!(ran.stderr.contains("out of the plane") && ran.stderr.contains("goes around"), "{}", ran.stderr);
    let figure = std::fs::read_to_string(out.join("space.svg")).unwrap();
    assert_eq!(figure.matches("<polyline").count(), 6, "three plots of two touches, and nothing between these");
    let table = std::fs::read_to_string(out.join("space.csv")).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let mut sides = 0;
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), header.len());
        let number = |name: &str| cells[header.iter().position(|h| *h == name).unwrap()].parse::<f64>().unwrap();
        for name in ["x", "r", "angle"] {
            let [lo, value, hi] = [format!("{name}_min"), name.to_owned(), format!("{name}_max")].map(|n| number(&n));
            assert!(lo <= value && value <= hi, "{line}");
        }
        if cells[2] == "side" {
            sides += 1;
            assert!((number("x_odom") - 0.05).abs() < 1e-5 && (number("z") + 0.002).abs() < 1e-5, "{line}");
        }
    }
    assert!(sides > 40, "{sides}");
    let json: serde_json::Value =
        serde_json::from_str(&vibrissa(&["contact", &log, "--space", "--json"]).stdout).unwrap();
    assert_eq!(json["side"].as_u64(), Some(sides));
    assert!(json["contacts"][0]["angle"].as_f64().unwrap() < 0.0);
    let planar = put(&folder, "planar.csv", &peg_log());
    let refused = vibrissa(&["contact", &planar, "--space"]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("across") && refused.stderr.contains("planar.csv"), "{}", refused.stderr);
}

#[test]
fn an_outline_is_written_and_compared() {
    let folder = folder("profile_demo");
    let demo = folder.join("demo");
    assert_eq!(vibrissa(&["demo", "--out", demo.to_str().unwrap(), "--json"]).code, Some(0));
    let out = folder.join("out");
    let [log, map] = ["log.csv", "map.svg"].map(|name| demo.join(name).to_str().unwrap().to_owned());
    let ran = vibrissa(&["profile", &log, "--truth", &map, "--json", "--out", out.to_str().unwrap()]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let json: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let error = |kind: &str| json["truth"][kind]["mean_m"].as_f64().unwrap();
    // The demo's odometry begins at the origin, so that the outline is the map's only up to a motion.
    assert!(error("shape") <= error("absolute"), "{}", ran.stdout);
    assert!(json["truth"]["scaled"].is_null());
    let text = std::fs::read_to_string(out.join("profile.geojson")).unwrap();
    let outline: serde_json::Value = serde_json::from_str(&text).unwrap();
    let features = outline["features"].as_array().unwrap();
    assert_eq!(features[0]["geometry"]["type"], "LineString");
    assert_eq!(features[1]["properties"]["role"], "band");
    // The truth is drawn where it fits, so that the shapes can be compared by eye.
    let figure = std::fs::read_to_string(out.join("profile.svg")).unwrap();
    assert!(figure.starts_with("<svg") && figure.contains("moved to where it fits best"));
    let (truth, felt) = (drawn(&figure, "truth"), drawn(&figure, "outline"));
    let [truth, felt] = [truth, felt].map(|paths| paths.into_iter().max_by_key(Vec::len).unwrap());
    assert!(truth.len() > 50 && felt.len() > 20, "{} {}", truth.len(), felt.len());
    let gap = |p: &Vec2| truth.windows(2).map(|w| p.distance(nearest(w, *p))).fold(f64::INFINITY, f64::min);
    assert!(felt.iter().map(gap).fold(0.0, f64::max) < 1.5, "page units, where the shape error is 0.2 mm");
}

/// The vertices of the paths of a class (page units).
fn drawn(figure: &str, class: &str) -> Vec<Vec<Vec2>> {
    let end = format!("\" class=\"{class}\"/>");
    let paths = figure.split("<path d=\"").filter_map(|path| path.split_once(&end)).map(|(data, _)| data);
    let vertex = |pair: &str| {
        let (x, y) = pair.trim().trim_end_matches('Z').split_once(' ')?;
        Some(Vec2::new(x.parse().ok()?, y.parse().ok()?))
    };
    paths.map(|data| data.split(['M', 'L']).filter_map(vertex).collect()).collect()
}

/// The point of a segment that is nearest to `p`.
fn nearest(segment: &[Vec2], p: Vec2) -> Vec2 {
    let along = segment[1] - segment[0];
    let share = (p - segment[0]).dot(along) / along.dot(along).max(f64::MIN_POSITIVE);
    segment[0] + along * share.clamp(0.0, 1.0)
}

#[test]
fn broken_logs_are_named_with_line_and_next_step() {
    let folder = folder("contact_broken");
    let rows = peg_log();
    let cases = [
        ("empty.csv", String::new(), 1, "help:"),
        ("short.csv", rows.replacen("t,x,y,theta,moment", "t,x,y,theta,slope", 1), 1, "moment"),
        ("words.csv", rows.replacen(",0,0.004,", ",0,high,", 1), 1, ":2"),
        (
            "late.csv",
            rows.lines().take(3).chain(rows.lines().skip(1)).fold(String::new(), |t, l| t + l + "\n"),
            1,
            ":4",
        ),
    ];
    for (name, text, code, word) in cases {
        let path = put(&folder, name, &text);
        for command in ["contact", "profile"] {
            let ran = vibrissa(&[command, &path]);
            assert_eq!(ran.code, Some(code), "{command} {name}: {ran:?}");
            assert!(ran.stderr.contains(name) || name == "short.csv", "{command} {name}: {}", ran.stderr);
            assert!(ran.stderr.contains(word) && ran.stderr.contains("help:"), "{command} {name}: {}", ran.stderr);
        }
    }
    let ran = vibrissa(&["contact", folder.join("none.csv").to_str().unwrap()]);
    assert_eq!(ran.code, Some(1), "{ran:?}");
    assert_eq!(vibrissa(&["profile"]).code, Some(2));
    let log = put(&folder, "log.csv", &rows);
    assert_eq!(vibrissa(&["profile", &log, "--free-scale"]).code, Some(2), "a scale needs a truth");
}

#[test]
fn a_log_without_contact_is_no_error() {
    let folder = folder("contact_none");
    let log = put(&folder, "log.csv", "t,x,y,theta,moment\n0,0,0,0,0\n0.1,0.001,0,0,1e-6\n");
    for command in ["contact", "profile"] {
        let out = folder.join(command);
        let ran = vibrissa(&[command, &log, "--out", out.to_str().unwrap()]);
        assert_eq!(ran.code, Some(0), "{ran:?}");
    }
}
