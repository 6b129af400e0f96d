//! The command, as its users call it.

#![allow(clippy::duplicate_mod, reason = "each file is a test of its own, with the helpers that it takes")]

mod bad_input;
mod beam_command;
mod calibrate_command;
mod contact_profile;
mod contact_set_command;
mod defaults;
mod demo_command;
mod faults;
mod figures;
mod hostile_files;
mod imu_command;
mod join_command;
mod live_command;
mod live_ros2;
mod localize_outputs;
mod mcap_command;
mod plan_command;
mod reproduce_command;
mod sensor_command;
mod simulate_command;
mod studio_command;
mod terminal;
mod usage;
