//! What people do with the corridor, one call each.

#[cfg(feature = "mcap")]
pub mod bag;
pub mod batch;
pub mod calibrate;
pub mod contact;
pub mod demo;
mod drawing;
mod localize;
pub mod profile;
pub mod reproduce;
pub mod scenario;
pub mod simulate;

pub use drawing::outlines;
pub use localize::{StatesObserver, localize, localize_watched, localize_while};
pub use scenario::{Scenario, Simulation};
pub use simulate::{SimulateOptions, Sweep, SweepNoise, simulate, simulate_tip_sweep};
