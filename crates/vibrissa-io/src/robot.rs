//! The robot's TOML file: one reader, one writer.

mod beam;
mod errors;
mod lean;
mod toml_reader;
mod toml_writer;

pub use toml_reader::{from_toml, map_scale, odometry_section, read, whisker_entries};
pub use toml_writer::to_toml;
