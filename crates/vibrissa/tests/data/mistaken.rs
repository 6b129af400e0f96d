//! Logs of robots whose odometry is wrong.

use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::Pose2;

/// The log with every increment of its odometry so much too long, aside (rad, to the left) and turned too far by the same share.
pub(crate) fn mistaken(log: &SensorLog, [long, aside, turn]: [f64; 3]) -> SensorLog {
    let mut out = log.clone();
    for row in 1..log.rows.len() {
        let step = log.rows[row - 1].odom_from_robot.between(log.rows[row].odom_from_robot);
        let place = (step.position() * (1.0 + long)).rotated(aside);
        let step = Pose2 { x: place.x, y: place.y, theta: (1.0 + turn) * step.theta };
        out.rows[row].odom_from_robot = out.rows[row - 1].odom_from_robot.compose(step);
    }
    out
}
