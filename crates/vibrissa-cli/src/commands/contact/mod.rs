//! `vibrissa contact`: where the whisker was touched.

mod steps;
mod taps;

use crate::output::OutputArgs;
use std::path::PathBuf;
use vibrissa::io::log::foreign::Format;
use vibrissa::{Error, Result};

/// Find where a whisker was touched, step by step.
///
/// The log is a CSV file with the columns `t,x,y,theta,moment` (s, m, rad, N m); the robot is a .toml file and defaults to
/// the paper's whisker. A contact that stands still is found from all the readings of the base's motion; a tip that slides
/// is traced along a smooth wall. The closed forms of earlier work stand beside it.
///
/// With --taps: the radial distance of each short contact of a base that turns at the rate of the calibration.
///
/// With --out DIR: contacts.csv and the figure contacts.svg; with --taps, taps.csv.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor log (.csv), or the recording of taps
    log: PathBuf,
    /// The robot's whiskers and error bounds (.toml) [default: the paper's whisker at the robot's origin]
    #[arg(long, value_name = "ROBOT", conflicts_with = "taps")]
    robot: Option<PathBuf>,
    /// Taps: one distance for each short contact
    #[arg(long, requires = "calibration")]
    taps: bool,
    /// The calibration of the taps (cal.json), made by `vibrissa calibrate`
    #[arg(long, value_name = "CAL", requires = "taps")]
    calibration: Option<PathBuf>,
    /// The format of the recording: serial, serial2, ratatouille, openwhisker, rostopic, csv [default for taps: csv
    /// where the first line names a column t, else ratatouille]
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// The sensor that feels the ambient field alone, subtracted from the calibration's
    #[arg(long, value_name = "SENSOR", requires = "taps")]
    reference: Option<String>,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    match &args.calibration {
        Some(calibration) => taps::run(&args.log, calibration, args.format, args.reference.as_deref(), &args.output),
        None if args.taps => Err(Error::usage("--taps needs --calibration").remedy("add --calibration cal.json")),
        None => steps::run(&args.log, args.robot.as_deref(), args.format, &args.output),
    }
}
