//! `vibrissa contact`: where the whisker was touched.

mod steps;

use crate::output::OutputArgs;
use std::path::PathBuf;
use vibrissa::Result;

/// Find where a whisker was touched, step by step.
///
/// The log is a CSV file with the columns `t,x,y,theta,moment` (s, m, rad, N m); the robot is a .toml file and defaults to
/// the paper's whisker. A contact that stands still is found from all the readings of the base's motion; a tip that slides
/// is traced along a smooth wall. The closed forms of earlier work stand beside it.
///
/// With --out DIR: contacts.csv and the figure contacts.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor log (.csv)
    log: PathBuf,
    /// The robot's whiskers and error bounds (.toml) [default: the paper's whisker at the robot's origin]
    #[arg(long, value_name = "ROBOT")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    steps::run(&args.log, args.robot.as_deref(), &args.output)
}
