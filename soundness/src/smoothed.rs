//! The drives around corners by the probabilistic method: whether its 95 % regions hold the truth, and what it cannot explain.

use crate::random_sweep::contains;
use crate::region::{CHI2_95, distance};
use crate::ridge::off_ridge;
use crate::{Call, corner_drive};
use std::process::ExitCode;
use std::time::Instant;
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Hypothesis, Localization, Status};
use vibrissa::plane::Pose2;
use vibrissa::{Method, localize};

/// A truth this near to a ridge is on it: m, rad.
const ON_RIDGE: (f64, f64) = (1e-3, 0.02);
/// A localized pose further off than this is wrong (m).
const WRONG: f64 = 0.05;
/// Shares of truths in the regions that mean what they say.
const HELD: (f64, f64) = (0.93, 0.97);

/// What became of a drive.
pub(crate) struct Smoothed {
    law: &'static str,
    has_prior: bool,
    doubled: bool,
    rows: usize,
    seconds: f64,
    /// None where it was refused.
    status: Option<Status>,
    /// Whether a 95 % region or a ridge holds the truth.
    is_held: bool,
    /// Off the truth (m), where localized.
    error: Option<f64>,
}

/// The drive of a seed, if there is one; losses are printed.
pub(crate) fn drive(seed: u64, call: &Call) -> Option<(u64, Smoothed)> {
    let (drive, prior) = corner_drive(seed, call.whiskers)?;
    if call.law.as_ref().is_some_and(|law| law != drive.law) {
        return None;
    }
    let mut robot = drive.robot.clone();
    for whisker in &mut robot.whiskers {
        whisker.noise.moment_relative *= call.declared;
        whisker.noise.moment_absolute *= call.declared;
    }
    let options = ProbabilisticOptions { prior, ..ProbabilisticOptions::default() };
    let began = Instant::now();
    let answer = localize(&drive.log, &drive.map, &robot, &Method::Probabilistic(options), &mut |_| {});
    let seconds = began.elapsed().as_secs_f64();
    let (doubled, has_prior) = (drive.doubled > 0, prior.is_some());
    let told = |what: &str| {
        let kind = if doubled { "two contacts" } else { "one contact" };
        println!("seed {seed} ({kind}, {}, prior {has_prior}, {} rows): {what}", drive.law, drive.log.rows.len());
    };
    let one = Smoothed {
        law: drive.law,
        has_prior,
        doubled,
        rows: drive.log.rows.len(),
        seconds,
        status: None,
        is_held: false,
        error: None,
    };
    let found = match answer {
        Ok(found) => found,
        Err(error) => {
            told(&error.to_string());
            return Some((seed, one));
        }
    };
    let off = |h: &Hypothesis| h.pose.position().distance(drive.truth.position());
    let best = found.hypotheses.first();
    let is_held = holds(&found, drive.truth);
    if !is_held && found.status != Status::NoContact {
        let best = best.map_or(f64::NAN, |h| 1e3 * off(h));
        let event = found.events.last().map(|event| (event.t, event.kind));
        let squared = found.hypotheses.iter().map(|h| distance(h, drive.truth)).fold(f64::INFINITY, f64::min);
        let places = found.hypotheses.len();
        told(&format!("{}, best {best:.2} mm off, squared {squared:.1}, of {places} places; {event:?}", found.status));
    }
    let error = best.filter(|_| found.status == Status::Localized).map(off);
    Some((seed, Smoothed { status: Some(found.status), is_held, error, ..one }))
}

/// Whether a region or a ridge holds the truth; a method that tells no place leaves all possible.
fn holds(found: &Localization, truth: Pose2) -> bool {
    let on_ridge = |h: &Hypothesis| {
        off_ridge(&h.ridge, truth).is_some_and(|(place, turn)| place <= ON_RIDGE.0 && turn <= ON_RIDGE.1)
    };
    if found.encloses {
        return contains(found, truth);
    }
    found.status == Status::Ambiguous && found.hypotheses.is_empty()
        || found.hypotheses.iter().any(|h| distance(h, truth) <= CHI2_95 || on_ridge(h))
}

/// Counts of all drives that touched something; fails where regions do not mean what they say or a drive is `inconsistent`.
pub(crate) fn report(all: &[Smoothed]) -> ExitCode {
    let touched: Vec<&Smoothed> = all.iter().filter(|one| one.status != Some(Status::NoContact)).collect();
    let line = |name: &str, of: &dyn Fn(&Smoothed) -> bool| {
        let some: Vec<&&Smoothed> = touched.iter().filter(|one| of(one)).collect();
        let count = |status: Status| some.iter().filter(|one| one.status == Some(status)).count();
        let held = some.iter().filter(|one| one.is_held).count();
        let wrong = some.iter().filter(|one| one.error.is_some_and(|error| error > WRONG)).count();
        let mut errors: Vec<f64> = some.iter().filter_map(|one| one.error).collect();
        errors.sort_by(f64::total_cmp);
        let median = errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN);
        println!(
            "| {name} | {} | {:.1} % | {} | {} | {} | {wrong} | {:.2} mm |",
            some.len(),
            100.0 * held as f64 / some.len().max(1) as f64,
            count(Status::Localized),
            count(Status::Ambiguous),
            count(Status::Inconsistent),
            1e3 * median,
        );
    };
    println!("| drives | count | truth held | localized | ambiguous | inconsistent | wrong | median error |");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut laws: Vec<&str> = all.iter().map(|one| one.law).collect();
    laws.sort_unstable();
    laws.dedup();
    for law in laws {
        line(law, &|one| one.law == law);
    }
    line("one contact at a time", &|one| !one.doubled);
    line("two contacts at once", &|one| one.doubled);
    line("without a prior", &|one| !one.has_prior);
    line("all", &|_| true);
    let (rows, seconds) = all.iter().fold((0, 0.0), |(rows, s), one| (rows + one.rows, s + one.seconds));
    println!("{rows} rows, {:.0} rows a second of one thread", rows as f64 / seconds);
    let held = touched.iter().filter(|one| one.is_held).count() as f64 / touched.len().max(1) as f64;
    let inconsistent = touched.iter().any(|one| one.status == Some(Status::Inconsistent));
    if (HELD.0..=HELD.1).contains(&held) && !inconsistent { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
