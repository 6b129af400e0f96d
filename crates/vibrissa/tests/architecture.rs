//! Guards the house plan: arrows between crates and between rooms of a crate point one way only, the mechanics and the
//! localization core touch no files, and no library prints or reads a clock. Reads manifests and sources as text.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::fs;
use std::path::{Path, PathBuf};

/// The library crates by folder, and those of them that each may depend on.
const CRATES: &[(&str, &[&str])] = &[
    ("crates/vibrissa-beam", &[]),
    ("crates/vibrissa-head", &["vibrissa-beam"]),
    ("crates/vibrissa-c", &["vibrissa-beam", "vibrissa-head"]),
    ("crates/vibrissa-core", &["vibrissa-beam"]),
    ("crates/vibrissa-io", &["vibrissa-core"]),
    ("crates/vibrissa-sim", &["vibrissa-core", "vibrissa-io"]),
    ("crates/vibrissa-live", &["vibrissa-core", "vibrissa-head", "vibrissa-io", "vibrissa-sim"]),
    ("crates/vibrissa-figure", &["vibrissa-core"]),
    ("crates/vibrissa", &["vibrissa-core", "vibrissa-figure", "vibrissa-io", "vibrissa-sim"]),
    ("crates/vibrissa-wasm", &["vibrissa"]),
    ("validation/reproduce", &["vibrissa"]),
];

/// Within each crate its rooms (files or folders right under `src`) in order: a room may use those before it.
const ROOMS: &[(&str, &[&str])] = &[
    (
        "crates/vibrissa-beam",
        &["math", "platform", "error", "config", "linear_algebra", "plane", "sets", "sensing", "beam"],
    ),
    (
        "crates/vibrissa-head",
        &["packet", "calibration", "unwrap", "bus", "command", "frame", "chip", "head", "simulated"],
    ),
    (
        "crates/vibrissa-core",
        &["stop", "work_budget", "coroutine", "config", "world", "contact", "flow", "localizer", "control"],
    ),
    (
        "crates/vibrissa-io",
        &[
            "text",
            "units",
            "toml_section",
            "calibration",
            "grid",
            "ros",
            "trajectory",
            "log",
            "calibrated",
            "robot",
            "map",
            "recording",
        ],
    ),
    (
        "crates/vibrissa-live",
        &[
            "config", "head", "counts", "latency", "output", "clock", "decode", "timing", "doubts", "join", "source",
            "setup", "pipeline", "estimate", "carry", "record", "journal", "replay", "run", "robot", "scene", "view",
        ],
    ),
    ("crates/vibrissa-sim", &["simulate", "scenario", "recording"]),
    ("crates/vibrissa", &["book", "least_squares", "tasks"]),
];

/// Crates that know no files, and what they may not name.
const WITHOUT_FILES: &[&str] = &["crates/vibrissa-beam", "crates/vibrissa-core"];
const OUTSIDE: &[&str] =
    &["std::fs", "std::io", "std::thread", "std::env", "std::net", "std::process", "HashMap", "HashSet"];
/// What no part of the library may do.
const PRINTING: &[&str] = &["println!", "print!", "eprintln!", "eprint!", "dbg!", "std::process::exit"];
/// A result depends on no clock,
const CLOCKS: &[&str] = &["std::time", "Instant::now", "SystemTime"];
/// but what arrives has a time of arrival, a disk is given time, and a recording is played at a speed.
const WITH_CLOCKS: &[(&str, &[&str])] =
    &[("crates/vibrissa-live", &["source", "record", "replay", "run", "robot", "view"])];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The room of a source file: its first folder, or its stem directly under `src`.
fn room(source: &Path, path: &Path) -> String {
    let inside = path.strip_prefix(source).unwrap();
    inside.components().next().unwrap().as_os_str().to_string_lossy().trim_end_matches(".rs").to_owned()
}

/// The code of a file by line number, without comments and without unit tests at its end.
fn code(text: &str) -> Vec<(usize, String)> {
    text.lines()
        .enumerate()
        .take_while(|(_, line)| line.trim() != "#[cfg(test)]")
        .map(|(index, line)| (index + 1, line.split("//").next().unwrap_or_default().to_owned()))
        .collect()
}

/// The rooms that one line names after `crate::`, alone or in braces; what starts with a capital is no room.
fn named_rooms(line: &str) -> Vec<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut rooms = Vec::new();
    for piece in line.split("crate::").skip(1) {
        match piece.strip_prefix('{') {
            Some(list) => {
                let mut depth = 0;
                let flat: String = list
                    .chars()
                    .take_while(|c| {
                        depth += i32::from(*c == '{') - i32::from(*c == '}');
                        depth >= 0
                    })
                    .collect();
                rooms.extend(top_level_items(&flat).iter().map(|item| word(item.trim())));
            }
            None => rooms.push(word(piece)),
        }
    }
    rooms.retain(|room| room.starts_with(|c: char| c.is_lowercase()));
    rooms
}

fn top_level_items(list: &str) -> Vec<String> {
    let (mut depth, mut items) = (0, vec![String::new()]);
    for character in list.chars() {
        depth += i32::from(character == '{') - i32::from(character == '}');
        if character == ',' && depth == 0 {
            items.push(String::new());
        } else if let Some(item) = items.last_mut() {
            item.push(character);
        }
    }
    items
}

/// What is wrong with the code of one file in a room of a crate.
fn faults(folder: &str, room: &str, name: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let rooms = ROOMS.iter().find(|(known, _)| *known == folder).map(|(_, rooms)| *rooms);
    let here = rooms.map(|rooms| rooms.iter().position(|known| *known == room));
    if here == Some(None) {
        return vec![format!("{name}: room `{room}` is not in the plan: add it to ROOMS and to ARCHITECTURE.md")];
    }
    let forbidden: &[&str] = if WITHOUT_FILES.contains(&folder) { OUTSIDE } else { &[] };
    let timed = WITH_CLOCKS.iter().any(|(known, rooms)| *known == folder && rooms.contains(&room));
    let clocks: &[&str] = if timed { &[] } else { CLOCKS };
    for (number, line) in code(text) {
        for other in named_rooms(&line) {
            let there = rooms.and_then(|rooms| rooms.iter().position(|known| *known == other));
            if here.flatten().zip(there).is_some_and(|(here, there)| there > here) {
                found.push(format!("{name}:{number}: `{room}` must not use `{other}`"));
            }
        }
        for word in forbidden.iter().chain(PRINTING).chain(clocks).filter(|word| line.contains(**word)) {
            found.push(format!("{name}:{number}: `{room}` must not use `{word}`"));
        }
    }
    found
}

#[test]
fn the_sources_keep_to_the_plan() {
    let mut found = Vec::new();
    let mut seen = 0;
    for (folder, _) in CRATES {
        let source = root().join(folder).join("src");
        for path in files(&source).iter().filter(|path| room(&source, path) != "lib") {
            let name = format!("{folder}/src/{}", path.strip_prefix(&source).unwrap().display());
            found.extend(faults(folder, &room(&source, path), &name, &fs::read_to_string(path).unwrap()));
            seen += 1;
        }
    }
    assert!(seen > 300, "only {seen} files seen");
    assert!(found.is_empty(), "the house plan is broken:\n{}", found.join("\n"));
}

/// The crates of this workspace that a manifest depends on outside of tests.
fn dependencies(manifest: &str) -> Vec<String> {
    let mut on = false;
    let mut found = Vec::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            on = line == "[dependencies]";
        } else if on && line.starts_with("vibrissa") {
            found.push(line.split(['=', ' ', '.']).next().unwrap().to_owned());
        }
    }
    found
}

#[test]
fn the_crates_depend_on_each_other_as_planned() {
    for (index, (folder, allowed)) in CRATES.iter().enumerate() {
        let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap();
        for used in dependencies(&manifest) {
            assert!(allowed.contains(&used.as_str()), "{folder} must not depend on {used}");
        }
        for used in *allowed {
            let place = CRATES.iter().position(|(known, _)| known.ends_with(&format!("/{used}"))).unwrap();
            assert!(place < index, "{folder} may depend on {used}, which stands after it");
        }
    }
    assert_eq!(
        dependencies("[dependencies]\nvibrissa-io = { workspace = true }\n[dev-dependencies]\nvibrissa = 1"),
        ["vibrissa-io"]
    );
}

#[test]
fn every_file_of_tests_is_run() {
    for crate_name in ["vibrissa-beam", "vibrissa", "vibrissa-cli"] {
        let folder = root().join("crates").join(crate_name);
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let roots: Vec<String> = manifest
            .split("[[test]]")
            .skip(1)
            .filter_map(|part| part.split('"').nth(1))
            .map(|name| fs::read_to_string(folder.join("tests").join(format!("{name}.rs"))).unwrap() + name)
            .collect();
        for file in fs::read_dir(folder.join("tests")).unwrap().map(|entry| entry.unwrap().path()) {
            let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
            let listed = |text: &String| text.ends_with(&name) || text.contains(&format!("\nmod {name};\n"));
            assert!(file.is_dir() || roots.iter().any(listed), "{crate_name}: no root in tests/ says `mod {name};`");
        }
    }
}

#[test]
fn the_guard_sees_what_it_must() {
    let (beam, core, main) = ("crates/vibrissa-beam", "crates/vibrissa-core", "crates/vibrissa");
    let wrong = [
        (beam, "plane", "use crate::beam::Whisker;"),
        (beam, "error", "use crate::{plane::{Pose2, Vec2}, sets::Interval};"),
        (core, "flow", "let x = crate::localizer::Localizer::new();"),
        (core, "world", "use std::fs;"),
        (beam, "plane", "use std::collections::HashMap;"),
        (beam, "beam", "let now = std::time::Instant::now();"),
        (main, "tasks", "println!(\"done\");"),
        (main, "cellar", "fn f() {}"),
        ("crates/vibrissa-live", "pipeline", "let now = std::time::Instant::now();"),
    ];
    for (folder, room, line) in wrong {
        let found = faults(folder, room, "x.rs", &format!("//! head\n{line}\n"));
        assert!(!found.is_empty(), "{room}: {line}");
        assert!(room == "cellar" || found[0].starts_with("x.rs:2: "), "{found:?}");
    }
    let right = [
        (core, "flow", "use crate::{Error, Result};"),
        (core, "world", "use crate::{Result, plane::{Pose2, Vec2}, beam::Whisker};"),
        (beam, "plane", "// crate::beam is above us, println! too"),
        ("crates/vibrissa-io", "log", "use std::fs;"),
        (core, "world", "#[cfg(test)]\nmod tests { use std::fs; }"),
        ("crates/vibrissa-live", "source", "let now = std::time::Instant::now();"),
    ];
    for (folder, room, line) in right {
        assert_eq!(faults(folder, room, "x.rs", line), Vec::<String>::new(), "{room}: {line}");
    }
}
