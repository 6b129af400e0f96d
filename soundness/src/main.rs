//! Random worlds in which the possibilistic method must not lose the truth, on all cores; losses are told with their seeds.
//!
//!     cargo run --release -p vibrissa-soundness              the 200 worlds of every CI run
//!     cargo run --release -p vibrissa-soundness -- --nightly
//!     cargo run --release -p vibrissa-soundness -- --worlds 10000 --first 5000 --threads 2
//!     cargo run --release -p vibrissa-soundness -- --replay 1234
//!     cargo run --release -p vibrissa-soundness -- --rods --worlds 500    no uniform whiskers
//!     cargo run --release -p vibrissa-soundness -- --bands --worlds 500   maps drawn within bands beside the true walls, with unknown stretches
//!     cargo run --release -p vibrissa-soundness -- --quick --nightly      without the refinement at the end of each log
//!     cargo run --release -p vibrissa-soundness -- --corners 100        drives around corners, with two contacts at once
//!     cargo run --release -p vibrissa-soundness -- --corners 100 --smoother    the same drives by the probabilistic method
//!     cargo run --release -p vibrissa-soundness -- --corners 100 --smoother --whiskers 4    by robots of four whiskers
//!     cargo run --release -p vibrissa-soundness -- --corners 100 --smoother --law hysteresis    drives with noise of one law
//!     cargo run --release -p vibrissa-soundness -- --corners 100 --forward     how much of these drives the forward model knows
//!     cargo run --release -p vibrissa-soundness -- --explore 100        robots that find out where they are by their own motion
//!     cargo run --release -p vibrissa-soundness -- --follow 100         robots that follow walls by touch
//!     cargo run --release -p vibrissa-soundness -- --worlds 40 --declare 90    bounds told 10 % too small: losses must show
//!
//! In every thirtieth world the whisker is tapered, curved at rest or of several wires, half of the time with declared errors of
//! length and stiffness. Maps, whiskers, mounts, paths, bounds and errors are drawn from the seed; half of the time errors stand at the edge of
//! their bounds with signs that stay. A seed that gives no sweep is passed over. The last line holds the counts, and how
//! small the sets that held the truth were.

mod banded;
mod corners;
mod exploring;
mod following;
mod forward;
#[path = "../../crates/vibrissa/tests/data/random_sweep.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod random_sweep;
#[path = "../../crates/vibrissa/tests/data/region.rs"]
mod region;
#[path = "../../crates/vibrissa/tests/data/ridge.rs"]
mod ridge;
mod smoothed;

use random_sweep::random::Random;
use random_sweep::{Trial, contains, random_sweep_of};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::{Localization, Status, StepRecord};
use vibrissa::plane::Pose2;
use vibrissa::{Method, localize};

/// Worlds of a CI run and of a nightly one.
const SHORT: usize = 200;
/// The whisker is not uniform in one world of so many.
const ROD_EVERY: u64 = 30;
const NIGHTLY: usize = 10_000;
/// How much work goes into the end of a log without a prior: it tries the start on a whole map, and is soon over.
const LAST_WORK: usize = 5_000;
/// How much goes into the end with a prior about the truth, where all of it tries cells that may hold the truth.
const NEAR_WORK: usize = 200_000;

/// From so far after the first contact on drives around corners reckon with two contacts (m).
const TWO_CONTACTS: f64 = 0.05;

/// What the command line asks for.
struct Call {
    worlds: usize,
    first: u64,
    threads: usize,
    replay: Option<u64>,
    /// Whiskers that are not uniform in all worlds, instead of every thirtieth.
    rods: bool,
    /// Maps that are off within declared bands.
    bands: bool,
    /// Without the refinement at the end of the log.
    quick: bool,
    /// Drives around corners instead of sweeps along walls.
    corners: bool,
    /// By the probabilistic method, with noise that may be correlated.
    smoother: bool,
    /// The smoother's forward model alone, along the true way.
    forward: bool,
    /// Robots that choose their motions.
    explore: bool,
    /// Robots that follow walls.
    follow: bool,
    /// Tells each motion.
    verbose: bool,
    /// How many of the policies: 1 for planned motions alone.
    policies: usize,
    /// How many whiskers the robots of such drives have.
    whiskers: usize,
    /// From so far after the first contact on such drives reckon with two contacts (m).
    two_contacts: Option<f64>,
    /// By drives with noise of this law alone.
    law: Option<String>,
    /// The share of their bounds that errors are declared with: below one, truths must be lost.
    declared: f64,
}

/// What became of one world.
struct Outcome {
    seed: u64,
    rows: usize,
    /// Whether the whisker is not uniform.
    is_rod: bool,
    /// Rows in which the whisker has an inflection, and in which it is curled.
    inflected: usize,
    curled: usize,
    /// The verdict with a prior.
    status: Option<Status>,
    /// Volumes of the set (m² rad) after its first reading without a prior, and after its last with one.
    volumes: [f64; 2],
    /// What to tell of it, if the truth is lost or there is no answer.
    loss: Option<String>,
}

fn main() -> ExitCode {
    match parse(std::env::args().skip(1)) {
        Ok(call @ Call { replay: Some(seed), .. }) => replay(seed, &call),
        Ok(call) if call.explore => {
            exploring::report(&all_corners(&call, |seed| exploring::compare(seed, call.verbose, call.policies)))
        }
        Ok(call) if call.follow => following::report(&all_corners(&call, |seed| following::follow(seed, call.verbose))),
        Ok(call) if call.corners && call.forward => forward::report(&all_corners(&call, forward::drive)),
        Ok(call) if call.corners && call.smoother => {
            smoothed::report(&all_corners(&call, |seed| smoothed::drive(seed, &call)))
        }
        Ok(call) if call.corners => corner_report(&run_corners(&call), &call),
        Ok(call) => report(&run(&call), &call),
        Err(message) => {
            eprintln!(
                "error: {message}\n  --worlds N --corners N --explore N --follow N --policies N --verbose --one-place --two-contacts MM --whiskers N --smoother --law NAME --forward --nightly --rods --bands --quick --first SEED --threads N --replay SEED --declare PERCENT"
            );
            ExitCode::from(2)
        }
    }
}

fn parse(mut words: impl Iterator<Item = String>) -> Result<Call, String> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut call = Call {
        worlds: SHORT,
        first: 1,
        threads,
        replay: None,
        rods: false,
        bands: false,
        quick: false,
        corners: false,
        smoother: false,
        forward: false,
        explore: false,
        follow: false,
        verbose: false,
        policies: exploring::POLICIES.len(),
        whiskers: 1,
        two_contacts: Some(TWO_CONTACTS),
        law: None,
        declared: 1.0,
    };
    while let Some(word) = words.next() {
        if word == "--law" {
            let known = |name: &String| corners::LAWS.contains(&name.as_str());
            call.law = Some(words.next().filter(known).ok_or(format!("--law is one of {}", corners::LAWS.join(", ")))?);
            continue;
        }
        let mut number = || {
            let value = words.next().ok_or(format!("{word} needs a value"))?;
            value.parse::<u64>().map_err(|error| format!("{word} {value}: {error}"))
        };
        match word.as_str() {
            "--rods" => call.rods = true,
            "--bands" => call.bands = true,
            "--quick" => call.quick = true,
            "--smoother" => call.smoother = true,
            "--forward" => call.forward = true,
            "--one-place" => call.two_contacts = None,
            "--two-contacts" => call.two_contacts = Some(number()? as f64 * 1e-3),
            "--explore" => (call.explore, call.worlds) = (true, number()? as usize),
            "--follow" => (call.follow, call.worlds) = (true, number()? as usize),
            "--verbose" => call.verbose = true,
            "--policies" => call.policies = number()?.max(1) as usize,
            "--corners" => (call.corners, call.worlds) = (true, number()? as usize),
            "--whiskers" => call.whiskers = number()?.clamp(1, 64) as usize,
            "--nightly" => call.worlds = NIGHTLY,
            "--worlds" => call.worlds = number()? as usize,
            "--first" => call.first = number()?,
            "--threads" => call.threads = number()?.clamp(1, 256) as usize,
            "--replay" => call.replay = Some(number()?),
            "--declare" => call.declared = number()?.min(100) as f64 / 100.0,
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
                    own.extend(world(seed, call));
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

/// What became of a drive around corners.
struct Cornered {
    seed: u64,
    law: &'static str,
    rows: usize,
    doubled: usize,
    status: Option<Status>,
    volume: f64,
    loss: Option<String>,
}

/// The drive of a seed, if there is one, and a prior about its first pose, but for every third. Errors of every kind are drawn for every
/// second drive.
fn corner_drive(seed: u64, whiskers: usize) -> Option<(corners::Drive, Option<[[f64; 2]; 3]>)> {
    let drive = corners::drive(seed, seed.is_multiple_of(2), whiskers)?;
    let mut draw = Random(seed.wrapping_mul(0x9fb2_1c65_1e98_df25));
    let prior = (!seed.is_multiple_of(3)).then(|| region(&drive.first, &mut draw));
    Some((drive, prior))
}

fn cornered(seed: u64, call: &Call) -> Option<Cornered> {
    let Call { declared, two_contacts, .. } = *call;
    let (drive, prior) = corner_drive(seed, call.whiskers)?;
    let last_work = if prior.is_none() { LAST_WORK } else { NEAR_WORK };
    let options = PossibilisticOptions { last_work, prior, two_contacts, ..Default::default() };
    let options = Method::Possibilistic(options);
    let mut robot = drive.robot.clone();
    for whisker in &mut robot.whiskers {
        whisker.noise.moment_relative *= declared;
        whisker.noise.moment_absolute *= declared;
    }
    let one = Cornered {
        seed,
        law: drive.law,
        rows: drive.log.rows.len(),
        doubled: drive.doubled,
        status: None,
        volume: f64::NAN,
        loss: None,
    };
    Some(match localize(&drive.log, &drive.map, &robot, &options, &mut |_| {}) {
        Ok(found) => {
            let lost = found.status != Status::NoContact && !contains(&found, drive.truth);
            let event = found.events.last().map(|event| (event.t, event.kind));
            let loss = lost.then(|| {
                let kind = if one.doubled > 0 { "two contacts" } else { "one contact" };
                format!("seed {seed} ({kind}, {}, prior {}): {}; {event:?}", one.law, prior.is_some(), found.status)
            });
            let volume = found.steps.last().map_or(f64::NAN, |step| step.volume);
            Cornered { status: Some(found.status), volume, loss, ..one }
        }
        Err(error) => Cornered { loss: Some(format!("seed {seed}: {error}")), ..one },
    })
}

/// What became of the first seeds that give a drive, in the order of these.
fn run_corners(call: &Call) -> Vec<Cornered> {
    all_corners(call, |seed| {
        let one = cornered(seed, call)?;
        one.loss.iter().for_each(|loss| println!("{loss}"));
        Some((seed, one))
    })
}

/// Drives on all threads until there are enough.
fn all_corners<T: Send>(call: &Call, drive: impl Fn(u64) -> Option<(u64, T)> + Sync) -> Vec<T> {
    let (next, done) = (AtomicU64::new(call.first), AtomicU64::new(0));
    let worker = || {
        let mut own = Vec::new();
        while done.load(Ordering::Relaxed) < call.worlds as u64 {
            if let Some(one) = drive(next.fetch_add(1, Ordering::Relaxed)) {
                done.fetch_add(1, Ordering::Relaxed);
                own.push(one);
            }
        }
        own
    };
    let mut all: Vec<(u64, T)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..call.threads).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().flat_map(|w| w.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause))).collect()
    });
    all.sort_by_key(|one| one.0);
    // More threads begin a drive or two more.
    all.truncate(call.worlds);
    all.into_iter().map(|one| one.1).collect()
}

fn corner_report(all: &[Cornered], call: &Call) -> ExitCode {
    let of = |status: Status| all.iter().filter(|one| one.status == Some(status)).count();
    let doubled = || all.iter().filter(|one| one.doubled > 0);
    let lost = all.iter().filter(|one| one.loss.is_some()).count();
    let mut laws: std::collections::BTreeMap<&str, usize> = std::collections::BTreeMap::new();
    all.iter().for_each(|one| *laws.entry(one.law).or_default() += 1);
    println!(
        "corners: {} drives (seeds {} to {}) of {} rows, {} with two contacts in {} drives: truth lost in {lost} ({} with two \
         contacts); localized {}, ambiguous {}, inconsistent {}, no contact {}; noise {laws:?}; \
         volume of the set at the end: median {:.1e} m² rad",
        all.len(),
        call.first,
        all.last().map_or(call.first, |one| one.seed),
        all.iter().map(|one| one.rows).sum::<usize>(),
        doubled().map(|one| one.doubled).sum::<usize>(),
        doubled().count(),
        doubled().filter(|one| one.loss.is_some()).count(),
        of(Status::Localized),
        of(Status::Ambiguous),
        of(Status::Inconsistent),
        of(Status::NoContact),
        median(all.iter().map(|one| one.volume).collect()),
    );
    if lost == 0 && !all.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// What the method tells of a trial, without a prior or with one, when readings are declared with this share of their bounds.
fn answer(trial: &Trial, prior: Option<[[f64; 2]; 3]>, declared: f64, quick: bool) -> vibrissa::Result<Localization> {
    let last_work = if quick {
        0
    } else if prior.is_none() {
        LAST_WORK
    } else {
        NEAR_WORK
    };
    let possibilistic = PossibilisticOptions { last_work, prior, ..PossibilisticOptions::default() };
    let options = Method::Possibilistic(possibilistic);
    let mut robot = trial.robot.clone();
    for whisker in &mut robot.whiskers {
        whisker.noise.moment_relative *= declared;
        whisker.noise.moment_absolute *= declared;
    }
    localize(&trial.log, &trial.map, &robot, &options, &mut |_| {})
}

/// A region that holds the first true pose (m, m, rad), often at its edge.
fn about(trial: &Trial, seed: u64) -> Option<[[f64; 2]; 3]> {
    Some(region(trial.path.first()?, &mut Random(seed.wrapping_mul(0xd134_2543_de82_ef95))))
}

fn region(first: &Pose2, draw: &mut Random) -> [[f64; 2]; 3] {
    let mut side = |truth: f64, widest: f64| {
        let (half, off) = (draw.between(0.05, 1.0) * widest, (1.2 * draw.signed(1.0)).clamp(-0.999_999, 0.999_999));
        [truth + (off - 1.0) * half, truth + (off + 1.0) * half]
    };
    [side(first.x, 0.04), side(first.y, 0.04), side(first.theta, 0.4)]
}

/// What became of one answer.
struct Judged {
    status: Option<Status>,
    /// Volumes of the set (m² rad) after its first and its last reading.
    volumes: [f64; 2],
    loss: Option<String>,
}

fn judged(trial: &Trial, prior: Option<[[f64; 2]; 3]>, declared: f64, quick: bool) -> Judged {
    match answer(trial, prior, declared, quick) {
        Ok(found) => {
            let lost = found.status != Status::NoContact && !contains(&found, trial.truth);
            let loss = || format!("{}, lost {:?}; {:?}", found.status, trial.truth, found.events.last());
            let volume = |step: Option<&StepRecord>| step.map_or(f64::NAN, |step| step.volume);
            let volumes = [volume(found.steps.first()), volume(found.steps.last())].map(|volume| volume + 0.0);
            Judged { status: Some(found.status), volumes, loss: lost.then(loss) }
        }
        Err(error) => Judged { status: None, volumes: [f64::NAN; 2], loss: Some(error.to_string()) },
    }
}

/// The world of a seed, if there is one.
fn trial(seed: u64, call: &Call) -> Option<Trial> {
    let is_rod = call.rods || seed.is_multiple_of(ROD_EVERY);
    let trial = random_sweep_of(seed, is_rod)?;
    if !call.bands {
        return Some(trial);
    }
    let map = banded::drawn(&trial.map, &mut Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d)), call.declared)?;
    Some(Trial { map, ..trial })
}

/// The world of a seed, if there is one: localized without a prior and with one.
fn world(seed: u64, call: &Call) -> Option<Outcome> {
    let is_rod = call.rods || seed.is_multiple_of(ROD_EVERY);
    let trial = trial(seed, call)?;
    // Bands are told too small alone, where they are.
    let (declared, quick) = (if call.bands { 1.0 } else { call.declared }, call.quick);
    let (rows, [.., inflected, curled]) = (trial.log.rows.len(), trial.kinds);
    let (anywhere, near) =
        (judged(&trial, None, declared, quick), judged(&trial, about(&trial, seed), declared, quick));
    let told = |name: &str, loss: String| format!("seed {seed}, {name}: {loss}");
    let loss = anywhere.loss.map(|loss| told("without a prior", loss));
    let loss = loss.or(near.loss.map(|loss| told("with a prior", loss)));
    let volumes = [anywhere.volumes[0], near.volumes[1]];
    Some(Outcome { seed, rows, is_rod, inflected, curled, status: near.status, volumes, loss })
}

/// The middle of these values; NaN of none.
fn median(mut values: Vec<f64>) -> f64 {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn report(outcomes: &[Outcome], call: &Call) -> ExitCode {
    let of = |status: Status| outcomes.iter().filter(|o| o.status == Some(status)).count();
    let lost: Vec<u64> = outcomes.iter().filter(|o| o.loss.is_some()).map(|o| o.seed).collect();
    for seed in &lost {
        let kind = if call.rods { "--rods " } else { "" }.to_owned() + if call.bands { "--bands " } else { "" };
        println!("replay: cargo run --release -p vibrissa-soundness -- {kind}--replay {seed}");
    }
    println!(
        "soundness: {} worlds (seeds {} to {}), {} of them with whiskers that are not uniform, of {} rows: truth lost in {}; localized {}, ambiguous {}, \
         inconsistent {}, no contact {}; {} rows with an inflection in {} worlds, \
         {} of a slope beyond 2 rad in {}; \
         volume of the set: median {:.1e} m² rad at its start, {:.1e} at the end with a prior",
        outcomes.len(),
        call.first,
        outcomes.last().map_or(call.first, |o| o.seed),
        outcomes.iter().filter(|o| o.is_rod).count(),
        outcomes.iter().map(|o| o.rows).sum::<usize>(),
        lost.len(),
        of(Status::Localized),
        of(Status::Ambiguous),
        of(Status::Inconsistent),
        of(Status::NoContact),
        outcomes.iter().map(|o| o.inflected).sum::<usize>(),
        outcomes.iter().filter(|o| o.inflected > 0).count(),
        outcomes.iter().map(|o| o.curled).sum::<usize>(),
        outcomes.iter().filter(|o| o.curled > 0).count(),
        median(outcomes.iter().map(|o| o.volumes[0]).collect()),
        median(outcomes.iter().map(|o| o.volumes[1]).collect()),
    );
    if lost.is_empty() && !outcomes.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// One world in full: its size and verdict, and every event.
fn replay(seed: u64, call: &Call) -> ExitCode {
    let declared = if call.bands { 1.0 } else { call.declared };
    let Some(trial) = trial(seed, call) else {
        println!("the seed {seed} gives no sweep");
        return ExitCode::from(2);
    };
    println!("seed {seed}: {} rows, robot {:?}, truth {:?}", trial.log.rows.len(), trial.robot, trial.truth);
    let Some(outcome) = world(seed, call) else { return ExitCode::from(2) };
    for (name, prior) in [("without a prior", None), ("with a prior", about(&trial, seed))] {
        println!("{name} {prior:?}:");
        for event in answer(&trial, prior, declared, false).map(|found| found.events).unwrap_or_default() {
            println!("  {:.3} s {}: {}", event.t, event.kind, event.detail);
        }
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
