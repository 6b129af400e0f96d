//! The next motion that tells places apart, and a simulated robot that makes it.

use crate::arrays::{poses, trajectory};
use crate::error::OrRaise;
use crate::inputs::RobotIn;
use crate::localize::{fields, method_of};
use crate::log::PySensorLog;
use crate::long::run;
use crate::simulate::PyScenario;
use crate::world::PyMap;
use core::ops::ControlFlow;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use vibrissa::plane::Pose2;
use vibrissa::sim::{SimulateOptions, Stage, SweepNoise};
use vibrissa::tasks::explore::{Exploration, ExploreOptions, Made, Strategy, beginning, explore_watched};
use vibrissa::tasks::plan::{Criterion, Plan, PlanOptions, PlannedMotion, plan_from};

/// The next motion from a log; gives the fields of `vibrissa.Plan`.
#[pyfunction]
pub(crate) fn plan<'py>(
    py: Python<'py>,
    log: &PySensorLog,
    map: &PyMap,
    robot: RobotIn,
    method: &str,
    options: &Bound<'py, PyDict>,
    limits: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyDict>> {
    let (method, robot, limits) = (method_of(py, method, options)?, robot.robot().or_raise(py)?, limits_of(limits)?);
    let (log, map) = (Arc::clone(&log.0), Arc::clone(&map.0));
    let (answer, plan) = run(py, None, 0, move |_| plan_from(&log, &map, &robot, &method, &limits))?;
    let out = plan_fields(py, &plan)?;
    out.set_item("answer", fields(py, &answer)?)?;
    Ok(out)
}

/// A simulated robot finds out where it is; gives its log and the fields of `vibrissa.Exploration`.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // Called from one place, by name.
pub(crate) fn explore<'py>(
    py: Python<'py>,
    scenario: &PyScenario,
    begin: f64,
    most_way: f64,
    seed: u64,
    strategy: &str,
    tested: bool,
    method: &str,
    options: &Bound<'py, PyDict>,
    limits: &Bound<'py, PyDict>,
) -> PyResult<(PySensorLog, Bound<'py, PyDict>)> {
    let (method, plan) = (method_of(py, method, options)?, limits_of(limits)?);
    let (scenario, follows) = (Arc::clone(&scenario.0), strategy == "wall");
    let found = run(py, None, 0, move |watch| {
        let options = ExploreOptions { plan, most_way, is_tested: tested, ..ExploreOptions::default() };
        let (map, robot) = (scenario.map.clone(), scenario.robot.clone());
        let stage = Stage::new(map, robot, SimulateOptions::default())?;
        let strategy = if follows { Strategy::Following(options.follow()) } else { Strategy::Planned };
        let begin = beginning(&scenario.path, begin);
        let noise = SweepNoise::seeded(seed);
        // Nobody waits for the answer once the caller has given up.
        explore_watched(&stage, &begin, &method, &noise, &options, strategy, &mut |_| {
            if watch.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    })?;
    let out = exploration_fields(py, &found)?;
    Ok((PySensorLog(Arc::new(found.log)), out))
}

/// What the robot can do; what is None keeps its default.
fn limits_of(given: &Bound<'_, PyDict>) -> PyResult<PlanOptions> {
    let mut limits = PlanOptions::default();
    for (name, value) in given.iter().filter(|(_, value)| !value.is_none()) {
        let name: String = name.extract()?;
        match name.as_str() {
            "longest" => limits.longest = value.extract()?,
            "footprint" => limits.footprint = value.extract()?,
            "sideways" => limits.sideways = value.extract()?,
            "turns" => limits.turns = value.extract()?,
            "largest_moment" => limits.largest_moment = Some(value.extract()?),
            "budget" => limits.budget = value.extract()?,
            "worst" if value.extract()? => limits.criterion = Criterion::Worst,
            _ => {}
        }
    }
    Ok(limits)
}

fn plan_fields<'py>(py: Python<'py>, plan: &Plan) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("verdict", plan.verdict.as_str())?;
    out.set_item("words", plan.words())?;
    out.set_item("motion", plan.next.as_ref().map(|next| motion(py, next)).transpose()?)?;
    out.set_item("places", plan.places)?;
    out.set_item("extent", (plan.extent[0], plan.extent[1]))?;
    out.set_item("looked_at", (plan.looked_at[0], plan.looked_at[1]))?;
    out.set_item("readings", plan.readings)?;
    Ok(out)
}

fn motion<'py>(py: Python<'py>, next: &PlannedMotion) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("name", next.motion.name())?;
    out.set_item("waypoints", poses(py, next.motion.waypoints().iter().copied())?)?;
    out.set_item("stop_at", next.stop_at.clone())?;
    out.set_item("places", (next.places[0], next.places[1]))?;
    out.set_item("extent", (next.extent[0], next.extent[1]))?;
    out.set_item("information", next.information)?;
    out.set_item("way", next.motion.way())?;
    out.set_item("turn", next.motion.turn())?;
    Ok(out)
}

fn exploration_fields<'py>(py: Python<'py>, found: &Exploration) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("ended", found.ended.as_str())?;
    out.set_item("way", found.way)?;
    out.set_item("turn", found.turn)?;
    out.set_item("motions", found.motions.iter().map(|one| made(py, one)).collect::<PyResult<Vec<_>>>()?)?;
    out.set_item("truth", trajectory(py, &found.truth)?)?;
    out.set_item("collided", found.collided)?;
    out.set_item("hardest", found.hardest)?;
    out.set_item("since", found.since)?;
    out.set_item("answer", fields(py, &found.answer)?)?;
    Ok(out)
}

fn made<'py>(py: Python<'py>, one: &Made) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let words = one.plan.as_ref().map_or_else(|| one.name.to_owned(), Plan::words);
    let places: Vec<Pose2> = one.places.iter().map(|place| place.0).collect();
    out.set_item("words", words)?;
    out.set_item("row", one.row)?;
    out.set_item("places", poses(py, places)?)?;
    out.set_item("stopped", one.stopped)?;
    Ok(out)
}
