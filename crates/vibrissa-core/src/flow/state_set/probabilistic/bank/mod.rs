//! The bank of hypotheses \[reid1979algorithm\]: update, relinearisation \[kaess2012isam2\], merging, pruning and the
//! marginalisation of old rows \[sibley2010sliding\].

mod congruent_replay;
mod free_space;
mod initialisation;
mod merge;
mod pruning;
mod recalibration;
mod tempering;
mod update;

use super::calibrated_path::CalibrationPrior;
use super::hypothesis::{CostLimits, GaussianHypothesis, MeasurementModel, difference, moved};
use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetries;
use super::sensor::{LikelihoodOptions, Sensor};
use crate::beam::TipTable;
use crate::config::ProbabilisticOptions;
use crate::contact::Boundaries;
use crate::contact::follow::Mechanics;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, Robot};
use congruent_replay::ThinnedLog;
use core::ops::Range;
pub(super) use initialisation::GlobalLocalization;
pub(super) use merge::{PredictedOptimum, best_of_cells, merge_cell_size};
use pruning::PrunedHypotheses;
pub(super) use tempering::MOST_TEMPERED;
use update::RowUpdate;

/// Inverse variances that keep a step finite where the readings leave a direction open (5 mm, 5°).
pub(super) const DAMPING: [f64; 3] = [4e4, 4e4, 131.0];
/// Longest step of one linearisation (m, rad).
const LONGEST: [f64; 2] = [3e-3, 0.06];
/// A step longer than this (m, rad) asks for a new linearisation, if it predicts so much (nats).
const STALE: [f64; 2] = [1e-4, 2e-3];
const LEAST_DECREASE: f64 = 0.1;
/// One that predicts so much (nats) asks for it however short it is.
const LARGE_DECREASE: f64 = 8.0;
/// Readings that may be run again for each new row, and how many are saved up for it when there is nothing to do.
const BUDGET: usize = 80;
const SAVED: usize = 3 * BUDGET;
/// Inverse variances that keep covariances finite (20 mm, 20°).
pub(super) const WEAK_PRIOR: [f64; 3] = [2.5e3, 2.5e3, 8.2];
/// When so many rows have cost so much each (nats), hypotheses are refitted with tempering by readings that seem false.
pub(super) const TEMPERING_ROWS: usize = 8;
const TEMPERING_COST: f64 = 2.5;
/// Those that are refitted with tempering together
/// stand so far apart (m, rad).
const APART: [f64; 2] = [15e-3, 0.1];
/// Hypotheses this near to each other (m, rad) are to be told on the same side of a map that is symmetric.
const GATHER_DISTANCE: [f64; 2] = [60e-3, 0.2];

/// Errors of the odometry that are not the same share of every increment, as a part of the declared bound, when rows are marginalised.
const VARYING: f64 = 0.25;

/// The hypotheses and the rows that they have seen.
pub(super) struct HypothesisBank {
    pub(super) hypotheses: Vec<GaussianHypothesis>,
    /// The rows of the history that are used, in order.
    pub(super) used: Vec<usize>,
    /// The first row that has not been looked at.
    pub(super) next: usize,
    pub(super) pivot: Vec2,
    pub(super) shared: CalibrationPrior,
    /// The last row that is used, as long as not all hypotheses have taken it.
    row_update: Option<RowUpdate>,
    work_saved: usize,
    cursor: usize,
    rows_since_merge: usize,
    /// The least cost after each of the used rows.
    reference_costs: Vec<f64>,
    /// The least costs after the last few rows.
    recent_costs: Vec<f64>,
    dropped: PrunedHypotheses,
    /// What is kept of rows that have been marginalised; nothing where the log began in contact.
    thinned_log: Option<ThinnedLog>,
    /// Whether rows have been marginalised, the history's first among them.
    marginalised: bool,
    /// Whether each hypothesis stands for all its images on a map that is symmetric.
    pub(super) by_symmetry: bool,
}

/// What the bank works with.
#[derive(Clone, Copy)]
pub(super) struct BankContext<'a> {
    pub(super) map: &'a Map,
    pub(super) ground: &'a Boundaries,
    pub(super) symmetries: &'a MapSymmetries,
    pub(super) table: &'a TipTable,
    pub(super) robot: &'a Robot,
    pub(super) sensors: &'a [Sensor],
    pub(super) options: &'a ProbabilisticOptions,
}

impl<'a> BankContext<'a> {
    pub(super) fn model(
        &self,
        history: &'a LogWindow,
        pivot: Vec2,
        likelihood: LikelihoodOptions,
        shared: CalibrationPrior,
    ) -> MeasurementModel<'a> {
        MeasurementModel {
            solver: Mechanics::Table(self.table),
            map: self.map,
            ground: self.ground,
            sensors: self.sensors,
            history,
            pivot,
            likelihood,
            shared,
            model_error: false,
            whole: true,
            heading_std: self.options.heading_error / SQRT_3,
        }
    }
}

impl BankContext<'_> {
    /// Whether a place is in the prior's region and near the absolute headings, give or take a cell of the search. The
    /// odometry frame is the robot's at the first row.
    pub(super) fn satisfies_prior(&self, history: &LogWindow, map_from_odom: Pose2) -> bool {
        let (place, turn) = (self.options.seed_spacing, self.options.seed_turn);
        let within = |[[a, b], [c, d], [e, f]]: [[f64; 2]; 3]| {
            let off = wrap_angle(map_from_odom.theta - 0.5 * (e + f)).abs();
            (a - place..=b + place).contains(&map_from_odom.x)
                && (c - place..=d + place).contains(&map_from_odom.y)
                && off <= 0.5 * (f - e) + turn
        };
        let points =
            |heading: f64| wrap_angle(map_from_odom.theta - heading).abs() <= 1.5 * self.options.heading_error + turn;
        self.options.prior.is_none_or(within) && history.heading().is_none_or(points)
    }
}

impl BankContext<'_> {
    /// Whether the robot's origin stands in free space at a row, give or take a step of the search; the whisker's base is
    /// asked elsewhere.
    pub(super) fn origin_is_free(&self, history: &LogWindow, map_from_odom: Pose2, row: usize) -> bool {
        if self.sensors.iter().all(|f| f.robot_from_whisker.position().norm_squared() == 0.0) {
            return true;
        }
        let origin = map_from_odom.transform_point(history.pose(row).position());
        self.map.is_free(origin) || self.map.nearest_within(origin, self.options.seed_spacing).is_some()
    }
}

/// A step cut to a length that linearisations can be trusted for.
pub(super) fn trust_region_step(d: [f64; 3]) -> [f64; 3] {
    let share = (LONGEST[0] / (d[0] * d[0] + d[1] * d[1]).sqrt()).min(LONGEST[1] / d[2].abs()).min(1.0);
    d.map(|v| v * share)
}

/// Whether a step is longer than a linearisation is trusted for.
fn is_stale(d: [f64; 3]) -> bool {
    d[0] * d[0] + d[1] * d[1] > STALE[0] * STALE[0] || d[2].abs() > STALE[1]
}

/// Whether a step that predicts so much (nats) asks for a new linearisation.
fn needs_relinearisation(predicted: f64, d: [f64; 3]) -> bool {
    is_stale(d) && predicted > LEAST_DECREASE || predicted > LARGE_DECREASE
}

impl HypothesisBank {
    /// Runs these hypotheses anew, each moved to its best place.
    pub(super) fn relinearise_all(&mut self, context: &BankContext<'_>, history: &LogWindow, which: Range<usize>) {
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        for h in &mut self.hypotheses[which] {
            let (_, d) = h.damped_step(DAMPING, self.shared);
            let to = moved(h.map_from_odom, self.pivot, trust_region_step(d));
            h.relinearise(&model, to, self.used.iter().copied());
            h.update_prediction(DAMPING, self.shared);
        }
    }

    /// Uses every row from now on, or so many that are evenly spread; the best hypothesis comes first, and those that come
    /// to cost so much more are given up.
    pub(super) fn use_rows(&mut self, context: &BankContext<'_>, history: &LogWindow, most: usize, more: f64) {
        let stride = history.len().div_ceil(most.max(1)).max(1);
        // The first row has been marginalised where anything has.
        let marginalised = usize::from(self.marginalised);
        self.used = (marginalised..history.len()).rev().step_by(stride).collect();
        self.used.reverse();
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        self.relinearise_all(context, history, 0..self.hypotheses.len().min(1));
        self.reference_costs = self.hypotheses.first().map_or_else(Vec::new, |h| h.costs(&model, &self.used));
        let (used, shared, pivot) = (&self.used, self.shared, self.pivot);
        let limits = CostLimits { reference_costs: &self.reference_costs, more };
        let mut first = true;
        self.hypotheses.retain_mut(|h| {
            if core::mem::take(&mut first) {
                return true;
            }
            let to = moved(h.map_from_odom, pivot, trust_region_step(h.damped_step(DAMPING, shared).1));
            let below = h.relinearise_below(&model, to, used, limits);
            h.update_prediction(DAMPING, shared);
            below
        });
    }

    /// Whether some of the rows are not used.
    pub(super) fn leaves_out_rows(&self, history: &LogWindow) -> bool {
        self.used.len() + usize::from(self.marginalised) < history.len()
    }

    /// Takes these among the hypotheses, run with the rows that are used now where they stand.
    pub(super) fn readmit(
        &mut self,
        context: &BankContext<'_>,
        history: &LogWindow,
        hypotheses: Vec<GaussianHypothesis>,
    ) {
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        for mut h in hypotheses {
            h.relinearise(&model, h.map_from_odom, self.used.iter().copied());
            h.update_prediction(DAMPING, self.shared);
            self.hypotheses.push(h);
        }
    }

    /// Finds the costs of the best hypothesis after each used row.
    fn update_reference_costs(&mut self, context: &BankContext<'_>, history: &LogWindow) {
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let known = self.hypotheses.iter().filter(|h| !h.is_pending);
        let best = known.min_by(|a, b| a.cost(self.shared).total_cmp(&b.cost(self.shared)));
        self.reference_costs =
            best.map_or_else(|| vec![f64::INFINITY; self.used.len()], |h| h.costs(&model, &self.used));
    }

    /// Linearises those whose estimate has moved, as far as the budget goes: what is under way, then the best one, then in turn.
    fn relinearise_moved(&mut self, context: &BankContext<'_>, history: &LogWindow) {
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        self.work_saved = (self.work_saved + BUDGET).min(SAVED);
        let costs = self.hypotheses.iter().enumerate().map(|(index, h)| (h.predicted.0, index));
        let Some((_, best)) = costs.min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        let row_update = self.hypotheses.iter().position(|h| h.relinearisation.is_some() && !h.is_pending);
        for index in row_update.into_iter().chain([best]) {
            self.relinearise_if_moved(&model, index);
        }
        for _ in 0..self.hypotheses.len() {
            if self.work_saved == 0 {
                return;
            }
            self.cursor = (self.cursor + 1) % self.hypotheses.len();
            self.relinearise_if_moved(&model, self.cursor);
        }
    }

    /// Linearises one hypothesis anew if its estimate has moved, or goes on with that.
    fn relinearise_if_moved(&mut self, model: &MeasurementModel<'_>, index: usize) {
        let h = &mut self.hypotheses[index];
        if h.age == 0 || h.is_pending || self.work_saved == 0 {
            return;
        }
        let (cost, d) = h.predicted;
        let moved = || needs_relinearisation(h.cost(self.shared) - cost, d);
        if (h.relinearisation.is_some() || moved())
            && h.relinearise_step(model, trust_region_step(d), &self.used, &mut self.work_saved)
        {
            h.update_prediction(DAMPING, self.shared);
        }
    }

    /// How many places each hypothesis stands for.
    pub(super) fn times(&self, symmetries: &MapSymmetries) -> usize {
        if self.by_symmetry { symmetries.order() } else { 1 }
    }

    /// Puts all images in the place of the hypotheses that stand for them.
    pub(super) fn expand_images(&mut self, symmetries: &MapSymmetries) {
        if core::mem::take(&mut self.by_symmetry) {
            let images = self.hypotheses.iter().flat_map(|h| symmetries.all.iter().map(|turn| h.turned(turn)));
            let images: Vec<GaussianHypothesis> = images.collect();
            self.hypotheses.extend(images);
        }
    }

    /// Turns hypotheses to where better ones are, so that none stands at an image of another's place.
    pub(super) fn gather_images(&mut self, symmetries: &MapSymmetries) {
        if !self.by_symmetry {
            return;
        }
        let shared = self.shared;
        self.hypotheses.sort_by(|a, b| a.cost(shared).total_cmp(&b.cost(shared)));
        let mut open = core::mem::take(&mut self.hypotheses);
        while !open.is_empty() {
            let mut next = self.hypotheses.len();
            self.hypotheses.push(open.remove(0));
            while let Some(at) = self.hypotheses.get(next).map(|h| h.map_from_odom) {
                let mut rest = Vec::new();
                for h in open {
                    let near = |frame: Pose2| {
                        let [x, y, turn] = difference(at, frame, self.pivot);
                        x.hypot(y) < GATHER_DISTANCE[0] && turn.abs() < GATHER_DISTANCE[1]
                    };
                    if near(h.map_from_odom) {
                        self.hypotheses.push(h);
                    } else if let Some(turn) = symmetries.all.iter().find(|t| near(t.motion.compose(h.map_from_odom))) {
                        self.hypotheses.push(h.turned(turn));
                    } else {
                        rest.push(h);
                    }
                }
                open = rest;
                next += 1;
            }
        }
        self.hypotheses.sort_by(|a, b| a.cost(shared).total_cmp(&b.cost(shared)));
    }

    /// Whether rows have been marginalised.
    pub(super) fn has_marginalised(&self) -> bool {
        self.marginalised
    }

    /// Hypotheses on the side, with these rows.
    pub(super) fn with_hypotheses(&self, hypotheses: Vec<GaussianHypothesis>, used: Vec<usize>) -> Self {
        Self {
            hypotheses,
            used,
            next: self.next,
            pivot: self.pivot,
            shared: self.shared,
            row_update: None,
            work_saved: 0,
            cursor: 0,
            rows_since_merge: 0,
            reference_costs: Vec::new(),
            recent_costs: Vec::new(),
            dropped: PrunedHypotheses::default(),
            thinned_log: None,
            marginalised: self.marginalised,
            by_symmetry: self.by_symmetry,
        }
    }

    /// Those of these, in order, that stand apart from all before.
    ///
    /// Equal places explain the readings equally well; if all that are refitted stood at one of them, the others would be
    /// lost for no reason but their order.
    pub(super) fn apart(&self, order: impl Iterator<Item = usize>, most: usize) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        for index in order {
            let near = |other: &usize| {
                let [x, y, turn] =
                    difference(self.hypotheses[*other].map_from_odom, self.hypotheses[index].map_from_odom, self.pivot);
                x.hypot(y) < APART[0] && turn.abs() < APART[1]
            };
            if chosen.len() < most && !chosen.iter().any(near) {
                chosen.push(index);
            }
        }
        chosen
    }

    /// Marginalises the first `count` rows, so that no more than a window of them is kept.
    pub(super) fn marginalise(&mut self, context: &BankContext<'_>, history: &mut LogWindow, count: usize) {
        let early = self.used.partition_point(|&row| row < count);
        let Some(&last) = self.used[..early].last() else { return };
        // What is marginalised is never linearised again: readings that are steep over a tiny range must not fix a place for good.
        let model = MeasurementModel {
            model_error: true,
            ..context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared)
        };
        let odometry = &context.robot.odometry;
        let (mut way, mut turn) = (0.0, 0.0);
        for row in 0..last {
            let (a, b) = (history.pose(row), history.pose(row + 1));
            way += a.position().distance(b.position());
            turn += a.between(b).theta.abs();
        }
        let place = (VARYING * 0.5 * odometry.translation_relative * way).powi(2);
        let heading = (VARYING * odometry.rotation_relative / SQRT_3 * turn).powi(2);
        for h in self.hypotheses.iter_mut().chain(self.dropped.since(early, self.pivot)) {
            let robot = h.map_from_odom.transform_point(history.pose(last).position());
            let arm = (h.map_from_odom.transform_point(self.pivot) - robot).perp();
            let process_noise = [
                [place + heading * arm.x * arm.x, heading * arm.x * arm.y, heading * arm.x],
                [heading * arm.x * arm.y, place + heading * arm.y * arm.y, heading * arm.y],
                [heading * arm.x, heading * arm.y, heading],
            ];
            h.marginalise(&model, &self.used[..early], &process_noise);
        }
        if let Some(trail) = &mut self.thinned_log {
            // The first row that is left by the time before is the last that was marginalised then.
            trail.take(history, usize::from(self.marginalised)..last);
        }
        self.marginalised = true;
        self.used.drain(..early);
        self.reference_costs.drain(..early);
        self.used.iter_mut().for_each(|row| *row -= last);
        self.next -= last;
        history.forget(last);
    }

    /// The least cost of any hypothesis, as last looked at.
    pub(super) fn least(&self) -> f64 {
        self.hypotheses.iter().map(|h| h.predicted.0).fold(f64::INFINITY, f64::min)
    }
}

/// The standard deviation of an even law is its bound over this.
const SQRT_3: f64 = 1.732_050_807_568_877_2;
