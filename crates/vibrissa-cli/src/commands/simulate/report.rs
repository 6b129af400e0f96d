//! What a simulation leaves: words, JSON, tables and a figure.

use super::cannot_encode;
use crate::output::counted;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use vibrissa::Result;
use vibrissa::figure::{Outline, Series, SimulationScene, simulation_figure};
use vibrissa::flow::sensor_log::Quantity;
use vibrissa::plane::Vec2;
use vibrissa::sim::recorder::Columns;
use vibrissa::sim::{Scenario, Simulation};
use vibrissa::sim::{Sweep, SweptShape, shapes};

/// Whisker shapes in the figure, of all whiskers together.
const SHAPES: usize = 90;
/// How many events are listed one by one.
const LISTED: usize = 12;

#[derive(Serialize)]
struct Json<'a> {
    title: &'a str,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    interrupted: bool,
    seed: u64,
    rows: usize,
    recorded_rows: usize,
    duration_s: f64,
    distance_m: f64,
    whiskers: Vec<WhiskerJson<'a>>,
    events: Vec<EventJson<'a>>,
    warnings: &'a [String],
}

#[derive(Serialize)]
struct WhiskerJson<'a> {
    name: &'a str,
    rows_in_contact: usize,
    strongest_moment: f64,
}

#[derive(Serialize)]
struct EventJson<'a> {
    t: f64,
    kind: &'a str,
    detail: &'a str,
}

/// The summary as JSON (s, m, N m).
pub(super) fn json(scenario: &Scenario, simulation: &Simulation) -> Result<String> {
    let sweep = &simulation.sweep;
    let events = sweep.events.iter().map(|e| EventJson { t: e.t, kind: e.kind, detail: &e.detail }).collect();
    let value = Json {
        title: &scenario.title,
        interrupted: sweep.truth.len() < scenario.path.len(),
        seed: scenario.seed(),
        rows: sweep.truth.len(),
        recorded_rows: simulation.recording.log.rows.len(),
        duration_s: duration(sweep),
        distance_m: distance(sweep),
        whiskers: whiskers(scenario, sweep),
        events,
        warnings: &simulation.warnings,
    };
    let mut text = serde_json::to_string_pretty(&value).map_err(|error| cannot_encode(&error))?;
    text.push('\n');
    Ok(text)
}

fn whiskers<'a>(scenario: &'a Scenario, sweep: &Sweep) -> Vec<WhiskerJson<'a>> {
    let one = |(index, whisker): (usize, &'a vibrissa::world::MountedWhisker)| {
        let mut rows: Vec<usize> = sweep.contacts.iter().filter(|t| t.whisker == index).map(|t| t.row).collect();
        rows.dedup();
        let strongest =
            sweep.exact_moments.iter().map(|m| m[index]).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        WhiskerJson { name: &whisker.name, rows_in_contact: rows.len(), strongest_moment: strongest }
    };
    scenario.robot.whiskers.iter().enumerate().map(one).collect()
}

fn duration(sweep: &Sweep) -> f64 {
    sweep.truth.last().map_or(0.0, |last| last.t)
}

fn distance(sweep: &Sweep) -> f64 {
    let step = |pair: &[vibrissa::flow::pose::StampedPose]| {
        pair[0].map_from_robot.position().distance(pair[1].map_from_robot.position())
    };
    sweep.truth.windows(2).map(step).sum()
}

/// The first line of words, also the figure's caption.
fn caption(sweep: &Sweep, recorded: usize) -> String {
    let (rows, seconds, metres) = (sweep.truth.len(), duration(sweep), distance(sweep));
    let lost = if recorded < rows { format!(", {recorded} recorded") } else { String::new() };
    let (rows, touches) = (counted(rows, "row", "rows"), counted(sweep.contacts.len(), "touch", "touches"));
    format!("{rows}{lost} in {seconds:.2} s, {:.0} mm of way, {touches}", metres * 1e3)
}

/// The summary in words.
pub(super) fn text(scenario: &Scenario, simulation: &Simulation, written: Option<&[PathBuf]>) -> String {
    let sweep = &simulation.sweep;
    // Writing into a string cannot fail.
    let mut text = format!(
        "{} (seed {})\n{}\n\n",
        scenario.title,
        scenario.seed(),
        caption(sweep, simulation.recording.log.rows.len())
    );
    let _ = writeln!(text, "  whisker     rows in contact   strongest moment");
    for whisker in whiskers(scenario, sweep) {
        let _ = writeln!(
            text,
            "  {:<10} {:>8} of {:<8} {:>10.3} mN m",
            whisker.name,
            whisker.rows_in_contact,
            sweep.truth.len(),
            whisker.strongest_moment * 1e3
        );
    }
    if !sweep.events.is_empty() {
        text.push_str("\nevents\n");
    }
    for event in sweep.events.iter().take(LISTED) {
        let _ = writeln!(text, "  {:>9.3} s  {}: {}", event.t, event.kind, event.detail);
    }
    if sweep.events.len() > LISTED {
        let _ = writeln!(text, "  … and {} more events", sweep.events.len() - LISTED);
    }
    match written {
        Some(paths) => {
            text.push_str("\nwritten\n");
            for path in paths {
                let _ = writeln!(text, "  {}", path.display());
            }
            text.push_str(&next_step(scenario, paths));
            if sweep.events.iter().any(|event| event.kind == "discrete_rod") {
                text.push_str(TRAIL);
            }
        }
        None => text.push_str("\nNo files were written; add --out DIR for the log, the truth and a figure.\n"),
    }
    text
}

/// What helps against contacts that few methods take.
const TRAIL: &str = "A whisker touched at two places at once, which of the methods of `localize` only the probabilistic one models: let the \
                     tip trail (mount the whisker so that it points backwards) or keep a larger distance.\n";

/// How to localize the robot from the files, or what else the log is for; nothing when it holds raw readings alone.
fn next_step(scenario: &Scenario, paths: &[PathBuf]) -> String {
    let written = |name: &str| paths.iter().find(|path| path.ends_with(name)).cloned();
    let map = scenario.map_file.clone().or_else(|| written("map.geojson"));
    let files = [written("log.csv"), map, written("robot.toml"), written("truth.tum")];
    let holds = |wanted: &[Columns]| wanted.iter().any(|column| scenario.recorder.columns.contains(column));
    match files.map(|file| file.map(|path| path.display().to_string())) {
        [Some(log), Some(map), Some(robot), Some(truth)]
            if holds(&[Columns::Moment, Columns::Force, Columns::Slope]) =>
        {
            // The one method that takes whiskers that are curved at rest.
            let is_curved = scenario.robot.whiskers.iter().any(|w| w.beam.require_straight().is_err());
            let method = if is_curved { " --method possibilistic" } else { "" };
            format!(
                "\nNext, find the robot:\n  vibrissa localize {log} --map {map} --robot {robot} --truth {truth}{method}\n"
            )
        }
        [Some(log), _, Some(robot), _] if holds(&[Columns::Strip]) => {
            format!("\nNext, find the contacts:\n  vibrissa contact {log} --robot {robot} --filter\n")
        }
        _ => String::new(),
    }
}

/// The shapes as CSV: `t,whisker,s,x,y` (s, name, m, m, m), map frame.
pub(super) fn shapes_csv(scenario: &Scenario, sweep: &Sweep, shapes: &[SweptShape]) -> String {
    let mut text = String::from("t,whisker,s,x,y\n");
    for shape in shapes {
        let (whisker, t) = (&scenario.robot.whiskers[shape.whisker], sweep.truth[shape.row].t);
        let step = whisker.beam.length / (shape.points.len().max(2) - 1) as f64;
        // Every fourth point draws smoothly.
        for (index, point) in shape.points.iter().enumerate().step_by(4) {
            let _ = writeln!(text, "{t},{},{},{:.7},{:.7}", whisker.name, index as f64 * step, point.x, point.y);
        }
    }
    text
}

/// The moments without any error as CSV: `t` and a column for each whisker (s, N m).
pub(super) fn exact_csv(scenario: &Scenario, sweep: &Sweep) -> String {
    let alone = scenario.robot.whiskers.len() == 1;
    let column = |name: &String| if alone { "moment".to_owned() } else { format!("{name}.moment") };
    let columns: Vec<String> = scenario.robot.whiskers.iter().map(|w| column(&w.name)).collect();
    let mut text = format!("t,{}\n", columns.join(","));
    for (pose, moments) in sweep.truth.iter().zip(&sweep.exact_moments) {
        let moments: Vec<String> = moments.iter().map(f64::to_string).collect();
        let _ = writeln!(text, "{},{}", pose.t, moments.join(","));
    }
    text
}

/// The figure.
pub(super) fn figure(scenario: &Scenario, simulation: &Simulation, map: &[Outline]) -> String {
    let sweep = &simulation.sweep;
    let each = SHAPES / scenario.robot.whiskers.len().clamp(1, SHAPES);
    let drawn = shapes(&simulation.robot, sweep, sweep.truth.len().div_ceil(each).max(1));
    let shapes: Vec<Vec<Vec2>> = drawn.into_iter().map(|shape| shape.points.into_iter().step_by(4).collect()).collect();
    let touches: Vec<Vec2> = sweep.contacts.iter().map(|touch| touch.position).collect();
    let (series, quantity) = series(scenario, simulation);
    simulation_figure(&SimulationScene {
        title: &scenario.title,
        caption: &caption(sweep, simulation.recording.log.rows.len()),
        map,
        path: &sweep.truth,
        robot: &scenario.outline,
        shapes: &shapes,
        touches: &touches,
        series: &series,
        quantity,
    })
}

/// The moments, or where none are logged the field across the whisker.
fn series(scenario: &Scenario, simulation: &Simulation) -> (Vec<Series>, &'static str) {
    let recording = &simulation.recording;
    let channels: Vec<usize> =
        (0..recording.log.channels.len()).filter(|&c| recording.log.channels[c].quantity == Quantity::Moment).collect();
    let has_moments = !channels.is_empty();
    let one = |(index, whisker): (usize, &vibrissa::world::MountedWhisker)| {
        let value = |row: usize| match channels.get(index) {
            Some(&channel) => recording.log.rows[row].readings[channel] * 1e3,
            None => recording.flux[row][index][1] * 1e3,
        };
        let read = (0..recording.log.rows.len()).map(|row| (recording.log.rows[row].t, value(row))).collect();
        let exact = simulation.sweep.truth.iter().zip(&simulation.sweep.exact_moments);
        let exact = exact.map(|(pose, moments)| (pose.t, moments[index] * 1e3));
        let exact = if has_moments { exact.collect() } else { Vec::new() };
        Series { name: whisker.name.clone(), read, exact }
    };
    let series = scenario.robot.whiskers.iter().enumerate().map(one).collect();
    (series, if has_moments { "moment at the base, mN m" } else { "flux density along the chip's y axis, mT" })
}
