//! The paper's whisker and the constants of the method.

pub use vibrissa_beam::config::{
    BASE_STIFFNESS, CURVATURE, DIAMETER, FLEXURAL_RIGIDITY, LENGTH, STRAIN_LIMIT, TIP_RATIO, YOUNG_MODULUS,
};

/// Bound on the Coulomb coefficient: contact is frictionless, as in the paper.
pub const FRICTION: f64 = 0.0;
/// Bound on the reading's error relative to the reading: the paper's 5 % \[routray, section "Possibilistic Method"\].
pub const MOMENT_RELATIVE: f64 = 0.05;
/// Bound on the reading's error that stays at zero moment (N m).
pub const MOMENT_ABSOLUTE: f64 = 2e-5;
/// The same of a contact force: as that of the moment.
pub const FORCE_RELATIVE: f64 = 0.05;
/// Bound on a force's error at zero (N): the moment's at the end of the paper's whisker.
pub const FORCE_ABSOLUTE: f64 = 3e-4;
/// The same of a slope: as that of the moment.
pub const SLOPE_RELATIVE: f64 = 0.05;
/// Bound on a slope's error at zero (rad): that of the paper's whisker under the moment's.
pub const SLOPE_ABSOLUTE: f64 = 3e-3;
/// Bound on the error of each odometry increment relative to it: the paper's stage is exact to 10 µm.
pub const ODOMETRY_RELATIVE: f64 = 0.0;
/// Bound on the moment that is read while a whisker is free (N m).
pub const ZERO_ERROR: f64 = 0.0;
/// Bound on how fast that changes (N m/s).
pub const ZERO_DRIFT_ERROR: f64 = 0.0;
/// Bounds on the error of a whisker's base on the robot: x, y (m), heading (rad).
pub const MOUNT_ERROR: [f64; 3] = [0.0; 3];
/// Bound on the error of a whisker's length (m).
pub const LENGTH_ERROR: f64 = 0.0;
/// Bound on the error of its flexural rigidity, relative to it.
pub const STIFFNESS_ERROR: f64 = 0.0;
/// Bound on the error of the readings' gain, relative to it.
pub const GAIN_ERROR: f64 = 0.0;
/// Bound on how much earlier or later than the odometry readings are taken (s).
pub const DELAY_ERROR: f64 = 0.0;
/// Bound on the error of the map's scale, relative to it.
pub const MAP_SCALE_ERROR: f64 = 0.0;
/// What the probabilistic method takes for the bounds of errors that a robot file does not bound, see [`crate::world::Robot::with_typical_errors`]: about two
/// thirds of what a careful lab has been seen to be wrong by, so that this lies within three standard deviations.
///
/// Bound on a whisker's zero, as a share of `EI / L`: 0.3 mN m of the paper's whisker. Free rows tell it.
pub const TYPICAL_ZERO: f64 = 0.08;
/// Bound on the place of a whisker's base, as a share of its length, and on its heading (rad): 0.75 mm and 1.25° of the paper's whisker.
pub const TYPICAL_MOUNT: [f64; 2] = [0.01, 0.0218];
/// Bound on a whisker's length, relative to it.
pub const TYPICAL_LENGTH: f64 = 0.03;
/// Bound on the gain of the readings, relative to it; a rigidity that is off is hardly told from it.
pub const TYPICAL_GAIN: f64 = 0.05;
/// Bound on the odometry's translations and rotations, relative to them.
pub const TYPICAL_ODOMETRY: f64 = 0.03;
/// Bound on how much earlier or later than the odometry readings are taken (s): two frames at 130 Hz.
pub const TYPICAL_DELAY: f64 = 0.015;
/// Bound on the error of a log's absolute headings (rad): a compass indoors, 3°.
pub const HEADING_ERROR: f64 = 0.05;
/// Seed of the noise of the built-in sweep.
pub const SEED: u64 = 1;
/// Side of the cells of places in which a preimage is told (m).
pub const PREIMAGE_CELL: f64 = 1e-3;
/// How many cells of headings there are in it: one for each degree.
pub const PREIMAGE_HEADINGS: usize = 360;
