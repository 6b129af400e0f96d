//! Maps, robots, logs and their files; the order of the crates.

#![allow(clippy::duplicate_mod, reason = "each file is a test of its own, with the helpers that it takes")]

mod architecture;
mod hardware;
mod ros_bags;
mod sensor_log_csv;
mod sensor_log_foreign;
mod stop;
mod world_bands;
mod world_dxf;
mod world_grid;
mod world_map;
mod world_messages;
mod world_robot;
mod world_svg;
