//! How many instructions the hot paths take, counted by Valgrind's callgrind: the same on a busy machine as on an idle one.
//!
//!     bench/instructions/run              compares with bench/instructions.json; more than 10 % above it fails
//!     bench/instructions/run --record     writes bench/instructions.json anew
//!
//! `--path NAME` runs one path as callgrind sees it. Counts belong to a compiler and an architecture; those of another
//! are not compared.

mod paths;

use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// A path may take this many times the instructions that it took when it was recorded.
const MOST: f64 = 1.10;
/// Callgrind collects inside this function only.
const COLLECTED: &str = "--toggle-collect=*vibrissa_instructions*collected*";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = match words[..] {
        ["--path", name] => paths::run(name),
        [] => check(),
        ["--record"] => record(),
        _ => Err("usage: vibrissa-instructions [--record | --path NAME]".to_owned()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../instructions.json")
}

/// What the counts depend on besides the code.
fn build() -> Result<String, String> {
    let output = Command::new("rustc").arg("--version").output().map_err(|error| format!("rustc: {error}"))?;
    let version = String::from_utf8_lossy(&output.stdout);
    Ok(format!("{}, {}, release", version.trim(), std::env::consts::ARCH))
}

/// The instructions of one path.
fn count(name: &str) -> Result<u64, String> {
    let own = std::env::current_exe().map_err(|error| format!("cannot find this program ({error})"))?;
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null", COLLECTED]);
    let output = command.arg(own).args(["--path", name]).output().map_err(|error| format!("valgrind: {error}"))?;
    let told = String::from_utf8_lossy(&output.stderr);
    let line = told.lines().find_map(|line| line.split("Collected :").nth(1));
    let counted = line.and_then(|line| line.trim().parse().ok()).filter(|count| *count > 0);
    counted.filter(|_| output.status.success()).ok_or_else(|| format!("{name}: nothing was counted:\n{told}"))
}

fn record() -> Result<(), String> {
    let mut counts = Map::new();
    for name in paths::names() {
        let counted = count(name)?;
        println!("{name:44} {counted:>13}");
        counts.insert(name.to_owned(), counted.into());
    }
    let text = serde_json::to_string_pretty(&json!({ "build": build()?, "instructions": counts }));
    let text = text.map_err(|error| error.to_string())? + "\n";
    std::fs::write(file(), text).map_err(|error| format!("{}: {error}", file().display()))
}

fn check() -> Result<(), String> {
    let text = std::fs::read_to_string(file()).map_err(|error| format!("{}: {error}", file().display()))?;
    let recorded: Value = serde_json::from_str(&text).map_err(|error| format!("{}: {error}", file().display()))?;
    let build = build()?;
    if recorded["build"] != build.as_str() {
        println!("SKIPPED: counts of {} cannot judge {build}; instructions were NOT compared", recorded["build"]);
        return Ok(());
    }
    let mut slower = Vec::new();
    println!("{:44} {:>13} {:>13} {:>8}", "path", "instructions", "recorded", "ratio");
    for name in paths::names() {
        let counted = count(name)? as f64;
        let Some(before) = recorded["instructions"][name].as_f64() else {
            return Err(format!("{name} was never recorded; run bench/instructions/run --record"));
        };
        let ratio = counted / before;
        println!("{name:44} {counted:>13} {before:>13} {ratio:>8.3}");
        if ratio > MOST {
            slower.push(format!("{name} takes {:.0} % more instructions", 100.0 * (ratio - 1.0)));
        }
    }
    if slower.is_empty() {
        println!("instructions: {} paths, none more than 10 % above its record", paths::names().count());
        return Ok(());
    }
    Err(format!("{}; if that is worth it, run bench/instructions/run --record", slower.join("; ")))
}
