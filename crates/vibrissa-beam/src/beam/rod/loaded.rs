//! The rod under one known load, for those who tabulate it.

use super::Rod;
use super::march::march;
use super::shot::{Trial, gap_of};
use crate::plane::Vec2;

/// A rod under a force that turns with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::beam) struct Loaded {
    /// Slope at the contact (rad).
    pub(in crate::beam) slope: f64,
    /// The contact, whisker frame (m).
    pub(in crate::beam) contact: Vec2,
    /// Moment about the base (N m).
    pub(in crate::beam) moment: f64,
    /// Elastic energy, the base's share included (J).
    pub(in crate::beam) energy: f64,
}

impl Rod {
    /// The rod under `force` (N) at `s_a` (m), tilted by `beta` (rad) from its normal there, whatever the mode.
    pub(in crate::beam) fn loaded(&self, force: f64, s_a: f64, beta: f64) -> Option<Loaded> {
        let trial = Trial { force, s_a, gap: gap_of(beta) };
        let mut energy = 0.0;
        let base = march(self, trial.start(), trial.vector(), 0.0, |step, _| {
            energy += self.strain_energy(step);
            true
        })?;
        let turned = self.base_angle(base.moment);
        let slope = turned - base.phi;
        energy += 0.5 * base.moment * turned;
        Some(Loaded { slope, contact: (-base.position).rotated(slope), moment: base.moment, energy })
    }

    /// Slope at the contact (rad) and the contact under that load, whatever the mode.
    pub(in crate::beam) fn bent_under(&self, force: f64, s_a: f64, beta: f64) -> Option<(f64, Vec2)> {
        Trial { force, s_a, gap: gap_of(beta) }.shoot_on(self).map(|shot| (shot.phi_a, shot.contact))
    }

    /// Whether the shape under that load is of the first mode.
    pub(in crate::beam) fn keeps_first_mode(&self, force: f64, s_a: f64, beta: f64) -> bool {
        Trial { force, s_a, gap: gap_of(beta) }.shoot(self).is_some()
    }

    /// The normal force at `s_a` (m) that small-angle theory needs for a slope of one radian on a clamped base (N).
    pub(in crate::beam) fn unit_force(&self, s_a: f64) -> f64 {
        1.0 / self.softness(s_a)
    }

    /// Whether the rod is straight without load.
    pub(in crate::beam) fn is_straight(&self) -> bool {
        self.curvature.is_empty()
    }
}
