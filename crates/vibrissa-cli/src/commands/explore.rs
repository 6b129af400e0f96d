//! `vibrissa explore`: a simulated robot that finds out where it is by its own motion.

use super::localize::{MethodArgs, outlines};
use super::plan::{LimitArgs, check_robot, map_lines, named, value};
use crate::output::{OutputArgs, print, progress, warn, write_all};
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;
use vibrissa::figure::{Geometry, scene_figure, wrapped};
use vibrissa::io::format_tum;
use vibrissa::io::log::to_csv;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sim::{Scenario, SimulateOptions, Stage, SweepNoise};
use vibrissa::tasks::explore::{Ended, Exploration, ExploreOptions, explore};
use vibrissa::{Error, Result};

/// Let a simulated robot find out where it is by its own motion.
///
/// Map, robot and the first motion are those of the scenario; from then on the robot does what `plan` tells it, until it knows where it
/// is, or that no motion can tell. Its readings have the noise that the robot declares; other errors of the scenario are left out.
///
/// With --out DIR: log.csv, truth.tum, explore.json and the figure explore.svg.
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
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    use crate::quantity::of_option as quantity;
    use vibrissa::io::Dimension::Length;
    args.method.check()?;
    let most_way = quantity("--most-way", &args.most_way, Length)?;
    if !(0.0..=1000.0).contains(&most_way) {
        return Err(Error::usage("--most-way").value(&args.most_way).allowed("0 to 1000 m"));
    }
    let options = ExploreOptions { plan: args.limits.options()?, most_way, ..ExploreOptions::default() };
    let scenario = Scenario::read(&args.scenario)?;
    check_robot(&scenario.robot, &scenario.map)?;
    let begin = beginning(&scenario, quantity("--begin", &args.begin, Length)?);
    let map = outlines(&scenario.map);
    let stage = Stage::new(scenario.map, scenario.robot, SimulateOptions::default())?;
    progress::phase("exploring");
    let found = explore(&stage, &begin, args.method.method(), &SweepNoise::seeded(args.seed), &options)?;
    progress::phase("writing");
    if found.collided {
        warn("the robot or a whisker's base came to a boundary");
    }
    let words = words(&found);
    let json = as_json(&found, &words);
    if let Some(to) = args.output.destination() {
        let files = [
            ("log.csv", to_csv(&found.log)),
            ("truth.tum", format_tum(&found.truth)),
            ("explore.json", json.clone()),
            ("explore.svg", figure(&map, &found, &words)),
        ];
        write_all(to, &files)?;
    }
    print(&if args.output.json { json } else { text(&found, &words) })
}

/// The poses of the scenario's path up to so much way.
fn beginning(scenario: &Scenario, most: f64) -> Vec<Pose2> {
    let mut gone = 0.0;
    let mut poses: Vec<Pose2> = Vec::new();
    for pose in scenario.path.iter().map(|pose| pose.map_from_robot) {
        gone += poses.last().map_or(0.0, |last| last.position().distance(pose.position()));
        poses.push(pose);
        if gone >= most {
            break;
        }
    }
    poses
}

fn words(found: &Exploration) -> String {
    let (way, count) = (1e3 * found.way, found.motions.len());
    let motions = if count == 1 { "motion" } else { "motions" };
    let by = format!("after {count} {motions} and {way:.0} mm");
    match found.ended {
        Ended::Localized => {
            let truth = found.truth.last().map(|pose| pose.map_from_robot.position());
            let off = found.answer.estimate.zip(truth).map(|(pose, truth)| 1e3 * pose.position().distance(truth));
            format!("localized {by}, {:.2} mm off the truth", off.unwrap_or(f64::NAN))
        }
        Ended::Symmetric => format!("{} places left {by}: the map is symmetric", found.answer.hypotheses.len()),
        Ended::Inconsistent => format!("inconsistent {by}: no place explains what was felt"),
        Ended::GaveUp => format!("gave up {by} with {} places left", found.answer.hypotheses.len()),
        Ended::Confined => format!("no motion is free of collision and gentle at all places that are left, {by}"),
        Ended::NoPlace => "the first motion tells no place; begin with a longer touch (--begin)".to_owned(),
    }
}

fn ended(found: &Exploration) -> &'static str {
    match found.ended {
        Ended::Localized => "localized",
        Ended::Symmetric => "symmetric",
        Ended::Inconsistent => "inconsistent",
        Ended::GaveUp => "gave_up",
        Ended::Confined => "confined",
        Ended::NoPlace => "no_place",
    }
}

fn text(found: &Exploration, words: &str) -> String {
    let mut text = format!("{words}\n");
    for (index, made) in found.motions.iter().enumerate() {
        let plan = made.plan.as_ref().map_or_else(|| made.name.to_owned(), |plan| plan.words());
        let stopped = if made.stopped { "; ended by the whisker" } else { "" };
        let _ = writeln!(text, "  {:2}  {} places; {plan}{stopped}", index + 1, made.places.len());
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
                "plan": made.plan.as_ref().map(value),
            })
        })
        .collect();
    let value = json!({
        "ended": ended(found),
        "words": words,
        "way": found.way,
        "turn": found.turn,
        "collided": found.collided,
        "hardest": found.hardest,
        "estimate": found.answer.estimate.map(pose),
        "truth": found.truth.last().map(|row| pose(row.map_from_robot)),
        "motions": motions,
    });
    format!("{value:#}\n")
}

fn figure(map: &[vibrissa::figure::Outline], found: &Exploration, words: &str) -> String {
    let mut layers = map_lines(map);
    let first = found.motions.first().map_or(found.truth.len(), |made| made.row);
    let line = |rows: &[vibrissa::flow::pose::StampedPose]| -> Vec<Vec<Vec2>> {
        vec![rows.iter().map(|row| row.map_from_robot.position()).collect()]
    };
    let at = |row: usize| found.truth.get(row.saturating_sub(1)).map(|row| row.map_from_robot);
    let begins: Vec<Pose2> = found.motions.iter().filter_map(|made| at(made.row)).collect();
    let left: Vec<Pose2> =
        found.motions.iter().take(1).flat_map(|made| made.places.iter().map(|place| place.0)).collect();
    layers.extend([
        named(Geometry::States(left), "candidate", "places before the first motion"),
        named(Geometry::Lines(line(&found.truth[..first])), "truth", "the first touch"),
        named(
            Geometry::Lines(line(&found.truth[first.saturating_sub(1)..])),
            "path",
            "the robot's way, by its own motions",
        ),
        named(Geometry::States(begins), "survivor", "where it planned"),
    ]);
    if found.ended == Ended::Localized {
        let estimate = found.answer.estimate;
        layers.extend(estimate.map(|pose| named(Geometry::Arrow(pose), "estimate", "the estimate at the end")));
    } else {
        let places = found.answer.hypotheses.iter().map(|h| h.pose.position()).collect();
        layers.push(named(Geometry::Circles(places), "estimate", "places that are left at the end"));
    }
    scene_figure("A robot finds out where it is", &wrapped(words, 104), "map frame", &layers)
}
