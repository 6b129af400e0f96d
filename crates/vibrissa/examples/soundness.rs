//! Whether the possibilistic method ever loses the truth: random maps, whiskers, mounts, paths and bounds.
//!
//! `cargo run --release --example soundness -- [TRIALS] [FIRST_SEED]`. Errors of readings and odometry are drawn at the
//! edge of their bounds half of the time, with signs that stay. Tip and side touch walls, corners, posts and the ends of
//! thin walls, a third of the time with friction. A trial is cut off where one contact no longer explains what the
//! whisker does, and used as far as it goes. Every loss is printed with the seed that replays it.

#[path = "../tests/data/random_sweep.rs"]
mod random_sweep;

use random_sweep::{Trial, contains, random_sweep};
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::Status;
use vibrissa::{Method, Result, localize};

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (trials, first) = (arguments.next().unwrap_or(100), arguments.next().unwrap_or(1));
    let possibilistic = PossibilisticOptions { last_work: 5_000, ..PossibilisticOptions::default() };
    let options = Method::Possibilistic(possibilistic);
    let (mut run, mut lost, mut rows, mut verdicts, mut seed) = (0, 0, 0, [0; 4], first);
    let (mut kinds, mut rubbing) = ([0; 4], 0);
    while run < trials {
        seed += 1;
        let Some(trial) = random_sweep(seed) else { continue };
        run += 1;
        rows += trial.log.rows.len();
        kinds.iter_mut().zip(trial.kinds).for_each(|(all, one)| *all += one);
        rubbing += usize::from(trial.robot.whiskers[0].friction > 0.0);
        let answer = localize(&trial.log, &trial.map, &trial.robot, &options, &mut |_| {})?;
        verdicts[match answer.status {
            Status::Localized => 0,
            Status::Ambiguous => 1,
            Status::Inconsistent => 2,
            Status::NoContact => 3,
        }] += 1;
        if answer.status != Status::NoContact && !contains(&answer, trial.truth) {
            lost += 1;
            println!("seed {seed}: {} lost {:?}, {:?}", answer.status, trial.truth, answer.events.last());
            show_loss(&trial, &options)?;
        }
        if run % 250 == 0 {
            println!("{run} trials up to seed {seed}: truth lost in {lost}");
        }
    }
    let [localized, ambiguous, inconsistent, no_contact] = verdicts;
    println!(
        "{run} trials of {rows} rows: truth lost in {lost}; localized {localized}, ambiguous {ambiguous}, \
         inconsistent {inconsistent}, no contact {no_contact}; seeds {first} to {seed}"
    );
    let [side, left, right, inflected] = kinds;
    println!(
        "rows: {side} with the side, {left} bent to the left, {right} to the right, {inflected} with an inflection; \
         {rubbing} trials with friction"
    );
    Ok(())
}

/// Prints a row at which the truth goes, by halving the log, and the touches there.
fn show_loss(trial: &Trial, options: &Method) -> Result<()> {
    let whisker = &trial.robot.whiskers[0];
    let (mut kept, mut gone) = (0, trial.log.rows.len());
    while gone > kept + 1 {
        let rows = (kept + gone) / 2;
        let mut log = trial.log.clone();
        log.rows.truncate(rows);
        let answer = localize(&log, &trial.map, &trial.robot, options, &mut |_| {})?;
        let lost = answer.status != Status::NoContact && !contains(&answer, trial.path[rows - 1]);
        if lost { gone = rows } else { kept = rows }
    }
    println!("  lost after {gone} of {} rows; {whisker:?}", trial.log.rows.len());
    for touch in &trial.touches {
        if touch.row.abs_diff(gone) < 4 {
            println!("  reads {:.3e}: {touch:?}", trial.log.rows[touch.row].readings[0]);
        }
    }
    Ok(())
}
