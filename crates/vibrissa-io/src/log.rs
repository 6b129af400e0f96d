//! Sensor logs from files: CSV, recordings with ROS 2 messages, and the formats of other sensors.

#[cfg(feature = "mcap")]
mod bag;
#[cfg(feature = "mcap")]
mod bag_imu;
mod columns;
mod csv_lines;
mod csv_reader;
mod csv_writer;
mod degrees;
mod doubts;
pub mod foreign;
mod imu_topics;
mod odometry;
mod text_form;

#[cfg(feature = "mcap")]
pub use bag::{from_mcap, from_mcap_with};
pub use csv_reader::{from_bytes, from_csv, from_reader, read, read_with};
pub use csv_writer::to_csv;
pub use imu_topics::ImuTopics;
pub use odometry::read_odometry;
