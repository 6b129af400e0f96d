//! What people do with the corridor, one call each.

pub mod contact;
pub mod demo;
mod localize;
pub mod profile;
pub mod simulate;

pub use localize::{LocalizeOptions, localize};
pub use simulate::{Sweep, SweepNoise, simulate_tip_sweep};
