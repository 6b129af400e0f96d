//! Loads of fixed direction: the one-parameter family of whisker shapes under a force along a given line.
//!
//! Let `omega` in (0, 2 pi) be the force's direction seen from the side to which the whisker bends. The slope at the contact
//! `u` and the angle left to the tension direction `gap = beta + pi/2` share it: `u + gap = omega`. The parameter
//! `p = ln(u / gap)` resolves both ends: nearly straight (`p -> -inf`) and nearly aligned with the force (`p -> inf`).
//! Along it, for `omega <= pi`, the dimensionless length, moment and the contact's polar angle all rise, so each is matched by
//! at most one shape; for `omega > pi` the length falls and then rises.

use super::elastica::MAX_LENGTH;
use super::pendulum::{Pendulum, Swing, Tilt};
use super::root::{highest, root, root_through};
use crate::math;
use crate::platform::rem_euclid;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};

/// The parameter where shapes are straight to below the smallest numbers.
const LOWEST: f64 = -690.0;
/// The parameter beyond which no length up to [`MAX_LENGTH`] is found.
const HIGHEST: f64 = MAX_LENGTH + 10.0;

/// The parameters between which everyday shapes lie.
const USUAL: [f64; 2] = [-6.0, 4.0];

pub(super) struct FixedLine {
    omega: f64,
}

impl FixedLine {
    /// The family of the force direction `omega` (rad), any turn of it.
    pub(super) fn new(omega: f64) -> Self {
        Self { omega: rem_euclid(omega, TAU) }
    }

    fn pendulum(&self, p: f64) -> (Pendulum, f64) {
        let u = self.omega / (1.0 + math::exp(-p));
        let gap = self.omega / (1.0 + math::exp(p));
        (Pendulum::new(Tilt::from_gap(gap)), u)
    }

    /// The dimensionless length of the shape at parameter `p`.
    fn length(&self, p: f64) -> f64 {
        let (pendulum, u) = self.pendulum(p);
        pendulum.time_of(u)
    }

    fn shape(&self, p: f64) -> (Tilt, Swing) {
        let (pendulum, u) = self.pendulum(p);
        let t = pendulum.time_of(u);
        (pendulum.tilt, Swing { u, ..pendulum.at(t) })
    }

    /// Every shape of dimensionless length `t`.
    pub(super) fn at_length(&self, t: f64) -> Vec<(Tilt, Swing)> {
        let residual = |p: f64| math::ln(self.length(p) / t);
        let shape = |p: f64| {
            let (tilt, swing) = self.shape(p);
            (tilt, Swing { t, ..swing })
        };
        if self.omega <= PI {
            return root_through(residual, &[LOWEST, USUAL[0], t + 5.0, HIGHEST]).map(shape).into_iter().collect();
        }
        // The shape at the start is the end of the first mode, where the force's line passes through the base.
        let start = math::ln((2.0 * self.omega - TAU) / (TAU - self.omega));
        if t <= 0.5 * PI || start >= HIGHEST {
            return Vec::new();
        }
        let shortest = highest(|p| -self.length(p), start.max(-40.0), (start + 40.0).min(HIGHEST));
        let before = root(residual, start, shortest);
        let after = root(residual, shortest, HIGHEST);
        before.into_iter().chain(after).map(shape).collect()
    }

    /// The shape whose dimensionless moment `t u'` is `moment > 0`, for `omega <= pi`.
    pub(super) fn at_moment(&self, moment: f64) -> Option<(Tilt, Swing)> {
        let residual = |p: f64| {
            let (_, swing) = self.shape(p);
            math::ln(swing.t * swing.du / moment)
        };
        root_through(residual, &[LOWEST, USUAL[0], USUAL[1], HIGHEST]).map(|p| self.shape(p))
    }

    /// The shape whose contact lies at `polar_angle > 0`, for `omega <= pi`.
    pub(super) fn at_polar_angle(&self, polar_angle: f64) -> Option<(Tilt, Swing)> {
        let residual = |p: f64| math::ln(self.shape(p).1.polar_angle() / polar_angle);
        root_through(residual, &[LOWEST, USUAL[0], USUAL[1], HIGHEST]).map(|p| self.shape(p))
    }
}
