//! How contact points and outlines are found.

use crate::{Error, Result};

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
    /// What the odometry's places are rounded to (m): a base that moves evenly within it is taken to move evenly. The paper's stage.
    pub odometry_resolution: f64,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { spacing: 0.1e-3, rod_spacing: 0.75e-3, step_std: 1e-5, turn: 1.0, odometry_resolution: 1e-5 }
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
            ("odometry_resolution", self.odometry_resolution, 0.0, 1e-3),
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
