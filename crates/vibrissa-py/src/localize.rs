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
use std::path::PathBuf;
use std::sync::Arc;
use vibrissa::config::{DeterministicOptions, PossibilisticOptions, ProbabilisticOptions, TipLoad};
use vibrissa::flow::pose::{Hypothesis, Localization, Method, OdometryEstimate};
use vibrissa::flow::sensor_log::Quantity;
use vibrissa::flow::trajectory::trajectory_error;
use vibrissa::io::{format_tum, read_tum};
use vibrissa::sets::StateBox;
use vibrissa::tasks::demo;
use vibrissa::{Error, LocalizeOptions, Result};

const METHODS: [Method; 3] = [Method::Deterministic, Method::Possibilistic, Method::Probabilistic];

/// The options of `vibrissa.localize`, each None where the default is taken.
#[derive(Debug, Default, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct OptionsIn {
    method: String,
    tip_load: Option<String>,
    boundary_spacing: Option<f64>,
    history_shapes: Option<usize>,
    history_travel: Option<f64>,
    update_travel: Option<f64>,
    tolerance: Option<f64>,
    missed_share: Option<f64>,
    heading_error: Option<f64>,
    within: Option<[f64; 6]>,
    tolerate: Option<usize>,
    largest_slope: Option<f64>,
    work: Option<usize>,
    last_work: Option<usize>,
    seed_spacing: Option<f64>,
    seed_turn: Option<f64>,
    seed_travel: Option<f64>,
    shared_gain: Option<f64>,
    tolerated_share: Option<f64>,
}

impl OptionsIn {
    /// Every option that is given, with the methods that have it.
    fn given(&self) -> Vec<(&'static str, &'static [Method])> {
        let [det, pos, pro] = [&METHODS[..1], &METHODS[1..2], &METHODS[2..]];
        let all = [
            ("tip_load", self.tip_load.is_some(), det),
            ("boundary_spacing", self.boundary_spacing.is_some(), det),
            ("history_shapes", self.history_shapes.is_some(), det),
            ("history_travel", self.history_travel.is_some(), det),
            ("update_travel", self.update_travel.is_some(), det),
            ("tolerance", self.tolerance.is_some(), det),
            ("missed_share", self.missed_share.is_some(), det),
            ("heading_error", self.heading_error.is_some(), &METHODS[1..]),
            ("within", self.within.is_some(), &METHODS[..]),
            ("tolerate", self.tolerate.is_some(), pos),
            ("largest_slope", self.largest_slope.is_some(), pos),
            ("work", self.work.is_some(), pos),
            ("last_work", self.last_work.is_some(), pos),
            ("seed_spacing", self.seed_spacing.is_some(), pro),
            ("seed_turn", self.seed_turn.is_some(), pro),
            ("seed_travel", self.seed_travel.is_some(), pro),
            ("shared_gain", self.shared_gain.is_some(), pro),
            ("tolerated_share", self.tolerated_share.is_some(), pro),
        ];
        all.into_iter().filter(|(_, given, _)| *given).map(|(name, _, methods)| (name, methods)).collect()
    }

    fn options(&self) -> Result<LocalizeOptions> {
        let words = METHODS.map(Method::as_str);
        let method = METHODS.into_iter().find(|method| method.as_str() == self.method);
        let method = method.ok_or_else(|| Error::usage("method").value(&self.method).allowed(words.join(", ")))?;
        if let Some((name, methods)) = self.given().into_iter().find(|(_, methods)| !methods.contains(&method)) {
            let of: Vec<&str> = methods.iter().map(|method| method.as_str()).collect();
            return Err(Error::usage(format!("the option {name} is none of the method {}", method.as_str()))
                .remedy(format!("leave it out, or choose method {}", of.join(" or "))));
        }
        let options = LocalizeOptions {
            method,
            deterministic: self.deterministic()?,
            possibilistic: self.possibilistic(),
            probabilistic: self.probabilistic(),
        };
        match method {
            Method::Deterministic => options.deterministic.check(),
            Method::Possibilistic => options.possibilistic.check(),
            Method::Probabilistic => options.probabilistic.check(),
        }?;
        Ok(options)
    }

    fn deterministic(&self) -> Result<DeterministicOptions> {
        let default = DeterministicOptions::default();
        let tip_load = match self.tip_load.as_deref() {
            None => default.tip_load,
            Some("boundary-normal") => TipLoad::BoundaryNormal,
            Some("whisker-normal") => TipLoad::WhiskerNormal,
            Some(other) => {
                return Err(Error::usage("tip_load").value(other).allowed("boundary-normal, whisker-normal"));
            }
        };
        Ok(DeterministicOptions {
            tip_load,
            boundary_spacing: self.boundary_spacing.unwrap_or(default.boundary_spacing),
            history_shapes: self.history_shapes.unwrap_or(default.history_shapes),
            history_travel: self.history_travel.unwrap_or(default.history_travel),
            update_travel: self.update_travel.unwrap_or(default.update_travel),
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            missed_share: self.missed_share.unwrap_or(default.missed_share),
            prior: self.region(),
            ..default
        })
    }

    fn possibilistic(&self) -> PossibilisticOptions {
        let default = PossibilisticOptions::default();
        PossibilisticOptions {
            tolerate: self.tolerate.unwrap_or(default.tolerate),
            heading_error: self.heading_error.unwrap_or(default.heading_error),
            largest_slope: self.largest_slope.unwrap_or(default.largest_slope),
            work: self.work.unwrap_or(default.work),
            last_work: self.last_work.unwrap_or(default.last_work),
            prior: self.region(),
            ..default
        }
    }

    fn probabilistic(&self) -> ProbabilisticOptions {
        let default = ProbabilisticOptions::default();
        ProbabilisticOptions {
            seed_spacing: self.seed_spacing.unwrap_or(default.seed_spacing),
            seed_turn: self.seed_turn.unwrap_or(default.seed_turn),
            seed_travel: self.seed_travel.unwrap_or(default.seed_travel),
            shared_gain: self.shared_gain,
            tolerated_share: self.tolerated_share.unwrap_or(default.tolerated_share),
            heading_error: self.heading_error.unwrap_or(default.heading_error),
            prior: self.region(),
            ..default
        }
    }

    fn region(&self) -> Option<[[f64; 2]; 3]> {
        self.within.map(|[a, b, c, d, e, f]| [[a, b], [c, d], [e, f]])
    }
}

/// Localizes; gives the fields of `vibrissa.Localization` as a dict.
#[pyfunction]
pub(crate) fn localize<'py>(
    py: Python<'py>,
    log: &PySensorLog,
    map: &PyMap,
    robot: RobotIn,
    options: OptionsIn,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (options, robot) = (options.options().or_raise(py)?, robot.robot().or_raise(py)?);
    let mounted = |name: &str| robot.whiskers.iter().any(|whisker| whisker.name == name);
    let unused = log.0.channels.iter().filter(|channel| {
        channel.quantity == Quantity::Moment && !channel.whisker.is_empty() && !mounted(&channel.whisker)
    });
    let unused: Vec<String> = unused
        .map(|channel| format!("the column `{}` is not used: the robot has no whisker of this name", channel.column()))
        .collect();
    warn(py, &unused)?;
    let (log, map, total) = (Arc::clone(&log.0), Arc::clone(&map.0), log.0.rows.len());
    let answer = run(py, progress, total, move |watch| {
        vibrissa::localize(&log, &map, &robot, &options, &mut |row| watch.tell(row + 1))
    })?;
    fields(py, &answer)
}

fn sides(state: &StateBox) -> [f64; 6] {
    [state.x.lo(), state.x.hi(), state.y.lo(), state.y.hi(), state.theta.lo(), state.theta.hi()]
}

fn fields<'py>(py: Python<'py>, answer: &Localization) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("method", answer.method.as_str())?;
    out.set_item("status", answer.status.as_str())?;
    out.set_item("estimate", answer.estimate.map(|pose| (pose.x, pose.y, pose.theta)))?;
    out.set_item("hypotheses", answer.hypotheses.iter().map(|h| hypothesis(py, h)).collect::<PyResult<Vec<_>>>()?)?;
    out.set_item("trajectory", trajectory(py, &answer.trajectory)?)?;
    out.set_item("states", table(py, &answer.states, sides)?)?;
    out.set_item("first_states", poses(py, answer.first_states.iter().copied())?)?;
    out.set_item("odometry", answer.odometry.as_ref().map(|one| odometry(py, one)).transpose()?)?;
    let steps = PyDict::new(py);
    steps.set_item("t", column(py, &answer.steps, |step| step.t))?;
    steps.set_item("components", counts(py, &answer.steps, |step| step.components))?;
    steps.set_item("area_m2", column(py, &answer.steps, |step| step.area_m2))?;
    steps.set_item("volume", column(py, &answer.steps, |step| step.volume))?;
    out.set_item("steps", steps)?;
    out.set_item("events", events(&answer.events))?;
    let shapes = answer.shapes.iter().map(|shape| Ok((shape.t, points(py, &shape.points)?)));
    out.set_item("shapes", shapes.collect::<PyResult<Vec<_>>>()?)?;
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
