//! Where the robot is: the one-call door to the whole corridor.

use crate::Result;
use crate::config::{DeterministicOptions, ProbabilisticOptions};
use crate::flow::calibrated::calibrated;
use crate::flow::pose::{Localization, Method};
use crate::flow::sensor_log::SensorLog;
use crate::localizer::{Localizer, ProbabilisticLocalizer};
use crate::world::{Map, Robot};

/// What can be chosen about a localization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalizeOptions {
    /// The estimator.
    pub method: Method,
    /// The knobs of the deterministic method.
    pub deterministic: DeterministicOptions,
    /// The knobs of the probabilistic method.
    pub probabilistic: ProbabilisticOptions,
}

impl Default for LocalizeOptions {
    fn default() -> Self {
        Self {
            method: Method::Deterministic,
            deterministic: DeterministicOptions::default(),
            probabilistic: ProbabilisticOptions::default(),
        }
    }
}

/// Localizes a robot from what it recorded, raw readings through the calibration that the robot file names; `observer` is called with the index of each row once it is used.
///
/// # Errors
///
/// A robot that the method does not cover, options out of range, a log without moments, or a moment that no whisker
/// shape explains; the message names file and line.
pub fn localize(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    options: &LocalizeOptions,
    observer: &mut dyn FnMut(usize),
) -> Result<Localization> {
    let in_log = |error: crate::Error| match &log.source {
        Some(file) if error.line().is_some() => error.in_file(file),
        _ => error,
    };
    let (log, robot) = calibrated(log, robot)?;
    match options.method {
        Method::Deterministic => {
            let mut localizer = Localizer::new(map, &robot, &log.channels, options.deterministic)?;
            for (index, row) in log.rows.iter().enumerate() {
                localizer.step(row).map_err(in_log)?;
                observer(index);
            }
            Ok(localizer.finish())
        }
        Method::Probabilistic => {
            let mut localizer = ProbabilisticLocalizer::new(map, &robot, &log.channels, options.probabilistic)?;
            for (index, row) in log.rows.iter().enumerate() {
                localizer.step(row).map_err(in_log)?;
                observer(index);
            }
            Ok(localizer.finish())
        }
    }
}
