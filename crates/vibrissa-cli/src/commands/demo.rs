//! `vibrissa demo`: the main job without any file.

use super::localize::outlines;
use crate::output::OutputArgs;
use crate::output::{Run, Stopwatch, deliver, print};
use std::path::Path;
use vibrissa::config::defaults::SEED;
use vibrissa::io::format_tum;
use vibrissa::io::log::to_csv;
use vibrissa::sim::{Sweep, contacts_csv};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, Result, localize};

/// Simulate a sweep in the built-in arena, localize, and compare with the truth.
///
/// A whisker is swept along the arena's upper wall and felt with 5 % noise; where the robot is, is found from these
/// readings and the map alone, and compared with the truth.
///
/// With --out DIR: all files of `localize`, and the files that it works on: log.csv, map.svg, truth.tum, contacts.csv.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The seed of the noise; the same seed gives the same readings
    #[arg(long, value_name = "N", default_value_t = SEED)]
    seed: u64,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let sweep = demo::sweep(args.seed)?;
    deliver(&localized(&sweep, args.seed)?, &args.output)?;
    match &args.output.out {
        Some(folder) if !args.output.json => print(&next_step(folder)),
        _ => Ok(()),
    }
}

/// The sweep, localized.
fn localized(sweep: &Sweep, seed: u64) -> Result<Run> {
    let map = demo::arena()?;
    let mut stopwatch = Stopwatch::start();
    let answer = localize(&sweep.log, &map, &Robot::default(), &Method::default(), &mut |_row| stopwatch.lap())?;
    let runtime = stopwatch.stop(&sweep.log.rows, &answer.steps);
    Ok(Run {
        title: format!("demo: simulated sweep (seed {seed}) in the built-in arena"),
        answer,
        runtime,
        rows: sweep.log.rows.len(),
        interrupted: false,
        map: outlines(&map),
        truth: Some(sweep.truth.clone()),
        recording: None,
        film: None,
        inputs: input_files(sweep),
    })
}

/// The files that a localization needs, and those that say what is true.
fn input_files(sweep: &Sweep) -> Vec<(&'static str, String)> {
    vec![
        ("log.csv", to_csv(&sweep.log)),
        ("map.svg", demo::ARENA_SVG.to_owned()),
        ("truth.tum", format_tum(&sweep.truth)),
        ("contacts.csv", contacts_csv(sweep)),
    ]
}

/// What to try with the files.
fn next_step(folder: &Path) -> String {
    let [log, map, truth] = ["log.csv", "map.svg", "truth.tum"].map(|name| folder.join(name).display().to_string());
    format!("\nNext, the same from these files:\n  vibrissa localize {log} --map {map} --truth {truth}\n")
}
