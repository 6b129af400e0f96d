//! A log's contacts as words, JSON, table and figure.

use crate::interrupt::{Heedful, stop};
use crate::output::{OutputArgs, counted, print, progress, warn, write_all, wrote};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;
use vibrissa::beam::{Load, point_mode};
use vibrissa::config::ContactOptions;
use vibrissa::figure::{Geometry, Layer, scene_figure};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::Vec2;
use vibrissa::tasks::contact::{Baseline, ContactKind, ContactReading, ContactReport, ContactStep, contacts_until};
use vibrissa::tasks::doubts;
use vibrissa::world::Robot;
use vibrissa::{Error, Result};

/// Bent whiskers in the figure.
const DRAWN: usize = 14;
/// Events that are told in words.
const TOLD: usize = 20;

#[derive(Serialize)]
struct Answer<'a> {
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    interrupted: bool,
    steps: usize,
    side: usize,
    tip: usize,
    unknown: usize,
    contacts: Vec<ContactJson>,
    events: Vec<EventJson<'a>>,
}

#[derive(Serialize)]
struct ContactJson {
    t: f64,
    whisker: String,
    kind: &'static str,
    x: Option<f64>,
    y: Option<f64>,
    x_odom: Option<f64>,
    y_odom: Option<f64>,
    s_a: Option<f64>,
    std: Option<f64>,
}

#[derive(Serialize)]
struct EventJson<'a> {
    t: f64,
    kind: &'a str,
    detail: &'a str,
}

/// Finds, writes and prints.
pub(super) fn run(log: &Path, read: &SensorLog, robot: Option<&Path>, output: &OutputArgs) -> Result<()> {
    let robot = robot.map_or_else(|| Ok(Robot::default()), vibrissa::read_robot)?;
    read.warnings.iter().chain(&doubts(Some(read), &robot, None)).for_each(|warning| warn(warning));
    let heeds = Heedful::hurried();
    let found = contacts_until(read, &robot, &ContactOptions::default(), &stop(), &mut progress::readings);
    let report = found.map_err(|error| error.in_file(log))?;
    drop(heeds);
    if let Some(t) = report.stopped_at {
        warn(&format!("interrupted: the contacts from {t:.3} s on are missing"));
    }
    let written = match output.destination() {
        Some(to) => {
            let until = report.stopped_at.map_or_else(String::new, |t| format!(", interrupted at {t:.3} s"));
            let title = format!("Contacts of {}{until}", log.file_name().unwrap_or(log.as_os_str()).to_string_lossy());
            let files = [("contacts.csv", csv(&report, &robot)), ("contacts.svg", figure(&report, &robot, &title))];
            write_all(to, &files)?
        }
        None => Vec::new(),
    };
    if output.json {
        return print(&json(&report, &robot)?);
    }
    print(&(words(&report) + &wrote(&written)))
}

fn count(report: &ContactReport, kind: ContactKind) -> usize {
    report.steps.iter().filter(|step| step.kind == kind).count()
}

/// Whether the side leaned on a point that stood still.
fn stands(step: &ContactStep) -> bool {
    step.kind == ContactKind::Side && step.normal.is_none()
}

fn name(robot: &Robot, step: &ContactStep) -> String {
    robot.whiskers.get(step.whisker).map_or_else(String::new, |whisker| whisker.name.clone())
}

fn cell(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or_else(String::new, |v| v.to_string())
}

fn csv(report: &ContactReport, robot: &Robot) -> String {
    let mut text = String::from(
        "t,whisker,kind,x,y,x_odom,y_odom,s_a,distance,std,distance_min,distance_max,moment,kaneko,solomon,small_angle\n",
    );
    for step in &report.steps {
        let odom = step.position();
        let Baseline { rotation, translation, both } = step.baseline;
        let cells = [
            cell(step.contact.map(|c| c.x)),
            cell(step.contact.map(|c| c.y)),
            cell(odom.map(|c| c.x)),
            cell(odom.map(|c| c.y)),
            cell(step.s_a),
            cell(step.contact.map(Vec2::norm)),
            cell(step.std),
            cell(step.bounds.map(|b| b.lo())),
            cell(step.bounds.map(|b| b.hi())),
            cell(Some(step.moment)),
            cell(rotation),
            cell(translation),
            cell(both),
        ];
        let _ = writeln!(text, "{},{},{},{}", step.t, name(robot, step), step.kind.word(), cells.join(","));
    }
    text
}

fn json(report: &ContactReport, robot: &Robot) -> Result<String> {
    let contact = |step: &ContactStep| {
        let odom = step.position();
        ContactJson {
            t: step.t,
            whisker: name(robot, step),
            kind: step.kind.word(),
            x: step.contact.map(|c| c.x),
            y: step.contact.map(|c| c.y),
            x_odom: odom.map(|c| c.x),
            y_odom: odom.map(|c| c.y),
            s_a: step.s_a,
            std: step.std.filter(|std| std.is_finite()),
        }
    };
    let answer = Answer {
        interrupted: report.stopped_at.is_some(),
        steps: report.steps.len(),
        side: count(report, ContactKind::Side),
        tip: count(report, ContactKind::Tip),
        unknown: count(report, ContactKind::Unknown),
        contacts: report.steps.iter().map(contact).collect(),
        events: report.events.iter().map(|e| EventJson { t: e.t, kind: e.kind, detail: &e.detail }).collect(),
    };
    let text = serde_json::to_string_pretty(&answer);
    text.map(|text| text + "\n").map_err(|error| Error::data(format!("cannot write the result as JSON ({error})")))
}

fn words(report: &ContactReport) -> String {
    if report.steps.is_empty() && report.stopped_at.is_none() {
        return "no contact: no reading rises above the declared noise\n".to_owned();
    }
    let [side, tip, unknown] =
        [ContactKind::Side, ContactKind::Tip, ContactKind::Unknown].map(|kind| count(report, kind));
    let mut text = format!(
        "{} in contact: {side} with the side, {tip} with the tip, {unknown} not found\n",
        counted(report.steps.len(), "step", "steps")
    );
    let mut last = None;
    for step in report.steps.iter().filter(|step| stands(step)) {
        if let (Some(contact), Some(position), Some(std)) = (step.contact, step.position(), step.std)
            && last != Some(step.piece)
        {
            last = Some(step.piece);
            let _ = writeln!(
                text,
                "  side contact at ({:.2}, {:.2}) mm in the odometry frame, {:.2} ± {:.2} mm from the base at t = {:.3} s",
                1e3 * position.x,
                1e3 * position.y,
                1e3 * contact.norm(),
                1e3 * std,
                step.t
            );
        }
    }
    for event in report.events.iter().take(TOLD) {
        let _ = writeln!(text, "  {:.3} s  {}: {}", event.t, event.kind, event.detail);
    }
    if report.events.len() > TOLD {
        let _ = writeln!(text, "  and {} more events", report.events.len() - TOLD);
    }
    text
}

fn figure(report: &ContactReport, robot: &Robot, title: &str) -> String {
    let of = |keep: &dyn Fn(&ContactStep) -> bool| -> Vec<Vec2> {
        report.steps.iter().filter(|step| keep(step)).filter_map(ContactStep::position).collect()
    };
    let slides = |step: &ContactStep| step.kind == ContactKind::Side && !stands(step);
    let layer = |geometry, class, label: &str, framed| Layer { geometry, class, label: label.to_owned(), framed };
    let many = robot.whiskers.len() > 1;
    let (bent, base) =
        if many { ("bent whiskers", "the whiskers' bases") } else { ("the bent whisker", "the whisker's base") };
    let layers = [
        layer(Geometry::Lines(shapes(report, robot)), "whisker", bent, true),
        layer(Geometry::Dots(closed_forms(report, robot)), "closed-form", "small-angle closed form", false),
        layer(Geometry::Lines(bases(report)), "path", base, true),
        layer(
            Geometry::Dots(of(&|step| step.kind == ContactKind::Tip)),
            "tip-contact",
            "contact of the sliding tip",
            true,
        ),
        layer(Geometry::Dots(of(&slides)), "sliding-side", "contact of the sliding side", true),
        layer(Geometry::Dots(of(&stands)), "side-contact", "contact of the side, standing still", true),
    ];
    let [side, tip, unknown] =
        [ContactKind::Side, ContactKind::Tip, ContactKind::Unknown].map(|kind| count(report, kind));
    let caption = format!(
        "{} in contact: side {side}, tip {tip}, not found {unknown}",
        counted(report.steps.len(), "step", "steps")
    );
    scene_figure(title, &[caption], "odometry frame", &layers)
}

/// Rows of one contact are no further apart than so many of the shortest gaps between rows.
const GAPS: f64 = 8.0;

/// The way of each whisker's base while it touches, odometry frame: a line for each contact.
fn bases(report: &ContactReport) -> Vec<Vec<Vec2>> {
    let gap = |pair: &[&ContactStep]| pair[1].t - pair[0].t;
    let mut ways = Vec::new();
    for steps in of_each_whisker(report, |_| true) {
        let mut gaps: Vec<f64> = steps.windows(2).map(gap).collect();
        gaps.sort_by(f64::total_cmp);
        let longest = GAPS * gaps.get(gaps.len() / 2).copied().unwrap_or(0.0);
        let parts = steps.chunk_by(|a, b| b.t - a.t <= longest);
        ways.extend(parts.map(|part| part.iter().map(|s| s.odom_from_whisker.position()).collect()));
    }
    ways
}

/// The steps that `keep` takes, for each whisker that has any.
fn of_each_whisker(report: &ContactReport, keep: impl Fn(&ContactStep) -> bool) -> Vec<Vec<&ContactStep>> {
    let last = report.steps.iter().map(|step| step.whisker).max();
    let of = |whisker| report.steps.iter().filter(|step| step.whisker == whisker && keep(step)).collect();
    let each = last.into_iter().flat_map(|last| 0..=last).map(of);
    each.filter(|steps: &Vec<&ContactStep>| !steps.is_empty()).collect()
}

/// Some of the bent whiskers, as many of each, odometry frame.
fn shapes(report: &ContactReport, robot: &Robot) -> Vec<Vec<Vec2>> {
    let each = of_each_whisker(report, |step| step.contact.is_some());
    let most = (DRAWN / each.len().max(1)).max(2);
    let shape = |step: &&ContactStep| {
        let (beam, contact) = (robot.whiskers.get(step.whisker)?.beam, step.contact?);
        let points = match &step.bend {
            Some(bend) => bend.shape(beam.length, 60),
            None => point_mode(&beam, contact, Load::Normal).ok()?.first()?.shape(beam.length, 60),
        };
        Some(points.into_iter().map(|p| step.odom_from_whisker.transform_point(p)).collect())
    };
    each.iter().flat_map(|known| known.iter().step_by(known.len().div_ceil(most)).filter_map(shape)).collect()
}

/// Where the small-angle formula puts the contacts that stood still, odometry frame.
fn closed_forms(report: &ContactReport, robot: &Robot) -> Vec<Vec2> {
    let one = |step: &ContactStep| {
        let whisker = robot.whiskers.get(step.whisker)?;
        let reading = ContactReading {
            t: step.t,
            whisker: whisker.beam,
            odom_from_whisker: step.odom_from_whisker,
            moment: step.moment,
            noise: whisker.noise,
            count: 1,
        };
        let distance = step.baseline.both.filter(|d| *d < 2.0 * whisker.beam.length)?;
        Some(step.odom_from_whisker.transform_point(Baseline::contact(&reading, distance)))
    };
    report.steps.iter().filter(|step| stands(step)).filter_map(one).collect()
}
