//! Moment mode of the rod.

use super::super::bend::Bend;
use super::super::load::{Line, Load};
use super::super::moment_mode::pushing;
use super::super::{check_arc_length, finite, sorted};
use super::Rod;
use super::follow::Status;
use super::march::{RodState, march};
use super::newton::{Goal, ModeProblem, refine};
use super::point::MOST_TURNING;
use super::scan::{geometric, roots};
use super::shot::{Shot, Trial, gap_of};
use crate::error::Result;
use crate::math;
use crate::plane::Vec2;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Largest forces that are looked at, in small-angle slopes of the whisker (rad): for a load that turns with the whisker, and for one of
/// fixed direction.
const LARGEST_FOLLOWING: f64 = 80.0;
const LARGEST_FIXED: f64 = 300.0;
/// What rounding of a march may add to a moment, relative.
const ROUNDING: f64 = 1e-6;

impl Rod {
    /// Every first-mode equilibrium with `moment` (N m) about the base and contact at arc length `s_a` (m), least slope
    /// first; as [`moment_mode`](super::super::moment_mode).
    ///
    /// # Errors
    /// Usage: `moment` not finite or `s_a` outside (0, L].
    pub fn moment_mode(&self, moment: f64, s_a: f64, load: Load) -> Result<Vec<Bend>> {
        finite("moment", moment, "N m")?;
        check_arc_length(self.length, s_a)?;
        let line = load.line()?;
        if moment.abs() <= 0.0 {
            return Ok(vec![self.at_rest(s_a, line)]);
        }
        let largest = match line {
            Line::Following(_) => LARGEST_FOLLOWING,
            Line::Fixed(_) => LARGEST_FIXED,
        };
        if self.is_beyond(moment, s_a, largest) {
            return Ok(Vec::new());
        }
        let shots = match line {
            Line::Following(beta) => self.following_moment(moment, s_a, beta),
            Line::Fixed(psi) => self.fixed_moment(moment, s_a, psi),
        };
        sorted(self.bends(shots, line))
    }

    /// Whether no force up to so large a small-angle slope has the moment, however the rod is bent: its lever is no longer than the rod
    /// up to the contact, and the base turns by no more than half a turn. Without it a reading of another whisker takes milliseconds.
    fn is_beyond(&self, moment: f64, s_a: f64, largest: f64) -> bool {
        let force = largest / self.softness(s_a);
        moment.abs() > (1.0 + ROUNDING) * force * s_a || self.base_angle(moment).abs() > (1.0 + ROUNDING) * PI
    }

    fn following_moment(&self, moment: f64, s_a: f64, beta: f64) -> Vec<Shot> {
        let sign = (moment * math::cos(beta)).signum();
        let unit = 1.0 / self.softness(s_a);
        // Of a rod that is curved at rest the moment may change sign before the base.
        let signs = if self.curvature.is_empty() { vec![sign] } else { vec![sign, -sign] };
        let mut grid = vec![f64::MIN_POSITIVE];
        grid.extend(geometric(0.05, 1.12, LARGEST_FOLLOWING));
        let with_sign = |sign: f64| {
            let trial = |q: f64| Trial { force: sign * q * unit, s_a, gap: gap_of(beta) };
            // The scan runs on through higher modes, where the moment is as smooth, so that no root hides at their border.
            let residual = |q: f64| trial(q).shoot_on(self).map_or(f64::NAN, |shot| shot.moment / moment - 1.0);
            roots(residual, &grid).into_iter().filter_map(|q| trial(q).shoot(self)).collect::<Vec<_>>()
        };
        signs.into_iter().flat_map(with_sign).collect()
    }

    /// Under a force of fixed direction the base tells all: its slope and moment are known, the force is where the moment
    /// at the contact vanishes.
    fn fixed_moment(&self, moment: f64, s_a: f64, psi: f64) -> Vec<Shot> {
        let sign = pushing(psi, moment.signum()).0;
        let unit = 1.0 / self.softness(s_a);
        let base = RodState { s: 0.0, phi: self.base_angle(moment), moment, position: Vec2::ZERO };
        let end = |q: f64, to: f64| {
            let force = sign * q * unit * Vec2::from_angle(psi);
            march(self, base, force, to, |_, state| state.phi.abs() < MOST_TURNING)
        };
        let residual = |q: f64| end(q, s_a).map_or(f64::NAN, |state| state.moment / moment);
        let mut grid = vec![f64::MIN_POSITIVE];
        grid.extend(geometric(0.02, 1.15, LARGEST_FIXED));
        let found = roots(residual, &grid).into_iter().filter_map(|q| {
            let state = end(q, s_a)?;
            let start = Trial { force: sign * q * unit, s_a, gap: psi - state.phi };
            let problem = ModeProblem { rod: self, line: Line::Fixed(psi), goal: Goal::Moment(moment) };
            let refined = refine(&problem, start);
            refined.shot.filter(|shot| refined.status == Status::Converged && shot.trial.shoot(self).is_some())
        });
        found.collect()
    }
}
