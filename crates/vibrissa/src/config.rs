//! Every default of the product, once, with its unit and its reason.

use crate::{Error, Result};

/// Tolerances of the geometry, and the limits beyond which a file is taken to be in the wrong unit.
pub mod limits {
    /// Largest distance between a map's curve and the chain of lines that stands for it in look-ups (m): a micrometre.
    pub const FLATTEN_TOLERANCE: f64 = 1e-6;
    /// Largest distance between a circular or elliptical arc and the cubics that replace it (m): a nanometre.
    pub const ARC_TOLERANCE: f64 = 1e-9;
    /// Largest coordinate of a map (m): beyond it the file is in millimetres, degrees or a geographic grid.
    pub const LARGEST_COORDINATE: f64 = 1e5;
    /// Largest odometry coordinate (m): any metric grid fits, and a micrometre is still resolved.
    pub const LARGEST_ODOMETRY: f64 = 1e8;
    /// Most boundary points at which whiskers are aligned: 100 m of walls at 1 mm, and at worst a GB of candidates.
    pub const MOST_SAMPLES: f64 = 1e5;
    /// Coarsest spacing of these points (m).
    pub const COARSEST_SPACING: f64 = 0.1;
    /// Largest extent of a map that raises no doubt (m).
    pub const LARGEST_MAP: f64 = 200.0;
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
    /// Bound on the error of each odometry increment relative to it: the paper's stage is exact to 10 µm.
    pub const ODOMETRY_RELATIVE: f64 = 0.0;
}

/// Which way the contact force acts at a whisker's tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TipLoad {
    /// Normal to the boundary, as frictionless contact of a tip with a smooth wall is.
    #[default]
    BoundaryNormal,
    /// Normal to the whisker, as the paper has it; millimetres off where the whisker meets the wall aslant.
    WhiskerNormal,
}

/// The knobs of the deterministic method \[routray, section "Localization: Deterministic Method"\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeterministicOptions {
    /// Spacing of the points along the boundary at which the whisker is aligned (m); the paper's 1 mm.
    pub boundary_spacing: f64,
    /// How many whisker shapes estimate the boundary's slope; the paper's 2 to 5.
    pub history_shapes: usize,
    /// How far the whisker base travels from the first to the last of these shapes (m).
    ///
    /// A reading off by 5 % moves the tip by a millimetre or two. Over 10 mm the slope is good to a few degrees, and
    /// walls are still all but straight.
    pub history_travel: f64,
    /// How far the whisker base travels between two updates (m).
    pub update_travel: f64,
    /// Where on the boundary and at which heading a candidate may miss an observation, in standard deviations.
    pub tolerance: f64,
    /// Heading tolerance that stays when readings are exact (rad): the wall bends within the history.
    pub heading_floor: f64,
    /// Position tolerance that stays when readings are exact (m): shapes and walls are interpolated.
    pub position_floor: f64,
    /// Share of the observations that a candidate may miss: 0 is the paper's plain intersection.
    ///
    /// At corners the slope of the history is nobody's slope; a few bad observations must not empty the set.
    pub missed_share: f64,
    /// Which way the force acts at the tip.
    pub tip_load: TipLoad,
}

/// The knobs of contact points and outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactOptions {
    /// Readings are merged into one step while the base is nearer than this to their mean (m): finer than any wall of interest.
    pub spacing: f64,
    /// The same for whiskers that are integrated (m): each of their shapes takes thousands of times as long.
    pub rod_spacing: f64,
    /// How far a step of a sliding tip may miss the wall's direction (m); walls are smooth at 10 µm.
    pub step_std: f64,
    /// How much a wall turns along the way (rad per root of a metre): 0.03 rad over a millimetre.
    pub turn: f64,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { spacing: 0.1e-3, rod_spacing: 0.75e-3, step_std: 1e-5, turn: 1.0 }
    }
}

impl ContactOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        for (name, value, lo, hi) in [
            ("spacing", self.spacing, 0.0, 0.01),
            ("rod_spacing", self.rod_spacing, 0.0, 0.01),
            ("step_std", self.step_std, 1e-7, 1e-2),
            ("turn", self.turn, 1e-3, 1e3),
        ] {
            if !(value >= lo && value <= hi) {
                return Err(Error::usage(format!("the option {name} is out of range"))
                    .value(value)
                    .allowed(format!("{lo} to {hi}")));
            }
        }
        Ok(())
    }
}

/// The knobs of outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileOptions {
    /// Spacing of an outline's points (m).
    pub resolution: f64,
    /// How near runs of contact are taken to be the same wall (m): several times a sweep's error.
    pub reach: f64,
    /// Largest standard deviation of a contact on an outline (m).
    pub largest_std: f64,
    /// Largest gap within a run (m).
    pub largest_gap: f64,
    /// Fewest contacts of a run.
    pub fewest: usize,
    /// Shortest run (m).
    pub shortest: f64,
}

impl Default for ProfileOptions {
    fn default() -> Self {
        Self { resolution: 0.5e-3, reach: 2e-3, largest_std: 1e-3, largest_gap: 5e-3, fewest: 8, shortest: 2e-3 }
    }
}

impl ProfileOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        for (name, value, lo, hi) in [
            ("resolution", self.resolution, 1e-5, 0.1),
            ("reach", self.reach, 1e-5, 0.1),
            ("largest_std", self.largest_std, 1e-6, 1.0),
            ("largest_gap", self.largest_gap, 1e-5, 1.0),
            ("shortest", self.shortest, 0.0, 1.0),
        ] {
            if !(value >= lo && value <= hi) {
                return Err(Error::usage(format!("the option {name} is out of range"))
                    .value(value)
                    .allowed(format!("{lo} to {hi} m")));
            }
        }
        Ok(())
    }
}

impl Default for DeterministicOptions {
    fn default() -> Self {
        Self {
            boundary_spacing: 1e-3,
            history_shapes: 5,
            history_travel: 10e-3,
            update_travel: 2e-3,
            tolerance: 4.0,
            heading_floor: 0.05,
            position_floor: 0.7e-3,
            missed_share: 0.25,
            tip_load: TipLoad::default(),
        }
    }
}

impl DeterministicOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        let within = |name: &str, value: f64, lo: f64, hi: f64, unit: &str| {
            if value >= lo && value <= hi {
                return Ok(());
            }
            Err(Error::usage(format!("the option {name} is out of range"))
                .value(value)
                .allowed(format!("{lo} to {hi} {unit}")))
        };
        within("boundary_spacing", self.boundary_spacing, 1e-5, limits::COARSEST_SPACING, "m")?;
        within("history_shapes", self.history_shapes as f64, 2.0, 5.0, "shapes")?;
        within("history_travel", self.history_travel, 1e-5, 1.0, "m")?;
        // Shorter updates share all but a hundredth of their readings: time is spent, nothing is learned.
        let least = 0.01 * self.history_travel;
        within(
            "update_travel",
            self.update_travel,
            least,
            self.history_travel,
            "m, a hundredth to all of history_travel",
        )?;
        within("tolerance", self.tolerance, 0.1, 10.0, "standard deviations")?;
        within("heading_floor", self.heading_floor, 0.0, 1.0, "rad")?;
        within("position_floor", self.position_floor, 0.0, 0.1, "m")?;
        within("missed_share", self.missed_share, 0.0, 0.9, "of the observations")
    }
}
