//! Pruning of unlikely hypotheses \[reid1979algorithm\], and the recovery of pruned ones at corners.
//!
//! Along a straight wall hypotheses stand millimetres apart, and all explain the readings. The corner at its end does not
//! forgive that: a whisker snaps out of it at one millimetre of the way. Of several corners the one whose hypothesis happened to
//! stand best would be told as the only place. So those that were dropped are tried again: slid along the wall to where they
//! meet their own corner in time, and, where other corners are alike, where the best one's place would be at those.

use super::super::hypothesis::{CostLimits, GaussianHypothesis, MeasurementModel, difference};
use super::super::log_window::LogWindow;
use super::super::sensor::LikelihoodOptions;
use super::super::shared_runs::RunKey;
use super::{BankContext, DAMPING, HypothesisBank, LARGE_DECREASE, is_stale, trust_region_step};
use crate::plane::{Pose2, Vec2};
use std::collections::VecDeque;

/// A hypothesis less likely than the best by this (nats) is dropped; the second part shrinks with the share of the rows
/// that are used.
const DROP: f64 = 30.0;
const DROP_MORE: f64 = 20.0;
/// Readings that may be run again, for each new row, for those that are relinearised before they are dropped.
const WORK_FOR_PENDING: usize = 200;
/// One that is revived may have come only part of the way: it is, so often in turn.
const MOST_RETRIES: u32 = 3;
/// What has become costlier than the best was then by this many times what drops a hypothesis is given up while it is still being
/// run.
const HOPELESS: f64 = 1.3;
/// So many of those dropped last are kept, for so many used rows, and looked for at corners that are alike for so many.
const KEPT: usize = 256;
const KEPT_ROWS: usize = 384;
const ROWS: usize = 96;
/// With no more hypotheses than this those that were dropped are slid to where they meet corners in time.
const RETRIES_AMONG: usize = 64;
/// Readings that may be run for that for each new row, and before everything is given up; beginning with one counts like so many.
const WORK_FOR_RETRIES: usize = 80;
const LAST_WORK_FOR_RETRIES: usize = 200_000;
const BEGUN: usize = 20;
/// With more hypotheses than this nothing is called back.
const FEW: usize = 24;
/// How far one that was dropped may have stood from where it should have (m, rad).
const REACH: [f64; 2] = [10e-3, 0.06];
/// What is no further than this from a hypothesis is known (m, rad).
const KNOWN: [f64; 2] = [3e-3, 0.03];

/// Those that were dropped last.
#[derive(Default)]
pub(super) struct PrunedHypotheses(VecDeque<PrunedHypothesis>);

/// One that was dropped.
struct PrunedHypothesis {
    h: GaussianHypothesis,
    /// How many rows had been used when it was last thought of.
    then: usize,
    /// By how much it was costlier than the best (nats).
    excess_cost: f64,
    /// Whether it has been tried again since.
    tried: bool,
}

impl PrunedHypotheses {
    pub(super) fn push(&mut self, h: GaussianHypothesis, then: usize, least: f64) {
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        let excess_cost = h.predicted.0 - least;
        self.0.push_back(PrunedHypothesis { h, then, excess_cost, tried: false });
    }

    /// All of them.
    pub(super) fn all(&mut self) -> impl Iterator<Item = &mut GaussianHypothesis> {
        self.0.iter_mut().map(|lost| &mut lost.h)
    }

    /// Tries those that were dropped, first those that had come furthest, and slides them to where they meet corners in time, with no more
    /// than this much work (readings); those that come through all rows.
    fn retried(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        most: CostLimits<'_>,
        work: &mut usize,
    ) -> Vec<GaussianHypothesis> {
        let mut back = Vec::new();
        while *work > 0 {
            let open = self.0.iter_mut().filter(|lost| !lost.tried);
            let first = |a: &&mut PrunedHypothesis, b: &&mut PrunedHypothesis| {
                let begun = b.h.relinearisation.is_some().cmp(&a.h.relinearisation.is_some());
                begun.then(b.h.row.cmp(&a.h.row)).then(a.excess_cost.total_cmp(&b.excess_cost))
            };
            let Some(next) = open.min_by(first) else { break };
            let d = trust_region_step(next.h.predicted.1);
            // What was dropped long ago was not for a corner.
            let early = 2 * next.h.row < rows.last().copied().unwrap_or(0);
            next.tried = early || !next.h.has_unobservable_direction(model.shared);
            *work = work.saturating_sub(BEGUN);
            if next.tried {
                continue;
            }
            let Some((alive, _)) = next.h.retry(model, d, rows, most, true, work) else { break };
            next.tried = true;
            if alive {
                next.h.update_prediction(DAMPING, model.shared);
                back.push(next.h.clone());
            }
        }
        back
    }

    /// Forgets those that had been dropped by the first `early` of the used rows, which are marginalised now, and some of those
    /// that stand together; gives the others, for which these rows have to be marginalised, too.
    pub(super) fn since(&mut self, early: usize, pivot: Vec2) -> impl Iterator<Item = &mut GaussianHypothesis> {
        let mut stay: Vec<Pose2> = Vec::new();
        self.0.retain_mut(|PrunedHypothesis { h, then, .. }| {
            let near = |frame: &Pose2| {
                let [x, y, turn] = difference(*frame, h.map_from_odom, pivot);
                x.hypot(y) < 0.5 * REACH[0] && turn.abs() < 0.5 * REACH[1]
            };
            if *then <= early || stay.iter().any(near) {
                return false;
            }
            *then -= early;
            stay.push(h.map_from_odom);
            true
        });
        self.all()
    }
}

impl HypothesisBank {
    /// What a hypothesis may cost more than the best one (nats).
    pub(super) fn prune_threshold(&self, history: &LogWindow) -> f64 {
        DROP + DROP_MORE * self.used.len() as f64 / history.len() as f64
    }

    /// Drops what is much less likely than the best; each gets one more chance at its best place.
    pub(super) fn prune(&mut self, context: &BankContext<'_>, history: &LogWindow) {
        let least = self.least();
        let drop = self.prune_threshold(history);
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let (used, shared) = (&self.used, self.shared);
        let limits = CostLimits { reference_costs: &self.reference_costs, more: HOPELESS * drop };
        let may_move =
            |h: &GaussianHypothesis| is_stale(h.predicted.1) || h.cost(shared) - h.predicted.0 > LARGE_DECREASE;
        let mut dropped = core::mem::take(&mut self.dropped);
        let lost = self.hypotheses.extract_if(.., |h| {
            if h.is_pending || h.predicted.0 <= least + drop {
                return false;
            }
            // What it costs may say only that its linearisation is old. Until it is relinearised it takes none of the rows to come.
            let old = h.age * 6 > used.len();
            if old {
                h.retries = 0;
            }
            h.is_pending = (old || (1..MOST_RETRIES).contains(&h.retries)) && may_move(h);
            h.relinearisation = None;
            !h.is_pending
        });
        lost.for_each(|h| dropped.push(h, used.len(), least));
        let waiting = self.hypotheses.iter().enumerate().filter(|(_, h)| h.is_pending);
        let mut waiting: Vec<(bool, f64, usize)> =
            waiting.map(|(index, h)| (h.relinearisation.is_none(), h.predicted.0, index)).collect();
        waiting.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut dead = vec![false; self.hypotheses.len()];
        let mut work = WORK_FOR_PENDING;
        for (.., index) in waiting {
            if work == 0 {
                break;
            }
            let h = &mut self.hypotheses[index];
            if !h.is_pending || dead[index] {
                continue;
            }
            let before = RunKey::of(h);
            let Some((alive, track)) =
                h.retry(&model, trust_region_step(h.predicted.1), used, limits, false, &mut work)
            else {
                break;
            };
            h.update_prediction(DAMPING, shared);
            h.retries += 1;
            let dear = h.predicted.0 > least + drop;
            h.is_pending = alive && dear && h.retries < MOST_RETRIES && may_move(h);
            dead[index] = !alive || dear && !h.is_pending;
            // Along a straight wall others come to the same.
            let outcome = h.clone();
            for (other, h) in self.hypotheses.iter_mut().enumerate().filter(|(_, h)| h.is_pending) {
                if let Some(there) = before.at(context.ground, track, &outcome, h).filter(|_| other != index) {
                    dead[other] = dead[index];
                    if alive {
                        *h = there;
                    }
                }
            }
        }
        let mut dead = dead.into_iter();
        let lost = self.hypotheses.extract_if(.., |_| dead.next() == Some(true));
        lost.for_each(|h| dropped.push(h, used.len(), least));
        self.dropped = dropped;
        if self.hypotheses.len() <= RETRIES_AMONG {
            self.retry_pruned(context, history, WORK_FOR_RETRIES);
        }
    }

    /// Tries those that were dropped, slid to where they meet corners in time, with so much work (readings), and takes back what then
    /// explains the rows nearly as well as the best.
    fn retry_pruned(&mut self, context: &BankContext<'_>, history: &LogWindow, mut work: usize) {
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let limits = CostLimits { reference_costs: &self.reference_costs, more: self.prune_threshold(history) };
        let back = self.dropped.retried(&model, &self.used, limits, &mut work);
        self.hypotheses.extend(back);
    }

    /// Before all is given up: tries all that were dropped once more, along the path as the odometry has it; whether any comes back.
    pub(in super::super) fn retry_all_pruned(&mut self, context: &BankContext<'_>, history: &mut LogWindow) -> bool {
        self.reset_calibration(context, history);
        self.dropped.0.iter_mut().for_each(|lost| lost.tried = false);
        let before = self.hypotheses.len();
        self.retry_pruned(context, history, LAST_WORK_FOR_RETRIES);
        self.hypotheses.len() > before
    }

    /// Tries those that were dropped again, where the best one's place would be at other corners; what is costlier than the best
    /// by no more than this (nats) is called back.
    pub(super) fn recover_at_corners(&mut self, context: &BankContext<'_>, history: &LogWindow, more: f64) {
        let used = self.used.len();
        if self.hypotheses.len() > FEW {
            // As long as there are many, more are dropped at every row: what is gone first must not be forgotten before it is asked for.
            self.dropped.0.iter_mut().for_each(|lost| lost.then = used);
            return;
        }
        self.dropped.0.retain(|lost| lost.then + KEPT_ROWS > used);
        if !self.dropped.0.iter().any(|lost| lost.then + ROWS > used) {
            return;
        }
        let best =
            self.hypotheses.iter().filter(|h| !h.is_pending).min_by(|a, b| a.predicted.0.total_cmp(&b.predicted.0));
        let Some(best) = best else { return };
        let Some(contact) = best.states.iter().find_map(|state| state.tip_on()) else { return };
        let places = congruent_poses(context, contact, best.map_from_odom);
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let least = self.least();
        let mut back: Vec<GaussianHypothesis> = Vec::new();
        for frame in places {
            let off = |h: &GaussianHypothesis| {
                let [x, y, turn] = difference(frame, h.map_from_odom, self.pivot);
                (x.hypot(y), turn.abs())
            };
            let within = |h: &GaussianHypothesis, [place, angle]: [f64; 2]| off(h).0 < place && off(h).1 < angle;
            if self.hypotheses.iter().chain(&back).any(|h| within(h, KNOWN)) {
                continue;
            }
            let late = self.dropped.0.iter().filter(|lost| lost.then + ROWS > used);
            let near = late.map(|lost| &lost.h).filter(|h| within(h, REACH));
            let Some(near) = near.min_by(|a, b| off(a).0.total_cmp(&off(b).0)) else { continue };
            let mut again = near.clone();
            if again.relinearise_below(
                &model,
                frame,
                &self.used,
                CostLimits { reference_costs: &self.reference_costs, more },
            ) {
                again.update_prediction(DAMPING, self.shared);
                if again.predicted.0 <= least + more {
                    back.push(again);
                }
            }
        }
        self.hypotheses.extend(back);
    }
}

/// Where a frame with a contact of the tip (piece and parameter) would stand if it were as far from other corners that are alike.
pub(super) fn congruent_poses(
    context: &BankContext<'_>,
    contact: (u32, f64),
    frame: Pose2,
) -> impl Iterator<Item = Pose2> {
    let spot = |(piece, at): (u32, f64)| context.ground.pieces[piece as usize].spot(at);
    let from = spot(contact);
    context.ground.as_far_from_corners(contact).into_iter().map(move |place| {
        let to = spot(place);
        let turn = to.normal - from.normal;
        let origin = to.position + (frame.position() - from.position).rotated(turn);
        Pose2::new(origin.x, origin.y, frame.theta + turn)
    })
}
