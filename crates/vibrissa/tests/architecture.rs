//! Guards the house plan: arrows between modules point one way only, and the library neither prints nor, in its
//! innermost rooms, touches the outside world. Reads the sources as text.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::fs;
use std::path::{Path, PathBuf};

/// Each room and the rooms that it may use; a room may always use itself.
const ROOMS: &[(&str, &[&str])] = &[
    ("book", &[]),
    ("error", &[]),
    ("config", &[]),
    ("least_squares", &["config", "error"]),
    ("linear_algebra", &[]),
    ("plane", &["config", "error"]),
    ("sets", &["config", "error", "plane"]),
    ("beam", &["config", "error", "linear_algebra", "plane", "sets"]),
    ("world", &["config", "error", "plane", "sets", "beam"]),
    ("flow", &["config", "error", "linear_algebra", "plane", "sets", "beam", "world"]),
    ("localizer", &["config", "error", "plane", "sets", "beam", "world", "flow"]),
    ("figure", &["config", "error", "plane", "sets", "beam", "world", "flow"]),
    (
        "tasks",
        &[
            "config",
            "error",
            "least_squares",
            "linear_algebra",
            "plane",
            "sets",
            "beam",
            "world",
            "flow",
            "localizer",
            "figure",
        ],
    ),
];

/// Rooms that must build where there is no operating system, and what they may not name.
const PURE: &[&str] = &["plane", "sets", "beam"];
const OUTSIDE: &[&str] = &[
    "std::fs",
    "std::io",
    "std::time",
    "std::thread",
    "std::env",
    "std::net",
    "std::process",
    "std::path",
    "std::sync",
    "HashMap",
    "HashSet",
    "println!",
    "eprintln!",
];
/// What no part of the library may do.
const PRINTING: &[&str] = &["println!", "print!", "eprintln!", "eprint!", "dbg!", "std::process::exit"];
/// A result depends on no clock.
const CLOCKS: &[&str] = &["std::time", "Instant::now", "SystemTime"];

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
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
fn room(path: &Path) -> String {
    let inside = path.strip_prefix(source()).unwrap();
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

#[derive(Debug, PartialEq)]
struct Fault(String);

/// What is wrong with the code of one file of `room`.
fn faults(room: &str, name: &str, text: &str) -> Vec<Fault> {
    let mut found = Vec::new();
    let Some((_, allowed)) = ROOMS.iter().find(|(known, _)| *known == room) else {
        return vec![Fault(format!(
            "{name}: room `{room}` is not in the plan: add it to ROOMS and to ARCHITECTURE.md"
        ))];
    };
    let mut fault = |line: usize, what: String| found.push(Fault(format!("{name}:{line}: {what}")));
    for (number, line) in code(text) {
        for other in named_rooms(&line) {
            if ROOMS.iter().any(|(known, _)| *known == other) && other != room && !allowed.contains(&other.as_str()) {
                fault(number, format!("`{room}` must not use `{other}`"));
            }
        }
        let forbidden = if PURE.contains(&room) { OUTSIDE } else { &[] };
        for name in forbidden.iter().chain(PRINTING).chain(CLOCKS) {
            if line.contains(name) {
                fault(number, format!("`{room}` must not use `{name}`"));
            }
        }
    }
    found
}

#[test]
fn the_sources_keep_to_the_plan() {
    let mut found = Vec::new();
    let mut seen = 0;
    for path in files(&source()).iter().filter(|path| room(path) != "lib") {
        let name = path.strip_prefix(source()).unwrap().to_string_lossy().into_owned();
        found.extend(faults(&room(path), &name, &fs::read_to_string(path).unwrap()));
        seen += 1;
    }
    assert!(seen > 10, "only {seen} files seen");
    let list: Vec<String> = found.into_iter().map(|fault| fault.0).collect();
    assert!(list.is_empty(), "the house plan is broken:\n{}", list.join("\n"));
}

#[test]
fn the_plan_has_no_circle() {
    for (index, (room, allowed)) in ROOMS.iter().enumerate() {
        for used in *allowed {
            let place = ROOMS.iter().position(|(known, _)| known == used).expect("only known rooms");
            assert!(place < index, "`{room}` may use `{used}`, which stands after it");
        }
    }
}

#[test]
fn the_guard_sees_what_it_must() {
    let wrong = [
        ("plane", "use crate::flow::pose::Status;"),
        ("beam", "use crate::{plane::{Pose2, Vec2}, world::Robot};"),
        ("sets", "let x = crate::world::Robot::default();"),
        ("flow", "use crate::tasks::localize;"),
        ("world", "use crate::figure::Canvas;"),
        ("plane", "use std::collections::HashMap;"),
        ("beam", "let now = std::time::Instant::now();"),
        ("tasks", "println!(\"done\");"),
        ("cellar", "fn f() {}"),
    ];
    for (room, line) in wrong {
        let found = faults(room, "x.rs", &format!("//! head\n{line}\n"));
        assert!(!found.is_empty(), "{room}: {line}");
        assert!(room == "cellar" || found[0].0.starts_with("x.rs:2: "), "{found:?}");
    }
    let right = [
        ("flow", "use crate::{Error, Result};"),
        ("world", "use crate::{Result, plane::{Pose2, Vec2}, beam::Whisker};"),
        ("plane", "// crate::world is above us, println! too"),
        ("world", "use std::fs;"),
        ("plane", "#[cfg(test)]\nmod tests { use std::fs; }"),
    ];
    for (room, line) in right {
        assert_eq!(faults(room, "x.rs", line), [], "{room}: {line}");
    }
}
