//! Random worlds in which the possibilistic method must not lose the truth, on all cores; losses are told with their seeds.
//!
//!     cargo run --release -p vibrissa-soundness              the 300 worlds of every CI run
//!     cargo run --release -p vibrissa-soundness -- --nightly
//!     cargo run --release -p vibrissa-soundness -- --worlds 10000 --first 5000 --threads 2
//!     cargo run --release -p vibrissa-soundness -- --replay 1234
//!
//! Maps, whiskers, mounts, paths, bounds and errors are drawn from the seed; half of the time errors stand at the edge of
//! their bounds with signs that stay. A seed that gives no sweep is passed over. The last line holds the counts.

#[path = "../../crates/vibrissa/tests/data/random_sweep.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod random_sweep;

use random_sweep::{Trial, contains, random_sweep};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::{Localization, Method, Status};
use vibrissa::{LocalizeOptions, localize};

/// Worlds of a CI run and of a nightly one.
const SHORT: usize = 300;
const NIGHTLY: usize = 10_000;
/// How much work goes into the end of a log: soundness must not depend on it, time does.
const LAST_WORK: usize = 5_000;

/// What the command line asks for.
struct Call {
    worlds: usize,
    first: u64,
    threads: usize,
    replay: Option<u64>,
}

/// What became of one world.
struct Outcome {
    seed: u64,
    rows: usize,
    /// Rows in which the whisker has an inflection.
    inflected: usize,
    status: Option<Status>,
    /// What to tell of it, if the truth is lost or there is no answer.
    loss: Option<String>,
}

fn main() -> ExitCode {
    match parse(std::env::args().skip(1)) {
        Ok(Call { replay: Some(seed), .. }) => replay(seed),
        Ok(call) => report(&run(&call), &call),
        Err(message) => {
            eprintln!("error: {message}\n  --worlds N --nightly --first SEED --threads N --replay SEED");
            ExitCode::from(2)
        }
    }
}

fn parse(mut words: impl Iterator<Item = String>) -> Result<Call, String> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut call = Call { worlds: SHORT, first: 1, threads, replay: None };
    while let Some(word) = words.next() {
        let mut number = || {
            let value = words.next().ok_or(format!("{word} needs a value"))?;
            value.parse::<u64>().map_err(|error| format!("{word} {value}: {error}"))
        };
        match word.as_str() {
            "--nightly" => call.worlds = NIGHTLY,
            "--worlds" => call.worlds = number()? as usize,
            "--first" => call.first = number()?,
            "--threads" => call.threads = number()?.clamp(1, 256) as usize,
            "--replay" => call.replay = Some(number()?),
            _ => return Err(format!("unknown word {word}")),
        }
    }
    Ok(call)
}

/// The outcomes of the first worlds from `first` on, in the order of their seeds, whatever the number of threads.
fn run(call: &Call) -> Vec<Outcome> {
    let mut outcomes: Vec<Outcome> = Vec::new();
    let mut first = call.first;
    while outcomes.len() < call.worlds {
        // Some seeds give no sweep; the rest is looked for in further rounds.
        let missing = (call.worlds - outcomes.len()) as u64;
        let past = first.saturating_add(missing);
        let next = AtomicU64::new(first);
        let mut round: Vec<Outcome> = std::thread::scope(|scope| {
            let worker = || {
                let mut own = Vec::new();
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= past {
                        return own;
                    }
                    own.extend(world(seed));
                }
            };
            let workers: Vec<_> = (0..call.threads).map(|_| scope.spawn(worker)).collect();
            // A worker that panics takes the program down with its message.
            workers
                .into_iter()
                .flat_map(|w| w.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause)))
                .collect()
        });
        round.sort_by_key(|outcome| outcome.seed);
        round.iter().filter_map(|o| o.loss.as_ref()).for_each(|loss| println!("{loss}"));
        outcomes.extend(round);
        eprintln!("{} of {} worlds", outcomes.len(), call.worlds);
        first = past;
    }
    outcomes
}

fn answer(trial: &Trial) -> vibrissa::Result<Localization> {
    let possibilistic = PossibilisticOptions { last_work: LAST_WORK, ..PossibilisticOptions::default() };
    let options = LocalizeOptions { method: Method::Possibilistic, possibilistic, ..LocalizeOptions::default() };
    localize(&trial.log, &trial.map, &trial.robot, &options, &mut |_| {})
}

/// The world of a seed, if there is one.
fn world(seed: u64) -> Option<Outcome> {
    let trial = random_sweep(seed)?;
    let (rows, inflected) = (trial.log.rows.len(), trial.kinds[3]);
    Some(match answer(&trial) {
        Ok(found) => {
            let lost = found.status != Status::NoContact && !contains(&found, trial.truth);
            let loss = || format!("seed {seed}: {}, lost {:?}; {:?}", found.status, trial.truth, found.events.last());
            Outcome { seed, rows, inflected, status: Some(found.status), loss: lost.then(loss) }
        }
        Err(error) => Outcome { seed, rows, inflected, status: None, loss: Some(format!("seed {seed}: {error}")) },
    })
}

fn report(outcomes: &[Outcome], call: &Call) -> ExitCode {
    let of = |status: Status| outcomes.iter().filter(|o| o.status == Some(status)).count();
    let lost: Vec<u64> = outcomes.iter().filter(|o| o.loss.is_some()).map(|o| o.seed).collect();
    for seed in &lost {
        println!("replay: cargo run --release -p vibrissa-soundness -- --replay {seed}");
    }
    println!(
        "soundness: {} worlds (seeds {} to {}) of {} rows: truth lost in {}; localized {}, ambiguous {}, \
         inconsistent {}, no contact {}; {} rows with an inflection in {} worlds",
        outcomes.len(),
        call.first,
        outcomes.last().map_or(call.first, |o| o.seed),
        outcomes.iter().map(|o| o.rows).sum::<usize>(),
        lost.len(),
        of(Status::Localized),
        of(Status::Ambiguous),
        of(Status::Inconsistent),
        of(Status::NoContact),
        outcomes.iter().map(|o| o.inflected).sum::<usize>(),
        outcomes.iter().filter(|o| o.inflected > 0).count()
    );
    if lost.is_empty() && !outcomes.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// One world in full: its size and verdict, and every event.
fn replay(seed: u64) -> ExitCode {
    let (Some(trial), Some(outcome)) = (random_sweep(seed), world(seed)) else {
        println!("the seed {seed} gives no sweep");
        return ExitCode::from(2);
    };
    println!("seed {seed}: {} rows, robot {:?}, truth {:?}", outcome.rows, trial.robot, trial.truth);
    for event in answer(&trial).map(|found| found.events).unwrap_or_default() {
        println!("  {:.3} s {}: {}", event.t, event.kind, event.detail);
    }
    match outcome.loss {
        Some(loss) => {
            println!("{loss}");
            ExitCode::FAILURE
        }
        None => {
            println!("kept: {:?}", outcome.status);
            ExitCode::SUCCESS
        }
    }
}
