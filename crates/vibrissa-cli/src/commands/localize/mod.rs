//! `vibrissa localize`: where the robot is.

mod inputs;
mod interrupted;
mod known;
mod method;
mod robot;

use super::logs::LogArgs;
use crate::interrupt::{Heedful, stopped};
use crate::output::OutputArgs;
use crate::output::{Run, Stopwatch, deliver, progress, warn};
use inputs::Inputs;
pub(super) use inputs::outlines;
use interrupted::Known;
pub(crate) use known::joined;
pub(super) use method::MethodArgs;
pub(super) use robot::read as read_robot;
use std::ops::ControlFlow;
use std::path::PathBuf;
use vibrissa::Result;
use vibrissa::figure::FilmFrame;
use vibrissa::flow::pose::Localization;
#[cfg(feature = "mcap")]
use vibrissa::io::recording::StatesWatch;
use vibrissa::tasks::RowObserver;

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
    #[command(flatten)]
    reading: LogArgs,
    /// The true trajectory in the map frame (.tum), to report errors against
    #[arg(long, value_name = "TRUTH")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    method: MethodArgs,
    /// Also write localization.mcap: map, readings, whisker, states and estimate as ROS 2 messages
    #[cfg(feature = "mcap")]
    #[arg(long, requires = "out")]
    mcap: bool,
    /// Also write localization.html: a film of the states that explain the log as it goes on
    #[arg(long, requires = "out")]
    animate: bool,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let method = &args.method.method;
    args.method.check()?;
    let inputs = Inputs::read(args)?;
    let stopwatch = Stopwatch::start();
    let heeds = Heedful::hurried();
    inputs.warnings().iter().for_each(|warning| warn(warning));
    let unused = |flag: &String| format!("{flag} is not used: the method {method} has no such option");
    args.method.unused.iter().for_each(|flag| warn(&unused(flag)));
    let run = localized(args, &inputs, stopwatch)?;
    drop(heeds);
    if run.interrupted {
        let (used, rows) = (run.rows, inputs.rows().len());
        let what =
            if used < rows { "those of a log that ends there" } else { "less sharp than with the search at the end" };
        warn(&format!("interrupted after {used} of {rows} rows: the results are {what}"));
    }
    deliver(&run, &args.output)
}

/// The localization, as far as it comes before an interrupt.
fn localized(args: &Args, inputs: &Inputs, mut stopwatch: Stopwatch) -> Result<Run> {
    let method = &args.method.method;
    let known = Known::keep(inputs, method, &args.output);
    progress::phase("localizing");
    let mut used = 0;
    let (mut answer, recording, frames) = answered(args, inputs, &mut |row, localizer| {
        stopwatch.lap();
        used = row + 1;
        known.row(used, localizer);
        if stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let runtime = stopwatch.stop(inputs.rows(), &answer.steps);
    let interrupted = stopped();
    if !interrupted {
        known.answer(&answer, &recording);
        progress::phase("looking for what would explain the log");
        inputs.advise(&mut answer, method, &mut || !stopped())?;
        if stopped() {
            warn(WHOLE);
        }
    }
    Ok(Run {
        title: inputs.title(),
        answer,
        runtime,
        rows: used,
        interrupted,
        map: inputs.outlines(),
        truth: inputs.truth.clone(),
        recording,
        inputs: Vec::new(),
        film: args.animate.then_some(frames),
    })
}

/// What is said where an interrupt comes after the answer.
const WHOLE: &str = "interrupted: the results are whole, but not what to try where nothing explains the log";

/// Frames of a film.
const FRAMES: usize = 100;

/// What a run leaves.
type Answered = (Localization, Option<Vec<u8>>, Vec<FilmFrame>);

/// The answer, the recording and the frames of the film, where they are asked for.
fn answered(args: &Args, inputs: &Inputs, lap: &mut RowObserver) -> Result<Answered> {
    let rows = inputs.rows();
    let every = rows.len().div_ceil(FRAMES).max(1);
    let mut frames = Vec::new();
    #[cfg(feature = "mcap")]
    let mut watch = args.mcap.then(|| StatesWatch::new(rows.len()));
    #[cfg(feature = "mcap")]
    if args.mcap {
        inputs.clock_warning().iter().for_each(|warning| warn(warning));
    }
    let answer = inputs.localize(&args.method.method, &mut |row, localizer| {
        #[cfg(feature = "mcap")]
        if let Some(watch) = &mut watch {
            watch.look(row, rows[row].t, &|| localizer.states_now());
        }
        if args.animate && (row % every == 0 || row + 1 == rows.len()) {
            frames.push(FilmFrame { t: rows[row].t, states: localizer.states_now() });
        }
        lap(row, localizer)
    })?;
    #[cfg(feature = "mcap")]
    let recording = watch.map(|watch| inputs.recording(&answer, &watch.finish())).transpose()?;
    #[cfg(not(feature = "mcap"))]
    let recording = None;
    Ok((answer, recording, frames))
}
