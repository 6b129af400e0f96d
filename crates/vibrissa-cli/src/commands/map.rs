//! `vibrissa map`: an outline and the robot's way from logs alone.

use super::localize::outlines;
use super::logs::{Felt, OutlineArgs};
use crate::interrupt::{Heedful, stop};
use crate::output::{OutputArgs, counted, print, progress, warn, write_all, wrote};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;
use vibrissa::config::MappingOptions;
use vibrissa::figure::{Geometry, Layer, Outline, map_figure};
use vibrissa::io::map::to_geojson;
use vibrissa::io::trajectory::format_tum;
use vibrissa::plane::Vec2;
use vibrissa::tasks::mapping::{
    Change, ChangeKind, Closure, ClosureVerdict, Mapped, Share, Visit, graph_to_json, map_logs,
};
use vibrissa::tasks::profile::{Alignment, compare};
use vibrissa::world::{Map, PieceCourse};
use vibrissa::{Error, Result};

/// Spacing of the outline's points that are compared with a truth (m).
const SPACING: f64 = 1e-3;

/// Make a map from logs: the outline of what the whiskers touched, and the robot's way.
///
/// A log is a CSV file with the columns `t,x,y,theta,moment` (s, m, rad, N m); no map is needed. Where the robot provably came back, its
/// way and the outline are corrected; other places where it may have come back are told. The robot file bounds the odometry's errors.
///
/// Further logs of the same place may begin anywhere: each is placed in the outline of those before, adds to it, and tells where walls have
/// moved since. One that cannot be placed surely is told, and adds nothing.
///
/// With --out DIR: map.geojson (boundaries with bands and unknown stretches, which `vibrissa localize` reads), trajectory.tum,
/// covariances.csv, graph.json (the factor graph that was solved) and the figure mapping.svg; for further logs trajectory-2.tum,
/// covariances-2.csv and so on.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor logs (.csv), the oldest first
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    bounds: BoundArgs,
    /// Every log begins where the first one does, within so many mm and degrees: at a dock [default: anywhere]
    #[arg(long, value_names = ["MM", "DEG"], num_args = 2)]
    same_start: Option<Vec<f64>>,
    #[command(flatten)]
    reading: OutlineArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// What is known of the robot beside its file.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct BoundArgs {
    /// Bound on the drift of the odometry's heading, in degrees for each metre of way [default: 0]
    #[arg(long, value_name = "DEG")]
    drift: Option<f64>,
    /// Radius of a disc around the robot's origin that its body fills, in mm [default: 0]
    #[arg(long, value_name = "MM")]
    body: Option<f64>,
}

impl BoundArgs {
    /// Whether any is given.
    pub(super) fn is_given(&self) -> bool {
        self.drift.is_some() || self.body.is_some()
    }

    /// The options with these.
    pub(super) fn options(&self) -> MappingOptions {
        let default = MappingOptions::default();
        MappingOptions {
            drift: self.drift.map_or(default.drift, f64::to_radians),
            body_radius: self.body.map_or(default.body_radius, |mm| 1e-3 * mm),
            ..default
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let options = options(args)?;
    let Felt { robot, logs, truth } = args.reading.read(&args.logs)?;
    let _heeds = Heedful::hurried();
    let asked = stop();
    let found = map_logs(&logs, &robot, options, &asked, &mut progress::readings)?;
    if asked.is_asked() {
        warn("interrupted: what came after is missing, and closures were not looked for to the end");
    }
    let compared = truth.as_ref().and_then(|truth| compare(&found.outline.known_points(SPACING), truth, false));
    let mut written = Vec::new();
    if let Some(to) = args.output.destination() {
        let files = files(&found, truth.as_ref(), compared.as_ref());
        let files: Vec<(&str, String)> = files.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
        written = write_all(to, &files)?;
    }
    if args.output.json {
        let text = serde_json::to_string_pretty(&summary(&found, compared.as_ref()));
        let text = text.map_err(|error| Error::data(format!("cannot write the result as JSON ({error})")))?;
        return print(&(text + "\n"));
    }
    print(&(report(&found, compared.as_ref()) + &wrote(&written)))
}

/// The result's files, by name.
pub(super) fn files(found: &Mapped, truth: Option<&Map>, compared: Option<&Alignment>) -> Vec<(String, String)> {
    let mut files = vec![("map.geojson".to_owned(), to_geojson(&found.outline.map))];
    for (k, visit) in found.visits.iter().enumerate() {
        let number = if k == 0 { String::new() } else { format!("-{}", k + 1) };
        if visit.placed == ClosureVerdict::Proved {
            files.push((format!("trajectory{number}.tum"), format_tum(&visit.trajectory)));
            files.push((format!("covariances{number}.csv"), covariances(visit)));
        }
    }
    files.push(("graph.json".to_owned(), graph_to_json(&found.graph).to_string() + "\n"));
    files.push(("mapping.svg".to_owned(), figure(found, truth, compared)));
    files
}

/// The result in words.
pub(super) fn report(found: &Mapped, compared: Option<&Alignment>) -> String {
    let mut text: String = captions(found, compared).iter().map(|line| format!("{line}\n")).collect();
    for (k, visit) in found.visits.iter().enumerate().skip(1) {
        let _ = writeln!(text, "  log {}: {}", k + 1, placed(visit));
    }
    for change in &found.changes {
        let _ = writeln!(text, "  {}", changed(change));
    }
    for closure in &found.closures {
        let _ = writeln!(text, "  {}", told(closure));
    }
    text
}

fn options(args: &Args) -> Result<MappingOptions> {
    let options = MappingOptions {
        same_start: args.same_start.as_deref().and_then(|values| match values {
            [mm, degrees] => Some((1e-3 * mm, degrees.to_radians())),
            _ => None,
        }),
        ..args.bounds.options()
    };
    options.check()?;
    Ok(options)
}

pub(super) fn captions(found: &Mapped, compared: Option<&Alignment>) -> Vec<String> {
    let (known, unknown) = found.outline.lengths();
    let count = |verdict| found.closures.iter().filter(|closure| closure.verdict == verdict).count();
    let mut lines = vec![
        format!(
            "{}: {known:.3} m of wall known, {unknown:.3} m unknown, {} found",
            counted(found.outline.map.boundaries().len(), "boundary", "boundaries"),
            counted(found.outline.corners.len(), "corner", "corners")
        ),
        format!(
            "came back: {} proved, {} not told from others",
            counted(count(ClosureVerdict::Proved), "place", "places"),
            count(ClosureVerdict::Hypothesis) + count(ClosureVerdict::Unfinished)
        ),
    ];
    if count(ClosureVerdict::Contradiction) > 0 {
        lines.push("what was felt contradicts the declared bounds of the odometry: are they too small?".to_owned());
    }
    if let Some(compared) = compared {
        let shape = &compared.shape;
        let mm = |v: f64| 1e3 * v;
        let (mean, p95, max) = (mm(shape.mean), mm(shape.p95), mm(shape.max));
        lines.push(format!(
            "shape error (best rigid motion): mean {mean:.3} mm, 95 % below {p95:.3} mm, largest {max:.3} mm"
        ));
    }
    lines
}

/// Where a later log begins.
fn placed(visit: &Visit) -> String {
    match visit.placed {
        ClosureVerdict::Proved => "placed in the outline of those before".to_owned(),
        ClosureVerdict::Hypothesis if visit.places > 0 => {
            let places = counted(visit.places, "place", "places");
            format!(
                "not used, {places} in the outline would explain it: record a longer way, around corners that differ"
            )
        }
        ClosureVerdict::Hypothesis => "not used, it touches too little to be placed".to_owned(),
        ClosureVerdict::Contradiction => {
            "not used, no place in the outline explains it: is it another room, or are the declared bounds too small?"
                .to_owned()
        }
        ClosureVerdict::Unfinished => "not used, the search for its place was cut short".to_owned(),
    }
}

/// How a wall changed, in words.
fn changed(change: &Change) -> String {
    let [from, to] = [change.points.first(), change.points.last()].map(|p| p.copied().unwrap_or_default());
    let mm = |p: Vec2| format!("({:.0}, {:.0}) mm", 1e3 * p.x, 1e3 * p.y);
    let stretch = format!("{:.0} mm of wall from {} to {}", 1e3 * change.length(), mm(from), mm(to));
    let log = change.log + 1;
    match change.kind {
        ChangeKind::Moved { by, std } => {
            let side = if by > 0.0 { "towards the robot's side" } else { "away from the robot's side" };
            format!("log {log}: {stretch} have moved by {:.1} +- {:.1} mm, {side}", 1e3 * by.abs(), 1e3 * std)
        }
        ChangeKind::Gone => format!("log {log}: {stretch} are gone"),
    }
}

fn told(closure: &Closure) -> String {
    let [x, y, theta] = closure.extent;
    let size = format!("{:.0} mm by {:.0} mm, {:.1} deg", 2e3 * x, 2e3 * y, 2.0 * theta.to_degrees());
    let log = |number: usize| if number > 0 { format!(" of log {}", number + 1) } else { String::new() };
    let (later, earlier) = closure.logs;
    let when = format!("{:.2} s{} at the place of {:.2} s{}", closure.later, log(later), closure.earlier, log(earlier));
    match closure.verdict {
        ClosureVerdict::Proved => format!("{when}: proved, within {size}"),
        ClosureVerdict::Hypothesis => {
            let places = counted(closure.places, "separate place", "separate places");
            format!("{when}: a hypothesis, {places} within {size}")
        }
        ClosureVerdict::Contradiction => format!("{when}: contradicts the declared odometry bounds"),
        ClosureVerdict::Unfinished => format!("{when}: a hypothesis, the search for other places was cut short"),
    }
}

fn covariances(visit: &Visit) -> String {
    let mut text = "t,xx,xy,xtheta,yy,ytheta,thetatheta\n".to_owned();
    for (t, c) in &visit.covariances {
        let _ = writeln!(text, "{t},{},{},{},{},{},{}", c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]);
    }
    text
}

pub(super) fn summary(found: &Mapped, compared: Option<&Alignment>) -> Value {
    let (known, unknown) = found.outline.lengths();
    let share = |share: Share| json!({ "value": share.value, "std": share.std });
    let closure = |closure: &Closure| {
        json!({
            "later_s": closure.later, "earlier_s": closure.earlier, "later_log": closure.logs.0, "earlier_log": closure.logs.1, "verdict": closure.verdict.as_str(), "places": closure.places,
            "extent": closure.extent,
        })
    };
    let visit = |visit: &Visit| json!({ "placed": visit.placed.as_str(), "places": visit.places });
    let change = |change: &Change| {
        let points: Vec<[f64; 2]> = change.points.iter().map(|p| [p.x, p.y]).collect();
        let (kind, moved) = match change.kind {
            ChangeKind::Moved { by, std } => ("moved", Some((by, std))),
            ChangeKind::Gone => ("gone", None),
        };
        json!({
            "log": change.log, "kind": kind, "moved_m": moved.map(|(by, _)| by), "std_m": moved.map(|(_, std)| std),
            "length_m": change.length(), "points": points,
        })
    };
    let corners = found.outline.corners.iter();
    let corners = corners.map(|c| json!({ "x": c.position.x, "y": c.position.y, "std_m": c.band.std }));
    let mut answer = json!({
        "boundaries": found.outline.map.boundaries().len(), "known_m": known, "unknown_m": unknown,
        "corners": corners.collect::<Vec<Value>>(),
        "closures": found.closures.iter().map(closure).collect::<Vec<Value>>(),
        "logs": found.visits.iter().map(visit).collect::<Vec<Value>>(),
        "changes": found.changes.iter().map(change).collect::<Vec<Value>>(),
        "odometry": {
            "scale": share(found.shares.scale), "turn": share(found.shares.turn), "drift_rad_per_m": share(found.shares.drift),
        },
    });
    if let Some(compared) = compared {
        let shape = &compared.shape;
        answer["truth"] = json!({ "mean_m": shape.mean, "p95_m": shape.p95, "max_m": shape.max });
    }
    answer
}

fn figure(found: &Mapped, truth: Option<&Map>, compared: Option<&Alignment>) -> String {
    let layer = |geometry, class, label: &str, framed| Layer { geometry, class, label: label.to_owned(), framed };
    let closed = |outline: &Outline| -> Vec<Vec2> {
        let first = outline.points.first().copied().filter(|_| outline.closed);
        outline.points.iter().copied().chain(first).collect()
    };
    let moved = compared.map(|compared| compared.map_from_outline.inverse());
    let place = |line: Vec<Vec2>| -> Vec<Vec2> {
        line.into_iter().map(|p| moved.map_or(p, |moved| moved.transform_point(p))).collect()
    };
    let truth = truth.map(outlines).unwrap_or_default().iter().map(|outline| place(closed(outline))).collect();
    let own = outlines(&found.outline.map);
    let known = found.outline.map.boundaries().iter().flat_map(|boundary| {
        let segments = boundary.curve().segments().iter().enumerate();
        let is_known = |(k, _): &(usize, _)| !matches!(boundary.piece_course(*k), Some(PieceCourse::Unknown(_)));
        segments.filter(is_known).map(|(_, segment)| vec![segment.start(), segment.end()]).collect::<Vec<_>>()
    });
    let way = |visit: &Visit| {
        let mut way: Vec<Vec2> = Vec::new();
        for place in visit.trajectory.iter().map(|row| row.map_from_robot.position()) {
            if way.last().is_none_or(|last| last.distance(place) >= SPACING) {
                way.push(place);
            }
        }
        way
    };
    let placed = found.visits.iter().filter(|visit| visit.placed == ClosureVerdict::Proved);
    let changed: Vec<Vec<Vec2>> = found.changes.iter().map(|change| change.points.clone()).collect();
    let mut layers = vec![
        layer(Geometry::Lines(truth), "truth", "the true shape, moved to where it fits best", false),
        layer(Geometry::Lines(known.collect()), "edge", "the outline felt", true),
        layer(Geometry::Lines(placed.map(way).collect()), "path", "the robot's way", true),
        layer(Geometry::Circles(found.outline.corners.iter().map(|c| c.position).collect()), "start", "corners", true),
    ];
    if !changed.is_empty() {
        layers.push(layer(Geometry::Lines(changed), "survivor", "walls that changed", true));
    }
    map_figure("A map made by touch", &captions(found, compared), "odometry frame of the first row", &own, &layers)
}
