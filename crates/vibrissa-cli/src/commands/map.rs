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
use vibrissa::tasks::mapping::{Closure, ClosureVerdict, Mapped, Share, map_log};
use vibrissa::tasks::profile::{Alignment, compare};
use vibrissa::world::{Map, PieceCourse};
use vibrissa::{Error, Result};

/// Spacing of the outline's points that are compared with a truth (m).
const SPACING: f64 = 1e-3;

/// Make a map from a log: the outline of what the whiskers touched, and the robot's way.
///
/// The log is a CSV file with the columns `t,x,y,theta,moment` (s, m, rad, N m); no map is needed. Where the robot provably came back, its
/// way and the outline are corrected; other places where it may have come back are told. The robot file bounds the odometry's errors.
///
/// With --out DIR: map.geojson (boundaries with bands and unknown stretches, which `vibrissa localize` reads), trajectory.tum,
/// covariances.csv and the figure mapping.svg.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The sensor log (.csv)
    log: PathBuf,
    /// Bound on the drift of the odometry's heading, in degrees for each metre of way [default: 0]
    #[arg(long, value_name = "DEG")]
    drift: Option<f64>,
    /// Radius of a disc around the robot's origin that its body fills, in mm [default: 0]
    #[arg(long, value_name = "MM")]
    body: Option<f64>,
    #[command(flatten)]
    reading: OutlineArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<()> {
    let options = options(args)?;
    let Felt { robot, logs, truth } = args.reading.read(core::slice::from_ref(&args.log))?;
    let _heeds = Heedful::hurried();
    let asked = stop();
    let in_file = |error: Error| error.in_file(&args.log);
    let log = logs.first().ok_or_else(|| Error::data("no log"))?;
    let found = map_log(log, &robot, options, &asked, &mut progress::readings).map_err(in_file)?;
    if asked.is_asked() {
        warn("interrupted: what came after is missing, and closures were not looked for to the end");
    }
    let compared = truth.as_ref().and_then(|truth| compare(&found.outline.known_points(SPACING), truth, false));
    let mut written = Vec::new();
    if let Some(to) = args.output.destination() {
        let files = [
            ("map.geojson", to_geojson(&found.outline.map)),
            ("trajectory.tum", format_tum(&found.trajectory)),
            ("covariances.csv", covariances(&found)),
            ("mapping.svg", figure(&found, truth.as_ref(), compared.as_ref())),
        ];
        written = write_all(to, &files)?;
    }
    if args.output.json {
        let text = serde_json::to_string_pretty(&summary(&found, compared.as_ref()));
        let text = text.map_err(|error| Error::data(format!("cannot write the result as JSON ({error})")))?;
        return print(&(text + "\n"));
    }
    let mut text: String = captions(&found, compared.as_ref()).iter().map(|line| format!("{line}\n")).collect();
    for closure in &found.closures {
        let _ = writeln!(text, "  {}", told(closure));
    }
    print(&(text + &wrote(&written)))
}

fn options(args: &Args) -> Result<MappingOptions> {
    let default = MappingOptions::default();
    let options = MappingOptions {
        drift: args.drift.map_or(default.drift, f64::to_radians),
        body_radius: args.body.map_or(default.body_radius, |mm| 1e-3 * mm),
        ..default
    };
    options.check()?;
    Ok(options)
}

fn captions(found: &Mapped, compared: Option<&Alignment>) -> Vec<String> {
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

fn told(closure: &Closure) -> String {
    let [x, y, theta] = closure.extent;
    let size = format!("{:.0} mm by {:.0} mm, {:.1} deg", 2e3 * x, 2e3 * y, 2.0 * theta.to_degrees());
    let when = format!("{:.2} s at the place of {:.2} s", closure.later, closure.earlier);
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

fn covariances(found: &Mapped) -> String {
    let mut text = "t,xx,xy,xtheta,yy,ytheta,thetatheta\n".to_owned();
    for (t, c) in &found.covariances {
        let _ = writeln!(text, "{t},{},{},{},{},{},{}", c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]);
    }
    text
}

fn summary(found: &Mapped, compared: Option<&Alignment>) -> Value {
    let (known, unknown) = found.outline.lengths();
    let share = |share: Share| json!({ "value": share.value, "std": share.std });
    let closure = |closure: &Closure| {
        json!({
            "later_s": closure.later, "earlier_s": closure.earlier, "verdict": closure.verdict.as_str(), "places": closure.places,
            "extent": closure.extent,
        })
    };
    let corners = found.outline.corners.iter();
    let corners = corners.map(|c| json!({ "x": c.position.x, "y": c.position.y, "std_m": c.band.std }));
    let mut answer = json!({
        "boundaries": found.outline.map.boundaries().len(), "known_m": known, "unknown_m": unknown,
        "corners": corners.collect::<Vec<Value>>(),
        "closures": found.closures.iter().map(closure).collect::<Vec<Value>>(),
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
    let mut way: Vec<Vec2> = Vec::new();
    for place in found.trajectory.iter().map(|row| row.map_from_robot.position()) {
        if way.last().is_none_or(|last| last.distance(place) >= SPACING) {
            way.push(place);
        }
    }
    let layers = [
        layer(Geometry::Lines(truth), "truth", "the true shape, moved to where it fits best", false),
        layer(Geometry::Lines(known.collect()), "edge", "the outline felt", true),
        layer(Geometry::Lines(vec![way]), "path", "the robot's way", true),
        layer(Geometry::Circles(found.outline.corners.iter().map(|c| c.position).collect()), "start", "corners", true),
    ];
    map_figure("A map made by touch", &captions(found, compared), "odometry frame of the first row", &own, &layers)
}
