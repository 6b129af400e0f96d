//! The rod under a force of known tilt: one march, no search.

use super::super::bend::Bend;
use super::super::load::Line;
use super::Rod;
use super::shot::{Trial, gap_of};
use crate::plane::Vec2;
use alloc::vec;

impl Rod {
    /// The rod under `force` (N) at arc length `s_a` (m), tilted by `beta` (rad) from the rod's normal there.
    ///
    /// The counterpart of [`elastica::bend`](super::super::elastica::bend), beyond the first mode, too. None when a number is
    /// not finite, `s_a` is not positive or the march fails.
    #[must_use]
    pub fn pushed(&self, force: f64, s_a: f64, beta: f64) -> Option<Bend> {
        let shot = trial(force, s_a, beta)?.shoot_on(self)?;
        self.bends(vec![shot], Line::Following(beta)).pop()
    }

    /// As [`Rod::pushed`], only the contact point (m), the slope there (rad) and the base moment (N m).
    #[must_use]
    pub fn contact_under(&self, force: f64, s_a: f64, beta: f64) -> Option<(Vec2, f64, f64)> {
        let shot = trial(force, s_a, beta)?.shoot_on(self)?;
        Some((shot.contact, shot.phi_a, shot.moment))
    }
}

fn trial(force: f64, s_a: f64, beta: f64) -> Option<Trial> {
    let sound = force.is_finite() && beta.is_finite() && s_a > 0.0 && s_a.is_finite();
    sound.then_some(Trial { force, s_a, gap: gap_of(beta) })
}
