//! What people do with the corridor, one call each.

pub mod demo;
mod localize;
pub mod simulate;

pub use localize::{LocalizeOptions, localize};
pub use simulate::{SimulateOptions, Sweep, SweepNoise, simulate, simulate_tip_sweep};
