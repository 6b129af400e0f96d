//! The simulator of vibrissa: quasi-static sweeps of bent whiskers over a map, their logs and their truth.
//!
//! [`simulate`](fn@simulate) moves a robot with whiskers along a path and tells what they read; [`scenario`] takes map,
//! robot, path and errors from one file. [`discrete`] is a second, independent model of the whisker that checks the first.

#[cfg(feature = "mcap")]
pub mod recording;
pub mod scenario;
mod simulate;

pub use scenario::{Scenario, Simulation};
pub use simulate::{
    Drive, Grip, Pace, Part, Shape, SimulateOptions, Solver, Stage, Sweep, SweepNoise, SweptShape, Touch, contacts_csv,
    discrete, path_through, recorder, shapes, simulate, simulate_tip_sweep, simulate_until, simulate_watched,
};

use vibrissa_core::{Error, Result, Stop, beam, config, contact, flow, plane, sensing, world};
use vibrissa_io as io;
