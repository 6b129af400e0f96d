//! The paper's whisker and the constants of the method.

/// Whisker length (m): the paper's Nitinol wire \[routray, section "Sensor Fabrication"\].
pub const LENGTH: f64 = 0.075;
/// Young's modulus (Pa): Nitinol, \[routray, section "Sensor Fabrication"\].
pub const YOUNG_MODULUS: f64 = 52e9;
/// Wire diameter (m), \[routray, section "Sensor Fabrication"\].
pub const DIAMETER: f64 = 0.58e-3;
/// Largest strain of the surface that raises no doubt: superelastic Nitinol springs back from about 6 %.
pub const STRAIN_LIMIT: f64 = 0.06;
/// Flexural rigidity E I (N m²): 52 GPa times 5.555e-15 m⁴, rounded as the paper rounds it.
pub const FLEXURAL_RIGIDITY: f64 = 2.8886e-4;
/// Tip radius over base radius: the paper's wire does not taper.
pub const TIP_RATIO: f64 = 1.0;
/// Intrinsic curvature (1/m): the paper's wire is straight.
pub const CURVATURE: f64 = 0.0;
/// Rotational stiffness of the base (N m/rad): clamped.
pub const BASE_STIFFNESS: f64 = f64::INFINITY;
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
/// Bound on the error of a log's absolute headings (rad): a compass indoors, 3°.
pub const HEADING_ERROR: f64 = 0.05;
/// Seed of the noise of the built-in sweep.
pub const SEED: u64 = 1;
/// Side of the cells of places in which a preimage is told (m).
pub const PREIMAGE_CELL: f64 = 1e-3;
/// How many cells of headings there are in it: one for each degree.
pub const PREIMAGE_HEADINGS: usize = 360;
