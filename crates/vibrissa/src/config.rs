//! Every default of the product, once, with its unit and its reason.

/// Tolerances of the geometry, and the limits beyond which a file is taken to be in the wrong unit.
pub mod limits {
    /// Largest distance between a map's curve and the chain of lines that stands for it in look-ups (m): a micrometre.
    pub const FLATTEN_TOLERANCE: f64 = 1e-6;
    /// Largest distance between a circular or elliptical arc and the cubics that replace it (m): a nanometre.
    pub const ARC_TOLERANCE: f64 = 1e-9;
    /// Largest coordinate of a map (m): beyond it the file is in millimetres, degrees or a geographic grid.
    pub const LARGEST_COORDINATE: f64 = 1e5;
    /// Largest heading change between two rows of a log that raises no doubt (rad).
    pub const HEADING_JUMP: f64 = 1.0;
    /// Largest move between two rows of a log that raises no doubt (m): 30 m/s at 300 Hz.
    pub const POSITION_JUMP: f64 = 0.1;
    /// Largest moment of a whisker that raises no doubt (N m): hundreds of times the paper's readings.
    pub const LARGEST_MOMENT: f64 = 1.0;
}

/// The paper's whisker and the constants of the method.
pub mod defaults {
    /// Whisker length (m): the paper's Nitinol wire \[routray, section "Sensor Fabrication"\].
    pub const LENGTH: f64 = 0.075;
    /// Young's modulus (Pa): Nitinol, \[routray, section "Sensor Fabrication"\].
    pub const YOUNG_MODULUS: f64 = 52e9;
    /// Wire diameter (m), \[routray, section "Sensor Fabrication"\].
    pub const DIAMETER: f64 = 0.58e-3;
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
    /// Bound on the error of each odometry increment relative to it: the paper's stage is exact to 10 µm.
    pub const ODOMETRY_RELATIVE: f64 = 0.0;
}
