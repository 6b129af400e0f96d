//! Where the robot is: the one-call door to the whole corridor.

use super::second_opinion::Told;
use crate::flow::pose::Localization;
use crate::flow::sensor_log::SensorLog;
use crate::io::calibrated;
use crate::localizer::{Localizer, Method};
use crate::plane::Pose2;
use crate::world::{Map, Robot};
use crate::{Result, Stop};
use core::ops::ControlFlow;

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
    method: &Method,
    observer: &mut dyn FnMut(usize),
) -> Result<Localization> {
    let mut go_on = |row| {
        observer(row);
        ControlFlow::Continue(())
    };
    localize_while(log, map, robot, method, &mut go_on)
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
    method: &Method,
    observer: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Localization> {
    localize_watched(log, map, robot, method, &mut |row, _| observer(row))
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
    method: &Method,
    observer: &mut StatesObserver,
) -> Result<Localization> {
    localize_observed(log, map, robot, method, &mut |row, localizer| observer(row, &|| localizer.states_now()))
}

/// What is called after each row with its index and the localizer, which tells what can be said by then; a break ends the log there.
pub type RowObserver<'a> = dyn FnMut(usize, &Localizer<'_>) -> ControlFlow<()> + 'a;

/// As [`localize_while`], and the observer may ask the localizer for its estimate at that row.
///
/// # Errors
///
/// As [`localize`].
pub fn localize_observed(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    method: &Method,
    observer: &mut RowObserver,
) -> Result<Localization> {
    localize_until(log, map, robot, method, &Stop::default(), observer)
}

/// As [`localize_observed`], until `stop` is asked for: the answer is that of a log that ends with the row under way, and less sharp,
/// since what refines it at the end ends early, too ([`Estimator::heed`](crate::Estimator::heed)).
///
/// Where the probabilistic method finds no place that explains the log, and the set of all states that the declared bounds leave open is no more
/// than four places of 0.15 m, these are the answer (event `enclosed`, [`Localization::encloses`]).
///
/// # Errors
///
/// As [`localize`].
pub fn localize_until(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    method: &Method,
    stop: &Stop,
    observer: &mut RowObserver,
) -> Result<Localization> {
    let (log, robot) = calibrated(log, robot)?;
    let mut localizer = Localizer::new(map, &robot, &log.channels, method)?;
    localizer.heed(stop);
    let mut used = 0;
    for (index, row) in log.rows.iter().enumerate() {
        localizer.step(row).map_err(|error| match &log.source {
            Some(file) if error.line().is_some() => error.in_file(file),
            _ => error,
        })?;
        used = index + 1;
        if observer(index, &localizer).is_break() || stop.is_asked() {
            break;
        }
    }
    let answer = localizer.finish();
    Ok(match method {
        Method::Probabilistic(options) => {
            Told { log: &log, rows: &log.rows[..used], map, robot: &robot, options, stop }.answer(answer)
        }
        _ => answer,
    })
}
