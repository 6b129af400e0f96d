//! The whisker whose tip stands on a boundary: Newton's method on the closed form.
//!
//! Unknowns are the dimensionless force `q = F L² / EI`, the tilt `beta` and, on a smooth piece, the place along it;
//! equations are that the tip is there and that the force is normal there. With `p` the tip over the length and
//! `m = M0 L / EI`, the derivatives by force at fixed tilt are `dp/dq = (1 - x - m y, m x - y) / 2q` and
//! `dphi/dq = m / 2q`; the derivatives by tilt are differences.

use super::foothold::{Foothold, Joint};
use crate::beam::{Bend, Whisker, elastica};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::Map;
use core::f64::consts::FRAC_PI_2;

/// Newton steps before it is given up.
const MOST_STEPS: usize = 40;
/// Residual (whisker lengths, rad) at which an equilibrium is found.
const FOUND: f64 = 2e-13;
/// Residual that is good enough when rounding stops the descent.
const GOOD: f64 = 1e-11;
/// Step of the differences by tilt (rad).
const TILT_STEP: f64 = 1e-6;
/// Below this force the derivatives by force are replaced by their limits.
const WEAK: f64 = 1e-8;
/// Largest change of the tilt in one Newton step (rad).
const LARGEST_TURN: f64 = 0.3;

/// The load of a tip: dimensionless force and tilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TipLoadState {
    /// `F L² / EI`; negative would pull the tip towards the boundary.
    pub(super) q: f64,
    /// Tilt from the whisker's normal at the tip (rad).
    pub(super) beta: f64,
}

/// One whisker on its base: what all equilibria share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stance<'a> {
    pub(super) map: &'a Map,
    pub(super) beam: &'a Whisker,
    pub(super) map_from_whisker: Pose2,
}

/// A whisker and its derivatives by force and tilt, lengths over L.
struct Tip {
    p: Vec2,
    slope: f64,
    p_q: Vec2,
    slope_q: f64,
    p_beta: Vec2,
    slope_beta: f64,
}

/// Where Newton's method on a piece ended.
pub(super) enum OnPiece {
    /// An equilibrium, maybe on the continuation of the piece; stable when the flag is set.
    Found { load: TipLoadState, foothold: Foothold, stable: bool },
    /// The place left the piece before an equilibrium was found.
    Lost(Foothold),
    /// No equilibrium near.
    Failed,
}

impl Stance<'_> {
    /// The whisker under this load; none beyond the first mode.
    pub(super) fn bend(&self, load: TipLoadState) -> Option<Bend> {
        let Whisker { length, flexural_rigidity, .. } = *self.beam;
        elastica::bend(flexural_rigidity, load.q * flexural_rigidity / (length * length), length, load.beta)
    }

    fn tip(&self, load: TipLoadState) -> Option<Tip> {
        let here = self.bend(load)?;
        let scale = 1.0 / self.beam.length;
        let p = here.contact * scale;
        let m = here.moment * self.beam.length / self.beam.flexural_rigidity;
        let (p_q, slope_q) = if load.q.abs() < WEAK {
            let across = load.beta.cos();
            (Vec2::new(0.0, across / 3.0), 0.5 * across)
        } else {
            let half = 0.5 / load.q;
            (Vec2::new(1.0 - p.x - m * p.y, m * p.x - p.y) * half, m * half)
        };
        let turned = |by: f64| self.bend(TipLoadState { beta: load.beta + by, ..load });
        let (more, less) = (turned(TILT_STEP)?, turned(-TILT_STEP)?);
        let per = 0.5 / TILT_STEP;
        Some(Tip {
            p,
            slope: here.phi_a,
            p_q,
            slope_q,
            p_beta: (more.contact - less.contact) * (scale * per),
            slope_beta: (more.phi_a - less.phi_a) * per,
        })
    }

    /// The unloaded whisker about to be pushed along the normal at `foothold`.
    pub(super) fn untouched(&self, foothold: &Foothold) -> TipLoadState {
        let normal = foothold.ground(self.map).normal - self.map_from_whisker.theta;
        TipLoadState { q: 0.0, beta: wrap_angle(normal - FRAC_PI_2) }
    }

    /// The equilibrium with the tip on the piece of `foothold`, from this start.
    pub(super) fn on_piece(&self, mut load: TipLoadState, mut foothold: Foothold) -> OnPiece {
        let heading = self.map_from_whisker.theta;
        let per_length = 1.0 / self.beam.length;
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let Some(tip) = self.tip(load) else { return OnPiece::Failed };
            let ground = foothold.ground(self.map);
            let target = self.map_from_whisker.inverse_transform_point(ground.position) * per_length;
            let velocity = ground.velocity.rotated(-heading) * per_length;
            let gap = tip.p - target;
            let aslant = wrap_angle(heading + tip.slope + load.beta + FRAC_PI_2 - ground.normal);
            let rows = [
                [tip.p_q.x, tip.p_beta.x, -velocity.x],
                [tip.p_q.y, tip.p_beta.y, -velocity.y],
                [tip.slope_q, 1.0 + tip.slope_beta, -ground.turning],
            ];
            let residual = gap.norm().max(aslant.abs());
            if residual < FOUND || (residual < GOOD && residual >= 0.5 * last) {
                // Weak forces have a negative determinant and are stable; the sign changes where the branch folds.
                let stable = determinant(rows) * foothold.side < 0.0;
                return OnPiece::Found { load, foothold, stable };
            }
            let Some([dq, dbeta, dat]) = solve(rows, [gap.x, gap.y, aslant]) else { return OnPiece::Failed };
            let damp = (LARGEST_TURN / dbeta.abs()).min((0.5 + 0.5 * load.q.abs()) / dq.abs()).min(1.0);
            load = TipLoadState { q: load.q - damp * dq, beta: load.beta - damp * dbeta };
            foothold.at -= damp * dat;
            if foothold.is_lost(self.map) {
                return OnPiece::Lost(foothold);
            }
            last = residual;
        }
        OnPiece::Failed
    }

    /// The equilibrium with the tip in a corner, from this start, and where its force points within the corner: 0 along
    /// the normal before, 1 along the normal after.
    pub(super) fn in_corner(&self, mut load: TipLoadState, joint: &Joint) -> Option<(TipLoadState, f64)> {
        let target = self.map_from_whisker.inverse_transform_point(joint.position) * (1.0 / self.beam.length);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let tip = self.tip(load)?;
            let gap = tip.p - target;
            let residual = gap.norm();
            if residual < FOUND || (residual < GOOD && residual >= 0.5 * last) {
                let direction = self.map_from_whisker.theta + tip.slope + load.beta + FRAC_PI_2;
                return Some((load, wrap_angle(direction - joint.normal) / joint.turn));
            }
            let det = tip.p_q.cross(tip.p_beta);
            let (dq, dbeta) = (gap.cross(tip.p_beta) / det, tip.p_q.cross(gap) / det);
            let damp = (LARGEST_TURN / dbeta.abs()).min((0.5 + 0.5 * load.q.abs()) / dq.abs()).min(1.0);
            load = TipLoadState { q: load.q - damp * dq, beta: load.beta - damp * dbeta };
            if !(load.q.is_finite() && load.beta.is_finite()) {
                return None;
            }
            last = residual;
        }
        None
    }
}

fn determinant(m: [[f64; 3]; 3]) -> f64 {
    let minor = |a: usize, b: usize| m[1][a] * m[2][b] - m[1][b] * m[2][a];
    m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
}

/// The solution of three equations by Cramer's rule; none when it is not finite.
fn solve(rows: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let det = determinant(rows);
    let mut solution = [0.0; 3];
    for (k, value) in solution.iter_mut().enumerate() {
        let mut replaced = rows;
        for (row, r) in replaced.iter_mut().zip(right) {
            row[k] = r;
        }
        *value = determinant(replaced) / det;
    }
    solution.iter().all(|v| v.is_finite()).then_some(solution)
}
