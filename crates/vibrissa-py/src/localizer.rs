//! Where the robot is, row by row: the estimator lives on a thread of its own, which owns the map and the robot that it borrows.

use crate::error::OrRaise;
use crate::inputs::RobotIn;
use crate::localize::{estimate_fields, fields, method_of};
use crate::world::PyMap;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Mutex, PoisonError};
use vibrissa::flow::pose::{Estimate, Localization};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity};
use vibrissa::io::Calibrator;
use vibrissa::plane::Pose2;
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Localizer, Method, Result};

/// What the estimator is asked.
enum Call {
    Step(LogRow, SyncSender<Result<()>>),
    Estimate(SyncSender<Estimate>),
    Finish(SyncSender<Localization>),
}

/// A localizer that takes rows as they come.
#[pyclass(frozen, module = "vibrissa", name = "LocalizerCore")]
#[derive(Debug)]
pub(crate) struct PyLocalizer {
    /// None once the answer was given.
    calls: Mutex<Option<Sender<Call>>>,
    columns: usize,
}

#[pymethods]
impl PyLocalizer {
    #[new]
    fn new(
        py: Python<'_>,
        map: &PyMap,
        robot: RobotIn,
        method: &str,
        options: &Bound<'_, PyDict>,
        columns: Vec<String>,
    ) -> PyResult<Self> {
        let (method, robot) = (method_of(py, method, options)?, robot.robot().or_raise(py)?);
        let channels: Vec<Channel> = columns.iter().map(|name| channel_of(name)).collect::<Result<_>>().or_raise(py)?;
        let map = Arc::clone(&map.0);
        let (calls, inbox) = channel();
        let (ready, begun) = sync_channel(1);
        std::thread::spawn(move || serve(&map, &robot, &channels, &method, &inbox, &ready));
        let begun = py.detach(move || begun.recv());
        begun.unwrap_or_else(|_| Err(Error::data("the estimator ended"))).or_raise(py)?;
        Ok(Self { calls: Mutex::new(Some(calls)), columns: columns.len() })
    }

    /// Takes a row: time (s), odometry x, y, theta (m, m, rad), one reading for each column, absolute heading (rad).
    fn step(&self, py: Python<'_>, t: f64, pose: [f64; 3], readings: Vec<f64>, heading: Option<f64>) -> PyResult<()> {
        if readings.len() != self.columns {
            let error =
                Error::usage("the number of readings").value(readings.len()).allowed(format!("{}", self.columns));
            return Err(error).or_raise(py);
        }
        if !pose.iter().chain(&readings).chain([&t]).chain(&heading).all(|value| value.is_finite()) {
            let error = Error::data("a row holds what is no number")
                .value(format!("t {t}, pose {pose:?}, readings {readings:?}"));
            return Err(error.remedy("leave the row out")).or_raise(py);
        }
        let [x, y, theta] = pose;
        let row = LogRow { t, odom_from_robot: Pose2::new(x, y, theta), readings, heading, line: 0 };
        self.ask(py, |reply| Call::Step(row, reply))?.or_raise(py)
    }

    /// What can be said now: the fields of `vibrissa.Estimate`.
    fn estimate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let estimate = self.ask(py, Call::Estimate)?;
        estimate_fields(py, &estimate)
    }

    /// Ends the log: the fields of `vibrissa.Localization`.
    fn finish<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let answer = self.ask(py, Call::Finish)?;
        drop(self.calls.lock().unwrap_or_else(PoisonError::into_inner).take());
        fields(py, &answer)
    }
}

impl PyLocalizer {
    fn ask<T: Send>(&self, py: Python<'_>, call: impl FnOnce(SyncSender<T>) -> Call) -> PyResult<T> {
        let (reply, answer) = sync_channel(1);
        {
            let calls = self.calls.lock().unwrap_or_else(PoisonError::into_inner);
            let Some(calls) = calls.as_ref() else {
                return Err(PyRuntimeError::new_err("this localizer has finished; make a new one"));
            };
            // Where nobody listens any more there is no answer either.
            let _ = calls.send(call(reply));
        }
        py.detach(move || answer.recv()).map_err(|_| PyRuntimeError::new_err("the estimator ended"))
    }
}

/// Answers calls until the answer of the log is asked for or nobody asks any more.
fn serve(
    map: &Map,
    robot: &Robot,
    channels: &[Channel],
    method: &Method,
    inbox: &Receiver<Call>,
    ready: &SyncSender<Result<()>>,
) {
    let begun = Calibrator::new(channels, robot).map(|calibrator| match &calibrator {
        Some(found) => (found.channels(channels), found.robot(robot), calibrator),
        None => (channels.to_vec(), robot.clone(), None),
    });
    let (channels, robot, calibrator) = match begun {
        Ok(begun) => begun,
        Err(error) => return drop(ready.send(Err(error))),
    };
    let mut localizer = match Localizer::new(map, &robot, &channels, method) {
        Ok(localizer) => localizer,
        Err(error) => return drop(ready.send(Err(error))),
    };
    let _ = ready.send(Ok(()));
    let mut last = f64::NEG_INFINITY;
    for call in inbox {
        match call {
            Call::Step(mut row, reply) => {
                let stepped = later(row.t, &mut last)
                    .and_then(|()| calibrator.as_ref().map_or(Ok(()), |calibrator| calibrator.row(&mut row)))
                    .and_then(|()| localizer.step(&row));
                let _ = reply.send(stepped);
            }
            Call::Estimate(reply) => drop(reply.send(localizer.estimate())),
            Call::Finish(reply) => {
                let _ = reply.send(localizer.finish());
                return;
            }
        }
    }
}

fn later(t: f64, last: &mut f64) -> Result<()> {
    if t > *last {
        *last = t;
        return Ok(());
    }
    Err(Error::data("t does not increase").value(format!("{t} s after {last} s")).remedy("leave repeated rows out"))
}

fn channel_of(name: &str) -> Result<Channel> {
    let (whisker, word) = name.rsplit_once('.').unwrap_or(("", name));
    let words = Quantity::ALL.map(Quantity::word);
    let quantity = Quantity::ALL.into_iter().find(|quantity| quantity.word() == word).ok_or_else(|| {
        Error::usage("unknown column")
            .value(format!("\"{name}\""))
            .allowed(format!("{}, or NAME.moment", words.join(", ")))
    })?;
    Ok(Channel { whisker: whisker.to_owned(), quantity })
}
