//! `vibrissa calibrate`: from recordings with known truth to `cal.json`.

mod contacts;
mod distance;
mod recording;

use crate::output::{OutputArgs, print, warn, write_all};
use contacts::ContactArgs;
use distance::DistanceArgs;
pub(super) use recording::{read_taps, repairs_json, say_repairs};
use std::path::PathBuf;
use vibrissa::Result;
use vibrissa::io::log::foreign::Format;

/// Calibrate a whisker: raw readings to moments, slopes of taps to distances, constants of the whisker.
///
/// One LOG of labelled contacts (.csv with the contact point x,y in m in the whisker frame, and bx,by,bz in T, ax,ay,az in
/// counts or moment in N m) gives the curve from readings to moments, from moments to the tip's retreat, and, with --free,
/// constants of the whisker. Contacts x,y,z from all sides of the whisker calibrate both transverse axes of the chip. --taps DIST=FILE … gives the distance of taps on a base that turns at a constant rate. One LOG
/// of --format openwhisker (a staircase of lateral travel) gives the distance of static contacts.
///
/// With --out DIR: cal.json and the figure calibration.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A log of labelled contacts (.csv), or a staircase with --format openwhisker
    #[arg(required_unless_present = "taps")]
    log: Option<PathBuf>,
    /// Taps of known radial distance from the base, each with its unit: `60mm=deflection_60.csv`
    #[arg(long, value_name = "DIST=FILE", num_args = 1.., conflicts_with = "log")]
    taps: Vec<String>,
    /// The format of the recordings: serial, serial2, ratatouille, openwhisker, rostopic, csv [default: csv for labelled
    /// contacts; for taps csv where the first line names a column t, else ratatouille]
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// The robot whose first whisker is calibrated (.toml) [default: the paper's whisker for labelled contacts]
    #[arg(long, value_name = "ROBOT")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    contacts: ContactArgs,
    #[command(flatten)]
    distance: DistanceArgs,
}

/// What a calibration has to say and to write.
pub(super) struct Report {
    text: String,
    json: serde_json::Value,
    files: Vec<(&'static str, String)>,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let robot = args.robot.as_deref().map(vibrissa::read_robot).transpose()?;
    let report = match (&args.log, args.format) {
        (None, format) => distance::from_taps(&args.taps, format, robot.as_ref(), &args.distance)?,
        (Some(log), Some(Format::Openwhisker)) => distance::from_staircase(log, robot.as_ref(), &args.distance)?,
        (Some(log), format) => contacts::from_contacts(log, format, robot.as_ref(), &args.contacts)?,
    };
    deliver(&report, &args.output)
}

fn deliver(report: &Report, output: &OutputArgs) -> Result<()> {
    let written = output.destination().map(|to| write_all(to, &report.files)).transpose()?;
    if output.json {
        return print(&pretty(&report.json));
    }
    let mut text = report.text.clone();
    match written {
        Some(paths) => {
            let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
            text.push_str(&format!("\nwritten: {}\n", names.join(", ")));
        }
        None => text.push_str("\nNo files were written; add --out DIR for cal.json and a figure.\n"),
    }
    print(&text)
}

/// JSON with a line end.
pub(super) fn pretty(value: &serde_json::Value) -> String {
    format!("{value:#}\n")
}

/// The file's name without its folders.
fn file_name(path: &std::path::Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Tells what was mended in a file.
fn tell(words: &[String], file: &str) {
    words.iter().for_each(|word| warn(&format!("{file}: {word}")));
}
