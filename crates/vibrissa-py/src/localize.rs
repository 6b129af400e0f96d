//! Where the robot is.

use crate::arrays::{column, counts, events, points, poses, rows, stamped, table, trajectory};
use crate::error::{OrRaise, warn};
use crate::inputs::RobotIn;
use crate::log::PySensorLog;
use crate::long::run;
use crate::world::PyMap;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use vibrissa::Method;
use vibrissa::config::{SettingValue, Slot};
use vibrissa::figure::{LocalizationScene, localization_figure};
use vibrissa::flow::pose::{ConsistencyReport, Estimate, Hypothesis, Localization, Nuisance, OdometryEstimate, Status};
use vibrissa::flow::sensor_log::Quantity;
use vibrissa::flow::trajectory::trajectory_error;
use vibrissa::io::{format_tum, read_tum};
use vibrissa::sets::StateBox;
use vibrissa::tasks::{advise, demo, doubts, localize_until, outlines};

/// The methods by name, the default one first.
#[pyfunction]
pub(crate) fn methods() -> Vec<&'static str> {
    let default = Method::default().name();
    let others = Method::all().into_iter().map(|method| method.name()).filter(|name| *name != default);
    core::iter::once(default).chain(others).collect()
}

/// A method with its options, those that are None at their defaults.
pub(crate) fn method_of(py: Python<'_>, name: &str, options: &Bound<'_, PyDict>) -> PyResult<Method> {
    let mut method = Method::named(name).or_raise(py)?;
    for (option, given) in options.iter().filter(|(_, given)| !given.is_none()) {
        let option: String = option.extract()?;
        let kind = method.settings().into_iter().find(|setting| setting.name == option).map(|setting| setting.field);
        let value = match kind {
            Some(Slot::Count(_)) => SettingValue::Count(given.extract()?),
            Some(Slot::Choice(_)) => SettingValue::Choice(given.extract()?),
            Some(Slot::Region(_)) => {
                let [a, b, c, d, e, f] = given.extract()?;
                SettingValue::Region([[a, b], [c, d], [e, f]])
            }
            Some(Slot::Number(_) | Slot::OptionalNumber(..)) => SettingValue::Number(given.extract()?),
            // There is no such option: the method says so, whatever was given.
            None => SettingValue::Number(0.0),
        };
        method.set(&option, value).or_raise(py)?;
    }
    method.check().or_raise(py)?;
    Ok(method)
}

/// Localizes; gives the fields of `vibrissa.Localization` as a dict.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // Called from one place.
pub(crate) fn localize<'py>(
    py: Python<'py>,
    log: &PySensorLog,
    map: &PyMap,
    robot: RobotIn,
    method: &str,
    options: &Bound<'py, PyDict>,
    progress: Option<&Bound<'py, PyAny>>,
    truth: Option<(PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>)>,
) -> PyResult<Bound<'py, PyDict>> {
    let truth = truth.map(|(t, poses)| PyResult::Ok(stamped(t.as_slice()?, &rows(&poses)?))).transpose()?;
    let (method, robot) = (method_of(py, method, options)?, robot.robot().or_raise(py)?);
    let mounted = |name: &str| robot.whiskers.iter().any(|whisker| whisker.name == name);
    let unused = log.0.channels.iter().filter(|channel| {
        channel.quantity == Quantity::Moment && !channel.whisker.is_empty() && !mounted(&channel.whisker)
    });
    let unused: Vec<String> = unused
        .map(|channel| format!("the column `{}` is not used: the robot has no whisker of this name", channel.column()))
        .collect();
    warn(py, &unused)?;
    warn(py, &doubts(Some(&log.0), &robot, Some(&map.0)))?;
    let (log, map, total) = (Arc::clone(&log.0), Arc::clone(&map.0), log.0.rows.len());
    let (answer, figure) = run(py, progress, total, move |watch| {
        let mut answer = localize_until(&log, &map, &robot, &method, watch.stop(), &mut |row, _| {
            watch.tell(row + 1);
            ControlFlow::Continue(())
        })?;
        advise(&mut answer, &log, &map, &robot, &method, &mut || {
            // Ends here once the caller has given up.
            watch.tell(total);
            true
        })?;
        let outlines = outlines(&map, DRAWING_TOLERANCE);
        let title = answer.method;
        let scene = LocalizationScene { title, map: &outlines, answer: &answer, truth: truth.as_deref(), robot: &[] };
        let figure = localization_figure(&scene);
        Ok((answer, figure))
    })?;
    let out = fields(py, &answer)?;
    out.set_item("_svg", figure)?;
    Ok(out)
}

/// How far a drawn boundary may be from the map's (m).
const DRAWING_TOLERANCE: f64 = 2e-5;

fn sides(state: &StateBox) -> [f64; 6] {
    [state.x.lo(), state.x.hi(), state.y.lo(), state.y.hi(), state.theta.lo(), state.theta.hi()]
}

/// The fields of `vibrissa.Localization`.
pub(crate) fn fields<'py>(py: Python<'py>, answer: &Localization) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("method", answer.method)?;
    out.set_item("status", answer.status.as_str())?;
    // Where nothing explains the log no pose may look like an answer.
    let answered = answer.status != Status::Inconsistent;
    out.set_item("estimate", answer.estimate.filter(|_| answered).map(|pose| (pose.x, pose.y, pose.theta)))?;
    let places = answer.hypotheses.iter().filter(|_| answered);
    out.set_item("hypotheses", places.map(|h| hypothesis(py, h)).collect::<PyResult<Vec<_>>>()?)?;
    out.set_item("trajectory", trajectory(py, &answer.trajectory)?)?;
    out.set_item("states", table(py, &answer.states, sides)?)?;
    out.set_item("first_states", poses(py, answer.first_states.iter().copied())?)?;
    out.set_item("odometry", answer.odometry.as_ref().map(|one| odometry(py, one)).transpose()?)?;
    out.set_item("nuisances", answer.nuisances.iter().map(|one| nuisance(py, one)).collect::<PyResult<Vec<_>>>()?)?;
    out.set_item("consistency", answer.consistency.as_ref().map(|one| consistency(py, one)).transpose()?)?;
    out.set_item("unsure", table(py, &answer.unsure, |stretch| [stretch.from, stretch.to])?)?;
    let steps = PyDict::new(py);
    steps.set_item("t", column(py, &answer.steps, |step| step.t))?;
    steps.set_item("components", counts(py, &answer.steps, |step| step.components))?;
    steps.set_item("area_m2", column(py, &answer.steps, |step| step.area_m2))?;
    steps.set_item("volume", column(py, &answer.steps, |step| step.volume))?;
    out.set_item("steps", steps)?;
    out.set_item("events", events(&answer.events))?;
    let shapes = answer.shapes.iter().map(|shape| Ok((shape.t, points(py, &shape.points)?, shape.whisker)));
    out.set_item("shapes", shapes.collect::<PyResult<Vec<_>>>()?)?;
    Ok(out)
}

/// The fields of `vibrissa.Estimate`.
pub(crate) fn estimate_fields<'py>(py: Python<'py>, estimate: &Estimate) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let answered = estimate.status != Status::Inconsistent;
    out.set_item("status", estimate.status.as_str())?;
    out.set_item("rows", estimate.rows)?;
    out.set_item("pose", estimate.pose().filter(|_| answered).map(|pose| (pose.x, pose.y, pose.theta)))?;
    let places = estimate.hypotheses.iter().filter(|_| answered);
    out.set_item("hypotheses", places.map(|h| hypothesis(py, h)).collect::<PyResult<Vec<_>>>()?)?;
    Ok(out)
}

fn odometry<'py>(py: Python<'py>, one: &OdometryEstimate) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("translation_scale", one.translation_scale)?;
    out.set_item("translation_scale_std", one.translation_scale_std)?;
    out.set_item("aside", one.aside)?;
    out.set_item("aside_std", one.aside_std)?;
    out.set_item("rotation_scale", one.rotation_scale)?;
    out.set_item("rotation_scale_std", one.rotation_scale_std)?;
    Ok(out)
}

fn nuisance<'py>(py: Python<'py>, one: &Nuisance) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("quantity", one.quantity.as_str())?;
    out.set_item("whisker", one.whisker.as_deref())?;
    out.set_item("unit", one.quantity.unit())?;
    out.set_item("estimate", one.estimate)?;
    out.set_item("std", one.std)?;
    out.set_item("bound", one.bound)?;
    Ok(out)
}

fn consistency<'py>(py: Python<'py>, one: &ConsistencyReport) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("statistic", one.statistic)?;
    out.set_item("most", one.most)?;
    out.set_item("correlation_time", one.correlation_time)?;
    out.set_item("worst", one.worst.map(|(stretch, statistic)| (stretch.from, stretch.to, statistic)))?;
    let remedies = one.remedies.iter().map(|remedy| (remedy.change.clone(), remedy.statistic, remedy.status.as_str()));
    out.set_item("remedies", remedies.collect::<Vec<_>>())?;
    Ok(out)
}

fn hypothesis<'py>(py: Python<'py>, one: &Hypothesis) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("x", one.pose.x)?;
    out.set_item("y", one.pose.y)?;
    out.set_item("theta", one.pose.theta)?;
    out.set_item("weight", one.weight)?;
    let names = ["x_min", "x_max", "y_min", "y_max", "theta_min", "theta_max"];
    for (name, value) in names.into_iter().zip(sides(&one.extent)) {
        out.set_item(name, value)?;
    }
    out.set_item("covariance", one.covariance.map(|rows| table(py, rows, |row| row)).transpose()?)?;
    out.set_item("ridge", poses(py, one.ridge.iter().copied())?)?;
    Ok(out)
}

/// A trajectory file: stamps and poses.
#[pyfunction]
pub(crate) fn tum_read(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    trajectory(py, &read_tum(path).or_raise(py)?)?.into_pyobject(py).map(Bound::into_any)
}

/// A trajectory as the text of its file.
#[pyfunction]
pub(crate) fn tum_format(t: PyReadonlyArray1<'_, f64>, poses: PyReadonlyArray2<'_, f64>) -> PyResult<String> {
    Ok(format_tum(&stamped(t.as_slice()?, &rows(&poses)?)))
}

/// Rows, final position (m) and heading (rad), mean position (m) and heading (rad).
type Told = (usize, f64, f64, f64, f64);

/// How far an estimate is from the truth: rows, final position and heading, mean position and heading.
#[pyfunction]
pub(crate) fn tum_error(
    t: PyReadonlyArray1<'_, f64>,
    poses: PyReadonlyArray2<'_, f64>,
    true_t: PyReadonlyArray1<'_, f64>,
    true_poses: PyReadonlyArray2<'_, f64>,
) -> PyResult<Option<Told>> {
    let estimate = stamped(t.as_slice()?, &rows(&poses)?);
    let truth = stamped(true_t.as_slice()?, &rows(&true_poses)?);
    let told = trajectory_error(&estimate, &truth);
    Ok(told.map(|e| (e.rows, e.final_position, e.final_heading, e.mean_position, e.mean_heading)))
}

/// The demo's sweep: its log, and the fields of `vibrissa.Sweep`.
#[pyfunction]
pub(crate) fn demo_sweep(py: Python<'_>, seed: u64) -> PyResult<(PySensorLog, Bound<'_, PyDict>)> {
    let sweep = run(py, None, 0, move |_| demo::sweep(seed))?;
    let fields = crate::simulate::fields(py, &sweep)?;
    Ok((PySensorLog::new(py, sweep.log)?, fields))
}
