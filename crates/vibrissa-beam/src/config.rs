//! The paper's whisker, the magnet and the chip at its base, and the tolerance of arcs.

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

/// Largest distance between a circular or elliptical arc and the cubics that replace it (m): a nanometre.
pub const ARC_TOLERANCE: f64 = 1e-9;

/// The magnet and the rubber disc at a whisker's base, where a scenario asks for flux or counts.
pub mod sensing {
    /// Rotational stiffness of the compliant element (N m/rad): a strong contact of 5 mN m turns the magnet by 6 deg.
    pub const STIFFNESS: f64 = 0.05;
    /// Dipole moment of the magnet (A m²): a neodymium disc of 2 mm diameter and 1 mm height.
    pub const MAGNET_MOMENT: f64 = 3.6e-3;
    /// Depth of the magnet below the pivot (m).
    pub const MAGNET_DEPTH: f64 = 3e-3;
    /// Distance from the magnet to the chip (m): the field along the whisker, 5.8 mT, is well inside the chip's range.
    pub const CHIP_DISTANCE: f64 = 5e-3;
}
