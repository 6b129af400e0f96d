//! How a robot came to where it is, and the plan from its log.

use super::{Plan, PlanOptions, plan, remaining};
use crate::flow::pose::Localization;
use crate::flow::sensor_log::SensorLog;
use crate::io::calibrated;
use crate::localizer::Method;
use crate::plane::{Pose2, wrap_angle};
use crate::tasks::localize;
use crate::world::{Map, Robot};
use crate::{Error, Result};

/// How far back (m) a plan looks at how the robot came, how finely (m, rad), and most poses.
pub(super) const FAR: f64 = 0.06;
pub(super) const STEP: f64 = 4e-3;
pub(super) const STEP_TURN: f64 = 0.05;
const MOST: usize = 40;

/// How the robot came here.
#[derive(Clone, Copy, Debug, Default)]
pub struct Past<'a> {
    /// Its last poses, seen from where it is now, the oldest first: whiskers are bent by what they came over.
    pub history: &'a [Pose2],
    /// The last reading of each whisker's moment (N m), in the order of the robot's whiskers.
    pub readings: &'a [f64],
}

/// The last poses of a way by odometry (odometry frame, the oldest first), seen from the last one, see [`Past`].
#[must_use]
pub fn history(way: impl DoubleEndedIterator<Item = Pose2>) -> Vec<Pose2> {
    let mut newest_first = way.rev();
    let Some(last) = newest_first.next() else { return Vec::new() };
    let (mut poses, mut at, mut gone) = (Vec::new(), last, 0.0);
    for pose in newest_first {
        let way = pose.position().distance(at.position());
        if way < STEP && wrap_angle(pose.theta - at.theta).abs() < STEP_TURN {
            continue;
        }
        gone += way;
        if gone > FAR || poses.len() >= MOST {
            break;
        }
        poses.push(last.between(pose));
        at = pose;
    }
    poses.reverse();
    poses
}

/// Where a robot is by its log, and the next motion that tells the places apart.
///
/// # Errors
///
/// As [`localize`] and [`plan`]; a log that tells no place yet.
pub fn plan_from(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    method: &Method,
    options: &PlanOptions,
) -> Result<(Localization, Plan)> {
    options.check()?;
    let (log, robot) = calibrated(log, robot)?;
    let answer = localize(&log, map, &robot, method, &mut |_| {})?;
    if answer.hypotheses.is_empty() {
        return Err(Error::data("the log tells no place between which a motion could decide")
            .value(answer.status.as_str())
            .remedy("touch a wall for some centimetres first; `vibrissa localize` tells what is missing"));
    }
    let states = remaining(&answer.hypotheses, options.states);
    let readings = readings(&log, &robot);
    let past = Past { history: &history(log.rows.iter().map(|row| row.odom_from_robot)), readings: &readings };
    let plan = plan(map, &robot, &states, &past, options)?;
    Ok((answer, plan))
}

/// The last moments of all whiskers, where the log has them all.
fn readings(log: &SensorLog, robot: &Robot) -> Vec<f64> {
    let read = |name: &String| log.rows.last()?.readings.get(log.moment_channel(name).ok()?).copied();
    robot.whiskers.iter().map(|whisker| read(&whisker.name)).collect::<Option<Vec<f64>>>().unwrap_or_default()
}
