//! Calibration: from recordings with known truth to the constants that turn readings into moments and distances.

mod distance;
pub mod least_squares;
mod staircase;

pub use distance::{DistanceFit, DistanceSet, LeftOut, Shaft, fit_distance, leave_one_out};
pub use staircase::staircase;
