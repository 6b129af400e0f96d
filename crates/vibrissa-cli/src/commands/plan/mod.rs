//! `vibrissa plan`: the next motion that tells places apart.

mod figure;
mod limits;
mod result;

use super::localize::{MethodArgs, outlines, read_robot};
use super::logs::LogArgs;
use crate::output::{OutputArgs, counted, print, progress, warn, write_all, wrote};
pub(super) use figure::named;
pub(super) use limits::LimitArgs;
use std::fmt::Write;
use std::path::PathBuf;
use vibrissa::flow::pose::Hypothesis;
use vibrissa::plane::Pose2;
use vibrissa::tasks::plan::{Motion, Past, Plan, PlanOptions, PlannedMotion, plan, plan_from, remaining, to_json};
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Result};

/// Tell the next motion that parts the places which a log leaves open.
///
/// FROM is a sensor log, which is localized first, or the result.json of `localize`. The motion is free of collision and gentle at
/// every place that is left, if the robot ends it where a whisker feels as much as is told.
///
/// With --out DIR: motion.csv (waypoints seen from where the robot is), plan.json and the figure plan.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor log (.csv, .mcap), or the result of a localization (.json)
    from: PathBuf,
    /// The map (.geojson, .svg, .dxf, .yaml, .mcap)
    #[arg(long, value_name = "MAP")]
    map: PathBuf,
    #[command(flatten)]
    reading: LogArgs,
    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let options = args.limits.options()?;
    args.method.check()?;
    let method = args.method.method();
    let map = vibrissa::read_map(&args.map)?;
    map.warnings.iter().for_each(|warning| warn(warning));
    let robot = read_robot(args.reading.robot.as_deref(), method)?;
    let is_result = args.from.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let (hypotheses, shapes, plan) = if is_result {
        let hypotheses = result::read(&args.from)?;
        progress::phase("planning");
        let states = remaining(&hypotheses, options.states);
        let plan = plan(&map, &robot, &states, &Past::default(), &options)?;
        (hypotheses, Vec::new(), plan)
    } else {
        let log = args.reading.read(&args.from)?;
        progress::phase("localizing and planning");
        let (answer, plan) = plan_from(&log, &map, &robot, method, &options)?;
        let t = log.rows.last().map_or(0.0, |row| row.t);
        (answer.hypotheses, answer.shapes.into_iter().filter(|shape| shape.t >= t).collect(), plan)
    };
    progress::phase("writing");
    let json = as_json(&plan);
    let mut written = Vec::new();
    if let Some(to) = args.output.destination() {
        let figure = figure::plan_figure(&outlines(&map), (&robot, &shapes), &hypotheses, &plan);
        written = write_all(to, &[("motion.csv", csv(&plan)), ("plan.json", json.clone()), ("plan.svg", figure)])?;
    }
    print(&if args.output.json { json } else { text(&plan, &hypotheses, &options) + &wrote(&written) })
}

fn text(plan: &Plan, hypotheses: &[Hypothesis], options: &PlanOptions) -> String {
    let mut text = format!("{}\n", plan.words());
    if let Some(next) = &plan.next {
        let _ = writeln!(text, "  waypoints     {}", waypoints(&next.motion));
        let _ = writeln!(text, "  stop          {}", where_to_stop(next));
        let _ = writeln!(text, "  information   {:.2} bit", next.information / core::f64::consts::LN_2);
    }
    let [looked, admissible] = plan.looked_at;
    let _ = writeln!(text, "  places        {} of {} that are told", plan.places, hypotheses.len());
    let _ = writeln!(
        text,
        "  looked at     {}, {admissible} of them admissible; {} of {} readings",
        counted(looked, "motion", "motions"),
        plan.readings,
        options.budget
    );
    text
}

/// Where a motion goes, in words.
pub(super) fn waypoints(motion: &Motion) -> String {
    let waypoint = |p: &Pose2| format!("({:.0}, {:.0}) mm {:.0} deg", 1e3 * p.x, 1e3 * p.y, p.theta.to_degrees());
    let way: Vec<String> = motion.waypoints().iter().skip(1).map(waypoint).collect();
    format!("{}, seen from the robot now", way.join(", "))
}

/// Where the robot has to end a motion, in words.
pub(super) fn where_to_stop(next: &PlannedMotion) -> String {
    let stop: Vec<String> = next.stop_at.iter().map(|moment| format!("{:.2} mN m", 1e3 * moment)).collect();
    format!("where a whisker feels {}", stop.join(", "))
}

fn as_json(plan: &Plan) -> String {
    format!("{:#}\n", to_json(plan))
}

fn csv(plan: &Plan) -> String {
    let mut text = String::from("x,y,theta\n");
    for p in plan.next.iter().flat_map(|next| next.motion.waypoints()) {
        let _ = writeln!(text, "{},{},{}", p.x, p.y, p.theta);
    }
    text
}

/// A robot whose whiskers can be looked ahead for, and its map.
pub(super) fn check_robot(robot: &Robot, map: &Map) -> Result<()> {
    if robot.whiskers.is_empty() {
        return Err(Error::data("the robot has no whisker"));
    }
    vibrissa::tasks::doubts(None, robot, Some(map)).iter().for_each(|warning| warn(warning));
    Ok(())
}
