//! One contact of a whisker, and the limits within which contacts are believed.

use crate::plane::Vec2;
use crate::{Error, Result};

/// A whisker touched at one point: the paper's shape `alpha`, told by the two numbers that fix it, and what follows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Force along the load's direction (N); negative when it pushes towards -y.
    pub force: f64,
    /// Arc length from the base to the contact (m).
    pub s_a: f64,
    /// Slope of the whisker at the contact (rad), counter-clockwise.
    pub phi_a: f64,
    /// The contact point, whisker frame (m).
    pub position: Vec2,
    /// Moment of the contact force about the base (N m), counter-clockwise positive.
    pub moment: f64,
    /// Tilt of the force from the whisker's normal at the contact (rad): 0 under a normal load.
    pub tilt: f64,
}

/// Which parts of a whisker may touch.
///
/// | part | direction of the force | two numbers name a contact |
/// | --- | --- | --- |
/// | side | the whisker's normal (the model's load) | force and arc length |
/// | tip | the wall's own normal, so at any tilt at which the whisker lies in front of the wall | force and tilt |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parts {
    /// Any place before the tip, and the tip under a normal load.
    Side,
    /// The tip.
    Tip,
    /// Both.
    #[default]
    All,
}

impl Parts {
    /// Whether the side may touch.
    #[must_use]
    pub fn side(self) -> bool {
        self != Self::Tip
    }

    /// Whether the tip may touch.
    #[must_use]
    pub fn tip(self) -> bool {
        self != Self::Side
    }
}

/// Declared maxima beyond which a whisker is not loaded; the paper's `F_max` and `M_max`, sizes of either sign.
///
/// The default has no limit but the first mode itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest force (N).
    pub force: f64,
    /// Largest moment about the base (N m).
    pub moment: f64,
    /// Largest slope at the contact (rad); the paper's end-slope sensor has a right angle.
    pub slope: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { force: f64::INFINITY, moment: f64::INFINITY, slope: f64::INFINITY }
    }
}

impl Limits {
    /// Whether a contact is within the limits, with room for rounding.
    #[must_use]
    pub fn admit(&self, contact: &Contact) -> bool {
        let within = |value: f64, limit: f64| value.abs() <= limit * (1.0 + 1e-12);
        within(contact.force, self.force) && within(contact.moment, self.moment) && within(contact.phi_a, self.slope)
    }

    /// Checks that every limit is a positive number, or infinite.
    ///
    /// # Errors
    /// Usage: names the limit and its value.
    pub fn check(&self) -> Result<()> {
        for (name, value, unit) in [
            ("largest force", self.force, "N"),
            ("largest moment", self.moment, "N m"),
            ("largest slope", self.slope, "rad"),
        ] {
            if value.is_nan() || value <= 0.0 {
                return Err(Error::usage(name).value(value).allowed(format!("above 0 {unit}, or inf for no limit")));
            }
        }
        Ok(())
    }
}
