//! Line search along the unobservable direction, to where the last rows are explained best.
//!
//! Hypotheses along a straight wall stand millimetres apart, and all explain the readings. The corner at the wall's end tells a tenth of
//! a millimetre, by rows that fit or are off by many standard deviations: nothing that a linearisation would lead to. So it is
//! asked which place along the wall explains the last rows.

use super::bank::WEAK_PRIOR;
use super::calibrated_path::CalibrationPrior;
use super::hypothesis::{CHECK_EVERY, GaussianHypothesis, MeasurementModel};

/// How far it is slid to either side at most (m), and as far as the readings leave open (standard deviations); in such steps (m).
const FARTHEST: f64 = 3.2e-3;
const OPEN_BY: f64 = 2.5;
const STEP: f64 = 0.4e-3;
/// What cannot be slid by so many steps is not tried.
const LEAST: f64 = 1.5;
/// It is tried where it stands and at both ends first.
const ENDS: usize = 3;
/// If rows cost the same at both ends to so much (nats), nothing changes between them.
const ALIKE: f64 = 1.0;

/// What comes to cost so much more than another step (nats) is not run to its end.
const DEARER: f64 = 3.0;

/// The direction that readings leave open: a move along it by a metre, and how far it may be moved to either side (m).
struct UnobservableDirection {
    along: [f64; 3],
    by: f64,
}

impl GaussianHypothesis {
    /// Whether its readings leave a direction open enough to be slid along.
    pub(super) fn has_unobservable_direction(&self, shared: CalibrationPrior) -> bool {
        self.unobservable_direction(shared).is_some()
    }

    /// Along the principal axis of its place's covariance, with the turn that goes with it.
    fn unobservable_direction(&self, shared: CalibrationPrior) -> Option<UnobservableDirection> {
        let c = self.marginal(shared).covariance(WEAK_PRIOR)?;
        let (sin, cos) = (0.5 * (2.0 * c[0][1]).atan2(c[0][0] - c[1][1])).sin_cos();
        let variance = cos * cos * c[0][0] + 2.0 * sin * cos * c[0][1] + sin * sin * c[1][1];
        let turn = (cos * c[0][2] + sin * c[1][2]) / variance;
        let by = (OPEN_BY * variance.sqrt()).min(FARTHEST);
        (by > LEAST * STEP).then_some(UnobservableDirection { along: [cos, sin, turn], by })
    }

    /// Begins to look for the slide that explains best the rows that come after those it has taken.
    pub(super) fn begin_line_search(self, shared: CalibrationPrior) -> Option<LineSearch> {
        let UnobservableDirection { along, by } = self.unobservable_direction(shared)?;
        let farthest = (by / STEP) as i32;
        let every_second = (1..=(farthest - 1) / 2).flat_map(|half| [2 * half, -2 * half]);
        // The first tells what it costs to stay; then every second step, and last the neighbours of the best.
        let steps: Vec<i32> = [0, farthest, -farthest].into_iter().chain(every_second).collect();
        let last = steps.len();
        Some(LineSearch { from: self, along, steps, last, costs: Vec::new() })
    }
}

/// A search for the slide that explains some rows best, a step after another.
#[derive(Clone, Debug)]
pub(super) struct LineSearch {
    from: GaussianHypothesis,
    along: [f64; 3],
    /// The steps that are tried, the neighbours of the best one beginning at `last`, and what the first of them cost.
    steps: Vec<i32>,
    last: usize,
    costs: Vec<f64>,
}

impl LineSearch {
    /// Tries the next step, for which these rows are run; whether there is no other.
    pub(super) fn step(&mut self, model: &MeasurementModel<'_>, rows: &[usize], work: &mut usize) -> bool {
        if let Some(&step) = self.steps.get(self.costs.len()) {
            let mut there = self.from.shifted(model, self.to(step));
            let most = self.best().1 + DEARER;
            let mut cost = f64::NEG_INFINITY;
            for some in rows.chunks(CHECK_EVERY) {
                some.iter().for_each(|&row| there.add_row(model, row));
                *work = work.saturating_sub(some.len());
                cost = there.cost(model.shared);
                if cost > most {
                    break;
                }
            }
            self.costs.push(cost);
        }
        if self.costs.len() == ENDS && self.is_alike() {
            self.steps.truncate(ENDS);
        } else if self.costs.len() == self.last && self.steps.len() == self.last {
            let (best, _) = self.best();
            let near = [best - 1, best + 1].into_iter().filter(|step| !self.steps.contains(step));
            self.steps.extend(near.collect::<Vec<_>>());
        }
        self.costs.len() == self.steps.len()
    }

    /// The best move and what it costs; none where no move makes a difference.
    pub(super) fn found(&self) -> Option<([f64; 3], f64)> {
        let (step, cost) = self.best();
        (step != 0 && !self.is_alike()).then(|| (self.to(step), cost))
    }

    fn to(&self, step: i32) -> [f64; 3] {
        self.along.map(|v| v * STEP * f64::from(step))
    }

    /// Whether nothing changes between both ends.
    fn is_alike(&self) -> bool {
        self.costs[1..].iter().take(ENDS - 1).all(|end| (end - self.costs[0]).abs() < ALIKE)
    }

    fn best(&self) -> (i32, f64) {
        let each = self.steps.iter().copied().zip(self.costs.iter().copied());
        each.fold((0, f64::INFINITY), |best, step| if step.1 < best.1 { step } else { best })
    }
}
