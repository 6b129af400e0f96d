//! Whether the possibilistic method ever loses the truth: random maps, whiskers, mounts, paths and bounds.
//!
//! `cargo run --release --example soundness -- [TRIALS] [FIRST_SEED]`. Errors of readings and odometry are drawn at the
//! edge of their bounds half of the time, with signs that stay. A trial that the simulator refuses (contact with the
//! whisker's side) is cut off before that and used as far as it goes, or replaced. Every loss is printed with the seed
//! that replays it.

#[path = "../tests/data/random_sweep.rs"]
mod random_sweep;

use random_sweep::{contains, random_sweep};
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::{Method, Status};
use vibrissa::{LocalizeOptions, Result, localize};

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (trials, first) = (arguments.next().unwrap_or(100), arguments.next().unwrap_or(1));
    let possibilistic = PossibilisticOptions { last_work: 5_000, ..PossibilisticOptions::default() };
    let options = LocalizeOptions { method: Method::Possibilistic, possibilistic, ..LocalizeOptions::default() };
    let (mut run, mut lost, mut rows, mut verdicts, mut seed) = (0, 0, 0, [0; 4], first);
    while run < trials {
        seed += 1;
        let Some(trial) = random_sweep(seed) else { continue };
        run += 1;
        rows += trial.log.rows.len();
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
        }
    }
    let [localized, ambiguous, inconsistent, no_contact] = verdicts;
    println!(
        "{run} trials of {rows} rows: truth lost in {lost}; localized {localized}, ambiguous {ambiguous}, \
         inconsistent {inconsistent}, no contact {no_contact}"
    );
    Ok(())
}
