//! Sensor logs from files: CSV, recordings with ROS 2 messages, and the formats of other sensors.

#[cfg(feature = "mcap")]
mod bag;
mod columns;
mod csv_lines;
mod csv_reader;
mod csv_writer;
mod doubts;
pub mod foreign;
mod odometry;
mod text_form;

#[cfg(feature = "mcap")]
pub use bag::from_mcap;
pub use csv_reader::{from_bytes, from_csv, from_reader, read};
pub use csv_writer::to_csv;
pub use odometry::read_odometry;
