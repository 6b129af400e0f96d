//! Maps from logs alone.

use crate::arrays::{block, column, points, table, trajectory};
use crate::contacts::alignment;
use crate::error::OrRaise;
use crate::inputs::RobotIn;
use crate::log::PySensorLog;
use crate::long::run;
use crate::world::PyMap;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use vibrissa::config::MappingOptions;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::tasks::mapping::{Change, ChangeKind, Mapped, Share, Visit, graph_to_json, map_logs};
use vibrissa::tasks::profile::compare;

/// Spacing of the outline's points that are compared with a truth (m).
const SPACING: f64 = 1e-3;

/// The map of logs; gives it, and the fields of `vibrissa.MappedLog`.
#[pyfunction]
pub(crate) fn map_log<'py>(
    py: Python<'py>,
    logs: Vec<PyRef<'py, PySensorLog>>,
    robot: RobotIn,
    truth: Option<&PyMap>,
    drift: Option<f64>,
    body_radius: Option<f64>,
    same_start: Option<(f64, f64)>,
) -> PyResult<(PyMap, Bound<'py, PyDict>)> {
    let robot = robot.robot().or_raise(py)?;
    let logs: Vec<SensorLog> = logs.iter().map(|log| (*log.0).clone()).collect();
    let default = MappingOptions::default();
    let (drift, body_radius) = (drift.unwrap_or(default.drift), body_radius.unwrap_or(default.body_radius));
    let options = MappingOptions { drift, body_radius, same_start, ..default };
    options.check().or_raise(py)?;
    let truth = truth.map(|map| Arc::clone(&map.0));
    let (found, compared) = run(py, None, 0, move |watch| {
        let found = map_logs(&logs, &robot, options, watch.stop(), &mut |done, _| watch.tell(done))?;
        let compared = truth.and_then(|map| compare(&found.outline.known_points(SPACING), &map, false));
        Ok((found, compared))
    })?;
    let out = fields(py, &found)?;
    out.set_item("alignment", compared.as_ref().map(|c| alignment(py, c)).transpose()?)?;
    Ok((PyMap(Arc::new(found.outline.map)), out))
}

/// The fields of a `vibrissa.Visit`.
fn visit<'py>(py: Python<'py>, visit: &Visit) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("placed", visit.placed.as_str())?;
    out.set_item("places", visit.places)?;
    out.set_item("trajectory", trajectory(py, &visit.trajectory)?)?;
    out.set_item("covariance_t", column(py, &visit.covariances, |(t, _)| *t))?;
    let flat: Vec<f64> = visit.covariances.iter().flat_map(|(_, own)| own.as_flattened()).copied().collect();
    out.set_item("covariances", block(py, flat, [visit.covariances.len(), 3, 3])?)?;
    Ok(out)
}

/// The fields of a `vibrissa.WallChange`.
fn change<'py>(py: Python<'py>, change: &Change) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let (kind, moved) = match change.kind {
        ChangeKind::Moved { by, std } => ("moved", Some((by, std))),
        ChangeKind::Gone => ("gone", None),
    };
    out.set_item("log", change.log)?;
    out.set_item("kind", kind)?;
    out.set_item("moved", moved)?;
    out.set_item("length", change.length())?;
    out.set_item("points", points(py, &change.points)?)?;
    Ok(out)
}

fn fields<'py>(py: Python<'py>, found: &Mapped) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let (known, unknown) = found.outline.lengths();
    out.set_item("known", known)?;
    out.set_item("unknown", unknown)?;
    out.set_item("points", points(py, &found.outline.known_points(SPACING))?)?;
    out.set_item("corners", table(py, &found.outline.corners, |c| [c.position.x, c.position.y, c.band.std])?)?;
    out.set_item("visits", found.visits.iter().map(|one| visit(py, one)).collect::<PyResult<Vec<_>>>()?)?;
    out.set_item("changes", found.changes.iter().map(|one| change(py, one)).collect::<PyResult<Vec<_>>>()?)?;
    for (name, Share { value, std }) in
        [("scale", found.shares.scale), ("turn", found.shares.turn), ("drift", found.shares.drift)]
    {
        out.set_item(name, (value, std))?;
    }
    let closures = found.closures.iter().map(|c| {
        let [x, y, theta] = c.extent;
        (c.later, c.earlier, c.verdict.as_str(), c.places, (x, y, theta), c.logs)
    });
    out.set_item("closures", closures.collect::<Vec<_>>())?;
    out.set_item("graph", graph_to_json(&found.graph).to_string())?;
    Ok(out)
}
