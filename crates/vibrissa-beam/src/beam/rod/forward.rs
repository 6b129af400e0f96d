//! The forward map of the rod by itself: one march, no search, no shape kept.

use super::Rod;
use super::shot::{Trial, gap_of};
use crate::plane::Vec2;

/// What one march tells about a rod under one force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touched {
    /// Slope at the contact (rad).
    pub phi_a: f64,
    /// Contact point, whisker frame (m).
    pub contact: Vec2,
    /// Moment about the base (N m).
    pub moment: f64,
}

impl Rod {
    /// The rod under `force` (N) at `s_a` (m), tilted by `beta` (rad) from its normal there; `None` beyond the first mode.
    #[must_use]
    pub fn touched(&self, force: f64, s_a: f64, beta: f64) -> Option<Touched> {
        let inside = force.is_finite() && beta.is_finite() && s_a > 0.0 && s_a <= self.length * (1.0 + 1e-9);
        if !inside || force.abs() > 3e4 / self.softness(s_a) {
            return None;
        }
        // Without a force the rod is at rest, which the first mode's signs cannot judge.
        let trial = Trial { force, s_a, gap: gap_of(beta) };
        let shot = if force.abs() <= 0.0 { trial.shoot_on(self) } else { trial.shoot(self) }?;
        Some(Touched { phi_a: shot.phi_a, contact: shot.contact, moment: shot.moment })
    }

    /// Whether the shape under that load has a moment, or else a curvature, of one sign; so has the rod without a force.
    #[must_use]
    pub fn keeps_one_sign(&self, force: f64, s_a: f64, beta: f64) -> bool {
        force.abs() <= 0.0 || Trial { force, s_a, gap: gap_of(beta) }.keeps_one_sign(self)
    }

    /// The slope at `s_a` (m) that a unit force across it causes by small-angle theory, the base's share included (rad/N).
    #[must_use]
    pub fn slope_compliance(&self, s_a: f64) -> f64 {
        self.softness(s_a) + self.base_angle(1.0) * s_a
    }
}
