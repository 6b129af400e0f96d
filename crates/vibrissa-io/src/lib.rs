//! Files of vibrissa: maps, robots, sensor logs, calibrations, trajectories and recordings, read and written.
//!
//! | what | formats | where |
//! | --- | --- | --- |
//! | map | GeoJSON, SVG, DXF, ROS `map_server` (YAML, PGM, PNG), MCAP | [`map`], [`grid`] |
//! | robot | TOML | [`robot`] |
//! | sensor log | CSV, MCAP, other sensors' formats | [`log`] |
//! | calibration | JSON | [`calibration`] |
//! | trajectory | TUM | [`trajectory`] |
//! | recording | MCAP with ROS 2 messages | [`ros`], [`recording`] |
//!
//! Errors name file, line, value, allowed range and the next step.

pub mod calibrated;
pub mod calibration;
pub mod grid;
pub mod log;
pub mod map;
#[cfg(feature = "mcap")]
pub mod recording;
pub mod robot;
#[cfg(feature = "mcap")]
pub mod ros;
pub mod text;
pub mod toml_section;
pub mod trajectory;
pub mod units;

pub use calibrated::{Calibrator, calibrated};
pub use calibration::read as read_calibration;
pub use log::read as read_log;
pub use map::read as read_map;
pub use robot::read as read_robot;
pub use trajectory::{format_tum, format_tum_with_doubts, parse_tum, read_tum};
pub use units::{Dimension, parse_quantity};

#[cfg(feature = "mcap")]
use vibrissa_core::sets;
use vibrissa_core::{Error, Result, beam, config, flow, math, plane, world};
