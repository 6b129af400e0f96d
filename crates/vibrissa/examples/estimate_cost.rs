//! What it costs to ask a localizer for its estimate while rows come in, by every method.
//!
//! `cargo run --release --example estimate_cost -- FOLDER [ONLY]` takes every `NAME.csv` of a folder with a `NAME.truth.tum`, on its map `MAP.geojson`
//! (`MAP` up to the first `-`), those of names that begin with `ONLY`, and asks after each row from the first contact on. One line
//! for each method: rows, then microseconds of a call: median, 99th percentile, longest; and the share of one core that thirty
//! median calls a second take.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;
use vibrissa::flow::pose::Status;
use vibrissa::localizer::{Localizer, Method};
use vibrissa::world::Robot;
use vibrissa::{Error, Result};

/// Calls a second in live use.
const RATE: f64 = 30.0;

/// The names of the sweeps in a folder that begin so.
fn names(folder: &Path, only: &str) -> Result<Vec<String>> {
    let files = std::fs::read_dir(folder).map_err(|error| Error::data(error.to_string()))?;
    let name =
        |file: std::fs::DirEntry| file.file_name().into_string().ok()?.strip_suffix(".truth.tum").map(str::to_owned);
    let mut names: Vec<String> = files.filter_map(|file| name(file.ok()?)).filter(|n| n.starts_with(only)).collect();
    names.sort();
    Ok(names)
}

/// How long each estimate of a sweep takes (µs), from the first contact on.
fn timed(folder: &Path, name: &str, method: &Method) -> Result<Vec<f64>> {
    let map = vibrissa::read_map(folder.join(format!("{}.geojson", name.split('-').next().unwrap_or_default())))?;
    let (log, robot) = (vibrissa::read_log(folder.join(format!("{name}.csv")))?, Robot::default());
    let mut localizer = Localizer::new(&map, &robot, &log.channels, method)?;
    let mut times = Vec::new();
    for row in &log.rows {
        localizer.step(row)?;
        let begun = Instant::now();
        let estimate = black_box(localizer.estimate());
        let time = 1e6 * begun.elapsed().as_secs_f64();
        if estimate.status != Status::NoContact {
            times.push(time);
        }
    }
    Ok(times)
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or_else(|| Error::usage("a folder of sweeps is missing"))?;
    let only = arguments.next().unwrap_or_default();
    let names = names(Path::new(&folder), &only)?;
    println!("{:14}{:>8}{:>10}{:>10}{:>10}{:>10}", "method", "rows", "p50 us", "p99 us", "most us", "30 Hz %");
    for method in Method::all() {
        let mut times = Vec::new();
        for name in &names {
            times.extend(timed(Path::new(&folder), name, &method)?);
        }
        times.sort_by(f64::total_cmp);
        let at =
            |share: f64| times.get((share * (times.len().max(1) - 1) as f64) as usize).copied().unwrap_or(f64::NAN);
        let share = 100.0 * RATE * 1e-6 * at(0.5);
        println!("{method:14}{:8}{:10.1}{:10.1}{:10.1}{share:10.3}", times.len(), at(0.5), at(0.99), at(1.0));
    }
    Ok(())
}
