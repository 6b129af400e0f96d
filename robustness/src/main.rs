//! What the localizers do under errors as they really are: noise laws within the declared bound, and errors that nobody
//! declared; two tables.
//!
//!     cargo run --release -p vibrissa-robustness                          200 worlds, both tables
//!     cargo run --release -p vibrissa-robustness -- --short               a few minutes; fails where a promise is broken
//!     cargo run --release -p vibrissa-robustness -- --runs 50 --laws sine,hysteresis --errors none --method probabilistic
//!     cargo run --release -p vibrissa-robustness -- --runs 1 --seed 17 --each --errors none
//!     cargo run --release -p vibrissa-robustness -- --free 100            a free whisker, 100 hours of each noise law
//!
//! A seed draws a room, a robot and a motion, and one sweep without any error, which all rows of the tables share. Each row
//! spoils it in its way; what is declared stays as it was. The same seed gives the same tables, whatever the number of threads.
//!
//! *Right* is nearer than 5 mm to the truth, *wrong* more than 5 cm off. *Truth held* counts runs in which a place's 95 % region or
//! ridge holds the truth (probabilistic), or the set does (possibilistic). *Off without a word* counts localized runs that are 5 mm or
//! more off while what is told excludes the truth.

mod call;
mod cells;
mod free;
#[path = "../../crates/vibrissa/tests/data/free_whisker.rs"]
mod free_whisker;
mod judge;
mod least_error;
mod promises;
#[path = "../../crates/vibrissa/tests/data/random.rs"]
mod random;
#[path = "../../crates/vibrissa/tests/data/random_arena.rs"]
mod random_arena;
#[path = "../../crates/vibrissa/tests/data/region.rs"]
mod region;
#[path = "../../crates/vibrissa/tests/data/ridge.rs"]
mod ridge;
mod table;
mod tally;
#[cfg(test)]
mod tests;
mod worlds;

use call::{Call, HELP};
use cells::Cell;
use judge::{Judged, Outcome, judged};
use least_error::Sensitivity;
use promises::PROMISES;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use table::Row;
use tally::Tally;
use worlds::World;

fn main() -> ExitCode {
    let call = match Call::parse(std::env::args().skip(1)) {
        Ok(call) => call,
        Err(message) => {
            eprintln!("error: {message}\n{HELP}");
            return ExitCode::from(2);
        }
    };
    if let Some(hours) = call.free {
        return match free::hours(hours, call.seed, call.threads) {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::FAILURE,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        };
    }
    let rows = tables(&call);
    for undeclared in [false, true] {
        if rows.iter().any(|row| row.undeclared == undeclared) {
            println!("{}", table::markdown(&rows, undeclared));
        }
    }
    if let Some(file) = &call.json
        && let Err(error) = std::fs::write(file, table::json(&rows))
    {
        eprintln!("error: {}: {error}", file.display());
        return ExitCode::from(1);
    }
    if call.judge && !promises_hold(&rows) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Tells every broken promise.
fn promises_hold(rows: &[Row]) -> bool {
    let mut broken = 0;
    for row in rows {
        let of = |p: &&promises::Promise| {
            p.method == row.method
                && p.undeclared == row.undeclared
                && (p.cells.is_empty() || p.cells.contains(&row.cell.word))
        };
        for promise in PROMISES.iter().filter(of) {
            let share = promise.quantity.share(&row.tally);
            // One run more or less than promised says nothing where the promise is not absolute.
            let chance = 1.0 / row.tally.runs as f64;
            let (low, high) = if promise.least < promise.most { (chance, chance) } else { (0.0, 0.0) };
            if share < promise.least - low || share > promise.most + high {
                broken += 1;
                println!(
                    "BROKEN, {} under `{}`: {}: {:.3}, promised {} to {}",
                    row.method,
                    row.cell.word,
                    promise.quantity.text(),
                    share,
                    promise.least,
                    promise.most
                );
            }
        }
    }
    println!("promises broken: {broken}");
    broken == 0
}

/// What is run: cells with their tables, by each method.
fn cells(call: &Call) -> Vec<(Cell, bool)> {
    let laws = call.laws.iter().map(|cell| (*cell, false));
    laws.chain(call.errors.iter().map(|cell| (*cell, true))).collect()
}

/// All rows of both tables.
fn tables(call: &Call) -> Vec<Row> {
    let worlds = run(call);
    let mut rows = Vec::new();
    for (k, (cell, undeclared)) in cells(call).into_iter().enumerate() {
        for (m, method) in call.methods.iter().enumerate() {
            let runs = worlds.iter().filter_map(|world| world.get(k * call.methods.len() + m).copied());
            rows.push(Row { cell, undeclared, method: method.name(), tally: Tally::of(runs) });
        }
    }
    rows
}

/// The runs of each world, in the order of seeds, whatever the number of threads.
fn run(call: &Call) -> Vec<Vec<Judged>> {
    let mut done: Vec<(u64, Vec<Judged>)> = Vec::new();
    let mut first = call.seed;
    let counted = AtomicU64::new(0);
    while done.len() < call.runs {
        // Some seeds give no sweep; the rest is looked for in further rounds.
        let past = first + (call.runs - done.len()) as u64;
        let next = AtomicU64::new(first);
        let mut round: Vec<(u64, Vec<Judged>)> = std::thread::scope(|scope| {
            let worker = || {
                let mut own = Vec::new();
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= past {
                        return own;
                    }
                    if let Some(mut world) = worlds::world(seed) {
                        world.robot.whiskers[0].noise.moment_relative = call.declared;
                        own.push((seed, runs(&world, seed, call)));
                        let count = counted.fetch_add(1, Ordering::Relaxed) + 1;
                        if count.is_multiple_of(10) {
                            eprintln!("{count} of {} worlds", call.runs);
                        }
                    }
                }
            };
            let workers: Vec<_> = (0..call.threads).map(|_| scope.spawn(worker)).collect();
            // A worker that panics takes the program down with its message.
            workers
                .into_iter()
                .flat_map(|w| w.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause)))
                .collect()
        });
        round.sort_by_key(|world| world.0);
        done.extend(round);
        first = past;
    }
    done.into_iter().map(|world| world.1).collect()
}

/// One world through all cells and methods.
fn runs(world: &World, seed: u64, call: &Call) -> Vec<Judged> {
    if call.worlds {
        let kinds: Vec<&str> = world.sweep.events.iter().map(|event| event.kind).collect();
        println!(
            "seed {seed}: {}, {}, {} rows, {} touches, {}",
            world.room,
            world.motion,
            world.sweep.truth.len(),
            world.sweep.contacts.len(),
            kinds.join(" ")
        );
        return Vec::new();
    }
    let sensitivity = Sensitivity::of(world);
    let mut out = Vec::new();
    for (cell, undeclared) in cells(call) {
        let background = if undeclared { call.noise } else { Default::default() };
        let told = format!("seed {seed}, {} in {}, {}", world.motion, world.room, cell.word);
        let trial = match cell.trial(world, seed, background) {
            Ok(trial) => trial,
            Err(error) => {
                eprintln!("{told}: {error}");
                return Vec::new();
            }
        };
        let least = cell.law().and_then(|law| sensitivity.as_ref()?.least_error(law));
        for method in &call.methods {
            let told = format!("{told}, {}", method.name());
            let began = std::time::Instant::now();
            let run = judged(&trial, method, least, &told);
            if call.each && (!run.held || !matches!(run.outcome, Outcome::Right | Outcome::AmbiguousWith)) {
                let off = run.error.map_or(f64::NAN, |error| 1e3 * error.0);
                let time = began.elapsed().as_secs_f64();
                println!(
                    "{told}: {:?}, truth held {}, {off:.2} mm off, distance {:.1}, {time:.2} s",
                    run.outcome, run.held, run.distance
                );
                if let Some(folder) = &call.logs
                    && let Err(error) = trial.write(&folder.join(format!("{seed}-{}", cell.word)))
                {
                    eprintln!("error: {}: {error}", folder.display());
                }
            }
            out.push(run);
        }
    }
    out
}
