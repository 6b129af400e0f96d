//! Gauss-Newton to convergence, and merging of hypotheses that end at the same place \[reid1979algorithm\].

use super::super::hypothesis::{GaussianHypothesis, MeasurementModel, difference, moved};
use super::super::log_window::LogWindow;
use super::super::odometry_calibration::Matrix;
use super::super::sensor::LikelihoodOptions;
use super::{BankContext, DAMPING, HypothesisBank, WEAK_PRIOR, trust_region_step};
use crate::contact::follow::Mechanics;
use crate::linear_algebra::{dot, times};
use crate::plane::{Pose2, Vec2};

/// Hypotheses this near to each other are one (m, rad),
const SAME_PLACE: f64 = 1.2e-3;
const SAME_HEADING: f64 = 0.015;
/// and while there are more than this many, those this near: the rest is left to their least squares.
const MANY: usize = 100;
const ROUGH_PLACE: f64 = 2.5e-3;
const ROUGH_HEADING: f64 = 0.04;
/// While they are followed and there are more than this many, most lie along straight walls, where their neighbours say the
/// same: then those this near are one.
const VERY_MANY: usize = 200;
const COARSE_PLACE: f64 = 5e-3;
const COARSE_HEADING: f64 = 0.06;
/// In the end so are those that lie within another's region (squared standard deviations) and no further away (m).
const OVERLAP: f64 = 0.5;
const FARTHEST: f64 = 0.05;
/// So many are moved to their least cost before rows are marginalised, in so many steps.
const FEW: usize = 8;
const FEW_ROUNDS: usize = 3;
/// A step that predicts less than this (nats) is not taken: a few hundredths of a standard deviation.
const SETTLED: f64 = 2e-2;
const SETTLED_EXACTLY: f64 = 1e-3;

impl HypothesisBank {
    /// Keeps the best of hypotheses that have run into each other.
    pub(in super::super) fn merge(&mut self, history: &LogWindow, tracking: bool) {
        let Some(last) = history.len().checked_sub(1) else { return };
        let count = self.hypotheses.len();
        let coarse = (tracking && count > VERY_MANY).then_some([COARSE_PLACE, COARSE_HEADING]);
        let size = coarse.unwrap_or_else(|| merge_cell_size(count));
        let pivot = self.pivot;
        let prospect = |h: &GaussianHypothesis| PredictedOptimum {
            at: moved(h.map_from_odom, pivot, trust_region_step(h.predicted.1)),
            cost: h.predicted.0,
        };
        let kept = best_of_cells(self.hypotheses.iter().map(prospect), pivot, history.pose(last), size);
        let mut kept = kept.into_iter();
        self.hypotheses.retain(|_| kept.next() == Some(true));
    }

    /// Moves every hypothesis to its least cost and joins those that end at the same place.
    pub(in super::super) fn optimise(
        &mut self,
        context: &BankContext<'_>,
        history: &LogWindow,
        rounds: usize,
        exact: usize,
    ) {
        let quick = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let closed = MeasurementModel {
            solver: Mechanics::ClosedForm,
            ..context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared)
        };
        for (index, h) in self.hypotheses.iter_mut().enumerate() {
            let (model, settled) = if index < exact { (&closed, SETTLED_EXACTLY) } else { (&quick, SETTLED) };
            if h.is_pending {
                // What it costs says nothing until it has taken all rows.
                let to = moved(h.map_from_odom, self.pivot, trust_region_step(h.predicted.1));
                h.relinearise(model, to, self.used.iter().copied());
            }
            let mut kept: Option<GaussianHypothesis> = None;
            for _ in 0..rounds {
                let from = kept.as_ref().unwrap_or(h);
                let (least, d) = from.damped_step_cost(DAMPING, self.shared);
                if from.cost(self.shared) - least < settled {
                    break;
                }
                let mut next = from.clone();
                next.relinearise(
                    model,
                    moved(from.map_from_odom, self.pivot, trust_region_step(d)),
                    self.used.iter().copied(),
                );
                if next.cost(self.shared) > from.cost(self.shared) + 1e-3 {
                    // Half the way where the whole does not go down.
                    next.relinearise(
                        model,
                        moved(from.map_from_odom, self.pivot, trust_region_step(d).map(|v| 0.3 * v)),
                        self.used.iter().copied(),
                    );
                    if next.cost(self.shared) > from.cost(self.shared) {
                        break;
                    }
                }
                kept = Some(next);
            }
            if let Some(kept) = kept {
                *h = kept;
            }
        }
        self.merge_overlapping();
    }

    /// Moves hypotheses to their least cost where they are few, and tells whether they are: what is marginalised is believed from
    /// then on.
    pub(in super::super) fn optimise_if_few(&mut self, context: &BankContext<'_>, history: &LogWindow) -> bool {
        let few = self.hypotheses.len() <= FEW;
        if few {
            self.optimise(context, history, FEW_ROUNDS, 0);
            self.hypotheses.iter_mut().for_each(|h| h.update_prediction(DAMPING, self.shared));
        }
        few
    }

    /// Keeps the best of hypotheses within each other's reach.
    fn merge_overlapping(&mut self) {
        let shared = self.shared;
        self.hypotheses.sort_by(|a, b| a.cost(shared).total_cmp(&b.cost(shared)));
        let mut kept: Vec<(GaussianHypothesis, Matrix)> = Vec::new();
        for h in self.hypotheses.drain(..) {
            let near = |(k, curvature): &(GaussianHypothesis, Matrix)| {
                let d = difference(k.map_from_odom, h.map_from_odom, self.pivot);
                d[0].hypot(d[1]) < 0.5 * SAME_PLACE && d[2].abs() < 0.5 * SAME_HEADING
                    || d[0].hypot(d[1]) < FARTHEST && dot(times(curvature, d), d) < OVERLAP
            };
            if !kept.iter().any(near) {
                let curvature = h.marginal(shared).damped(WEAK_PRIOR);
                kept.push((h, curvature));
            }
        }
        self.hypotheses = kept.into_iter().map(|(h, _)| h).collect();
    }
}

/// How near so many hypotheses are to each other where they are one (m, rad).
pub(in super::super) fn merge_cell_size(count: usize) -> [f64; 2] {
    if count > MANY { [ROUGH_PLACE, ROUGH_HEADING] } else { [SAME_PLACE, SAME_HEADING] }
}

/// Where a hypothesis would be best, and what it would cost there (nats).
pub(in super::super) struct PredictedOptimum {
    pub(in super::super) at: Pose2,
    pub(in super::super) cost: f64,
}

/// Which of these are the best of those that they meet; the robot is at `odom_from_robot`.
pub(in super::super) fn best_of_cells(
    prospects: impl Iterator<Item = PredictedOptimum>,
    pivot: Vec2,
    odom_from_robot: Pose2,
    size: [f64; 2],
) -> Vec<bool> {
    let key = |(index, p): (usize, PredictedOptimum)| (cell(p.at, pivot, odom_from_robot, size), p.cost, index);
    let mut keyed: Vec<_> = prospects.enumerate().map(key).collect();
    let mut kept = vec![false; keyed.len()];
    keyed.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    keyed.dedup_by(|later, kept| later.0 == kept.0);
    keyed.iter().for_each(|&(.., index)| kept[index] = true);
    kept
}

/// The cell of a frame's pose of the pivot and of the robot.
fn cell(at: Pose2, pivot: Vec2, odom_from_robot: Pose2, size: [f64; 2]) -> [i64; 5] {
    let (a, b) = (at.transform_point(pivot), at.compose(odom_from_robot));
    let round = |v: f64, by: f64| (v / by).round() as i64;
    let place = |v: f64| round(v, size[0]);
    [place(a.x), place(a.y), place(b.x), place(b.y), round(at.theta, size[1])]
}
