//! How long a slice of a localizer's work takes, by every method: between two of them a caller can answer others.
//!
//! `cargo run --release --example slice_cost -- [UNITS] [SEEDS]` localizes the built-in drive of so many seeds (1) in slices of so many units
//! (400, as the studio's worker does). One line for each method: slices, then microseconds of one of a row and of the end: median, 99th
//! percentile, longest.

use std::time::Instant;
use vibrissa::localizer::{Localizer, Method};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Error, Result, WorkBudget};

/// Works until nothing is left; how long each slice takes (µs).
fn worked(localizer: &mut Localizer<'_>, units: usize, times: &mut Vec<f64>) {
    loop {
        let begun = Instant::now();
        let is_done = localizer.advance(&mut WorkBudget::new(units));
        times.push(1e6 * begun.elapsed().as_secs_f64());
        if is_done {
            return;
        }
    }
}

/// Median, 99th percentile and longest.
fn spread(mut times: Vec<f64>) -> String {
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times.get((share * (times.len().max(1) - 1) as f64) as usize).copied().unwrap_or(f64::NAN);
    format!("{:10.1}{:10.1}{:10.1}", at(0.5), at(0.99), at(1.0))
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let mut number = |default: usize| {
        let given = arguments.next().map(|word| word.parse());
        given.unwrap_or(Ok(default)).map_err(|_| Error::usage("slice_cost [UNITS] [SEEDS], both whole numbers"))
    };
    let (units, seeds) = (number(400)?, number(1)?);
    let (map, robot) = (demo::arena()?, Robot::default());
    println!(
        "{:14}{:>9}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}",
        "method", "slices", "p50", "p99", "most", "end p50", "p99", "most"
    );
    for method in Method::all() {
        let (mut rows, mut ends) = (Vec::new(), Vec::new());
        for seed in 1..=seeds as u64 {
            let sweep = demo::sweep(seed)?;
            let mut localizer = Localizer::new(&map, &robot, &sweep.log.channels, &method)?;
            for row in &sweep.log.rows {
                let begun = Instant::now();
                localizer.begin(row)?;
                rows.push(1e6 * begun.elapsed().as_secs_f64());
                worked(&mut localizer, units, &mut rows);
            }
            localizer.end();
            worked(&mut localizer, units, &mut ends);
        }
        let slices = rows.len() + ends.len();
        println!("{:14}{slices:9}{}{}", method.name(), spread(rows), spread(ends));
    }
    Ok(())
}
