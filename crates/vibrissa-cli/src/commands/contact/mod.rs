//! `vibrissa contact`: where the whisker was touched.

mod filter;
mod space;
mod steps;
mod taps;

use crate::commands::logs::{ImuArgs, read_log};
use crate::output::OutputArgs;
use crate::quantity::of_option as quantity;
use std::path::PathBuf;
use vibrissa::io::Dimension;
use vibrissa::io::log::foreign::Format;
use vibrissa::tasks::temporal_filter::TemporalFilterOptions;
use vibrissa::{Error, Result};

/// Find where a whisker was touched, step by step.
///
/// The log is a CSV file with the columns `t,x,y,theta,moment` (s, m, rad, N m); the robot is a .toml file and defaults to
/// the paper's whisker. A contact that stands still is found from all the readings of the base's motion; a tip that slides
/// is traced along a smooth wall. The closed forms of earlier work stand beside it.
///
/// With --filter: temporal filtering. The contact sets of several readings (force, slope, strip, moment) are
/// moved along with the base and intersected; the contact is taken to stand still meanwhile.
///
/// With --space: contacts in space, from the columns `moment` and `across` or from flux with a calibration of both axes. Tells where the contact
/// is along the whisker, away from its axis and around it, and warns when it is out of the plane or slides around.
///
/// With --taps: the radial distance of each short contact of a base that turns at the rate of the calibration.
///
/// With --out DIR: contacts.csv and the figure contacts.svg; with --taps, taps.csv; with
/// --filter, filter.csv and filter.svg; with --space, space.csv and space.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor log (.csv), or the recording of taps
    log: PathBuf,
    /// The robot's whiskers and error bounds (.toml) [default: the paper's whisker at the robot's origin]
    #[arg(long, value_name = "ROBOT", conflicts_with = "taps")]
    robot: Option<PathBuf>,
    /// Intersect the contact sets of several readings instead of tracing contacts
    #[arg(long, conflicts_with = "taps")]
    filter: bool,
    /// Contacts in space, from the moments about both transverse axes
    #[arg(long, conflicts_with_all = ["taps", "filter"])]
    space: bool,
    /// How many readings are intersected
    #[arg(long, value_name = "N", requires = "filter", default_value_t = TemporalFilterOptions::default().readings)]
    readings: usize,
    /// How far the base moves between two of them
    #[arg(long, value_name = "LENGTH", requires = "filter",
          default_value = format!("{} mm", 1e3 * TemporalFilterOptions::default().spacing))]
    spacing: String,
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
    #[command(flatten)]
    imu: ImuArgs,
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
        None if args.filter => {
            let spacing = quantity("--spacing", &args.spacing, Dimension::Length)?;
            let options =
                TemporalFilterOptions { readings: args.readings, spacing, ..TemporalFilterOptions::default() };
            let read = read_log(&args.log, args.format, &args.imu)?;
            filter::run(&args.log, &read, args.robot.as_deref(), &options, &args.output)
        }
        None if args.space => {
            let read = read_log(&args.log, args.format, &args.imu)?;
            space::run(&args.log, &read, args.robot.as_deref(), &args.output)
        }
        None => {
            let read = read_log(&args.log, args.format, &args.imu)?;
            steps::run(&args.log, &read, args.robot.as_deref(), &args.output)
        }
    }
}
