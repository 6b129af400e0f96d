//! Where the robot is: the one-call door to the whole corridor.

use crate::Result;
use crate::config::{DeterministicOptions, PossibilisticOptions};
use crate::flow::pose::{Localization, Method};
use crate::flow::sensor_log::SensorLog;
use crate::localizer::{Localizer, PossibilisticLocalizer};
use crate::world::{Map, Robot};

/// What can be chosen about a localization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalizeOptions {
    /// The estimator.
    pub method: Method,
    /// The knobs of the deterministic method.
    pub deterministic: DeterministicOptions,
    /// The knobs of the possibilistic method.
    pub possibilistic: PossibilisticOptions,
}

impl Default for LocalizeOptions {
    fn default() -> Self {
        Self {
            method: Method::Deterministic,
            deterministic: DeterministicOptions::default(),
            possibilistic: PossibilisticOptions::default(),
        }
    }
}

/// Localizes a robot from what it recorded; `observer` is called with the index of each row once it is used.
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
    match options.method {
        Method::Deterministic => {
            let mut localizer = Localizer::new(map, robot, &log.channels, options.deterministic)?;
            for (index, row) in log.rows.iter().enumerate() {
                localizer.step(row).map_err(in_log)?;
                observer(index);
            }
            Ok(localizer.finish())
        }
        Method::Possibilistic => {
            let mut localizer = PossibilisticLocalizer::new(map, robot, &log.channels, options.possibilistic)?;
            for (index, row) in log.rows.iter().enumerate() {
                localizer.step(row).map_err(in_log)?;
                observer(index);
            }
            Ok(localizer.finish())
        }
    }
}
