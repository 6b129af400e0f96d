//! Sensor logs.

use crate::arrays::{Like1, Like2, Table, column, numbers, poses, rows};
use crate::error::{OrRaise, exception, warn};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use std::path::PathBuf;
use std::sync::Arc;
use vibrissa::flow::sensor_log::{Channel, SensorLog};
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::io::log::{ImuTopics, to_csv};
use vibrissa::{Error, Result};

/// What a robot recorded: times, odometry and readings.
///
/// t: time stamps (s), shape (rows). odometry: x (m), y (m), theta (rad) of the robot from any origin, shape (rows, 3).
/// readings: the moments (N m) of shape (rows), or columns by name as a file's header has them ("moment", "w0.moment",
/// "bx", ...). heading: absolute headings in the map frame (rad), shape (rows). The checks and warnings are those that files go
/// through.
#[pyclass(frozen, module = "vibrissa", name = "SensorLog")]
#[derive(Debug)]
pub(crate) struct PySensorLog(pub(crate) Arc<SensorLog>);

/// The format of a word.
pub(crate) fn format(py: Python<'_>, word: Option<&str>) -> PyResult<Option<Format>> {
    word.map(|word| word.parse::<Format>().or_raise(py)).transpose()
}

impl PySensorLog {
    pub(crate) fn new(py: Python<'_>, log: SensorLog) -> PyResult<Self> {
        warn(py, &log.warnings)?;
        Ok(Self(Arc::new(log)))
    }
}

#[pymethods]
impl PySensorLog {
    #[new]
    #[pyo3(signature = (t, odometry, readings, heading=None))]
    fn of_arrays(
        py: Python<'_>,
        t: Like1<'_>,
        odometry: Like2<'_>,
        readings: &Bound<'_, PyAny>,
        heading: Option<Like1<'_>>,
    ) -> PyResult<Self> {
        let poses = rows::<3>(&odometry)?;
        let pose = |k: usize| poses.iter().map(|pose| pose[k]).collect();
        let mut columns: Vec<(String, Vec<f64>)> =
            vec![("t".into(), numbers(&t)), ("x".into(), pose(0)), ("y".into(), pose(1)), ("theta".into(), pose(2))];
        columns.extend(named(readings)?);
        columns.extend(heading.map(|heading| ("heading".into(), numbers(&heading))));
        equally_long(&columns).or_raise(py)?;
        let read = py.detach(|| {
            let text = csv(&columns);
            vibrissa::io::log::from_csv(&text, ARRAYS)
        });
        let log = read.map_err(|error| in_rows(py, &error))?;
        Self::new(py, SensorLog { source: None, ..log })
    }

    /// The log of a file: .csv, .mcap, or a foreign `format` ("rostopic", ...).
    #[staticmethod]
    #[pyo3(signature = (path, format=None, *, headings=None, yaw_rates=None))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        format: Option<&str>,
        headings: Option<String>,
        yaw_rates: Option<String>,
    ) -> PyResult<Self> {
        let format = self::format(py, format)?;
        let topics = ImuTopics { headings, yaw_rates };
        if format.is_some() && !topics.is_empty() {
            return Err(Error::usage("headings and yaw_rates are of .mcap recordings, without a format")).or_raise(py);
        }
        let log = py.detach(|| read(path, format, &topics)).or_raise(py)?;
        Self::new(py, log)
    }

    /// Time stamps (s), shape (rows).
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        column(py, &self.0.rows, |row| row.t)
    }

    /// The robot in the odometry frame: x (m), y (m), theta (rad); shape (rows, 3).
    #[getter]
    fn odometry<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        poses(py, self.0.rows.iter().map(|row| row.odom_from_robot))
    }

    /// The readings by column name ("moment", "w0.moment", "bx", ...), each of shape (rows), SI or counts.
    #[getter]
    fn readings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for (index, channel) in self.0.channels.iter().enumerate() {
            let values = column(py, &self.0.rows, |row| row.readings.get(index).copied().unwrap_or(f64::NAN));
            out.set_item(Channel::column(channel), values)?;
        }
        Ok(out)
    }

    /// Absolute headings in the map frame (rad), shape (rows), NaN where there is none; None when none was logged.
    #[getter]
    fn heading<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let any = self.0.rows.iter().any(|row| row.heading.is_some());
        any.then(|| column(py, &self.0.rows, |row| row.heading.unwrap_or(f64::NAN)))
    }

    /// What looked wrong but could be read, for people.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.clone()
    }

    /// The log as CSV, every number with all its digits.
    fn to_csv(&self, py: Python<'_>) -> String {
        py.detach(|| to_csv(&self.0))
    }

    /// A `pandas.DataFrame` with the columns of the log's file: t, x, y, theta, readings and heading.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("vibrissa._show")?.getattr("log_frame")?.call1((slf,))
    }

    /// Draws the readings over time into axes of matplotlib, new ones for None, and gives them.
    #[pyo3(signature = (ax=None))]
    fn plot<'py>(slf: &Bound<'py, Self>, ax: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        let module = slf.py().import("vibrissa._show")?;
        let axes = module.getattr("axes")?.call1((ax,))?;
        module.getattr("draw_log")?.call1((&axes, slf))?;
        Ok(axes)
    }

    /// The columns with their least and largest values, as notebooks show them.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("vibrissa._show")?.getattr("log_table")?.call1((slf,))
    }

    /// The log of a CSV text with the warnings and the file of another, for copies in other processes.
    #[staticmethod]
    fn _from_parts(py: Python<'_>, text: &str, source: Option<PathBuf>, warnings: Vec<String>) -> PyResult<Self> {
        let log = py.detach(|| vibrissa::io::log::from_csv(text, ARRAYS)).or_raise(py)?;
        Ok(Self(Arc::new(SensorLog { source, warnings, ..log })))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, LogParts)> {
        let make = py.get_type::<Self>().getattr("_from_parts")?;
        Ok((make, (self.to_csv(py), self.0.source.clone(), self.0.warnings.clone())))
    }

    fn __len__(&self) -> usize {
        self.0.rows.len()
    }

    fn __repr__(&self) -> String {
        let names: Vec<String> = self.0.channels.iter().map(Channel::column).collect();
        let span = self.0.rows.last().zip(self.0.rows.first()).map_or(0.0, |(last, first)| last.t - first.t);
        format!("<vibrissa.SensorLog: {} rows in {span:.3} s, {}>", self.0.rows.len(), names.join(", "))
    }
}

/// Text, file and warnings of a log.
type LogParts = (String, Option<PathBuf>, Vec<String>);

/// What stands for the file when a log is made of arrays.
const ARRAYS: &str = "SensorLog";

fn read(path: PathBuf, format: Option<Format>, topics: &ImuTopics) -> Result<SensorLog> {
    match format {
        Some(format) => Recording::read(path, format)?.to_log(),
        None => vibrissa::io::log::read_with(path, topics),
    }
}

/// Columns by name, of a mapping or of the moments alone.
fn named(readings: &Bound<'_, PyAny>) -> PyResult<Vec<(String, Vec<f64>)>> {
    let Ok(mapping) = readings.cast::<PyMapping>() else {
        let moments: Like1<'_> = readings.extract()?;
        return Ok(vec![("moment".into(), numbers(&moments))]);
    };
    let mut columns = Vec::new();
    for item in mapping.items()?.iter() {
        let (name, values) = item.extract::<(String, Like1<'_>)>()?;
        columns.push((name, numbers(&values)));
    }
    Ok(columns)
}

/// Refuses columns of different lengths.
fn equally_long(columns: &[(String, Vec<f64>)]) -> Result<()> {
    if columns.windows(2).all(|pair| pair[0].1.len() == pair[1].1.len()) {
        return Ok(());
    }
    let told: Vec<String> = columns.iter().map(|(name, values)| format!("{name} {}", values.len())).collect();
    Err(Error::usage("the columns have different lengths").value(told.join(", ")))
}

/// Columns of equal length of a mapping by name.
pub(crate) fn columns_of(py: Python<'_>, mapping: &Bound<'_, PyAny>) -> PyResult<Vec<(String, Vec<f64>)>> {
    let columns = named(mapping)?;
    equally_long(&columns).or_raise(py)?;
    Ok(columns)
}

/// Columns as CSV, in the shortest form that reads back the same.
pub(crate) fn csv(columns: &[(String, Vec<f64>)]) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut text = names.join(",") + "\n";
    let rows = columns.iter().map(|(_, values)| values.len()).min().unwrap_or(0);
    for row in 0..rows {
        let cells: Vec<String> = columns.iter().map(|(_, values)| values[row].to_string()).collect();
        text += &cells.join(",");
        text.push('\n');
    }
    text
}

/// The exception for a fault in arrays: it counts rows from 0, not lines of a file.
fn in_rows(py: Python<'_>, error: &Error) -> PyErr {
    let text = error.to_string();
    let told = match error.line() {
        Some(line) if line > 1 => text.replacen(&format!("{ARRAYS}:{line}:"), &format!("row {}:", line - 2), 1),
        _ => text.replacen(&format!("{ARRAYS}:1:"), "columns:", 1),
    };
    exception(py, &Error::data(""), told)
}
