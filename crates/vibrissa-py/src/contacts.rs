//! Contact points, outlines, and distances of taps.

use crate::arrays::{Table, column, counts, events, table};
use crate::error::{OrRaise, warn};
use crate::inputs::RobotIn;
use crate::log::PySensorLog;
use crate::long::{Watch, run};
use crate::world::PyMap;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use vibrissa::config::{ContactOptions, ProfileOptions};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::Vec2;
use vibrissa::tasks::contact::{
    Band, ContactReport, ContactStep, SpacePoint, SpaceStep, contact_in_space as in_space, contacts_until,
};
use vibrissa::tasks::profile::{Alignment, Misfit, Outline, Profile, compare, profile_until};
use vibrissa::tasks::temporal_filter::{FilteredContact, TemporalFilterOptions, temporal_filter as filtered};
use vibrissa::world::Robot;

/// One number of a step.
type Number = fn(&ContactStep) -> f64;

/// Contact points of a log; gives the fields of `vibrissa.Contacts`.
#[pyfunction]
pub(crate) fn contact<'py>(
    py: Python<'py>,
    log: &PySensorLog,
    robot: RobotIn,
    spacing: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (log, robot) = (Arc::clone(&log.0), robot.robot().or_raise(py)?);
    let default = ContactOptions::default();
    let options = ContactOptions { spacing: spacing.unwrap_or(default.spacing), ..default };
    let names: Vec<String> = robot.whiskers.iter().map(|whisker| whisker.name.clone()).collect();
    let report = run(py, None, 0, move |watch| {
        let found = contacts_until(&log, &robot, &options, watch.stop(), &mut |done, _| watch.tell(done));
        found.map_err(|error| named(&log, error))
    })?;
    steps(py, &report, &names)
}

/// The error with the log's file.
fn named(log: &SensorLog, error: vibrissa::Error) -> vibrissa::Error {
    match &log.source {
        Some(file) => error.in_file(file),
        None => error,
    }
}

fn or_nan(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

fn place<'py>(
    py: Python<'py>,
    steps: &[ContactStep],
    of: impl Fn(&ContactStep) -> Option<Vec2>,
) -> PyResult<Table<'py>> {
    table(py, steps, |step| of(step).map_or([f64::NAN; 2], |p| [p.x, p.y]))
}

fn steps<'py>(py: Python<'py>, report: &ContactReport, names: &[String]) -> PyResult<Bound<'py, PyDict>> {
    let steps = &report.steps;
    let out = PyDict::new(py);
    let numbers: [(&str, Number); 8] = [
        ("t", |s| s.t),
        ("moment", |s| s.moment),
        ("s_a", |s| or_nan(s.s_a)),
        ("distance", |s| or_nan(s.contact.map(Vec2::norm))),
        ("std", |s| or_nan(s.std)),
        ("kaneko", |s| or_nan(s.baseline.rotation)),
        ("solomon", |s| or_nan(s.baseline.translation)),
        ("small_angle", |s| or_nan(s.baseline.both)),
    ];
    for (name, of) in numbers {
        out.set_item(name, column(py, steps, of))?;
    }
    let bounds = |s: &ContactStep| s.bounds.map_or([f64::NAN; 2], |b| [b.lo(), b.hi()]);
    out.set_item("distance_bounds", table(py, steps, bounds)?)?;
    out.set_item("piece", counts(py, steps, |s| s.piece))?;
    let name = |s: &ContactStep| names.get(s.whisker).cloned().unwrap_or_default();
    out.set_item("whisker", steps.iter().map(name).collect::<Vec<_>>())?;
    out.set_item("kind", steps.iter().map(|s| s.kind.word()).collect::<Vec<_>>())?;
    out.set_item("contact", place(py, steps, |s| s.contact)?)?;
    out.set_item("position", place(py, steps, ContactStep::position)?)?;
    let base = |s: &ContactStep| [s.odom_from_whisker.x, s.odom_from_whisker.y, s.odom_from_whisker.theta];
    out.set_item("odom_from_whisker", table(py, steps, base)?)?;
    out.set_item("events", events(&report.events))?;
    Ok(out)
}

/// Contacts of a log in space; gives the fields of `vibrissa.SpaceContacts`.
#[pyfunction]
pub(crate) fn contact_in_space<'py>(
    py: Python<'py>,
    log: &PySensorLog,
    robot: RobotIn,
    spacing: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (log, robot) = (Arc::clone(&log.0), robot.robot().or_raise(py)?);
    let default = ContactOptions::default();
    let options = ContactOptions { spacing: spacing.unwrap_or(default.spacing), ..default };
    let names: Vec<String> = robot.whiskers.iter().map(|whisker| whisker.name.clone()).collect();
    let report = run(py, None, 0, move |watch| {
        let found = in_space(&log, &robot, &options, watch.stop(), &mut |done, _| watch.tell(done));
        found.map_err(|error| named(&log, error))
    })?;
    let steps = &report.steps;
    let out = PyDict::new(py);
    out.set_item("t", column(py, steps, |s| s.t))?;
    out.set_item(
        "whisker",
        steps.iter().map(|s| names.get(s.whisker).cloned().unwrap_or_default()).collect::<Vec<_>>(),
    )?;
    out.set_item("kind", steps.iter().map(|s| s.kind.word()).collect::<Vec<_>>())?;
    out.set_item("moments", table(py, steps, |s| s.moments)?)?;
    out.set_item("plane", table(py, steps, |s| [s.plane().moment, s.plane().angle])?)?;
    out.set_item("plane_errors", table(py, steps, |s| s.plane().bands(s.errors))?)?;
    for (index, name) in ["x", "r", "angle"].into_iter().enumerate() {
        let of = |c: &SpacePoint| -> Band { [c.x, c.r, c.angle][index] };
        out.set_item(name, column(py, steps, |s| or_nan(s.contact.as_ref().map(|c| of(c).value))))?;
        let bounds = |s: &SpaceStep| s.contact.as_ref().map_or([f64::NAN; 2], |c| [of(c).lo, of(c).hi]);
        out.set_item(format!("{name}_bounds"), table(py, steps, bounds)?)?;
    }
    out.set_item("s_a", column(py, steps, |s| or_nan(s.s_a)))?;
    out.set_item("contact", table(py, steps, |s| s.contact.map_or([f64::NAN; 3], |c| c.position()))?)?;
    out.set_item("position", table(py, steps, |s| s.position().unwrap_or([f64::NAN; 3]))?)?;
    let base = |s: &SpaceStep| [s.odom_from_whisker.x, s.odom_from_whisker.y, s.odom_from_whisker.theta];
    out.set_item("odom_from_whisker", table(py, steps, base)?)?;
    out.set_item("events", events(&report.events))?;
    Ok(out)
}

/// Outlines of one or more logs; gives the fields of `vibrissa.Profile`.
#[pyfunction]
pub(crate) fn profile<'py>(
    py: Python<'py>,
    logs: Vec<PyRef<'py, PySensorLog>>,
    robot: RobotIn,
    truth: Option<&PyMap>,
    free_scale: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let robot = robot.robot().or_raise(py)?;
    let logs: Vec<SensorLog> = logs.iter().map(|log| (*log.0).clone()).collect();
    let truth = truth.map(|map| Arc::clone(&map.0));
    let (found, compared) = run(py, None, 0, move |watch| {
        let found = felt(&logs, &robot, watch)?;
        let points: Vec<Vec2> = found.outlines.iter().flat_map(|o| o.points.iter().map(|p| p.position)).collect();
        let compared = truth.and_then(|map| compare(&points, &map, free_scale));
        Ok((found, compared))
    })?;
    if found.outlines.is_empty() {
        warn(py, &["no outline was found: the tips slid along no wall, or not far enough".to_owned()])?;
    }
    let out = PyDict::new(py);
    out.set_item("outlines", found.outlines.iter().map(|o| outline(py, o)).collect::<PyResult<Vec<_>>>()?)?;
    out.set_item("pegs", table(py, &found.pegs, |(p, std)| [p.x, p.y, *std])?)?;
    out.set_item("steps", found.contacts)?;
    out.set_item("left_out", found.left_out)?;
    out.set_item("events", found.events.iter().map(|log| events(log)).collect::<Vec<_>>())?;
    out.set_item("alignment", compared.as_ref().map(|c| alignment(py, c)).transpose()?)?;
    Ok(out)
}

/// Contact sets of several readings, intersected; gives the fields of `vibrissa.FilteredContacts`.
#[pyfunction]
pub(crate) fn temporal_filter<'py>(
    py: Python<'py>,
    log: &PySensorLog,
    robot: RobotIn,
    readings: Option<usize>,
    spacing: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (log, robot) = (Arc::clone(&log.0), robot.robot().or_raise(py)?);
    let default = TemporalFilterOptions::default();
    let (readings, spacing) = (readings.unwrap_or(default.readings), spacing.unwrap_or(default.spacing));
    let options = TemporalFilterOptions { readings, spacing, ..default };
    let names: Vec<String> = robot.whiskers.iter().map(|whisker| whisker.name.clone()).collect();
    let found = run(py, None, 0, move |_| filtered(&log, &robot, &options).map_err(|error| named(&log, error)))?;
    let out = PyDict::new(py);
    out.set_item("t", column(py, &found, |one| one.t))?;
    out.set_item("whisker", found.iter().map(|one| names[one.whisker].clone()).collect::<Vec<_>>())?;
    out.set_item("readings", counts(py, &found, |one| one.readings))?;
    out.set_item("components", counts(py, &found, |one| one.components))?;
    out.set_item("area", column(py, &found, |one| one.area))?;
    out.set_item("contact", table(py, &found, |one| [one.contact.x, one.contact.y])?)?;
    out.set_item("position", table(py, &found, |one| [one.position().x, one.position().y])?)?;
    let sides = |one: &FilteredContact| {
        let [x, y] = one.extent;
        [x.lo(), x.hi(), y.lo(), y.hi()]
    };
    out.set_item("extent", table(py, &found, sides)?)?;
    Ok(out)
}

fn felt(logs: &[SensorLog], robot: &Robot, watch: &Watch) -> vibrissa::Result<Profile> {
    let (contact, options) = (ContactOptions::default(), ProfileOptions::default());
    profile_until(logs, robot, &contact, &options, watch.stop(), &mut |_, done, _| watch.tell(done))
}

fn outline<'py>(py: Python<'py>, one: &Outline) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("points", table(py, &one.points, |p| [p.position.x, p.position.y])?)?;
    out.set_item("normals", table(py, &one.points, |p| [p.normal.x, p.normal.y])?)?;
    out.set_item("std", column(py, &one.points, |p| p.std))?;
    out.set_item("runs", counts(py, &one.points, |p| p.runs))?;
    out.set_item("closed", one.closed)?;
    Ok(out)
}

pub(crate) fn alignment<'py>(py: Python<'py>, compared: &Alignment) -> PyResult<Bound<'py, PyDict>> {
    let misfit = |m: &Misfit| (m.mean, m.rms, m.p95, m.max);
    let out = PyDict::new(py);
    out.set_item("absolute", misfit(&compared.absolute))?;
    out.set_item("shape", misfit(&compared.shape))?;
    let pose = compared.map_from_outline;
    out.set_item("map_from_outline", (pose.x, pose.y, pose.theta))?;
    out.set_item("scaled", compared.scaled.as_ref().map(|(m, scale)| (misfit(m), *scale)))?;
    Ok(out)
}
