//! Force mode of the rod.

use super::super::bend::Bend;
use super::super::load::{Line, Load};
use super::super::{check_arc_length, finite, sorted};
use super::Rod;
use super::scan::roots;
use super::shot::{Shot, Trial, gap_of};
use crate::error::{Error, Result};
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Largest small-angle slope (rad) for which a load of fixed direction is solved.
const LARGEST_SLOPE: f64 = 300.0;
/// The same for a load that turns with the whisker.
const LARGEST_FOLLOWING: f64 = 3e4;

impl Rod {
    /// Every first-mode equilibrium under `force` (N) at arc length `s_a` (m), least slope first; as
    /// [`force_mode`](super::super::force_mode).
    ///
    /// # Errors
    /// Usage: `force` not finite or beyond what is solved, `s_a` outside (0, L].
    pub fn force_mode(&self, force: f64, s_a: f64, load: Load) -> Result<Vec<Bend>> {
        finite("force", force, "N")?;
        check_arc_length(self.length, s_a)?;
        let line = load.line()?;
        if force.abs() <= 0.0 {
            return Ok(vec![self.at_rest(s_a, line)]);
        }
        let most = match line {
            Line::Following(_) => LARGEST_FOLLOWING,
            Line::Fixed(_) => LARGEST_SLOPE,
        };
        // The softness takes as long as a short march; its bound decides everyday forces.
        if force.abs() * self.softness_at_most(s_a) > most {
            let limit = most / self.softness(s_a);
            if force.abs() > limit {
                return Err(Error::usage("force").value(force).allowed(format!("up to {limit:e} N at s_a = {s_a} m")));
            }
        }
        let shots = match line {
            Line::Following(beta) => Trial { force, s_a, gap: gap_of(beta) }.shoot(self).into_iter().collect(),
            Line::Fixed(psi) => self.fixed_force(force, s_a, psi),
        };
        sorted(self.bends(shots, line))
    }

    /// The shapes under a force along the fixed direction `psi`: those tilts whose direction comes out as `psi`.
    fn fixed_force(&self, force: f64, s_a: f64, psi: f64) -> Vec<Shot> {
        let shoot = |gap: f64| Trial { force, s_a, gap }.shoot(self);
        let direction = |gap: f64| shoot(gap).map_or(f64::NAN, |shot| shot.direction());
        let grid = tilts();
        let reached: Vec<f64> = grid.iter().map(|&gap| direction(gap)).collect();
        let (lo, hi) = reached.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(*v), hi.max(*v)));
        if lo > hi {
            return Vec::new();
        }
        let mut shots: Vec<Shot> = Vec::new();
        let turns = ((lo - psi) / TAU).floor() as i64..=((hi - psi) / TAU).ceil() as i64;
        for turn in turns {
            // The direction less the target, written so that tiny gaps keep their digits.
            let target = psi + TAU * turn as f64;
            for gap in roots(|gap| direction(gap) - target, &grid) {
                let Some(shot) = shoot(gap) else { continue };
                let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * (1e-6 + a.abs());
                if !shots.iter().any(|s| near(s.phi_a, shot.phi_a) && near(s.moment, shot.moment)) {
                    shots.push(shot);
                }
            }
        }
        shots
    }
}

/// A turn of tilts, dense where the force all but pulls or pushes along the whisker.
fn tilts() -> Vec<f64> {
    let near = [1e-10, 1e-8, 1e-6, 1e-4, 1e-3, 1e-2];
    let mut list = vec![-PI, 0.0, PI];
    for d in near {
        list.extend([-PI + d, -d, d, PI - d]);
    }
    for i in 1..48 {
        let gap = PI * f64::from(i) / 48.0;
        list.extend([-gap, gap]);
    }
    list.sort_by(f64::total_cmp);
    list
}
