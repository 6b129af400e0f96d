//! `vibrissa live` as a process: pipes, interrupts, and power cuts as far as a process can have them.

#![cfg(all(unix, feature = "live"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "common/mod.rs"]
mod common;

use common::{folder, vibrissa};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};
use vibrissa::io::log::to_csv;
use vibrissa::tasks::demo;
use vibrissa_live::journal;
use vibrissa_live::source::Arrived;

const SETUP: &str = "map = \"map.svg\"\n[[source]]\nname = \"log\"\npipe = \"-\"\n";

/// A folder with the demo's map and a setup that reads standard input, and the demo's log in lines.
fn prepared(name: &str) -> (std::path::PathBuf, Vec<String>) {
    let here = folder(name);
    std::fs::write(here.join("map.svg"), demo::ARENA_SVG).unwrap();
    std::fs::write(here.join("live.toml"), SETUP).unwrap();
    let log = to_csv(&demo::sweep(1).unwrap().log);
    (here, log.lines().map(|line| format!("{line}\n")).collect())
}

fn start(here: &Path, more: &[&str]) -> (Child, ChildStdin) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_vibrissa"))
        .arg("live")
        .arg(here.join("live.toml"))
        .arg("--out")
        .arg(here.join("out"))
        .args(more)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let input = child.stdin.take().unwrap();
    (child, input)
}

/// The raw bytes that a recording holds by now; none before it can be read.
fn recorded(out: &Path) -> Option<Vec<u8>> {
    let recorded = journal::read(out).ok()?;
    let mut bytes = Vec::new();
    journal::chunks(&recorded, |chunk| {
        if let Arrived::Bytes(raw) = chunk.what {
            bytes.extend(raw);
        }
        Ok(())
    })
    .ok()?;
    Some(bytes)
}

#[test]
fn a_process_that_is_killed_keeps_what_was_synchronised_and_runs_again() {
    for round in 0..5 {
        let (here, lines) = prepared(&format!("live-kill-{round}"));
        let (mut child, mut input) = start(&here, &[]);
        let (first, rest) = lines.split_at(120 + 40 * round);
        let safe = first.concat();
        input.write_all(safe.as_bytes()).unwrap();
        // Until it is on the disk, and an estimate with it, however long this machine takes.
        let out = here.join("out");
        let told = || journal::read(&out).is_ok_and(|recorded| !recorded.lines.is_empty());
        let mut looks = 0;
        while recorded(&out).is_none_or(|bytes| bytes.len() < safe.len()) || !told() {
            std::thread::sleep(Duration::from_millis(10));
            looks += 1;
            assert!(looks < 12_000, "round {round}: nothing reaches the disk");
        }
        // And then in the middle of something.
        for line in rest.iter().take(30 * round) {
            input.write_all(line.as_bytes()).unwrap();
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let bytes = recorded(&here.join("out")).unwrap();
        let sent = lines.concat();
        assert!(
            bytes.len() >= safe.len() && sent.as_bytes().starts_with(&bytes),
            "round {round}: {} bytes",
            bytes.len()
        );
        println!(
            "round {round}: {} of {} bytes after the last look survived",
            bytes.len() - safe.len(),
            rest.iter().take(30 * round).map(String::len).sum::<usize>()
        );
        let again = vibrissa(&["live", "--replay", here.join("out").to_str().unwrap()]);
        assert_eq!(again.code, Some(0), "{}", again.stderr);
        let told = again.stdout.lines().find(|line| line.contains("estimates: ")).unwrap();
        let mut counts = told.split_whitespace().filter_map(|word| word.parse::<usize>().ok());
        let (same, of) = (counts.next().unwrap(), counts.next().unwrap());
        assert!(same == of && of > 0, "{told}");
    }
}

#[test]
fn an_interrupt_ends_the_run_with_whole_files() {
    let (here, lines) = prepared("live-interrupt");
    let (mut child, mut input) = start(&here, &["--json"]);
    input.write_all(lines[..300].concat().as_bytes()).unwrap();
    let mut told = BufReader::new(child.stdout.take().unwrap()).lines();
    let first = told.next().unwrap().unwrap();
    assert!(first.starts_with("{\"t\":") && first.contains("\"status\":"), "{first}");
    // Standard input stays open: only the interrupt ends it.
    let sent = Command::new("kill").arg("-INT").arg(child.id().to_string()).status().unwrap();
    assert!(sent.success());
    let _rest: Vec<String> = told.map_while(Result::ok).collect();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    drop(input);
    let recorded = journal::read(&here.join("out")).unwrap();
    assert!(recorded.warnings.is_empty() && recorded.lines[0] == first, "{:?}", recorded.warnings);
    let again = vibrissa(&["live", "--replay", here.join("out").to_str().unwrap(), "--json"]);
    assert_eq!(again.stdout.lines().next(), Some(first.as_str()));
}

/// The search of a large map takes the estimator far longer than anybody waits.
#[test]
fn a_second_interrupt_ends_the_run_at_once_with_whole_files() {
    let (here, lines) = prepared("live-interrupt-twice");
    // A wavy ring that has no symmetry: there is a place for the robot nearly everywhere.
    let corner = |i: u32| {
        let turn = f64::from(i) * core::f64::consts::TAU / 20_000.0;
        let radius = 10.0 + 0.1 * (41.0 * turn).sin() + 0.05 * (83.0 * turn + 1.0).sin();
        (radius * turn.cos(), radius * turn.sin())
    };
    let ring: Vec<String> = (0..=20_000).map(|i| corner(i % 20_000)).map(|(x, y)| format!("[{x},{y}]")).collect();
    let arena = format!(
        r#"{{"type":"Feature","properties":{{"role":"arena"}},"geometry":{{"type":"Polygon","coordinates":[[{}]]}}}}"#,
        ring.join(",")
    );
    std::fs::write(here.join("ring.geojson"), arena).unwrap();
    let setup = SETUP.replace("map.svg", "ring.geojson");
    std::fs::write(here.join("live.toml"), setup).unwrap();
    let (mut child, mut input) = start(&here, &[]);
    let sent = lines[..400].concat();
    for piece in lines[..400].chunks(20) {
        input.write_all(piece.concat().as_bytes()).unwrap();
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut looks = 0;
    while recorded(&here.join("out")).is_none_or(|bytes| bytes.len() < sent.len()) {
        std::thread::sleep(Duration::from_millis(10));
        looks += 1;
        assert!(looks < 12_000, "nothing reaches the disk");
    }
    let id = child.id().to_string();
    let interrupt = || assert!(Command::new("kill").arg("-INT").arg(&id).status().unwrap().success());
    interrupt();
    // What arrives after the first one may be recorded or not; the estimator is busy with the map.
    std::thread::sleep(Duration::from_millis(500));
    assert!(child.try_wait().unwrap().is_none(), "the estimator is to be busy, or nothing is tested");
    let began = Instant::now();
    interrupt();
    let code = child.wait().unwrap().code();
    let took = began.elapsed();
    assert_eq!(code, Some(130));
    assert!(took < Duration::from_secs(3), "{took:?}");
    drop(input);
    let recorded = journal::read(&here.join("out")).unwrap();
    assert!(recorded.warnings.is_empty(), "{:?}", recorded.warnings);
    let mut bytes = Vec::new();
    journal::chunks(&recorded, |chunk| {
        if let Arrived::Bytes(raw) = chunk.what {
            bytes.extend(raw);
        }
        Ok(())
    })
    .unwrap();
    assert!(bytes == sent.as_bytes(), "{} of {} bytes", bytes.len(), sent.len());
}

#[test]
fn recordings_are_never_overwritten_and_mistakes_are_told() {
    let (here, lines) = prepared("live-twice");
    std::fs::write(here.join("log.csv"), lines.concat()).unwrap();
    std::fs::write(here.join("live.toml"), SETUP.replace("\"-\"", "\"log.csv\"")).unwrap();
    let setup = here.join("live.toml");
    for _ in 0..2 {
        let run = vibrissa(&["live", setup.to_str().unwrap()]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(run.stdout.starts_with("localized: x 3"), "{}", run.stdout);
    }
    let both = ["recording.mcap", "recording-2.mcap"].map(|name| here.join("live").join(name));
    assert!(both.iter().all(|path| path.exists()));
    let several = vibrissa(&["live", "--replay", here.join("live").to_str().unwrap()]);
    assert!(several.code == Some(1) && several.stderr.contains("several recordings"), "{}", several.stderr);
    // By another setup: the readings a little later.
    let later = here.join("later.toml");
    std::fs::write(&later, format!("{}delay = \"1 ms\"\n", SETUP.replace("\"-\"", "\"log.csv\""))).unwrap();
    let other = vibrissa(&["live", "--replay", both[0].to_str().unwrap(), later.to_str().unwrap()]);
    assert!(other.code == Some(0) && other.stdout.starts_with("localized"), "{} {}", other.stdout, other.stderr);
    let missing = vibrissa(&["live", "nowhere.toml"]);
    assert!(missing.code == Some(1) && missing.stderr.contains("no such file"), "{}", missing.stderr);
    assert_eq!(vibrissa(&["live"]).code, Some(2));
    assert_eq!(vibrissa(&["live", "--demo", "--speed", "2"]).code, Some(2));
}

#[test]
fn a_robot_that_has_come_to_rest_is_told_the_next_motion() {
    let (here, lines) = prepared("live-plan");
    // The first touch, which leaves several places, and then rest: for long enough that a slow machine catches up with it.
    let (first, _) = lines.split_at(170);
    let last: Vec<&str> = first[169].trim_end().split(',').collect();
    let t: f64 = last[0].parse().unwrap();
    let rest = (1..1500).map(|k| format!("{},{}\n", t + f64::from(k) / 300.0, last[1..].join(",")));
    let (child, mut input) = start(&here, &["--plan", "--footprint", "5 mm", "--json"]);
    let all = first.iter().cloned().chain(rest);
    // As a robot sends them: rows that pile up would be merged.
    for line in all {
        input.write_all(line.as_bytes()).unwrap();
        std::thread::sleep(Duration::from_micros(3_300));
    }
    drop(input);
    let told = child.wait_with_output().unwrap();
    assert!(told.status.success());
    let told = String::from_utf8(told.stdout).unwrap();
    let plans: Vec<serde_json::Value> = told
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .filter(|v: &serde_json::Value| !v["plan"].is_null())
        .collect();
    // Once for the rest, whatever the number of estimates.
    assert_eq!(plans.len(), 1, "{told}");
    assert!((plans[0]["t"].as_f64().unwrap() - t).abs() < 0.02, "{}", plans[0]);
    let plan = &plans[0]["plan"];
    assert!(plan["places"].as_u64().unwrap() > 1 && plan["looked_at"][0].as_u64().unwrap() > 10, "{plan}");
    assert!(["parts", "alike", "confined"].contains(&plan["verdict"].as_str().unwrap()), "{plan}");
    let bad = vibrissa(&["live", here.join("live.toml").to_str().unwrap(), "--plan", "--footprint", "5 s"]);
    assert!(bad.code == Some(2) && bad.stderr.contains("--footprint"), "{}", bad.stderr);
    assert_eq!(vibrissa(&["live", here.join("live.toml").to_str().unwrap(), "--explore"]).code, Some(2));
}

#[cfg(unix)]
#[test]
fn a_simulated_robot_explores_until_it_knows_where_it_is() {
    let run = vibrissa(&["live", "--demo", "--explore", "--no-record"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("plan: "), "{}", run.stderr);
    // In real time on a machine that may be busy: it may end without a place, but never at a wrong one.
    let off = run.stdout.lines().find(|line| line.contains("off the truth by"));
    let off = off.and_then(|line| line.split_whitespace().nth(4)).map_or(0.0, |word| word.parse::<f64>().unwrap());
    assert!(!run.stdout.starts_with("localized") || off < 5.0, "{}", run.stdout);
}

#[test]
fn a_setup_without_a_map_makes_the_map_that_its_log_makes() {
    let here = folder("live-mapping");
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/felt_room.toml");
    let path = |name: &str| here.join(name).to_str().unwrap().to_owned();
    let made = vibrissa(&["simulate", scenario.to_str().unwrap(), "--out", &path("lap")]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    // Along one wall and around a corner.
    let log = std::fs::read_to_string(path("lap/log.csv")).unwrap();
    let part: String = log.lines().take(2200).map(|line| format!("{line}\n")).collect();
    std::fs::write(path("log.csv"), part).unwrap();
    let setup = "robot = \"lap/robot.toml\"\n[[source]]\nname = \"log\"\npipe = \"log.csv\"\ntime = \"own\"\n";
    std::fs::write(path("live.toml"), setup).unwrap();
    let run = vibrissa(&["live", &path("live.toml"), "--mapping", "--body", "20", "--out", &path("run")]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stdout.contains("m of wall known") && run.stdout.contains("2199 used, 0 merged"), "{}", run.stdout);
    let robot = path("lap/robot.toml");
    let files = ["map.geojson", "trajectory.tum", "covariances.csv", "graph.json", "mapping.svg"];
    for (log, out) in [("log.csv", "of-log"), ("run/recording.mcap", "of-recording")] {
        let whole = vibrissa(&["map", &path(log), "--robot", &robot, "--body", "20", "--out", &path(out)]);
        assert_eq!(whole.code, Some(0), "{}", whole.stderr);
        for name in files {
            let [live, other] = ["run", out].map(|folder| std::fs::read(here.join(folder).join(name)).unwrap());
            assert!(live == other, "{name} of {log} is another");
        }
    }
    // A second run leaves the first one's files alone; each map is a line.
    let lines = vibrissa(&["live", &path("live.toml"), "--mapping", "--body", "20", "--out", &path("run"), "--json"]);
    let last: serde_json::Value = serde_json::from_str(lines.stdout.lines().last().unwrap()).unwrap();
    assert!(last["map"]["known_m"].as_f64().unwrap() > 0.2 && last["t"].as_f64().unwrap() > 7.0, "{last}");
    assert!(here.join("run/map-2.geojson").exists() && here.join("run/recording-2.mcap").exists());

    for (words, told) in [
        (vec!["live", &path("live.toml")], "let --mapping make one"),
        (vec!["live", "--replay", &path("run/recording.mcap")], "vibrissa map"),
        (vec!["live", &path("live.toml"), "--body", "20"], "--mapping"),
    ] {
        let refused = vibrissa(&words);
        assert!(refused.code != Some(0) && refused.stderr.contains(told), "{words:?}: {}", refused.stderr);
    }
    std::fs::write(path("live.toml"), format!("map = \"run/map.geojson\"\n{setup}")).unwrap();
    let both = vibrissa(&["live", &path("live.toml"), "--mapping", "--out", &path("both")]);
    assert!(both.code == Some(2) && both.stderr.contains("the setup names one"), "{}", both.stderr);
}
