//! One march from the contact to the base: the function that every mode searches.

use super::Rod;
use super::march::{RodState, march};
use crate::plane::Vec2;
use core::f64::consts::{FRAC_PI_2, PI};

/// A force at a contact, seen from the tangent there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trial {
    /// Force (N), signed.
    pub(super) force: f64,
    /// Arc length of the contact (m).
    pub(super) s_a: f64,
    /// Direction of a positive force less the slope at the contact (rad): `beta + pi/2`, kept because it may be tiny.
    pub(super) gap: f64,
}

/// What a rod looks like when the trial holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shot {
    pub(super) trial: Trial,
    /// Slope at the contact (rad).
    pub(super) phi_a: f64,
    /// Contact point, whisker frame (m).
    pub(super) contact: Vec2,
    /// Moment about the base (N m).
    pub(super) moment: f64,
}

impl Trial {
    /// The force in the frame of the tangent at the contact (N).
    pub(super) fn vector(&self) -> Vec2 {
        self.force * Vec2::from_angle(self.gap)
    }

    /// The start of the march, in the frame of the tangent at the contact.
    pub(super) fn start(&self) -> RodState {
        RodState { s: self.s_a, phi: 0.0, moment: 0.0, position: Vec2::ZERO }
    }

    /// The rod under this trial; `None` beyond the first mode, when both moment and curvature change sign on the way (the curvature from
    /// where the moment has changed its own on), and when the base would turn by more than half a turn.
    pub(super) fn shoot(&self, rod: &Rod) -> Option<Shot> {
        let push = self.vector().y;
        let rest = rod.rest_curvature(self.s_a);
        let (moment_sign, bend_sign) = (push, if rest.abs() > 0.0 { rest } else { push });
        let (mut moment_kept, mut bend_kept) = (true, true);
        self.shoot_while(rod, |state| {
            moment_kept &= moment_sign * state.moment >= 0.0;
            if !moment_kept {
                bend_kept &= bend_sign * rod.curvature_of(state) >= 0.0;
            }
            moment_kept || bend_kept
        })
        .filter(|shot| rod.base_angle(shot.moment).abs() <= PI)
    }

    /// Whether the moment, or else the curvature, has one sign at every step from the contact to the base. [`Trial::shoot`] asks the
    /// curvature only from where the moment has changed its sign.
    pub(super) fn keeps_one_sign(&self, rod: &Rod) -> bool {
        let push = self.vector().y;
        let rest = rod.rest_curvature(self.s_a);
        let bend_sign = if rest.abs() > 0.0 { rest } else { push };
        // Of a rod that is straight at rest the curvature has the moment's sign.
        let (mut moment_kept, mut bend_kept) = (true, !rod.curvature.is_empty());
        let shot = self.shoot_while(rod, |state| {
            moment_kept &= push * state.moment >= 0.0;
            bend_kept = bend_kept && bend_sign * rod.curvature_of(state) >= 0.0;
            moment_kept || bend_kept
        });
        shot.is_some()
    }

    /// As [`Trial::shoot`], whatever the mode: for searches that pass through such shapes.
    pub(super) fn shoot_on(&self, rod: &Rod) -> Option<Shot> {
        self.shoot_while(rod, |_| true)
    }

    #[inline]
    fn shoot_while(&self, rod: &Rod, mut keep: impl FnMut(&RodState) -> bool) -> Option<Shot> {
        let base = march(rod, self.start(), self.vector(), 0.0, |_, state| keep(state))?;
        // The base was marched to in the tangent frame; its own slope there must be the base's angle in the whisker frame.
        let phi_a = rod.base_angle(base.moment) - base.phi;
        Some(Shot { trial: *self, phi_a, contact: (-base.position).rotated(phi_a), moment: base.moment })
    }
}

impl Shot {
    /// Direction of a positive force in the whisker frame (rad), not wrapped.
    pub(super) fn direction(&self) -> f64 {
        self.phi_a + self.trial.gap
    }
}

/// The gap of a load that turns with the whisker.
pub(super) fn gap_of(beta: f64) -> f64 {
    beta + FRAC_PI_2
}
