//! What is done with it: contacts, profiles, calibration, plans.

#![allow(clippy::duplicate_mod, reason = "each file is a test of its own, with the helpers that it takes")]

mod bent_whisker;
mod calibrate_plane;
mod calibrate_real;
mod calibrate_synthetic;
mod contact_free;
mod contact_points;
mod contact_sides;
mod contact_space;
mod contact_sweeps;
mod control_wall_follower;
mod join_delay;
mod leaning;
mod profile_outline;
mod tasks_batch;
mod tasks_doubts;
mod tasks_explore;
mod tasks_mapping;
mod tasks_plan;
mod tasks_remedies;
mod tasks_sensor_design;
mod tasks_temporal_filter;
