//! `vibrissa simulate`: a sweep from a scenario file.

mod report;

use super::localize::outlines;
use crate::interrupt::{Heedful, stop, stopped};
use crate::output::{OutputArgs, print, progress, warn, write_bytes};
use std::path::PathBuf;
use vibrissa::io::format_tum;
use vibrissa::io::log::to_csv;
#[cfg(feature = "mcap")]
use vibrissa::sim::recording::sweep_mcap;
use vibrissa::sim::{Scenario, Simulation};
use vibrissa::sim::{contacts_csv, shapes};
use vibrissa::{Error, Result};

/// Simulate a sweep: what a robot with whiskers feels along a path through a map.
///
/// The scenario is a .toml file: a map, a robot, a path, its sensors and their errors; docs/scenarios.md has every key
/// and scenarios/ has examples.
///
/// With --out DIR: log.csv, truth.tum, contacts.csv, robot.toml and the figure simulate.svg; map.geojson where the map is
/// written in the scenario, serial.txt where it asks for one; with --dump also shapes.csv and exact.csv; with --mcap also
/// log.mcap, the log as ROS 2 messages with map, truth and whisker shapes.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The scenario (.toml)
    scenario: PathBuf,
    /// The seed of all noise, instead of the scenario's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Write the shape of every whisker at every row (shapes.csv) and the moments without noise (exact.csv)
    #[arg(long, requires = "out")]
    dump: bool,
    /// Write the log as ROS 2 messages too, with map, truth and whisker shapes (log.mcap)
    #[cfg(feature = "mcap")]
    #[arg(long, requires = "out")]
    mcap: bool,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let scenario = read(args)?;
    let rows = scenario.path.len() * scenario.robot.whiskers.len();
    progress::phase("simulating");
    let heeds = Heedful::hurried();
    let sweep = scenario.sweep_until(&stop(), &mut |done| progress::count(done, rows))?;
    // What is recorded of a long sweep takes as long as it is long: the work that is interrupted ends here.
    drop(heeds);
    let (poses, all) = (sweep.truth.len(), scenario.path.len());
    if poses == 0 && stopped() {
        warn("interrupted before the first row: no results are written");
        return Ok(());
    }
    if poses < all {
        warn(&format!("interrupted: the sweep ends after {poses} of {all} rows"));
    }
    progress::phase("writing");
    let simulation = scenario.recorded(sweep)?;
    simulation.warnings.iter().for_each(|warning| warn(warning));
    let written = match args.output.destination() {
        Some(to) => {
            let texts = files(&scenario, &simulation, args.dump);
            let mut files: Vec<(&str, &[u8])> = texts.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
            let recording = recording(args, &scenario, &simulation)?;
            files.extend(recording.as_deref().map(|bytes| ("log.mcap", bytes)));
            Some(write_bytes(to, &files)?)
        }
        None => None,
    };
    if args.output.json {
        print(&report::json(&scenario, &simulation)?)
    } else {
        print(&report::text(&scenario, &simulation, written.as_deref()))
    }
}

/// The log as a recording, where it is asked for.
#[cfg(feature = "mcap")]
fn recording(args: &Args, scenario: &Scenario, simulation: &Simulation) -> Result<Option<Vec<u8>>> {
    let made = || sweep_mcap(&scenario.map, &simulation.robot, &simulation.sweep, &simulation.recording.log);
    args.mcap.then(made).transpose()
}

#[cfg(not(feature = "mcap"))]
fn recording(_: &Args, _: &Scenario, _: &Simulation) -> Result<Option<Vec<u8>>> {
    Ok(None)
}

fn read(args: &Args) -> Result<Scenario> {
    let scenario = Scenario::read(&args.scenario)?;
    Ok(match args.seed {
        Some(seed) => scenario.with_seed(seed),
        None => scenario,
    })
}

fn files(scenario: &Scenario, simulation: &Simulation, dump: bool) -> Vec<(&'static str, String)> {
    let sweep = &simulation.sweep;
    let mut files = vec![
        ("log.csv", to_csv(&simulation.recording.log)),
        ("truth.tum", format_tum(&sweep.truth)),
        ("contacts.csv", contacts_csv(sweep)),
        ("simulate.svg", report::figure(scenario, simulation, &outlines(&scenario.map))),
    ];
    files.push(("robot.toml", vibrissa::io::robot::to_toml(&scenario.robot)));
    if scenario.map_file.is_none() {
        files.push(("map.geojson", vibrissa::io::map::to_geojson(&scenario.map)));
    }
    files.extend(simulation.serial.clone().map(|text| ("serial.txt", text)));
    if dump {
        files.push(("shapes.csv", report::shapes_csv(scenario, sweep, &shapes(&simulation.robot, sweep, 1))));
        files.push(("exact.csv", report::exact_csv(scenario, sweep)));
    }
    files
}

/// An error of serialization, which no scenario can cause.
fn cannot_encode(error: &serde_json::Error) -> Error {
    Error::data(format!("cannot write the result as JSON ({error})"))
}
