//! Whiskers and robots as Python describes them.

use crate::error::OrRaise;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use vibrissa::Result;
use vibrissa::beam::{CURVATURE_TERMS, Stretch, Whisker};
use vibrissa::io::{Dimension, parse_quantity};
use vibrissa::plane::Pose2;
use vibrissa::world::{Lean, MomentNoise, MountedWhisker, Odometry, ReadingNoise, Robot, WhiskerErrors};

/// The attributes of `vibrissa.Segment`.
#[derive(Debug, FromPyObject)]
pub(crate) struct SegmentIn {
    length: f64,
    flexural_rigidity: f64,
    tip_ratio: f64,
    diameter: Option<f64>,
}

/// The attributes of `vibrissa.Whisker`.
#[derive(Debug, FromPyObject)]
pub(crate) struct WhiskerIn {
    length: f64,
    flexural_rigidity: f64,
    tip_ratio: f64,
    curvature: f64,
    curvature_rise: Vec<f64>,
    base_stiffness: f64,
    segments: Vec<SegmentIn>,
    diameter: Option<f64>,
    strain_limit: f64,
}

/// The attributes of `vibrissa.MountedWhisker`.
#[derive(Debug, FromPyObject)]
pub(crate) struct MountedIn {
    name: String,
    beam: WhiskerIn,
    mount: [f64; 3],
    elevation: f64,
    roll: f64,
    friction: f64,
    calibration: Option<PathBuf>,
    moment_relative: f64,
    moment_absolute: f64,
    force_relative: f64,
    force_absolute: f64,
    slope_relative: f64,
    slope_absolute: f64,
    zero_error: f64,
    zero_drift_error: f64,
    mount_error: [f64; 3],
    length_error: f64,
    stiffness_error: f64,
    gain_error: f64,
}

/// The attributes of `vibrissa.Robot`.
#[derive(Debug, FromPyObject)]
pub(crate) struct RobotIn {
    whiskers: Vec<MountedIn>,
    translation_relative: f64,
    rotation_relative: f64,
    delay_error: f64,
    map_scale_error: f64,
}

impl WhiskerIn {
    pub(crate) fn whisker(&self) -> Result<Whisker> {
        let stretches: Vec<Stretch> = self.segments.iter().map(SegmentIn::stretch).collect();
        if self.curvature_rise.len() > CURVATURE_TERMS {
            return Err(vibrissa::Error::usage("the number of terms of curvature_rise")
                .value(self.curvature_rise.len())
                .allowed(format!("up to {CURVATURE_TERMS}")));
        }
        let mut curvature_rise = [0.0; CURVATURE_TERMS];
        curvature_rise.iter_mut().zip(&self.curvature_rise).for_each(|(to, from)| *to = *from);
        let wire = if stretches.is_empty() {
            Whisker {
                length: self.length,
                flexural_rigidity: self.flexural_rigidity,
                tip_ratio: self.tip_ratio,
                diameter: self.diameter,
                ..Whisker::default()
            }
        } else {
            Whisker::of_stretches(&stretches)?
        };
        Ok(Whisker {
            curvature: self.curvature,
            curvature_rise,
            base_stiffness: self.base_stiffness,
            strain_limit: self.strain_limit,
            ..wire
        })
    }
}

impl SegmentIn {
    fn stretch(&self) -> Stretch {
        Stretch {
            length: self.length,
            flexural_rigidity: self.flexural_rigidity,
            tip_ratio: self.tip_ratio,
            diameter: self.diameter,
        }
    }
}

impl RobotIn {
    /// The robot, checked as its file would be.
    pub(crate) fn robot(&self) -> Result<Robot> {
        let one = |mounted: &MountedIn| {
            let [x, y, theta] = mounted.mount;
            Ok(MountedWhisker {
                name: mounted.name.clone(),
                beam: mounted.beam.whisker()?,
                robot_from_whisker: Pose2 { x, y, theta },
                lean: Lean { elevation: mounted.elevation, roll: mounted.roll },
                friction: mounted.friction,
                calibration: mounted.calibration.clone(),
                noise: MomentNoise {
                    moment_relative: mounted.moment_relative,
                    moment_absolute: mounted.moment_absolute,
                },
                force_noise: ReadingNoise { relative: mounted.force_relative, absolute: mounted.force_absolute },
                slope_noise: ReadingNoise { relative: mounted.slope_relative, absolute: mounted.slope_absolute },
                errors: WhiskerErrors {
                    zero: mounted.zero_error,
                    zero_drift: mounted.zero_drift_error,
                    mount: mounted.mount_error,
                    length: mounted.length_error,
                    rigidity: mounted.stiffness_error,
                    gain: mounted.gain_error,
                },
            })
        };
        let robot = Robot {
            whiskers: self.whiskers.iter().map(one).collect::<Result<_>>()?,
            odometry: Odometry {
                translation_relative: self.translation_relative,
                rotation_relative: self.rotation_relative,
                delay: self.delay_error,
            },
            map_scale: self.map_scale_error,
        };
        vibrissa::io::robot::from_toml(&vibrissa::io::robot::to_toml(&robot), CHECKED).map_err(without_line)?;
        Ok(robot)
    }
}

/// What stands for the file while a robot is checked.
const CHECKED: &str = "Robot";

/// The error without the line of a text that nobody has seen.
fn without_line(error: vibrissa::Error) -> vibrissa::Error {
    let place = error.line().map(|line| format!("{CHECKED}:{line}: ")).unwrap_or_default();
    vibrissa::Error::data(error.to_string().replacen(&place, "", 1))
}

fn whisker_out<'py>(py: Python<'py>, whisker: &Whisker) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("length", whisker.length)?;
    out.set_item("flexural_rigidity", whisker.flexural_rigidity)?;
    out.set_item("tip_ratio", whisker.tip_ratio)?;
    out.set_item("curvature", whisker.curvature)?;
    let terms = whisker.curvature_rise.iter().rposition(|term| term.abs() > 0.0).map_or(0, |last| last + 1);
    out.set_item("curvature_rise", whisker.curvature_rise[..terms].to_vec())?;
    out.set_item("base_stiffness", whisker.base_stiffness)?;
    let segment = |s: &Stretch| (s.length, s.flexural_rigidity, s.tip_ratio, s.diameter);
    out.set_item("segments", whisker.stretches.as_slice().iter().map(segment).collect::<Vec<_>>())?;
    out.set_item("diameter", whisker.diameter)?;
    out.set_item("strain_limit", whisker.strain_limit)?;
    Ok(out)
}

fn robot_out<'py>(py: Python<'py>, robot: &Robot) -> PyResult<Bound<'py, PyDict>> {
    let whiskers = robot.whiskers.iter().map(|mounted| {
        let one = PyDict::new(py);
        let mount = mounted.robot_from_whisker;
        one.set_item("name", &mounted.name)?;
        one.set_item("beam", whisker_out(py, &mounted.beam)?)?;
        one.set_item("mount", (mount.x, mount.y, mount.theta))?;
        one.set_item("elevation", mounted.lean.elevation)?;
        one.set_item("roll", mounted.lean.roll)?;
        one.set_item("friction", mounted.friction)?;
        one.set_item("calibration", mounted.calibration.as_ref().map(|path| path.to_string_lossy().into_owned()))?;
        one.set_item("moment_relative", mounted.noise.moment_relative)?;
        one.set_item("moment_absolute", mounted.noise.moment_absolute)?;
        one.set_item("force_relative", mounted.force_noise.relative)?;
        one.set_item("force_absolute", mounted.force_noise.absolute)?;
        one.set_item("slope_relative", mounted.slope_noise.relative)?;
        one.set_item("slope_absolute", mounted.slope_noise.absolute)?;
        let errors = mounted.errors;
        one.set_item("zero_error", errors.zero)?;
        one.set_item("zero_drift_error", errors.zero_drift)?;
        one.set_item("mount_error", (errors.mount[0], errors.mount[1], errors.mount[2]))?;
        one.set_item("length_error", errors.length)?;
        one.set_item("stiffness_error", errors.rigidity)?;
        one.set_item("gain_error", errors.gain)?;
        Ok(one)
    });
    let out = PyDict::new(py);
    out.set_item("whiskers", whiskers.collect::<PyResult<Vec<_>>>()?)?;
    out.set_item("translation_relative", robot.odometry.translation_relative)?;
    out.set_item("rotation_relative", robot.odometry.rotation_relative)?;
    out.set_item("delay_error", robot.odometry.delay)?;
    out.set_item("map_scale_error", robot.map_scale)?;
    Ok(out)
}

/// The robot of a file, as nested dicts.
#[pyfunction]
pub(crate) fn robot_read(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    robot_out(py, &vibrissa::read_robot(path).or_raise(py)?)
}

/// The robot of a TOML text, as nested dicts.
#[pyfunction]
pub(crate) fn robot_parse<'py>(py: Python<'py>, text: &str, name: &str) -> PyResult<Bound<'py, PyDict>> {
    robot_out(py, &vibrissa::io::robot::from_toml(text, name).or_raise(py)?)
}

/// A robot as the text of its file.
#[pyfunction]
pub(crate) fn robot_toml(py: Python<'_>, robot: RobotIn) -> PyResult<String> {
    Ok(vibrissa::io::robot::to_toml(&robot.robot().or_raise(py)?))
}

/// The paper's robot: the default of everything that is left out.
#[pyfunction]
pub(crate) fn robot_default(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    robot_out(py, &Robot::default())
}

/// Whether the closed form covers a whisker.
#[pyfunction]
pub(crate) fn whisker_is_uniform(py: Python<'_>, whisker: WhiskerIn) -> PyResult<bool> {
    Ok(whisker.whisker().or_raise(py)?.is_uniform())
}

/// A number of a text with its unit, SI; `dimension` is a word such as "length", "angle" or "moment".
#[pyfunction]
pub(crate) fn quantity(py: Python<'_>, text: &str, dimension: &str) -> PyResult<f64> {
    let dimension = match dimension {
        "length" => Dimension::Length,
        "angle" => Dimension::Angle,
        "force" => Dimension::Force,
        "moment" => Dimension::Moment,
        "time" => Dimension::Time,
        "stiffness" => Dimension::Stiffness,
        "rigidity" => Dimension::FlexuralRigidity,
        "curvature" => Dimension::Curvature,
        "moment_rate" => Dimension::MomentRate,
        "ratio" => Dimension::Ratio,
        other => return Err(vibrissa::Error::usage("dimension").value(other)).or_raise(py),
    };
    parse_quantity(text, dimension).or_raise(py)
}
