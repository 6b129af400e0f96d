//! What time it is.

use ros2_client::ParameterValue;
use ros2_client::dds::Node;
use std::sync::atomic::{AtomicI64, Ordering};

/// The time of ROS: the system's, or that of the topic `/clock` (which `ros2_client` would read under another type than ROS sends).
pub(super) struct RosClock {
    pub(super) node: Node,
    /// The last time that `/clock` told (ns).
    pub(super) simulated: AtomicI64,
}

impl RosClock {
    /// Now (ns).
    pub(super) fn nanoseconds(&self) -> i64 {
        match self.node.get_parameter("use_sim_time") {
            Some(ParameterValue::Boolean(true)) => self.simulated.load(Ordering::Relaxed),
            _ => self.node.time_now_not_simulated().to_nanos(),
        }
    }

    /// Now (s).
    pub(super) fn now(&self) -> f64 {
        self.nanoseconds() as f64 * 1e-9
    }
}
