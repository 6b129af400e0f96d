//! Where the robot is: the one-call door to the whole corridor.

use crate::Result;
use crate::config::{DeterministicOptions, PossibilisticOptions, ProbabilisticOptions};
use crate::flow::pose::{Localization, Method};
use crate::flow::sensor_log::{LogRow, SensorLog};
use crate::io::calibrated;
use crate::localizer::{Localizer, PossibilisticLocalizer, ProbabilisticLocalizer};
use crate::plane::Pose2;
use crate::world::{Map, Robot};
use core::ops::ControlFlow;

/// What can be chosen about a localization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalizeOptions {
    /// The estimator.
    pub method: Method,
    /// The knobs of the deterministic method.
    pub deterministic: DeterministicOptions,
    /// The knobs of the possibilistic method.
    pub possibilistic: PossibilisticOptions,
    /// The knobs of the probabilistic method.
    pub probabilistic: ProbabilisticOptions,
}

impl Default for LocalizeOptions {
    fn default() -> Self {
        Self {
            method: Method::Deterministic,
            deterministic: DeterministicOptions::default(),
            possibilistic: PossibilisticOptions::default(),
            probabilistic: ProbabilisticOptions::default(),
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
    let mut go_on = |row| {
        observer(row);
        ControlFlow::Continue(())
    };
    localize_while(log, map, robot, options, &mut go_on)
}

/// Localizes a robot until the log ends or `observer`, called with the index of each row once it is used, breaks off.
///
/// What was broken off is answered as a log that ends with that row.
///
/// # Errors
///
/// As [`localize`].
pub fn localize_while(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    options: &LocalizeOptions,
    observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Localization> {
    localize_watched(log, map, robot, options, &mut |row, _| observer(row))
}

/// What is called after each row with its index, and with a way to ask for the states that explain the log so far; a break
/// ends the log there.
pub type StatesObserver<'a> = dyn FnMut(usize, &dyn Fn() -> Vec<Pose2>) -> ControlFlow<()> + 'a;

/// As [`localize_while`], and the observer may ask for the states that explain the log up to that row (map frame):
/// candidates, middles of cells, or best fits, as the method has them.
///
/// # Errors
///
/// As [`localize`].
pub fn localize_watched(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    options: &LocalizeOptions,
    observer: &mut StatesObserver,
) -> Result<Localization> {
    let (log, robot) = calibrated(log, robot)?;
    let channels = &log.channels;
    match options.method {
        Method::Deterministic => {
            let mut localizer = Localizer::new(map, &robot, channels, options.deterministic)?;
            each_row(&log, observer, &mut localizer, Localizer::step, Localizer::states_now)?;
            Ok(localizer.finish())
        }
        Method::Possibilistic => {
            let mut localizer = PossibilisticLocalizer::new(map, &robot, channels, options.possibilistic)?;
            each_row(&log, observer, &mut localizer, PossibilisticLocalizer::step, |l| {
                if l.set().has_started() { l.set().middles() } else { Vec::new() }
            })?;
            Ok(localizer.finish())
        }
        Method::Probabilistic => {
            let mut localizer = ProbabilisticLocalizer::new(map, &robot, channels, options.probabilistic)?;
            each_row(&log, observer, &mut localizer, ProbabilisticLocalizer::step, ProbabilisticLocalizer::states_now)?;
            Ok(localizer.finish())
        }
    }
}

/// Takes the rows of the log until the observer breaks off; errors name the file.
fn each_row<L>(
    log: &SensorLog,
    observer: &mut StatesObserver,
    localizer: &mut L,
    step: impl Fn(&mut L, &LogRow) -> Result<()>,
    states: impl Fn(&L) -> Vec<Pose2>,
) -> Result<()> {
    for (index, row) in log.rows.iter().enumerate() {
        step(localizer, row).map_err(|error| match &log.source {
            Some(file) if error.line().is_some() => error.in_file(file),
            _ => error,
        })?;
        if observer(index, &|| states(localizer)).is_break() {
            break;
        }
    }
    Ok(())
}
