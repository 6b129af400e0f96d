//! Contacts in space as words, JSON, table and figure.

use crate::interrupt::{Heedful, stop};
use crate::output::{OutputArgs, counted, print, progress, warn, write_all, wrote};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use vibrissa::config::ContactOptions;
use vibrissa::figure::{Plot, plots_figure};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::tasks::contact::{Band, ContactKind, SpaceReport, SpaceStep, contact_in_space};
use vibrissa::tasks::doubts;
use vibrissa::world::Robot;
use vibrissa::{Error, Result};

/// Events that are told in words.
const TOLD: usize = 20;
/// What says that planar methods are wrong here.
const WARNINGS: [&str; 2] = ["out_of_plane", "slides_around"];

/// Finds, writes and prints.
pub(super) fn run(log: &Path, read: &SensorLog, robot: Option<&Path>, output: &OutputArgs) -> Result<()> {
    let robot = robot.map_or_else(|| Ok(Robot::default()), vibrissa::read_robot)?;
    read.warnings.iter().chain(&doubts(Some(read), &robot, None)).for_each(|warning| warn(warning));
    let heeds = Heedful::hurried();
    let found = contact_in_space(read, &robot, &ContactOptions::default(), &stop(), &mut progress::readings);
    let report = found.map_err(|error| error.in_file(log))?;
    drop(heeds);
    if let Some(t) = report.stopped_at {
        warn(&format!("interrupted: the contacts from {t:.3} s on are missing"));
    }
    let warnings = report.events.iter().filter(|event| WARNINGS.contains(&event.kind));
    warnings.for_each(|event| warn(&format!("at {:.3} s {}", event.t, event.detail)));
    let written = match output.destination() {
        Some(to) => {
            let title =
                format!("Contacts of {} in space", log.file_name().unwrap_or(log.as_os_str()).to_string_lossy());
            write_all(to, &[("space.csv", csv(&report, &robot)), ("space.svg", figure(&report, &title))])?
        }
        None => Vec::new(),
    };
    if output.json {
        return print(&as_json(&report, &robot)?);
    }
    print(&(words(&report) + &wrote(&written)))
}

fn name(robot: &Robot, step: &SpaceStep) -> String {
    robot.whiskers.get(step.whisker).map_or_else(String::new, |whisker| whisker.name.clone())
}

/// The columns after `t,whisker,kind`, by name.
fn columns(step: &SpaceStep) -> [(&'static str, Option<f64>); 20] {
    let (plane, at) = (step.plane(), step.position());
    let [size, turn] = plane.bands(step.errors);
    let of = |of: fn(&vibrissa::tasks::contact::SpacePoint) -> Band| step.contact.as_ref().map(of);
    let (x, r, angle) = (of(|c| c.x), of(|c| c.r), of(|c| c.angle));
    [
        ("x", x.map(|b| b.value)),
        ("r", r.map(|b| b.value)),
        ("angle", Some(angle.map_or(plane.angle, |b| b.value))),
        ("x_min", x.map(|b| b.lo)),
        ("x_max", x.map(|b| b.hi)),
        ("r_min", r.map(|b| b.lo)),
        ("r_max", r.map(|b| b.hi)),
        ("angle_min", Some(angle.map_or(plane.angle - turn, |b| b.lo))),
        ("angle_max", Some(angle.map_or(plane.angle + turn, |b| b.hi))),
        ("s_a", step.s_a),
        ("x_odom", at.map(|p| p[0])),
        ("y_odom", at.map(|p| p[1])),
        ("z", at.map(|p| p[2])),
        ("moment", Some(step.moments[0])),
        ("across", Some(step.moments[1])),
        ("size", Some(plane.moment)),
        ("size_error", Some(size)),
        ("plane_angle", Some(plane.angle)),
        ("plane_angle_error", Some(turn)),
        ("out_of_plane", Some(plane.out_of_plane())),
    ]
}

fn csv(report: &SpaceReport, robot: &Robot) -> String {
    let mut text = String::from("t,whisker,kind");
    let blank = SpaceStep {
        t: 0.0,
        whisker: 0,
        kind: ContactKind::Unknown,
        moments: [0.0; 2],
        errors: [0.0; 2],
        odom_from_whisker: vibrissa::plane::Pose2::IDENTITY,
        contact: None,
        s_a: None,
    };
    columns(&blank).iter().for_each(|(name, _)| text.extend([",", name]));
    text.push('\n');
    for step in &report.steps {
        let cell = |value: Option<f64>| value.filter(|v| v.is_finite()).map_or_else(String::new, |v| v.to_string());
        let cells: Vec<String> = columns(step).iter().map(|(_, value)| cell(*value)).collect();
        let _ = writeln!(text, "{},{},{},{}", step.t, name(robot, step), step.kind.word(), cells.join(","));
    }
    text
}

fn as_json(report: &SpaceReport, robot: &Robot) -> Result<String> {
    let one = |step: &SpaceStep| {
        let mut object: serde_json::Map<String, Value> = columns(step)
            .into_iter()
            .map(|(name, value)| (name.to_owned(), json!(value.filter(|v| v.is_finite()))))
            .collect();
        object.insert("t".to_owned(), json!(step.t));
        object.insert("whisker".to_owned(), json!(name(robot, step)));
        object.insert("kind".to_owned(), json!(step.kind.word()));
        Value::Object(object)
    };
    let event = |e: &vibrissa::flow::pose::Event| json!({ "t": e.t, "kind": e.kind, "detail": e.detail });
    let [side, tip, unknown] = counts(report);
    let mut answer = json!({
        "steps": report.steps.len(), "side": side, "tip": tip, "unknown": unknown,
        "contacts": report.steps.iter().map(one).collect::<Vec<_>>(),
        "events": report.events.iter().map(event).collect::<Vec<_>>(),
    });
    if report.stopped_at.is_some() {
        answer["interrupted"] = json!(true);
    }
    let text = serde_json::to_string_pretty(&answer);
    text.map(|text| text + "\n").map_err(|error| Error::data(format!("cannot write the result as JSON ({error})")))
}

fn counts(report: &SpaceReport) -> [usize; 3] {
    [ContactKind::Side, ContactKind::Tip, ContactKind::Unknown]
        .map(|kind| report.steps.iter().filter(|step| step.kind == kind).count())
}

fn words(report: &SpaceReport) -> String {
    if report.steps.is_empty() && report.stopped_at.is_none() {
        return "no contact: no reading rises above the declared noise\n".to_owned();
    }
    let [side, tip, unknown] = counts(report);
    let mut text = format!(
        "{} in contact: {side} with the side, which stands still, {tip} taken for the tip, {unknown} not found\n",
        counted(report.steps.len(), "step", "steps")
    );
    let mut last = None;
    for step in &report.steps {
        if last == Some((step.whisker, step.kind)) {
            continue;
        }
        last = Some((step.whisker, step.kind));
        let Some(contact) = step.contact else { continue };
        let half = |band: Band| 0.5 * (band.hi - band.lo);
        let _ = writeln!(
            text,
            "  {} at t = {:.3} s: x {:.2} ± {:.2} mm, r {:.2} ± {:.2} mm, {:.1} ± {:.1} deg about the axis",
            step.kind.word(),
            step.t,
            1e3 * contact.x.value,
            1e3 * half(contact.x),
            1e3 * contact.r.value,
            1e3 * half(contact.r),
            contact.angle.value.to_degrees(),
            half(contact.angle).to_degrees(),
        );
    }
    for event in report.events.iter().take(TOLD) {
        let _ = writeln!(text, "  {:.3} s  {}: {}", event.t, event.kind, event.detail);
    }
    if report.events.len() > TOLD {
        let _ = writeln!(text, "  and {} more events", report.events.len() - TOLD);
    }
    text
}

/// Along, away and around over time: dots, and the bands' edges as a line around them.
fn figure(report: &SpaceReport, title: &str) -> String {
    let [side, tip, unknown] = counts(report);
    let steps = counted(report.steps.len(), "step", "steps");
    let notes = format!("{steps} in contact: side {side}, tip {tip}, not found {unknown}");
    let begins = report.events.iter().filter(|event| event.kind == "contact");
    let touches: Vec<f64> = begins.map(|event| event.t).collect();
    let plot = |y_label: &str, of: fn(&SpaceStep) -> Option<Band>, factor: f64| {
        let found = |step: &&SpaceStep| of(step).is_some();
        let mut steps: Vec<&SpaceStep> = report.steps.iter().filter(found).collect();
        steps.sort_by_key(|step| step.whisker);
        // Between two touches nothing is known.
        let touched = |a: f64, b: f64| touches.iter().any(|&t| a < t && t <= b);
        let stretches = steps.chunk_by(|a, b| a.whisker == b.whisker && !touched(a.t, b.t));
        let around = |stretch: &[&SpaceStep]| -> Vec<(f64, f64)> {
            let edge = |step: &&SpaceStep, of_band: fn(Band) -> f64| Some((step.t, of_band(of(step)?) * factor));
            let up = stretch.iter().filter_map(|step| edge(step, |band| band.hi));
            let down = stretch.iter().rev().filter_map(|step| edge(step, |band| band.lo));
            let closed = up.clone().take(1);
            up.chain(down).chain(closed).chain([(f64::NAN, f64::NAN)]).collect()
        };
        Plot {
            x_label: "time (s)".to_owned(),
            y_label: y_label.to_owned(),
            points: steps.iter().filter_map(|step| Some((step.t, of(step)?.value * factor))).collect(),
            curve: stretches.flat_map(around).collect(),
            ..Plot::default()
        }
    };
    let plots = [
        plot("along the whisker, x (mm), within its band", |step| step.contact.map(|c| c.x), 1e3),
        plot("away from its axis, r (mm)", |step| step.contact.map(|c| c.r), 1e3),
        plot(
            "about its axis, from left to up (deg)",
            |step| step.contact.map(|c| c.angle),
            360.0 / core::f64::consts::TAU,
        ),
    ];
    plots_figure(
        title,
        &notes,
        "Where the whisker is touched over time: along it, away from its axis, around it.",
        &plots,
    )
}
