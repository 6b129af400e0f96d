//! Poses over time from waypoints.

use crate::flow::pose::StampedPose;
use crate::plane::{Pose2, wrap_angle};
use crate::{Error, Result};

/// How fast a robot goes along its waypoints, and how often it is recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Speed (m/s), positive.
    pub speed: f64,
    /// Largest turning rate (rad/s), positive.
    pub turn_rate: f64,
    /// Rows a second (Hz), positive.
    pub rate: f64,
}

/// More rows than anybody sweeps: a guard against a pace in the wrong unit.
const MOST_ROWS: f64 = 1e7;

/// The poses of a robot that goes through `waypoints` (map frame), one every `1 / rate` seconds from time 0 on.
///
/// Between two waypoints the position goes straight and the heading turns evenly, the shorter way. Each leg takes as long
/// as its distance needs at full speed or its turn at the full turning rate, whichever is longer. The last waypoint is
/// reached by the last row to within one row's travel.
///
/// # Errors
///
/// Usage: fewer than two waypoints, waypoints that are not finite or all the same, a pace that is not positive, or more
/// than ten million rows.
pub fn path_through(waypoints: &[Pose2], pace: &Pace) -> Result<Vec<StampedPose>> {
    for (name, value) in [("speed", pace.speed), ("turn_rate", pace.turn_rate), ("rate", pace.rate)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(Error::usage(format!("the pace's {name}")).value(value).allowed("above 0"));
        }
    }
    if let Some(bad) = waypoints.iter().find(|w| !(w.position().is_finite() && w.theta.is_finite())) {
        return Err(Error::usage("a waypoint").value(format!("{bad:?}")).allowed("finite numbers"));
    }
    let mut nodes: Vec<StampedPose> = Vec::with_capacity(waypoints.len());
    for &map_from_robot in waypoints {
        let t = nodes.last().map_or(0.0, |last| last.t + leg_time(last.map_from_robot, map_from_robot, pace));
        nodes.push(StampedPose { t, map_from_robot });
    }
    let rows = nodes.last().map_or(0.0, |last| last.t) * pace.rate;
    if !(rows > 0.0 && rows <= MOST_ROWS) {
        return Err(Error::usage("the path's duration in rows")
            .value(rows)
            .allowed(format!("above 0 and up to {MOST_ROWS}"))
            .remedy("give at least two different waypoints in metres, and the pace in m/s, rad/s and Hz"));
    }
    Ok(sampled(&nodes, pace.rate))
}

/// How long the way from `a` to `b` takes (s).
pub(crate) fn leg_time(a: Pose2, b: Pose2, pace: &Pace) -> f64 {
    let distance = a.position().distance(b.position());
    let turn = wrap_angle(b.theta - a.theta).abs();
    (distance / pace.speed).max(turn / pace.turn_rate)
}

/// The poses every `1 / rate` seconds from time 0 on of a robot that is at `nodes`, between which the position goes
/// straight and the heading turns evenly; at least two nodes, the first at time 0.
pub(crate) fn sampled(nodes: &[StampedPose], rate: f64) -> Vec<StampedPose> {
    let rows = nodes.last().map_or(0.0, |last| last.t) * rate;
    let at = |row: usize| {
        let t = row as f64 / rate;
        StampedPose { t, map_from_robot: pose_at(nodes, t) }
    };
    (0..=(rows * (1.0 + 1e-12)).floor() as usize).map(at).collect()
}

/// The pose at the time `t`.
fn pose_at(nodes: &[StampedPose], t: f64) -> Pose2 {
    let leg = nodes.partition_point(|node| node.t < t).clamp(1, nodes.len() - 1);
    let (from, to) = (nodes[leg - 1], nodes[leg]);
    let (a, b) = (from.map_from_robot, to.map_from_robot);
    let duration = to.t - from.t;
    let share = if duration > 0.0 { ((t - from.t) / duration).clamp(0.0, 1.0) } else { 1.0 };
    let place = a.position() + (b.position() - a.position()) * share;
    Pose2::new(place.x, place.y, a.theta + share * wrap_angle(b.theta - a.theta))
}

/// Refuses paths that no robot drives.
pub(super) fn check(path: &[StampedPose]) -> Result<()> {
    if path.is_empty() {
        return Err(Error::usage("the path holds no pose"));
    }
    let finite = |p: &StampedPose| p.t.is_finite() && p.map_from_robot.position().is_finite();
    if let Some(bad) = path.iter().find(|p| !(finite(p) && p.map_from_robot.theta.is_finite())) {
        return Err(Error::usage("a pose of the path").value(format!("{bad:?}")).allowed("finite numbers"));
    }
    match path.windows(2).find(|w| w[1].t <= w[0].t) {
        Some(pair) => Err(Error::usage("the path's clock does not increase")
            .value(format!("{} s", pair[1].t))
            .allowed(format!("above {} s", pair[0].t))),
        None => Ok(()),
    }
}
