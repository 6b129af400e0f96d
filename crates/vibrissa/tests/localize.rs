//! Localization as a whole.

#![allow(clippy::duplicate_mod, reason = "each file is a test of its own, with the helpers that it takes")]

mod localize_alike;
mod localize_beside_corners;
mod localize_calibrated;
mod localize_corners;
mod localize_estimates;
mod localize_grazing;
mod localize_head_on;
mod localize_hostile;
mod localize_images;
mod localize_laws;
mod localize_long;
mod localize_nuisances;
mod localize_pressed;
mod localize_probabilistic;
mod localize_region;
mod localize_ridges;
mod localize_rods;
mod localize_rounding;
mod localize_senses;
mod localize_slices;
mod localize_sweeps;
mod localize_symmetries;
mod localize_whiskers;
