//! Sliding a hypothesis along what its readings leave open, to where it meets a corner in time.
//!
//! Hypotheses along a straight wall stand millimetres apart, and all explain the readings. The corner at the wall's end tells a tenth of
//! a millimetre, by rows that fit or are off by many standard deviations: nothing that a linearisation would lead to. So it is
//! asked which place along the wall explains the last rows.

use super::bank::OPEN;
use super::hypothesis::{Hypothesis, Scene};
use super::normal::inverse;
use super::shares::Shared;

/// How far it is slid to either side at most (m), and as far as the readings leave open (standard deviations); in such steps (m).
const FARTHEST: f64 = 3.2e-3;
const OPEN_BY: f64 = 2.5;
const STEP: f64 = 0.4e-3;
/// What cannot be slid by so many steps is not tried.
const LEAST: f64 = 1.5;
/// If rows cost the same at both ends to so much (nats), nothing changes between them.
const ALIKE: f64 = 1.0;

/// The direction that readings leave open: a move along it by a metre, and how far it may be moved to either side (m).
struct Open {
    along: [f64; 3],
    by: f64,
}

impl Hypothesis {
    /// Whether its readings leave a direction open enough to be slid along.
    pub(super) fn is_open(&self, shared: Shared) -> bool {
        self.open(shared).is_some()
    }

    /// Along the principal axis of its place's covariance, with the turn that goes with it.
    fn open(&self, shared: Shared) -> Option<Open> {
        let c = inverse(&self.marginal(shared).damped(OPEN))?;
        let (sin, cos) = (0.5 * (2.0 * c[0][1]).atan2(c[0][0] - c[1][1])).sin_cos();
        let variance = cos * cos * c[0][0] + 2.0 * sin * cos * c[0][1] + sin * sin * c[1][1];
        let turn = (cos * c[0][2] + sin * c[1][2]) / variance;
        let by = (OPEN_BY * variance.sqrt()).min(FARTHEST);
        (by > LEAST * STEP).then_some(Open { along: [cos, sin, turn], by })
    }

    /// Which move along the direction that its readings leave open explains these rows best, which come after those it has
    /// taken, and what it then has cost; none where no move makes a difference. The work is less by the readings that are run for that.
    pub(super) fn best_slide(&self, scene: &Scene<'_>, rows: &[usize], work: &mut usize) -> Option<([f64; 3], f64)> {
        let Open { along, by } = self.open(scene.shared)?;
        let steps = (by / STEP) as i32;
        let to = |step: i32| along.map(|v| v * STEP * f64::from(step));
        let mut cost = |step: i32| {
            let mut there = self.shifted(scene, to(step));
            rows.iter().for_each(|&row| there.take(scene, row));
            *work = work.saturating_sub(rows.len());
            (step, there.cost(scene.shared))
        };
        let (here, ends) = (cost(0).1, [cost(-steps), cost(steps)]);
        if ends.iter().all(|(_, end)| (end - here).abs() < ALIKE) {
            return None;
        }
        // Every second step, then the neighbours of the best.
        let cheaper = |a: (i32, f64), b: (i32, f64)| if b.1 < a.1 { b } else { a };
        let every_second = (1..=(steps - 1) / 2).flat_map(|half| [2 * half, -2 * half]);
        let best = every_second.map(&mut cost).chain(ends).fold((0, here), cheaper);
        let (step, least) = [best.0 - 1, best.0 + 1].into_iter().map(&mut cost).fold(best, cheaper);
        (step != 0).then(|| (to(step), least))
    }
}
