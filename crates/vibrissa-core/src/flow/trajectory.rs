//! Trajectories: poses between stamps, and the distance from the truth.

use super::pose::StampedPose;
use crate::plane::{Pose2, Twist2, wrap_angle};

/// How far a time stamp may lie outside the truth's span and still count as inside (s): half the last digit of a file.
const STAMP_SLACK: f64 = 1e-6;

/// How far an estimated trajectory is from the truth, over the rows that both cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryError {
    /// Rows compared, at least 1.
    pub rows: usize,
    /// Distance at the last compared row (m).
    pub final_position: f64,
    /// Size of the heading error at the last compared row (rad), at most pi.
    pub final_heading: f64,
    /// Mean distance (m).
    pub mean_position: f64,
    /// Mean size of the heading error (rad).
    pub mean_heading: f64,
}

/// The pose at time `t`, on the geodesic of SE(2) between its neighbours in time; none outside the trajectory's span.
#[must_use]
pub fn pose_at(trajectory: &[StampedPose], t: f64) -> Option<Pose2> {
    let (first, last) = (trajectory.first()?, trajectory.last()?);
    if t.is_nan() || t < first.t - STAMP_SLACK || t > last.t + STAMP_SLACK {
        return None;
    }
    let after = trajectory.partition_point(|pose| pose.t < t);
    let (Some(before), Some(next)) = (trajectory.get(after.wrapping_sub(1)), trajectory.get(after)) else {
        return Some(if after == 0 { first.map_from_robot } else { last.map_from_robot });
    };
    let share = (t - before.t) / (next.t - before.t);
    let step = before.map_from_robot.between(next.map_from_robot).log();
    let part = Twist2 { x: share * step.x, y: share * step.y, theta: share * step.theta };
    Some(before.map_from_robot.compose(Pose2::exp(part)))
}

/// The error of `estimate` against `truth`, which is interpolated at the estimate's time stamps.
///
/// Rows outside the truth's span are not compared; none when that leaves no row.
#[must_use]
pub fn trajectory_error(estimate: &[StampedPose], truth: &[StampedPose]) -> Option<TrajectoryError> {
    let errors: Vec<(f64, f64)> = estimate
        .iter()
        .filter_map(|row| {
            let (pose, true_pose) = (row.map_from_robot, pose_at(truth, row.t)?);
            Some((pose.position().distance(true_pose.position()), wrap_angle(pose.theta - true_pose.theta).abs()))
        })
        .collect();
    let &(final_position, final_heading) = errors.last()?;
    let count = errors.len() as f64;
    Some(TrajectoryError {
        rows: errors.len(),
        final_position,
        final_heading,
        mean_position: errors.iter().map(|error| error.0).sum::<f64>() / count,
        mean_heading: errors.iter().map(|error| error.1).sum::<f64>() / count,
    })
}
