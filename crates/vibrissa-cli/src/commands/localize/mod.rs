//! `vibrissa localize`: where the robot is.

mod deterministic;
mod inputs;
mod known;
mod possibilistic;
mod probabilistic;
mod robot;

use crate::interrupt::{Heedful, stopped};
use crate::output::OutputArgs;
use crate::output::{Run, Stopwatch, deliver, warn};
use clap::ValueEnum;
use deterministic::DeterministicArgs;
use inputs::Inputs;
pub(super) use inputs::{outlines, read_log};
use known::KnownArgs;
pub(crate) use known::joined;
use possibilistic::PossibilisticArgs;
use probabilistic::ProbabilisticArgs;
use std::ops::ControlFlow;
use std::path::PathBuf;
use vibrissa::flow::pose::Localization;
use vibrissa::io::log::foreign::Format;
#[cfg(feature = "mcap")]
use vibrissa::io::recording::StatesWatch;
use vibrissa::{LocalizeOptions, Result};

/// Find where the robot is from a sensor log and a map.
///
/// The log is a CSV file with the columns `t,x,y,theta,moment` (s, m, rad, N m) or an MCAP recording with ROS 2 messages;
/// the map is a .geojson (m), .svg (mm), .dxf or .yaml file (of ROS), or a recording that holds one; the robot is a .toml
/// file and defaults to the paper's whisker.
///
/// With --out DIR: trajectory.tum, result.json, states.csv, steps.csv and the figure localization.svg; with --mcap also
/// localization.mcap, which viewers such as Foxglove and Rerun show on the log's timeline.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor log (.csv, .mcap)
    log: PathBuf,
    /// The map (.geojson, .svg, .dxf, .yaml, .mcap)
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
    /// Also write localization.mcap: map, readings, whisker, states and estimate as ROS 2 messages
    #[cfg(feature = "mcap")]
    #[arg(long, requires = "out")]
    mcap: bool,
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
    let inputs =
        Inputs::read(&args.log, args.format, &args.map, args.robot.as_deref(), args.truth.as_deref(), options.method)?;
    let mut stopwatch = Stopwatch::start();
    let (answer, recording, used) = heedful(args, &inputs, &options, &mut stopwatch)?;
    let runtime = stopwatch.stop(inputs.rows(), &answer.steps);
    deliver(
        &Run {
            title: inputs.title(),
            answer,
            runtime,
            rows: used,
            interrupted: used < inputs.rows().len(),
            map: inputs.outlines(),
            truth: inputs.truth,
            recording,
        },
        &args.output,
    )
}

/// Warns of doubtful inputs, then the answer, the recording where it is asked for, and how many rows they are made of: an
/// interrupt keeps what is known by then.
fn heedful(
    args: &Args,
    inputs: &Inputs,
    options: &LocalizeOptions,
    stopwatch: &mut Stopwatch,
) -> Result<(Localization, Option<Vec<u8>>, usize)> {
    let _heeds = Heedful::begin();
    inputs.warnings().iter().for_each(|warning| warn(warning));
    let mut used = 0;
    let (answer, recording) = answered(args, inputs, options, &mut |row| {
        stopwatch.lap();
        used = row + 1;
        if stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let rows = inputs.rows().len();
    if used < rows {
        warn(&format!("interrupted after {used} of {rows} rows: the results are those of a log that ends there"));
    }
    Ok((answer, recording, used))
}

/// The answer, and the recording where it is asked for.
#[cfg(feature = "mcap")]
fn answered(
    args: &Args,
    inputs: &Inputs,
    options: &LocalizeOptions,
    lap: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<(Localization, Option<Vec<u8>>)> {
    if !args.mcap {
        return Ok((inputs.localize(options, lap)?, None));
    }
    let mut watch = StatesWatch::new(inputs.rows().len());
    let answer = inputs.localize_watched(options, &mut |row, states| {
        watch.look(row, inputs.rows()[row].t, states);
        lap(row)
    })?;
    let recording = inputs.recording(&answer, &watch.finish())?;
    Ok((answer, Some(recording)))
}

#[cfg(not(feature = "mcap"))]
fn answered(
    _: &Args,
    inputs: &Inputs,
    options: &LocalizeOptions,
    lap: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<(Localization, Option<Vec<u8>>)> {
    Ok((inputs.localize(options, lap)?, None))
}

fn options(args: &Args) -> Result<LocalizeOptions> {
    match args.method {
        MethodArg::Deterministic => args.deterministic.options(&args.known),
        MethodArg::Possibilistic => args.possibilistic.options(&args.known),
        MethodArg::Probabilistic => args.probabilistic.options(&args.known),
    }
}
