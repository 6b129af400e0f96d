//! The robot's motion between two odometry rows.

use crate::plane::Pose2;

/// The motions between successive odometry poses, each seen from the earlier pose.
///
/// This is the paper's `T_local`: the pose after step k is the pose before it composed with the increment, in whatever
/// frame the odometry is given \[routray, section "Motion Model"\].
pub fn increments(odom_from_robot: impl IntoIterator<Item = Pose2>) -> impl Iterator<Item = Pose2> {
    let mut poses = odom_from_robot.into_iter();
    let mut previous = poses.next();
    poses.filter_map(move |next| previous.replace(next).map(|before| before.between(next)))
}
