//! Which inertial measurement units of a recording are believed.

/// Which topics of `sensor_msgs/Imu` are believed; none are unless they are named: a heading has to be that of the map frame, and
/// a recording does not say whether it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ImuTopics {
    /// The topic whose orientation is the robot's heading in the map frame.
    pub headings: Option<String>,
    /// The topic whose angular velocity about z tells how the robot turns, instead of the odometry.
    pub yaw_rates: Option<String>,
}

impl ImuTopics {
    /// Whether no topic is named.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.headings.is_none() && self.yaw_rates.is_none()
    }
}
