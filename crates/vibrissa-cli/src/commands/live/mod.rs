//! `vibrissa live`: where the robot is while it drives.

#[cfg(unix)]
mod demo;
mod mapping;
mod monitor;
mod planning;
mod replay;
#[cfg(feature = "view")]
mod view;

use super::map::BoundArgs;
use super::plan::LimitArgs;
use crate::interrupt::{self, Heedful, stopped};
use crate::output::{print, warn};
use core::ops::ControlFlow;
use mapping::Mapping;
use monitor::Monitor;
use planning::Planning;
use std::path::{Path, PathBuf};
use std::sync::mpsc::Sender;
use vibrissa::flow::pose::StampedPose;
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Result};
use vibrissa_live::journal::Journal;
use vibrissa_live::record::{Closer, FileStorage};
use vibrissa_live::robot::Errand;
use vibrissa_live::run::{Health, Update, run as run_live};
use vibrissa_live::setup::{self, Setup};
use vibrissa_live::source::HostClock;

/// Find where the robot is while it drives, from serial ports, sockets, pipes or ROS 2.
///
/// A file live.toml names the map, the robot, and the sources of readings and odometry with their formats and delays. All that
/// arrives is recorded first, so that a power cut loses at most half a second. The pose, its extent, the verdict and what was
/// lost stand on a line of the terminal; --json prints each estimate as a line of JSON. Ctrl-C ends the run, a second one at once.
/// With --plan the next motion is told, too, whenever the robot has come to rest and does not know which of several places it is at.
///
/// With --mapping a setup that names no map makes one, as `map` does: of what the whiskers have felt so far, every few seconds and at the end.
///
/// With --out DIR: recording.mcap, which --replay runs again to the same estimates, and viewers such as Foxglove show; with --mapping also
/// map.geojson, trajectory.tum, covariances.csv, graph.json and mapping.svg, with the recording's number behind their names if it has one.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The setup (live.toml)
    setup: Option<PathBuf>,
    /// Drive a simulated robot along the built-in arena: real bytes in real time, from a pseudo-terminal
    #[arg(long, conflicts_with_all = ["setup", "replay", "speed"])]
    demo: bool,
    /// Run a recording again (recording.mcap, or its folder); with a setup, by that one
    #[arg(long, value_name = "RECORDING")]
    replay: Option<PathBuf>,
    /// Times the recording's own speed [default: as fast as it goes]
    #[arg(long, value_name = "N", requires = "replay")]
    speed: Option<f64>,
    /// Write recording.mcap into this folder, made if missing; earlier ones stay [default: live, beside the setup]
    #[arg(long, value_name = "DIR", conflicts_with = "no_record")]
    out: Option<PathBuf>,
    /// Record nothing
    #[arg(long)]
    no_record: bool,
    /// Print each estimate as a line of JSON
    #[arg(long)]
    json: bool,
    /// Show the run in the browser, and let viewers such as Foxglove look on: ws://localhost:PORT
    #[cfg(feature = "view")]
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = PORT, conflicts_with = "replay",
          help = format!("Show the run in the browser, and let viewers such as Foxglove look on: ws://localhost:PORT [default: {PORT}]"))]
    view: Option<u16>,
    /// Print the histogram of latencies at the end
    #[arg(long)]
    latency: bool,
    /// When the robot has come to rest and several places are left: tell the next motion that parts them, as `plan` does
    #[arg(long, conflicts_with = "replay")]
    plan: bool,
    /// The simulated robot goes where the plan tells it, until it knows where it is
    #[arg(long, conflicts_with_all = ["setup", "replay"])]
    explore: bool,
    /// Make a map of what the whiskers feel; the setup names none
    #[arg(long, conflicts_with_all = ["replay", "no_record", "plan", "explore"])]
    mapping: bool,
    #[command(flatten)]
    bounds: BoundArgs,
    #[command(flatten)]
    limits: LimitArgs,
}

/// How long a disk may take for the end of a recording when nobody wants to wait any more (s).
const HASTE: f64 = 2.0;

/// The name of a recording.
const RECORDING: &str = "recording";

/// Where viewers look on unless told otherwise: Foxglove's own port.
#[cfg(feature = "view")]
const PORT: &str = "8765";

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    if let Some(speed) = args.speed.filter(|speed| !(*speed > 0.0 && speed.is_finite())) {
        return Err(Error::usage("--speed").value(speed).allowed("above 0"));
    }
    if args.explore && !args.demo {
        return Err(Error::usage("--explore is for the simulated robot")
            .remedy("add --demo; a robot of your own is told where to go by --plan"));
    }
    if args.bounds.is_given() && !args.mapping {
        return Err(
            Error::usage("--drift and --body are for a map that is made").remedy("add --mapping, or leave them out")
        );
    }
    #[cfg(feature = "view")]
    if args.mapping && args.view.is_some() {
        return Err(Error::usage("--view shows a map that is known").remedy("leave out --view or --mapping"));
    }
    if args.setup.is_none() && args.replay.is_none() && !args.demo {
        return Err(Error::usage("no setup is given").remedy(
            "vibrissa live live.toml runs yours (docs/live.md shows whole files), vibrissa live --demo a simulated robot",
        ));
    }
    let live = match (&args.replay, &args.setup) {
        // Until here Ctrl-C ends the process: a scenario may take its time to simulate.
        (None, Some(path)) => Some((path, setup::read(path)?)),
        _ => None,
    };
    let _heeds = Heedful::begin();
    let result = match (&args.replay, live) {
        (Some(recording), _) => replay::run(args, recording, args.setup.as_deref()),
        (None, Some((path, setup))) => {
            let folder = folder_of(path);
            let out = args.out.clone().unwrap_or_else(|| folder.join("live"));
            on_robot(args, &setup, &folder, (!args.no_record).then_some(out.as_path()), Course::default())
        }
        #[cfg(unix)]
        (None, None) => demo::run(args),
        #[cfg(not(unix))]
        (None, None) => Err(Error::usage("--demo needs pseudo-terminals, which Linux and macOS have")),
    };
    // Ctrl-C is how a live run ends.
    interrupt::reset();
    result
}

/// The folder of a file, whole, so that a recording can be run again from anywhere.
fn folder_of(path: &Path) -> PathBuf {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    parent.canonicalize().unwrap_or_else(|_| parent.to_owned())
}

/// The map of a setup, with a word about what looks doubtful.
fn map_of(setup: &Setup) -> Result<Option<Map>> {
    let map = setup.map.as_ref().map(vibrissa::read_map).transpose()?;
    map.iter().flat_map(|map| &map.warnings).for_each(|warning| warn(warning));
    Ok(map)
}

/// What a setup that names no map is told.
fn no_map(setup: &Setup) -> Error {
    Error::data("the setup names no map").in_file(&setup.name).at_line(1)
}

/// The robot of a setup; where it is to be localized its whiskers are asked about, too.
fn robot_of(setup: &Setup, is_localized: bool) -> Result<Robot> {
    let robot = match &setup.robot {
        Some(path) => vibrissa::read_robot(path)?,
        None => Robot::default(),
    };
    setup.fits(&robot)?;
    for whisker in robot.whiskers.iter().filter(|_| is_localized) {
        let taken = setup.method.takes(&whisker.beam);
        taken.map_err(|error| error.about(&format!("whisker \"{}\"", whisker.name)))?;
    }
    Ok(robot)
}

/// Closes the recording for somebody who asks a second time.
fn close_at_once(closer: &Closer, makes_map: bool) {
    warn(match (closer.close_now(HASTE), makes_map) {
        (true, false) => {
            "interrupted again: the recording is whole; --replay with the setup estimates what was not estimated yet"
        }
        (true, true) => "interrupted again: the recording is whole; `vibrissa map` makes the map of it",
        _ => "interrupted again: the disk did not take the recording's end in time; it is read up to where it ends",
    });
}

/// What is known of a simulated robot's course, and the way to tell it where to go.
#[derive(Default)]
struct Course<'a> {
    truth: Option<&'a dyn Fn() -> Option<StampedPose>>,
    is_over: Option<&'a dyn Fn() -> bool>,
    errands: Option<Sender<Errand>>,
}

/// Runs a setup on the robot that it names.
fn on_robot(args: &Args, setup: &Setup, folder: &Path, out: Option<&Path>, course: Course<'_>) -> Result<()> {
    match &setup.map {
        None if !args.mapping => {
            return Err(no_map(setup).remedy("add map = \"arena.svg\" at its head, or let --mapping make one"));
        }
        Some(map) if args.mapping => {
            return Err(Error::usage("--mapping makes a map, and the setup names one")
                .value(map.display())
                .remedy("take map = … out of the setup, or leave out --mapping"));
        }
        _ => {}
    }
    let (map, robot) = (map_of(setup)?, robot_of(setup, !args.mapping)?);
    let limits = args.limits.options()?;
    let plans = args.plan || course.errands.is_some();
    let mut planning = match &map {
        Some(map) if plans => Some(Planning::start(map, &robot, limits, course.errands)?),
        _ => None,
    };
    let (journal, recording) = match out {
        Some(out) => {
            let (storage, path) = FileStorage::create(out, RECORDING)?;
            (Some(Journal::begin(storage, setup, folder, HostClock::new().now())), Some(path))
        }
        None => (None, None),
    };
    if let Some(journal) = &journal {
        let closer = journal.recorder().closer();
        let makes_map = args.mapping;
        interrupt::last_resort(move || close_at_once(&closer, makes_map));
    }
    #[cfg(feature = "view")]
    let view = args.view.zip(map.as_ref()).map(|(port, map)| view::View::start(port, map, args.json)).transpose()?;
    let mut mapping = match &recording {
        Some(recording) if args.mapping => Some(begin_mapping(args, setup, recording)?),
        _ => None,
    };
    let mut monitor = Monitor::new(args.json);
    let finished = run_live(setup, map.as_ref(), &robot, journal.as_ref(), &mut |update| {
        let is_over = course.is_over.is_some_and(|is_over| is_over());
        #[cfg(feature = "view")]
        if let Some(view) = &view {
            view.show(&update);
        }
        if let Some(planning) = &mut planning {
            planning.see(&update);
            while let Some(answer) = planning.ready() {
                monitor.plan(&answer);
                #[cfg(feature = "view")]
                view.iter().for_each(|view| view.plan(&answer));
            }
            planning.end_errands();
        }
        if let Some(mapping) = &mut mapping {
            mapping.see(&update);
            while let Some(answer) = mapping.ready() {
                monitor.map(&answer);
            }
        }
        match update {
            Update::Estimate(told, health) => monitor.estimate(told, health),
            Update::Began(..) | Update::Row(_) => {}
            // A simulated robot takes its ports away when it has arrived.
            Update::Notice(_) if is_over => {}
            Update::Notice(notice) => monitor.notice(notice),
            Update::Idle(health) => monitor.idle(health),
        }
        if stopped() || monitor.is_closed() || is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    monitor.end();
    let mut health = finished.as_ref().map_or_else(|_| Health::default(), |finished| finished.health.clone());
    if let Some(journal) = journal {
        health.dropped = journal.recorder().dropped();
        if let Err(reason) = journal.finish() {
            warn(&format!("the recording could not be closed ({reason}); what was written before is whole"));
        }
    }
    // Who asked for the end does not wait for a plan.
    if !stopped() {
        planning.into_iter().flat_map(Planning::end).for_each(|answer| monitor.plan(&answer));
    }
    let finished = finished?;
    let made = mapping.map(Mapping::end);
    if let (true, Some(Some(answer))) = (args.json, &made) {
        monitor.map(answer);
    }
    if args.json {
        return Ok(());
    }
    let mut text = match &made {
        Some(Some(answer)) => answer.report.clone(),
        Some(None) => "no map was made\n".to_owned(),
        None => monitor::verdict(&finished.estimate, &health),
    };
    if let (Some(truth), Some(pose)) = (course.truth.and_then(|last| last()), finished.estimate.pose()) {
        let off = pose.position().distance(truth.map_from_robot.position());
        text.push_str(&format!("  off the truth by {:.2} mm\n", 1e3 * off));
    }
    text.push_str(&monitor::account(&health, args.latency, args.mapping));
    match recording {
        Some(path) if args.mapping => text.push_str(&format!("\nRecorded: {}, the map beside it\n", path.display())),
        Some(path) => {
            text.push_str(&format!("\nRecorded: {0}\nRun it again: vibrissa live --replay {0}\n", path.display()))
        }
        None => text.push_str("\nNothing was recorded; --out DIR records.\n"),
    }
    print(&text)
}

/// Begins to make a map; its files lie beside the recording, and have its number.
fn begin_mapping(args: &Args, setup: &Setup, recording: &Path) -> Result<Mapping> {
    let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
    let suffix = stem.strip_prefix(RECORDING).unwrap_or_default();
    let patient = setup.sources.iter().all(|source| source.wire.is_file());
    Mapping::start(args.bounds.options(), patient, &folder_of(recording), suffix)
}
