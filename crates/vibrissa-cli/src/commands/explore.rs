//! `vibrissa explore`: a simulated robot that finds out where it is by its own motion.

use super::localize::{MethodArgs, outlines};
use super::plan::{LimitArgs, check_robot, named};
use crate::interrupt::{Heedful, last_resort, stopped};
use crate::output::{OutputArgs, complain, counted, print, progress, warn, write_all, wrote};
use clap::ValueEnum;
use core::ops::ControlFlow;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use vibrissa::figure::{FilmFrame, Geometry, LocalizationScene, Outline, localization_film, map_figure, wrapped};
use vibrissa::flow::one_in;
use vibrissa::flow::trajectory::pose_at;
use vibrissa::io::format_tum;
use vibrissa::io::log::to_csv;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sim::{Scenario, SimulateOptions, Stage, SweepNoise};
use vibrissa::tasks::explore::{Ended, Exploration, ExploreOptions, Strategy, beginning, explore_watched};
use vibrissa::tasks::plan::to_json;
use vibrissa::{Error, Localizer, Method, Result};

/// Let a simulated robot find out where it is by its own motion.
///
/// Map, robot and the first motion are those of the scenario; from then on the robot does what `plan` tells it, until it knows where it
/// is, or that no motion can tell. Its readings have the noise that the robot declares; other errors of the scenario are left out.
///
/// With --out DIR: log.csv, truth.tum, explore.json and the figure explore.svg; with --animate the film explore.html.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The scenario (.toml)
    scenario: PathBuf,
    /// How much of the scenario's path is the first motion (m)
    #[arg(long, value_name = "LENGTH", default_value = "80 mm")]
    begin: String,
    /// The way after which the robot gives up (m)
    #[arg(long, value_name = "LENGTH", default_value = "2 m")]
    most_way: String,
    /// The seed of the noise
    #[arg(long, value_name = "N", default_value_t = vibrissa::config::defaults::SEED)]
    seed: u64,
    /// How the robot chooses its motions
    #[arg(long, value_enum, default_value_t)]
    strategy: Choice,
    /// Stop as soon as the log tells the place, without a test of it: by the guaranteed set, or by one more motion
    #[arg(long)]
    untested: bool,
    /// Also write explore.html: a film of the states that explain what was felt so far
    #[arg(long, requires = "out")]
    animate: bool,
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Choice {
    /// As `plan` tells it
    #[default]
    Planned,
    /// Along the wall by touch, without a plan
    Wall,
}

impl Choice {
    fn strategy(self, options: &ExploreOptions) -> Strategy<'static> {
        match self {
            Self::Planned => Strategy::Planned,
            Self::Wall => Strategy::Following(options.follow()),
        }
    }
}

/// Frames of a film, and shapes of whiskers in the figure.
const FRAMES: usize = 100;
const SHAPES: usize = 30;

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    use crate::quantity::of_option as quantity;
    use vibrissa::io::Dimension::Length;
    args.method.check()?;
    let most_way = quantity("--most-way", &args.most_way, Length)?;
    if !(0.0..=1000.0).contains(&most_way) {
        return Err(Error::usage("--most-way").value(&args.most_way).allowed("0 to 1000 m"));
    }
    let (plan, is_tested) = (args.limits.options()?, !args.untested);
    let options = ExploreOptions { plan, most_way, is_tested, ..ExploreOptions::default() };
    let scenario = Scenario::read(&args.scenario)?;
    check_robot(&scenario.robot, &scenario.map)?;
    let begin = beginning(&scenario.path, quantity("--begin", &args.begin, Length)?);
    let map = outlines(&scenario.map);
    let stage = Stage::new(scenario.map, scenario.robot, SimulateOptions::default())?;
    let heeds = Heedful::hurried();
    let aside = keep(&map, &args.output);
    progress::phase("exploring");
    let strategy = args.strategy.strategy(&options);
    let noise = SweepNoise::seeded(args.seed);
    let mut last = Instant::now();
    let found = explore_watched(&stage, &begin, args.method.method(), &noise, &options, strategy, &mut |now| {
        if now.is_long() || last.elapsed() >= EVERY {
            progress::phase(&so_far(now.motions(), now.way()));
            put(&aside, now.so_far());
            // From its end on, so that slow estimates take no more than a part of the time.
            last = Instant::now();
        }
        if stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    if found.collided {
        warn("the robot or a whisker's base came to a boundary");
    }
    let mut film = None;
    if args.animate && found.ended != Ended::Interrupted {
        put(&aside, found.clone());
        progress::phase("drawing the film");
        film = self::film(&stage, args.method.method(), &map, &found)?;
    }
    drop(heeds);
    if stopped() {
        warn(interrupted(&found));
    }
    progress::phase("writing");
    deliver(&found, &map, film, &args.output)
}

/// How often what is known is put aside.
const EVERY: Duration = Duration::from_millis(100);

fn so_far(motions: usize, way: f64) -> String {
    format!("exploring: {}, {:.0} mm", counted(motions, "motion", "motions"), 1e3 * way)
}

fn interrupted(found: &Exploration) -> &'static str {
    match found.ended {
        Ended::Interrupted => "interrupted: the results are what was known by then",
        _ => "interrupted: the results are whole, but for the film",
    }
}

/// What is known, shared with the thread that is told of a signal.
type Aside = Arc<Mutex<Option<Exploration>>>;

fn put(aside: &Aside, found: Exploration) {
    *aside.lock().unwrap_or_else(PoisonError::into_inner) = Some(found);
}

/// Says what becomes of what is known where a plan or an answer does not heed an interrupt in time: the same files, marked.
fn keep(map: &[Outline], output: &OutputArgs) -> Aside {
    let aside = Aside::default();
    let (shared, map, output) = (Arc::clone(&aside), map.to_vec(), output.clone());
    last_resort(move || {
        let Some(found) = shared.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
        warn(interrupted(&found));
        if let Err(error) = deliver(&found, &map, None, &output) {
            complain("error", &error);
        }
    });
    aside
}

/// Writes and prints what was found.
fn deliver(found: &Exploration, map: &[Outline], film: Option<String>, output: &OutputArgs) -> Result<()> {
    let words = words(found);
    let json = as_json(found, &words);
    let mut written = Vec::new();
    if let Some(to) = output.destination() {
        let mut files = vec![
            ("log.csv", to_csv(&found.log)),
            ("truth.tum", format_tum(&found.truth)),
            ("explore.json", json.clone()),
            ("explore.svg", figure(map, found, &words)),
        ];
        files.extend(film.map(|film| ("explore.html", film)));
        written = write_all(to, &files)?;
    }
    print(&if output.json { json } else { text(found, &words) + &wrote(&written) })
}

/// The states that explain each row so far, beside the way as the whole log tells it; none where it is interrupted.
fn film(stage: &Stage, method: &Method, map: &[Outline], found: &Exploration) -> Result<Option<String>> {
    let mut localizer = Localizer::new(stage.map(), stage.robot(), &stage.channels(), method)?;
    let rows = &found.log.rows;
    let every = rows.len().div_ceil(FRAMES).max(1);
    let mut frames = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        if stopped() {
            return Ok(None);
        }
        progress::count(index, rows.len());
        if index > 0 && index == found.since {
            // What came before was forgotten.
            localizer = Localizer::new(stage.map(), stage.robot(), &stage.channels(), method)?;
        }
        localizer.step(row)?;
        if index % every == 0 || index + 1 == rows.len() {
            let now = localizer.states_now();
            let states = if now.is_empty() { carried(found, index) } else { now };
            frames.push(FilmFrame { t: row.t, states });
        }
    }
    let title = "A robot finds out where it is";
    let scene = LocalizationScene { title, map, answer: &found.answer, truth: Some(&found.truth), robot: &[] };
    Ok(Some(localization_film(&scene, &frames)))
}

/// The places that the last motion was chosen for, carried along by odometry to a row: what is known while nothing is told row by row.
fn carried(found: &Exploration, row: usize) -> Vec<Pose2> {
    let Some(made) = found.motions.iter().rev().find(|made| made.row <= row) else { return Vec::new() };
    let odometry = |row: usize| found.log.rows.get(row).map(|row| row.odom_from_robot);
    let Some((before, now)) = odometry(made.row.saturating_sub(1)).zip(odometry(row)) else { return Vec::new() };
    let moved = before.inverse().compose(now);
    made.places.iter().map(|place| place.0.compose(moved)).collect()
}

fn words(found: &Exploration) -> String {
    let (way, count) = (1e3 * found.way, found.motions.len());
    let by = format!("after {} and {way:.0} mm", counted(count, "motion", "motions"));
    let left = counted(found.answer.hypotheses.len(), "place", "places");
    match found.ended {
        Ended::Localized => {
            let truth = found.truth.last().map(|pose| pose.map_from_robot.position());
            let off = found.answer.estimate.zip(truth).map(|(pose, truth)| 1e3 * pose.position().distance(truth));
            format!("localized {by}, {:.2} mm off the truth", off.unwrap_or(f64::NAN))
        }
        Ended::Symmetric => format!("{left} left {by}: the map is symmetric"),
        Ended::Inconsistent => format!("inconsistent {by}: no place explains what was felt"),
        Ended::GaveUp => format!("gave up {by} with {left} left"),
        Ended::Confined => format!("no motion is free of collision and gentle at all places that are left, {by}"),
        Ended::Interrupted => match found.motions.last().filter(|_| found.answer.hypotheses.is_empty()) {
            Some(made) => {
                format!("interrupted {by}, {} left before the last", counted(made.places.len(), "place", "places"))
            }
            None => format!("interrupted {by}, {left} left"),
        },
        Ended::NoPlace => "the first motion tells no place; begin with a longer touch (--begin)".to_owned(),
    }
}

fn text(found: &Exploration, words: &str) -> String {
    let mut text = format!("{words}\n");
    for (index, made) in found.motions.iter().enumerate() {
        let plan = made.plan.as_ref().map_or_else(|| made.name.to_owned(), |plan| plan.words());
        let stopped = if made.stopped { "; ended by the whisker" } else { "" };
        let _ = writeln!(text, "  {:2}  {}; {plan}{stopped}", index + 1, counted(made.places.len(), "place", "places"));
    }
    text
}

fn as_json(found: &Exploration, words: &str) -> String {
    let pose = |p: Pose2| json!({"x": p.x, "y": p.y, "theta": p.theta});
    let motions: Vec<_> = found
        .motions
        .iter()
        .map(|made| {
            json!({
                "name": made.name,
                "row": made.row,
                "stopped": made.stopped,
                "places": made.places.len(),
                "plan": made.plan.as_ref().map(to_json),
            })
        })
        .collect();
    let mut value = json!({
        "ended": found.ended.as_str(),
        "words": words,
        "way": found.way,
        "turn": found.turn,
        "collided": found.collided,
        "hardest": found.hardest,
        "since": found.since,
        "estimate": found.answer.estimate.map(pose),
        "truth": found.truth.last().map(|row| pose(row.map_from_robot)),
        "motions": motions,
    });
    if found.ended == Ended::Interrupted {
        value["interrupted"] = true.into();
    }
    format!("{value:#}\n")
}

/// The whiskers' shapes along the true way, map frame.
fn whiskers(found: &Exploration) -> Vec<Vec<Vec2>> {
    let shapes = &found.answer.shapes;
    let thinned = one_in(shapes, shapes.len().div_ceil(SHAPES).max(1));
    let placed = thinned.filter_map(|shape| {
        let pose = pose_at(&found.truth, shape.t)?;
        Some(shape.points.iter().map(|&point| pose.transform_point(point)).collect())
    });
    placed.collect()
}

fn figure(map: &[Outline], found: &Exploration, words: &str) -> String {
    let line = |rows: &[vibrissa::flow::pose::StampedPose]| -> Geometry {
        Geometry::Lines(vec![rows.iter().map(|row| row.map_from_robot.position()).collect()])
    };
    let at = |row: usize| found.truth.get(row.saturating_sub(1)).map(|row| row.map_from_robot);
    let begins: Vec<Pose2> = found.motions.iter().filter_map(|made| at(made.row)).collect();
    let open: Vec<Pose2> =
        found.motions.iter().take(1).flat_map(|made| made.places.iter().map(|place| place.0)).collect();
    let end = |row: Option<&vibrissa::flow::pose::StampedPose>| {
        Geometry::Circles(row.iter().map(|row| row.map_from_robot.position()).collect())
    };
    let mut layers = vec![
        named(line(&found.truth), "truth", "true path"),
        named(Geometry::Lines(whiskers(found)), "whisker", "whiskers, as the answer bends them"),
        named(Geometry::States(open), "earlier", "places before the first motion"),
    ];
    let localized = found.ended == Ended::Localized;
    if localized {
        layers.push(named(line(&found.answer.trajectory), "path", "estimated path"));
    }
    layers.extend([
        named(end(found.truth.first()), "start", "its start, before the first touch"),
        named(Geometry::States(begins), "decision", "where the robot chose a motion"),
        named(end(found.truth.last()), "truth-mark", "true pose at the end"),
    ]);
    let places: Vec<Pose2> = found.answer.hypotheses.iter().map(|hypothesis| hypothesis.pose).collect();
    layers.extend(match found.answer.estimate.filter(|_| localized || places.len() == 1) {
        Some(pose) => Some(named(Geometry::Arrow(pose), "estimate", "estimate and heading")),
        None => (found.ended != Ended::Inconsistent)
            .then(|| named(Geometry::Places(places), "badge", "a place that explains the log")),
    });
    map_figure("A robot finds out where it is", &wrapped(words, 104), "map frame", map, &layers)
}
