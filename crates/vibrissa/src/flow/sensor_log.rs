//! The first door: what the robot recorded.

use crate::plane::Pose2;

/// What a column of a log measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Bending moment about the whisker base (N m), counter-clockwise positive.
    Moment,
}

/// One measured column of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The whisker's name; empty when the log does not name it (a log of one whisker).
    pub whisker: String,
    /// What is measured, and in which unit.
    pub quantity: Quantity,
}

/// One row of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct LogRow {
    /// Time stamp (s), strictly increasing over a log.
    pub t: f64,
    /// The robot in the odometry frame, whose origin is arbitrary.
    pub odom_from_robot: Pose2,
    /// One reading for each channel of the log, in its order.
    pub readings: Vec<f64>,
    /// Absolute heading in the map frame from an IMU or compass (rad), where logged.
    pub heading: Option<f64>,
}

/// A recorded run: odometry and readings over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorLog {
    /// The measured columns.
    pub channels: Vec<Channel>,
    /// The rows, in time order.
    pub rows: Vec<LogRow>,
    /// What looked wrong but could be read, for people.
    pub warnings: Vec<String>,
}
