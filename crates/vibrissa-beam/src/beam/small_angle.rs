//! The small-angle model of a uniform whisker: what most of the literature computes, kept under its own name.
//!
//! With the slope's square dropped the whisker keeps its length along x, and every load is normal:
//!
//! ```text
//! phi_a = F s_a² / (2 EI),   y = F s_a³ / (3 EI),   M0 = F s_a,   y(s) = F s² (3 s_a - s) / (6 EI)
//! ```
//!
//! The relative error grows like the square of the slope: about 1 % of the contact's distance at 13 degrees, and a
//! quarter at 70.

use crate::plane::Vec2;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A whisker in the small-angle model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallAngle {
    /// Flexural rigidity E I (N m²).
    pub flexural_rigidity: f64,
    /// Force across the whisker (N).
    pub force: f64,
    /// Arc length of the contact, here the same as its distance along x (m).
    pub s_a: f64,
}

impl SmallAngle {
    /// Force mode.
    #[must_use]
    pub fn from_force(flexural_rigidity: f64, force: f64, s_a: f64) -> Self {
        Self { flexural_rigidity, force, s_a }
    }

    /// Moment mode: `F = M0 / s_a`.
    #[must_use]
    pub fn from_moment(flexural_rigidity: f64, moment: f64, s_a: f64) -> Self {
        Self { flexural_rigidity, force: moment / s_a, s_a }
    }

    /// Point mode: `F = 3 EI y / x³`.
    #[must_use]
    pub fn from_point(flexural_rigidity: f64, contact: Vec2) -> Self {
        let force = 3.0 * flexural_rigidity * contact.y / (contact.x * contact.x * contact.x);
        Self { flexural_rigidity, force, s_a: contact.x }
    }

    /// The contact from the moment and the deflection there: `s_a = sqrt(3 EI y / M0)`, the estimate that the paper
    /// compares itself with \[routray, table "contactResults"\]; `None` when the two differ in sign or vanish.
    #[must_use]
    pub fn from_moment_and_deflection(flexural_rigidity: f64, moment: f64, deflection: f64) -> Option<Self> {
        let square = 3.0 * flexural_rigidity * deflection / moment;
        (square > 0.0 && square.is_finite()).then(|| Self::from_moment(flexural_rigidity, moment, square.sqrt()))
    }

    /// Slope at the contact (rad).
    #[must_use]
    pub fn phi_a(&self) -> f64 {
        0.5 * self.force * self.s_a * self.s_a / self.flexural_rigidity
    }

    /// Moment about the base (N m).
    #[must_use]
    pub fn moment(&self) -> f64 {
        self.force * self.s_a
    }

    /// The whisker at arc length `s` from the base on (m); straight beyond the contact.
    #[must_use]
    pub fn point_at(&self, s: f64) -> Vec2 {
        let bent = s.clamp(0.0, self.s_a);
        let y = self.force * bent * bent * (3.0 * self.s_a - bent) / (6.0 * self.flexural_rigidity);
        Vec2::new(s, y + (s - bent).max(0.0) * self.phi_a())
    }

    /// The contact point (m).
    #[must_use]
    pub fn contact(&self) -> Vec2 {
        self.point_at(self.s_a)
    }

    /// Elastic energy `F² s_a³ / (6 EI)` (J).
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.force * self.force * self.s_a * self.s_a * self.s_a / (6.0 * self.flexural_rigidity)
    }
}
