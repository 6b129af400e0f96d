//! `vibrissa localize`: where the robot is.

mod deterministic;
mod inputs;
mod known;
mod possibilistic;
mod probabilistic;

use crate::output::OutputArgs;
use crate::output::{Run, Stopwatch, deliver, warn};
use clap::ValueEnum;
use deterministic::DeterministicArgs;
use inputs::Inputs;
pub(super) use inputs::{outlines, read_log};
use known::KnownArgs;
use possibilistic::PossibilisticArgs;
use probabilistic::ProbabilisticArgs;
use std::path::PathBuf;
use vibrissa::flow::sensor_log::foreign::Format;
use vibrissa::{LocalizeOptions, Result};

/// Find where the robot is from a sensor log and a map.
///
/// The log is a CSV file with the columns `t,x,y,theta,moment` (s, m, rad, N m); the map is a .geojson (m) or .svg (mm)
/// file; the robot is a .toml file and defaults to the paper's whisker.
///
/// With --out DIR: trajectory.tum, result.json, states.csv, steps.csv and the figure localization.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor log (.csv)
    log: PathBuf,
    /// The map (.geojson, .svg)
    #[arg(long, value_name = "MAP")]
    map: PathBuf,
    /// The format of a log that is not ours: rostopic (odometry and wrench or magnetic field) [default: our .csv]
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    /// The robot's whiskers and error bounds (.toml) [default: the paper's whisker at the robot's origin]
    #[arg(long, value_name = "ROBOT")]
    robot: Option<PathBuf>,
    /// The true trajectory in the map frame (.tum), to report errors against
    #[arg(long, value_name = "TRUTH")]
    truth: Option<PathBuf>,
    /// The estimator
    #[arg(long, value_enum, default_value_t = MethodArg::Deterministic)]
    method: MethodArg,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    deterministic: DeterministicArgs,
    #[command(flatten)]
    known: KnownArgs,
    #[command(flatten)]
    possibilistic: PossibilisticArgs,
    #[command(flatten)]
    probabilistic: ProbabilisticArgs,
}

/// The estimators by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    /// The paper's intersection of discretised preimages
    Deterministic,
    /// Guaranteed bounds on the state: what is outside is ruled out
    Possibilistic,
    /// The most accurate estimate with calibrated weights
    Probabilistic,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let options = options(args)?;
    let inputs = Inputs::read(&args.log, args.format, &args.map, args.robot.as_deref(), args.truth.as_deref())?;
    inputs.warnings().iter().for_each(|warning| warn(warning));
    let mut stopwatch = Stopwatch::start();
    let answer = inputs.localize(&options, &mut |_row| stopwatch.lap())?;
    let runtime = stopwatch.stop(inputs.rows(), &answer.steps);
    deliver(
        &Run {
            title: inputs.title(),
            answer,
            runtime,
            rows: inputs.rows().len(),
            map: inputs.outlines(),
            truth: inputs.truth,
        },
        &args.output,
    )
}

fn options(args: &Args) -> Result<LocalizeOptions> {
    match args.method {
        MethodArg::Deterministic => args.deterministic.options(),
        MethodArg::Possibilistic => args.possibilistic.options(&args.known),
        MethodArg::Probabilistic => args.probabilistic.options(&args.known),
    }
}
