//! Damaged input for every reader, degenerate shapes for the geometry: no panic, no hang, bounded memory.
//!
//!     cargo run --release -p vibrissa-fuzz -- --seconds 60 --target geojson
//!
//! Without `--target` every target takes its turn of `--seconds`, those that draw whole worlds from 10 s on; `--long` shares an hour among them. `--seed N` gives other inputs. A finding is shortened
//! and kept under `target/fuzz`; `--replay FILE --target NAME` tries it again. Inputs that made the code do something new are kept in
//! `target/fuzz/corpus`, or the folder of `--corpus`, and later runs begin with them. Where a try ends the whole process, as an
//! exhausted stack does, `--trace` keeps each input before it is tried. `--markdown FILE` writes what came of each target as a table.

mod campaign;
mod mutate;
mod random;
mod structure;
mod targets;
mod watch;

use campaign::{LAST_PANIC, Plan, Tally, attempt, run};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::PoisonError;
use std::time::Duration;
use targets::{ALL, Target};
use watch::Watch;

/// Time for all targets in a long run (s).
const LONG: f64 = 3600.0;
/// Shorter turns (s) say nothing of targets whose tries take seconds; these are left out then, unless they are named.
const WORTHWHILE: f64 = 10.0;

/// What the command line asks for.
struct Call {
    plan: Plan,
    targets: Vec<&'static Target>,
    replay: Option<PathBuf>,
    markdown: Option<PathBuf>,
}

fn main() -> ExitCode {
    match parse(std::env::args().skip(1)) {
        // A thread of its own, because its stack is as small as a caller's may be.
        Ok(call) => std::thread::spawn(move || work(&call)).join().unwrap_or(ExitCode::FAILURE),
        Err(message) => {
            let names: Vec<&str> = ALL.iter().map(|target| target.name).collect();
            eprintln!(
                "error: {message}\n  --seconds S --long --target NAME --seed N --replay FILE --trace --corpus DIR --markdown FILE"
            );
            eprintln!("  targets: {}", names.join(", "));
            ExitCode::from(2)
        }
    }
}

fn parse(mut words: impl Iterator<Item = String>) -> Result<Call, String> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../target/fuzz");
    let corpus = folder.join("corpus");
    // Unoptimized builds are several times slower.
    let limit = Duration::from_secs(if cfg!(debug_assertions) { 5 } else { 1 });
    let mut call = Call {
        plan: Plan { seconds: 10.0, seed: 1, limit, folder, corpus, trace: false },
        targets: Vec::new(),
        replay: None,
        markdown: None,
    };
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--seconds" => call.plan.seconds = value()?.parse().map_err(|e| format!("--seconds: {e}"))?,
            "--seed" => call.plan.seed = value()?.parse().map_err(|e| format!("--seed: {e}"))?,
            "--target" => {
                let name = value()?;
                let found = ALL.iter().find(|target| target.name == name);
                call.targets.push(found.ok_or(format!("no target is called {name}"))?);
            }
            "--long" => call.plan.seconds = LONG / ALL.len() as f64,
            "--replay" => call.replay = Some(value()?.into()),
            "--markdown" => call.markdown = Some(value()?.into()),
            "--trace" => call.plan.trace = true,
            "--corpus" => call.plan.corpus = value()?.into(),
            _ => return Err(format!("unknown word {word}")),
        }
    }
    if call.targets.is_empty() {
        let (tried, left): (Vec<_>, Vec<_>) =
            ALL.iter().partition(|target| call.plan.seconds >= WORTHWHILE || !target.takes_seconds());
        for target in left {
            println!("{}: left out, turns of {WORTHWHILE} s or more try it", target.name);
        }
        call.targets = tried;
    }
    Ok(call)
}

fn work(call: &Call) -> ExitCode {
    std::panic::set_hook(Box::new(|info| {
        *LAST_PANIC.lock().unwrap_or_else(PoisonError::into_inner) = info.to_string();
    }));
    let watch = Watch::start(call.plan.folder.clone());
    if let Some(path) = &call.replay {
        return replay(call, path, &watch);
    }
    let (mut tries, mut findings) = (0, 0);
    let mut table = "| target | inputs | read | kinds of outcome | slowest (ms) | findings |\n| --- | --- | --- | --- | --- | --- |\n".to_owned();
    for target in &call.targets {
        let tally = run(target, &call.plan, &watch);
        report(target, &tally);
        table += &row(target, &tally);
        tries += tally.tries;
        findings += tally.findings.len();
    }
    println!("fuzzing: {tries} inputs, {findings} findings");
    if let Some(path) = &call.markdown
        && let Err(error) = std::fs::write(path, table)
    {
        eprintln!("cannot write {} ({error})", path.display());
        return ExitCode::from(2);
    }
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// What came of a target, as a row of the table.
fn row(target: &Target, tally: &Tally) -> String {
    let Tally { tries, read, marks, slowest, findings } = tally;
    let slowest = slowest.as_secs_f64() * 1e3;
    format!("| {} | {tries} | {read} | {} | {slowest:.0} | {} |\n", target.name, marks.len(), findings.len())
}

fn report(target: &Target, tally: &Tally) {
    println!(
        "{:12} {:8} inputs  {:8} read  {:4} kinds of outcome  slowest {:6.1} ms  {} findings",
        target.name,
        tally.tries,
        tally.read,
        tally.marks.len(),
        tally.slowest.as_secs_f64() * 1e3,
        tally.findings.len()
    );
    for (finding, path) in &tally.findings {
        println!("  {finding}\n  kept in {}", path.display());
    }
}

fn replay(call: &Call, path: &std::path::Path, watch: &Watch) -> ExitCode {
    let input = match std::fs::read(path) {
        Ok(input) => input,
        Err(error) => {
            eprintln!("cannot read {} ({error})", path.display());
            return ExitCode::from(2);
        }
    };
    let mut code = ExitCode::SUCCESS;
    for target in &call.targets {
        let (verdict, time) = attempt(target, &input, call.plan.limit, watch);
        match verdict {
            Ok(outcome) => println!("{}: {} in {time:?}", target.name, if outcome.read { "read" } else { "refused" }),
            Err(finding) => {
                println!("{}: {finding}", target.name);
                code = ExitCode::FAILURE;
            }
        }
    }
    code
}
