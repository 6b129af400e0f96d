//! Sweeps: what a robot would record.

use crate::arrays::{column, counts, events, points, rows, stamped, table, trajectory};
use crate::error::{OrRaise, warn};
use crate::inputs::RobotIn;
use crate::log::PySensorLog;
use crate::long::run;
use crate::world::PyMap;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyAny, PyDict};
use std::path::PathBuf;
use std::sync::Arc;
use vibrissa::Error;
use vibrissa::config::scenario;
use vibrissa::plane::Pose2;
use vibrissa::sim::{Pace, SimulateOptions, Solver, path_through, shapes, simulate_watched};
use vibrissa::sim::{Scenario, Sweep, SweepNoise};
use vibrissa::world::MomentNoise;

/// A scenario: map, robot, path and errors, ready to be simulated.
#[pyclass(frozen, module = "vibrissa", name = "Scenario")]
#[derive(Debug)]
pub(crate) struct PyScenario(pub(crate) Arc<Scenario>);

#[pymethods]
impl PyScenario {
    /// The scenario of a .toml file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = py.detach(|| Scenario::read(path)).or_raise(py)?;
        Ok(Self(Arc::new(read)))
    }

    /// What it is for, in a line.
    #[getter]
    fn title(&self) -> &str {
        &self.0.title
    }

    /// The seed of everything random.
    #[getter]
    fn seed(&self) -> u64 {
        self.0.seed()
    }

    /// The map.
    #[getter]
    fn map(&self) -> PyMap {
        PyMap(Arc::new(self.0.map.clone()))
    }

    /// The true path: t of shape (rows) and poses of shape (rows, 3), map frame (s; m, m, rad).
    #[getter]
    fn path<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        trajectory(py, &self.0.path)?.into_pyobject(py).map(Bound::into_any)
    }

    /// The robot as the text of its file.
    fn robot_toml(&self) -> String {
        vibrissa::io::robot::to_toml(&self.0.robot)
    }

    /// Simulates; gives the log, the fields of `vibrissa.Sweep`, and the serial line's text where there is one.
    fn _simulate<'py>(
        &self,
        py: Python<'py>,
        seed: Option<u64>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(PySensorLog, Bound<'py, PyDict>, Option<String>)> {
        let scenario = Arc::clone(&self.0);
        let total = scenario.path.len() * scenario.robot.whiskers.len();
        let done = run(py, progress, total, move |watch| {
            let scenario = seed.map_or_else(|| (*scenario).clone(), |seed| (*scenario).clone().with_seed(seed));
            scenario.simulate_watched(&mut |done| watch.tell(done))
        })?;
        warn(py, &done.warnings)?;
        let fields = fields(py, &done.sweep)?;
        // Its warnings are among those of the simulation.
        Ok((PySensorLog(Arc::new(done.recording.log)), fields, done.serial))
    }

    fn __repr__(&self) -> String {
        format!("<vibrissa.Scenario: {}, {} rows, seed {}>", self.0.title, self.0.path.len(), self.0.seed())
    }
}

/// Sweeps a robot along a path of stamps and poses; gives the log and the fields of `vibrissa.Sweep`.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // Called from one place, by name.
pub(crate) fn sweep<'py>(
    py: Python<'py>,
    map: &PyMap,
    robot: RobotIn,
    t: PyReadonlyArray1<'py, f64>,
    poses: PyReadonlyArray2<'py, f64>,
    seed: Option<u64>,
    moment: Option<(f64, f64)>,
    odometry: (f64, f64),
    discrete: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(PySensorLog, Bound<'py, PyDict>)> {
    let (map, robot, path) = (Arc::clone(&map.0), robot.robot().or_raise(py)?, stamped(t.as_slice()?, &rows(&poses)?));
    let declared = seed.map_or_else(SweepNoise::none, SweepNoise::seeded);
    let given = moment.map(|(moment_relative, moment_absolute)| MomentNoise { moment_relative, moment_absolute });
    let noise = SweepNoise {
        moment: given.or(declared.moment),
        translation_relative: odometry.0,
        rotation_relative: odometry.1,
        ..declared
    };
    let solver = if discrete { Solver::DiscreteRod } else { Solver::Auto };
    let options = SimulateOptions { solver, ..SimulateOptions::default() };
    let sweep = run(py, progress, path.len() * robot.whiskers.len(), move |watch| {
        let mut sweep = simulate_watched(&map, &robot, &path, &noise, &options, &mut |done| watch.tell(done))?;
        let every = path.len().div_ceil(DRAWN).max(1);
        sweep.shapes = shapes(&robot, &sweep, every)
            .into_iter()
            .map(|s| vibrissa::sim::Shape { row: s.row, whisker: s.whisker, points: s.points })
            .collect();
        Ok(sweep)
    })?;
    let fields = fields(py, &sweep)?;
    Ok((PySensorLog::new(py, sweep.log)?, fields))
}

/// Rows whose shapes are kept for drawing, at most.
const DRAWN: usize = 60;

/// What a sweep knows besides its log.
pub(crate) fn fields<'py>(py: Python<'py>, sweep: &Sweep) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("truth", trajectory(py, &sweep.truth)?)?;
    let whiskers = sweep.exact_moments.first().map_or(0, Vec::len);
    let flat: Vec<f64> = sweep.exact_moments.iter().flatten().copied().collect();
    let exact = crate::arrays::block(py, flat, [1, sweep.exact_moments.len(), whiskers])?;
    out.set_item("exact_moments", exact.get_item(0)?)?;
    out.set_item("contacts", contacts(py, sweep)?)?;
    out.set_item("events", events(&sweep.events))?;
    let shape = |s: &vibrissa::sim::Shape| Ok((s.row, s.whisker, points(py, &s.points)?));
    out.set_item("shapes", sweep.shapes.iter().map(shape).collect::<PyResult<Vec<_>>>()?)?;
    Ok(out)
}

fn contacts<'py>(py: Python<'py>, sweep: &Sweep) -> PyResult<Bound<'py, PyDict>> {
    let touches = &sweep.contacts;
    let out = PyDict::new(py);
    out.set_item("t", column(py, touches, |touch| touch.t))?;
    out.set_item("row", counts(py, touches, |touch| touch.row))?;
    out.set_item("whisker", counts(py, touches, |touch| touch.whisker))?;
    out.set_item("position", table(py, touches, |touch| [touch.position.x, touch.position.y])?)?;
    out.set_item("force", table(py, touches, |touch| [touch.force.x, touch.force.y])?)?;
    out.set_item("s_a", column(py, touches, |touch| touch.s_a))?;
    out.set_item("energy", column(py, touches, |touch| touch.energy))?;
    out.set_item("part", touches.iter().map(|touch| touch.part.word()).collect::<Vec<_>>())?;
    out.set_item("grip", touches.iter().map(|touch| touch.grip.word()).collect::<Vec<_>>())?;
    Ok(out)
}

/// Poses over time through waypoints (x, y, theta), map frame.
#[pyfunction]
pub(crate) fn path<'py>(
    py: Python<'py>,
    waypoints: PyReadonlyArray2<'py, f64>,
    speed: Option<f64>,
    turn_rate: Option<f64>,
    rate: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let pace = Pace {
        speed: speed.unwrap_or(scenario::SPEED),
        turn_rate: turn_rate.unwrap_or(scenario::TURN_RATE),
        rate: rate.unwrap_or(scenario::RATE),
    };
    let waypoints: Vec<Pose2> = rows(&waypoints)?.into_iter().map(|[x, y, theta]| Pose2 { x, y, theta }).collect();
    if waypoints.is_empty() {
        return Err(Error::usage("no waypoints").remedy("give at least two rows of x, y (m) and theta (rad)"))
            .or_raise(py);
    }
    let rows = path_through(&waypoints, &pace).or_raise(py)?;
    trajectory(py, &rows)?.into_pyobject(py).map(Bound::into_any)
}
