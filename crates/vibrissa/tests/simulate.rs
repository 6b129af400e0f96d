//! The simulator, scenarios and figures.

#![allow(clippy::duplicate_mod, reason = "each file is a test of its own, with the helpers that it takes")]

mod figure_calibration;
mod figure_localization;
mod figure_simulation;
mod scenario_library;
mod scenario_messages;
mod scenario_path;
mod sim_drive;
mod simulate_cases;
mod simulate_demo;
mod simulate_friction;
mod simulate_hostile;
mod simulate_properties;
mod simulate_recorder;
mod simulate_reference;
mod simulate_solvers;
