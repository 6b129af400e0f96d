//! Calibrations: made, read, written, and used.

use crate::arrays::{Column, Like1, Like2, Table, column, table};
use crate::error::{OrRaise, warn};
use crate::inputs::WhiskerIn;
use crate::log::{columns_of, csv, format};
use crate::long::run;
use numpy::{PyArray1, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vibrissa::beam::Whisker;
use vibrissa::config::StaircaseOptions;
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::tasks::calibrate::{
    Constant, DistanceFit, DistanceSet, LeftOut, Shaft, TapSets, Taper, calibrate_contacts, fit_distance,
    leave_one_out, read_taps, staircase,
};
use vibrissa::world::calibration::{Calibration, Motion, Source};
use vibrissa::{Error, Result};

/// A calibration: raw readings to moments, slopes of taps to distances, constants of the whisker.
#[pyclass(frozen, module = "vibrissa", name = "Calibration")]
#[derive(Debug)]
pub(crate) struct PyCalibration(Arc<Calibration>);

#[pymethods]
impl PyCalibration {
    /// The calibration of a file (cal.json).
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Ok(Self(Arc::new(vibrissa::read_calibration(path).or_raise(py)?)))
    }

    /// The calibration in a JSON text; `name` stands for the file in messages.
    #[staticmethod]
    #[pyo3(signature = (text, name="cal.json"))]
    fn from_json(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        Ok(Self(Arc::new(vibrissa::io::calibration::from_json(text, name).or_raise(py)?)))
    }

    /// The calibration as the text of its file.
    fn to_json(&self) -> String {
        format!("{:#}\n", vibrissa::io::calibration::to_json(&self.0))
    }

    /// Writes the file (cal.json).
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let told = |error| Error::data(format!("cannot write the calibration ({error})")).in_file(&path);
        std::fs::write(&path, self.to_json()).map_err(told).or_raise(py)
    }

    /// The columns that `moment` reads ("bx", ...), in order; none where moments are not calibrated.
    #[getter]
    fn inputs(&self) -> Vec<String> {
        let of_plane = self.0.plane.as_ref().map(|plane| plane.inputs.clone());
        of_plane.or_else(|| self.0.moment.as_ref().map(|curve| curve.inputs.clone())).unwrap_or_default()
    }

    /// Bound on the error of a moment (N m), where moments are calibrated.
    #[getter]
    fn moment_bound(&self) -> Option<f64> {
        let of_plane = self.0.plane.as_ref().map(|plane| plane.bound[0]);
        of_plane.or_else(|| self.0.moment.as_ref().map(|curve| curve.bound))
    }

    /// Bounds on the errors of both moments (N m), where both transverse axes are calibrated.
    #[getter]
    fn moment_bounds(&self) -> Option<(f64, f64)> {
        self.0.plane.as_ref().map(|plane| plane.bound.into())
    }

    /// Moments (N m), shape (n), of readings of shape (n, inputs).
    fn moment<'py>(&self, py: Python<'py>, readings: Like2<'_>) -> PyResult<Column<'py>> {
        if let Some(plane) = &self.0.plane {
            let moments = each(&readings, &plane.inputs, |row| plane.moments(row)).or_raise(py)?;
            return Ok(column(py, &moments, |both| both[0]));
        }
        let missing = || Error::data("the calibration does not tell moments from readings");
        let curve = self.0.moment.as_ref().ok_or_else(missing).or_raise(py)?;
        let moments = each(&readings, &curve.inputs, |row| curve.moment(row)).or_raise(py)?;
        Ok(PyArray1::from_vec(py, moments))
    }

    /// Moments about both transverse axes (N m), shape (n, 2), of readings of shape (n, inputs): in the whisker's plane, positive for a
    /// push towards +y, and across it, positive for a push towards +z.
    fn moments<'py>(&self, py: Python<'py>, readings: Like2<'_>) -> PyResult<Table<'py>> {
        let missing = || {
            let error = Error::data("the calibration does not tell the moments about both transverse axes");
            error.remedy("make one from labelled contacts with a column z")
        };
        let plane = self.0.plane.as_ref().ok_or_else(missing).or_raise(py)?;
        let moments = each(&readings, &plane.inputs, |row| plane.moments(row)).or_raise(py)?;
        table(py, &moments, |both| *both)
    }

    /// Distances (m) and their standard deviations (m), shape (n), for slopes of shape (n) (readings per s of a tap, per m of
    /// travel); NaN where no distance fits.
    fn distance<'py>(&self, py: Python<'py>, slopes: Like1<'_>) -> PyResult<(Column<'py>, Column<'py>)> {
        let model = self.0.distance.ok_or_else(|| Error::data("the calibration does not tell distances from slopes"));
        let model = model.or_raise(py)?;
        let found: Vec<_> = slopes.as_array().iter().map(|&slope| model.distance(slope)).collect();
        let of = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Ok((column(py, &found, |d| of(d.map(|d| d.distance))), column(py, &found, |d| of(d.map(|d| d.std)))))
    }

    fn __repr__(&self) -> String {
        let parts = [
            ("moment", self.0.moment.is_some()),
            ("plane", self.0.plane.is_some()),
            ("tip_deflection", self.0.tip_deflection.is_some()),
            ("whisker", self.0.whisker.is_some()),
            ("distance", self.0.distance.is_some()),
        ];
        let held: Vec<&str> = parts.into_iter().filter(|(_, held)| *held).map(|(name, _)| name).collect();
        format!("<vibrissa.Calibration: {}>", held.join(", "))
    }
}

/// What each row of readings gives.
fn each<T>(readings: &Like2<'_>, inputs: &[String], of: impl Fn(&[f64]) -> Result<T>) -> Result<Vec<T>> {
    let columns = readings.shape()[1];
    if columns != inputs.len() {
        let error = Error::usage("the number of inputs").value(columns);
        return Err(error.allowed(format!("{}: {}", inputs.len(), inputs.join(", "))));
    }
    readings.as_array().rows().into_iter().map(|row| of(&row.to_vec())).collect()
}

/// Says what was mended in a recording.
fn tell(py: Python<'_>, recording: &Recording) -> PyResult<()> {
    let words = recording.repairs.words();
    warn(py, &words.iter().map(|word| format!("{}: {word}", recording.source)).collect::<Vec<_>>())
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A calibration from labelled contacts: of a file, or of columns.
#[pyfunction]
pub(crate) fn calibrate_labelled(
    py: Python<'_>,
    path: Option<PathBuf>,
    columns: Option<&Bound<'_, PyAny>>,
    word: Option<&str>,
    whisker: WhiskerIn,
    free: Vec<String>,
) -> PyResult<(PyCalibration, usize)> {
    let (format, whisker) = (format(py, word)?.unwrap_or(Format::Csv), whisker.whisker().or_raise(py)?);
    let free = free.iter().map(|name| constant(name)).collect::<Result<Vec<_>>>().or_raise(py)?;
    let (recording, name) = match (path, columns) {
        (Some(path), _) => (Recording::read(&path, format).or_raise(py)?, file_name(&path)),
        (None, columns) => {
            let text = columns.map(|columns| columns_of(py, columns)).transpose()?.map(|columns| csv(&columns));
            let bytes = text.unwrap_or_default().into_bytes();
            (Recording::from_bytes(&bytes, format, "columns").or_raise(py)?, "columns".to_owned())
        }
    };
    tell(py, &recording)?;
    let found = run(py, None, 0, move |_| calibrate_contacts(&recording, &name, &whisker, &free))?;
    let lost = found.out_of_reach();
    Ok((PyCalibration(Arc::new(found.calibration)), lost))
}

fn constant(name: &str) -> Result<Constant> {
    let known = Constant::ALL.map(Constant::as_str).join(", ");
    let found = Constant::ALL.into_iter().find(|constant| constant.as_str() == name);
    found.ok_or_else(|| Error::usage("free").value(name).allowed(known))
}

/// The attributes that describe a shaft; the taper is a number, "free" or nothing.
#[derive(Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ShaftIn {
    length: Option<f64>,
    tip_ratio: Option<f64>,
    free_taper: bool,
    clamped: bool,
    channel: Option<String>,
    reference: Option<String>,
}

impl ShaftIn {
    fn shaft(&self, motion: Motion, whisker: Option<&Whisker>) -> Result<Shaft> {
        let given = self.tip_ratio.map_or(Taper::Usual, Taper::Given);
        let taper = if self.free_taper { Taper::Free } else { given };
        Shaft::described(motion, whisker, self.length, taper, self.clamped)
    }
}

/// A calibration of distances from taps at known distances (m).
#[pyfunction]
pub(crate) fn calibrate_taps<'py>(
    py: Python<'py>,
    files: Vec<(f64, PathBuf)>,
    word: Option<&str>,
    whisker: Option<WhiskerIn>,
    shaft: ShaftIn,
) -> PyResult<(PyCalibration, Bound<'py, PyDict>)> {
    let format = format(py, word)?;
    let whisker = whisker.map(|whisker| whisker.whisker()).transpose().or_raise(py)?;
    let channel = shaft.channel.clone().unwrap_or_else(|| "ax".to_owned());
    let shape = shaft.shaft(Motion::Turn, whisker.as_ref()).or_raise(py)?;
    let mut gathered = TapSets::default();
    for (distance, path) in files {
        if !(distance > 0.0 && distance <= shape.length) {
            let error = Error::usage("a distance off the shaft").value(format!("{distance} m"));
            return Err(error.allowed(format!("above 0, up to the length {} m", shape.length))).or_raise(py);
        }
        let read = py.detach(|| read_taps(&path, format, &channel, shaft.reference.as_deref()));
        let (recording, found) = read.or_raise(py)?;
        tell(py, &recording)?;
        if !gathered.add(&path, distance, &recording, &found) {
            let text = format!("{}: no taps found, the file is left out; check format and channel", path.display());
            warn(py, &[text])?;
        }
    }
    fitted(py, gathered.sets, shape, channel, gathered.data)
}

/// A calibration of distances from a staircase of lateral travel.
#[pyfunction]
pub(crate) fn calibrate_staircase<'py>(
    py: Python<'py>,
    path: PathBuf,
    whisker: Option<WhiskerIn>,
    shaft: ShaftIn,
) -> PyResult<(PyCalibration, Bound<'py, PyDict>)> {
    let whisker = whisker.map(|whisker| whisker.whisker()).transpose().or_raise(py)?;
    let channel = shaft.channel.clone().unwrap_or_else(|| "ay".to_owned());
    let shape = shaft.shaft(Motion::Travel, whisker.as_ref()).or_raise(py)?;
    let recording = py.detach(|| Recording::read(&path, Format::Openwhisker)).or_raise(py)?;
    tell(py, &recording)?;
    let sets = staircase(&recording, &channel, shape.length, &StaircaseOptions::default()).or_raise(py)?;
    let used = sets.iter().map(|set| set.samples.len()).sum();
    let data = vec![Source { file: file_name(&path), rows: recording.lines.len(), used, distance: None }];
    fitted(py, sets, shape, channel, data)
}

fn fitted(
    py: Python<'_>,
    sets: Vec<DistanceSet>,
    shaft: Shaft,
    channel: String,
    data: Vec<Source>,
) -> PyResult<(PyCalibration, Bound<'_, PyDict>)> {
    let work = move |_: &crate::long::Watch| Ok((fit_distance(&sets, shaft)?, leave_one_out(&sets, shaft)?));
    let (fit, left_out): (DistanceFit, Vec<LeftOut>) = run(py, None, 0, work)?;
    let calibration = Calibration { data, channel, distance: Some(fit.model), ..Calibration::default() };
    let out = PyDict::new(py);
    out.set_item("free", &fit.free)?;
    out.set_item("covariance", &fit.covariance)?;
    out.set_item("left_out", table(py, &left_out, |l| [l.truth, l.found.unwrap_or(f64::NAN)])?)?;
    Ok((PyCalibration(Arc::new(calibration)), out))
}

/// The taps of a recording and their distances; gives the fields of `vibrissa.Taps`.
#[pyfunction]
pub(crate) fn find_taps<'py>(
    py: Python<'py>,
    path: PathBuf,
    calibration: &PyCalibration,
    word: Option<&str>,
    reference: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let format = format(py, word)?;
    let model = calibration.0.distance.filter(|model| model.motion == Motion::Turn).ok_or_else(|| {
        Error::data("the calibration does not tell distances from taps")
            .remedy("make one with `vibrissa calibrate --taps DIST=FILE … --out DIR`")
    });
    let model = model.or_raise(py)?;
    let read = py.detach(|| read_taps(&path, format, &calibration.0.channel, reference));
    let (recording, found) = read.or_raise(py)?;
    tell(py, &recording)?;
    let distances: Vec<_> = found.iter().map(|tap| model.distance(tap.slope)).collect();
    let of = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let out = PyDict::new(py);
    out.set_item("t", column(py, &found, |tap| tap.t))?;
    out.set_item("distance", column(py, &distances, |d| of(d.map(|d| d.distance))))?;
    out.set_item("distance_std", column(py, &distances, |d| of(d.map(|d| d.std))))?;
    out.set_item("slope", column(py, &found, |tap| tap.slope))?;
    Ok(out)
}
