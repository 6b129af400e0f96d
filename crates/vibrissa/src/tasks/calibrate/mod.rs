//! Calibration: from recordings with known truth to the constants that turn readings into moments and distances.

mod constants;
mod contacts;
mod distance;
mod labelled;
mod moment_curve;
mod moment_plane;
mod scatter;
mod staircase;
mod tapped;

pub use constants::{Constant, fit_constants};
pub use contacts::{ContactCalibration, Taper, calibrate_contacts};
pub use distance::{DistanceFit, DistanceSet, LeftOut, Shaft, fit_distance, leave_one_out};
pub use labelled::{Explained, Labelled};
pub use moment_curve::{fit_moment_curve, fit_tip_deflection};
pub use moment_plane::fit_moment_plane;
pub use staircase::staircase;
pub use tapped::{TapSets, read_taps};
