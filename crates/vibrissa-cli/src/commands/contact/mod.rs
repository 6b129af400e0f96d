//! `vibrissa contact`: where the whisker was touched.

mod taps;

use crate::output::OutputArgs;
use std::path::PathBuf;
use vibrissa::flow::sensor_log::foreign::Format;
use vibrissa::{Error, Result};

/// Find where a whisker was touched.
///
/// With --taps: the radial distance of each short contact of a base that turns at the rate of the calibration.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The recording
    log: PathBuf,
    /// Taps: one distance for each short contact
    #[arg(long, requires = "calibration")]
    taps: bool,
    /// The calibration (cal.json), made by `vibrissa calibrate`
    #[arg(long, value_name = "CAL")]
    calibration: Option<PathBuf>,
    /// The format of the recording: serial, serial2, ratatouille, openwhisker, rostopic, csv [default for taps: csv
    /// where the first line names a column t, else ratatouille]
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// The sensor that feels the ambient field alone, subtracted from the calibration's
    #[arg(long, value_name = "SENSOR")]
    reference: Option<String>,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    match &args.calibration {
        Some(calibration) if args.taps => {
            taps::run(&args.log, calibration, args.format, args.reference.as_deref(), &args.output)
        }
        _ => Err(Error::usage("only taps are read yet")
            .allowed("vibrissa contact FILE --taps --calibration cal.json")
            .remedy("add --taps and --calibration")),
    }
}
