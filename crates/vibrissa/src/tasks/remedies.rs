//! What to try where no state explains a log: single changes of log, robot or units, each tried.

mod change;

use super::doubts::same_largest;
use crate::Result;
use crate::beam::TipModel;
use crate::config::{ProbabilisticOptions, UndeclaredErrors};
use crate::flow::pose::{ConsistencyReport, Localization, Remedy, Status};
use crate::flow::sensor_log::{LogRow, Quantity, SensorLog};
use crate::flow::state_set::probabilistic::predicted_moments;
use crate::io::calibrated;
use crate::localizer::{Localizer, Method};
use crate::plane::Pose2;
use crate::world::{Map, Robot};
use change::{Change, candidates};

/// Rows of the log that are looked at, and how many of them are used: up to every third.
const WINDOW: usize = 600;
const ROWS: usize = 200;
/// Rows of the window after the one at which the last state was ruled out.
const AFTER: usize = 60;
/// Most changes that are tried, and fewest; on large maps so many as there are maps of that size in so many metres of boundary.
const MOST_TRIED: usize = 32;
const FEWEST_TRIED: usize = 4;
const METRES: f64 = 60.0;
/// Most remedies that are told.
const TOLD: usize = 5;
/// A trial explains the readings where their mean square error is at most this many times that of the declared noise.
const EXPLAINS: f64 = 4.0;
/// A trial is told up to this many times: readings that are off by five times the declared noise have another cause.
const LARGEST_MISFIT: f64 = 25.0;

/// Fills in what to try where the answer is `inconsistent`: `consistency.remedies`, the best first. Other answers stay as they are.
///
/// As [`remedies`]; where the method told no consistency, its statistic is not a number.
///
/// # Errors
///
/// As [`remedies`].
pub fn advise(
    answer: &mut Localization,
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    method: &Method,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<()> {
    if answer.status != Status::Inconsistent {
        return Ok(());
    }
    let at = answer.events.iter().rev().find(|event| event.kind == "inconsistent").map(|event| event.t);
    let found = remedies(log, map, robot, method, at, go_on)?;
    let unknown = ConsistencyReport {
        statistic: f64::NAN,
        most: f64::NAN,
        correlation_time: 0.0,
        worst: None,
        remedies: Vec::new(),
    };
    answer.consistency.get_or_insert(unknown).remedies = found;
    Ok(())
}

/// Single changes with which `method`, or the probabilistic one in the place of the possibilistic, finds a place: the sign of a whisker's readings, axes and units of the odometry, whiskers
/// that are swapped, gain, zero and units of the readings, the whisker's length, a delay, no heading, no errors that the robot file does
/// not bound. Up to five with which the readings are off by at most five times the declared noise, by their verdict, then by how well the
/// readings fit.
///
/// Each change is one run over at most 200 rows, every third of a window of 600 that ends soon after the time `at` (s), at which the last
/// state was ruled out, or with the log; at most 32 changes are tried, on maps
/// with more than two metres of boundary as many as together have 60 m, and no fewer than four. Nothing is tried where every whisker reads just
/// its largest moment in many rows while the robot moves: no change mends a sensor that is stuck or saturated. `go_on` is asked at every row; where it says no, what has been
/// found by then is told.
///
/// # Errors
///
/// A log of raw readings whose calibration cannot be read. A change that makes no sense is no remedy.
pub fn remedies(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    method: &Method,
    at: Option<f64>,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Vec<Remedy>> {
    let (log, robot) = calibrated(log, robot)?;
    if robot.whiskers.iter().all(|whisker| same_largest(&log, whisker).is_some()) {
        return Ok(Vec::new());
    }
    let tried = trying(method);
    let mut found: Vec<(Rank, Remedy)> = Vec::new();
    let most = ((METRES / map.total_length()) as usize).clamp(FEWEST_TRIED, MOST_TRIED);
    let exact = has_undeclared_errors(method).then_some(Change::Exact);
    for change in exact.into_iter().chain(candidates(&log, &robot, map)).take(most) {
        // Changes that look at neighbours are made before rows are left out.
        let (changed, robot) = change.made(&log, &robot);
        let changed = window(changed, at);
        match trial(&changed, map, &robot, &tried, go_on) {
            Trial::Stopped => break,
            Trial::Lost => {}
            Trial::Done(answer) => found.extend(judged(&change, &answer, &changed, map, &robot)),
        }
    }
    found.sort_by(|a, b| a.0.better(&b.0));
    Ok(found.into_iter().take(TOLD).map(|(_, remedy)| remedy).collect())
}

/// What became of a trial.
enum Trial {
    Done(Box<Localization>),
    /// It was refused, or no state was left on the way: a remedy explains all rows.
    Lost,
    /// Nobody waits for it any more.
    Stopped,
}

fn trial(log: &SensorLog, map: &Map, robot: &Robot, method: &Method, go_on: &mut dyn FnMut() -> bool) -> Trial {
    let Ok(mut localizer) = Localizer::new(map, robot, &log.channels, method) else { return Trial::Lost };
    let mut known = false;
    for row in &log.rows {
        if !go_on() {
            return Trial::Stopped;
        }
        if localizer.step(row).is_err() {
            return Trial::Lost;
        }
        let left = !localizer.states_now().is_empty();
        if known && !left {
            return Trial::Lost;
        }
        known |= left;
    }
    Trial::Done(Box::new(localizer.finish()))
}

/// The method of the trials: in the place of the possibilistic one, whose set says which places are left and not how well they fit,
/// the probabilistic one.
fn trying(method: &Method) -> Method {
    match method {
        Method::Possibilistic(options) => Method::Probabilistic(ProbabilisticOptions {
            prior: options.prior,
            heading_error: options.heading_error,
            ..ProbabilisticOptions::exact()
        }),
        // One change is to mend all: nothing else is estimated along.
        Method::Probabilistic(options) => {
            Method::Probabilistic(ProbabilisticOptions { undeclared: UndeclaredErrors::None, ..*options })
        }
        other => *other,
    }
}

/// Whether the method takes what the robot file does not bound to be off.
fn has_undeclared_errors(method: &Method) -> bool {
    matches!(method, Method::Probabilistic(options) if options.undeclared != UndeclaredErrors::None)
}

/// The rows that are used.
fn window(mut log: SensorLog, at: Option<f64>) -> SensorLog {
    let end = at.map_or(log.rows.len(), |t| log.rows.partition_point(|row| row.t <= t) + AFTER).min(log.rows.len());
    let start = end.saturating_sub(WINDOW);
    let every = (end - start).div_ceil(ROWS).max(1);
    log.rows = log.rows[start..end].iter().step_by(every).cloned().collect();
    log
}

/// How good a remedy is.
struct Rank {
    explains: bool,
    one_place: bool,
    statistic: f64,
}

impl Rank {
    fn better(&self, other: &Self) -> core::cmp::Ordering {
        // By verdict, where the readings fit; what does not fit comes last.
        let key = |rank: &Self| (!rank.explains, !rank.one_place);
        key(self).cmp(&key(other)).then(self.statistic.total_cmp(&other.statistic))
    }
}

/// What a change is worth; nothing where no place is found with it.
fn judged(change: &Change, answer: &Localization, log: &SensorLog, map: &Map, robot: &Robot) -> Option<(Rank, Remedy)> {
    let place = matches!(answer.status, Status::Localized | Status::Ambiguous) && !answer.hypotheses.is_empty();
    if !place {
        return None;
    }
    let statistic = misfit(answer, log, map, robot).filter(|statistic| *statistic <= LARGEST_MISFIT)?;
    let rank = Rank { explains: statistic <= EXPLAINS, one_place: answer.status == Status::Localized, statistic };
    Some((rank, Remedy { change: change.words(), statistic, status: answer.status }))
}

/// The mean square error of the moments along the trajectory, over that of the declared noise taken as even.
fn misfit(answer: &Localization, log: &SensorLog, map: &Map, robot: &Robot) -> Option<f64> {
    let first = answer.trajectory.first()?.t;
    let rows: Vec<&LogRow> = log.rows.iter().filter(|row| row.t >= first).collect();
    let (mut sum, mut count) = (0.0, 0_usize);
    for whisker in &robot.whiskers {
        let Some(channel) = log.channel(&whisker.name, Quantity::Moment) else { continue };
        let tip = TipModel::new(&whisker.beam).ok()?;
        let base = |pose: Pose2| pose.compose(whisker.robot_from_whisker);
        let path: Vec<Pose2> = answer.trajectory.iter().map(|row| base(row.map_from_robot)).collect();
        for (row, felt) in rows.iter().zip(predicted_moments(map, &tip, &path)) {
            let z = row.readings[channel];
            let bound = whisker.noise.moment_relative * z.abs() + whisker.noise.moment_absolute;
            // Even noise has a third of its bound's square.
            sum += 3.0 * ((z - felt.moment) / bound).powi(2);
            count += 1;
        }
    }
    (count > 0).then(|| sum / count as f64)
}
