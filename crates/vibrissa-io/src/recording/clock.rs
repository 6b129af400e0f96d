//! Logs whose times no recording can hold.

use crate::flow::pose::{Localization, StampedPose, Stretch};
use crate::flow::sensor_log::SensorLog;

/// The last second of stamps (s).
const LAST: f64 = i32::MAX as f64;

/// Where a recording's times begin on the clock of a log (s): nowhere else than at 0 where they fit, else at the first row.
///
/// Stamps of messages count the seconds from 0 to 2^31: negative times and milliseconds since 1970 would all be the first or the last of them.
#[must_use]
pub fn clock_origin(log: &SensorLog) -> Option<f64> {
    let (first, last) = (log.rows.first()?.t, log.rows.last()?.t);
    (first < 0.0 || (first > 0.0 && last >= LAST)).then_some(first)
}

/// What to tell about such times, for people.
#[must_use]
pub fn clock_warning(log: &SensorLog) -> Option<String> {
    let (first, last) = (log.rows.first()?.t, log.rows.last()?.t);
    if first >= 0.0 && last < LAST {
        return None;
    }
    let doubt = if last >= 1e11 { "; are they milliseconds where seconds are due?" } else { "" };
    Some(format!(
        "the log's times, {first} to {last} s, do not fit the clock of a recording (0 to {} s): its messages are stamped by the \
         time since the first row{doubt}",
        i32::MAX
    ))
}

/// The log on a clock that begins at `origin` (s).
#[must_use]
pub fn shifted_log(log: &SensorLog, origin: f64) -> SensorLog {
    let mut log = log.clone();
    log.rows.iter_mut().for_each(|row| row.t -= origin);
    log
}

/// The answer on a clock that begins at `origin` (s).
pub(super) fn shifted_answer(answer: &Localization, origin: f64) -> Localization {
    let mut answer = answer.clone();
    shift_poses(&mut answer.trajectory, origin);
    answer.steps.iter_mut().for_each(|step| step.t -= origin);
    answer.events.iter_mut().for_each(|event| event.t -= origin);
    answer.shapes.iter_mut().for_each(|shape| shape.t -= origin);
    answer.unsure.iter_mut().for_each(|Stretch { from, to }| (*from, *to) = (*from - origin, *to - origin));
    answer
}

/// Poses on a clock that begins at `origin` (s).
pub(super) fn shift_poses(poses: &mut [StampedPose], origin: f64) {
    poses.iter_mut().for_each(|pose| pose.t -= origin);
}
