//! Draws random contacts, reads them by every virtual sensor, and counts how often the contact sets lose them.
//!
//! Usage: `cargo run --release --example random_readings [-- TRIALS [REGION_TRIALS]]`

#![allow(clippy::unwrap_used, reason = "a program for the maintainers")]

#[path = "../tests/data/random.rs"]
mod random;
#[path = "../tests/data/whiskers.rs"]
mod whiskers;

use random::Random;
use std::time::Instant;
use vibrissa::flow::contact_set::{ContactRegion, ContactSet, Reading, Resolution};
use vibrissa::sets::Interval;
use whiskers::{SENSORS, kinds, random_contact};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut numbers = std::env::args().skip(1).map(|a| a.parse::<usize>());
    let curve_trials = numbers.next().transpose()?.unwrap_or(100_000);
    let region_trials = numbers.next().transpose()?.unwrap_or(curve_trials / 50);
    let kinds = kinds();
    let worth: usize = kinds.iter().map(|(_, _, w)| w).sum();
    println!(
        "| whisker | curves: trials | lost | worst gap beyond tolerance (m) | regions: trials | lost | ms a region |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let mut random = Random(20);
    for (name, model, weight) in &kinds {
        let (trials, regions) = (curve_trials * weight / worth, (region_trials * weight / worth).max(40));
        let (mut lost, mut worst, mut lost_regions) = (0, f64::NEG_INFINITY, 0);
        for trial in 0..trials {
            let contact = random_contact(&mut random, model);
            let sensor = SENSORS[trial % 4];
            let set = ContactSet::new(model, sensor, sensor.read(&contact), 200)?;
            let beyond = set.distance(contact.position) - set.tolerance;
            worst = worst.max(beyond);
            lost += usize::from(beyond > 1e-9);
        }
        let clock = Instant::now();
        for trial in 0..regions {
            let contact = random_contact(&mut random, model);
            let sensor = SENSORS[trial % 4];
            let value = sensor.read(&contact);
            let width = 0.05 * value.abs();
            let value = Interval::new(value - width * random.unit(), value + width * random.unit());
            let region = ContactRegion::new(model, &[Reading { sensor, value }], &Resolution::even(1e-3, 0.3))?;
            lost_regions += usize::from(!region.explains(&contact));
        }
        let each = clock.elapsed().as_secs_f64() * 1e3 / regions as f64;
        println!("| {name} | {trials} | {lost} | {worst:.1e} | {regions} | {lost_regions} | {each:.2} |");
    }
    Ok(())
}
