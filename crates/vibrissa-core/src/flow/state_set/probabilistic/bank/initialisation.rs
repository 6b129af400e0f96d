//! Initialisation of the bank by global localization from a first contact \[thrun2005probabilistic, sec. 8.2\].

use super::super::calibrated_path::CalibrationPrior;
use super::super::grid_search::{ContactOnset, GridSearch};
use super::super::hypothesis::{MeasurementModel, moved};
use super::super::log_window::LogWindow;
use super::super::packed_hypothesis::PackedHypothesis;
use super::super::sensor::LikelihoodOptions;
use super::congruent_replay::ThinnedLog;
use super::merge::{PredictedOptimum, best_of_cells, merge_cell_size};
use super::{BankContext, DAMPING, HypothesisBank, trust_region_step};
use crate::flow::prior;
use crate::plane::{Pose2, Vec2};

/// More hypotheses than this are not carried on.
const MOST_SEEDS: usize = 8000;
/// Standard deviations are enlarged by this while cells are judged.
const SEED_STD_INFLATION: f64 = 1.5;

/// The search for the first hypotheses, in slices: a loaded whisker has every heading and branch at every place.
pub(in super::super) struct GlobalLocalization {
    pub(in super::super) sensor: usize,
    pub(in super::super) onset: usize,
    pub(in super::super) from_free: bool,
    /// Whether the contact has ended, so that following it for longer tells no more.
    pub(in super::super) ended: bool,
    /// How far the base had travelled when it began (m).
    pub(in super::super) travelled: f64,
    rows: Vec<usize>,
    /// How many rows there were then.
    seen: usize,
    pivot: Vec2,
    approach: Vec2,
    stage: SearchStage,
    /// Whether each hypothesis stands for all its images.
    pub(in super::super) by_symmetry: bool,
    /// What was found before it is run from the first row on, for a search that goes on with more rows.
    pub(in super::super) found: Vec<PackedHypothesis>,
}

/// What is being done.
enum SearchStage {
    New,
    GridSearch(GridSearch),
    /// All rows up to the last that judged, relinearised one hypothesis after the other.
    Running(Box<HypothesisBank>, usize),
}

impl GlobalLocalization {
    /// A search from the contact that began at row `onset` of the history with this whisker, or from what an earlier one found.
    #[allow(clippy::too_many_arguments, reason = "what is known of the contact")]
    pub(in super::super) fn new(
        context: &BankContext<'_>,
        history: &LogWindow,
        (sensor, onset): (usize, usize),
        from_free: bool,
        ended: bool,
        travelled: f64,
        found: Vec<PackedHypothesis>,
    ) -> Self {
        let own = &context.sensors[sensor];
        let odom_from_whisker = history.pose(onset).compose(own.robot_from_whisker);
        let tip = Vec2::new(own.length, 0.0);
        let before = history.pose(onset.saturating_sub(3)).compose(own.robot_from_whisker);
        Self {
            sensor,
            onset,
            from_free,
            ended,
            travelled,
            rows: test_rows(history, sensor, onset, context.options.seed_step),
            seen: history.len(),
            pivot: odom_from_whisker.transform_point(tip),
            approach: tip - odom_from_whisker.inverse_transform_point(before.transform_point(tip)),
            stage: SearchStage::New,
            by_symmetry: context.options.prior.is_none()
                && history.heading().is_none()
                && !context.symmetries.all.is_empty(),
            found,
        }
    }

    /// Whether more was found than is carried on, so that the truth may be among what was left out.
    pub(in super::super) fn is_cut(&self) -> bool {
        self.found.len() > MOST_SEEDS
    }

    /// Goes on until `work` (readings run through the forward model) is used up; gives the bank when it has come to the end.
    pub(in super::super) fn step(
        &mut self,
        context: &BankContext<'_>,
        history: &LogWindow,
        work: &mut usize,
    ) -> Option<HypothesisBank> {
        let options = context.options;
        let likelihood = LikelihoodOptions { std_inflation: SEED_STD_INFLATION, outlier_cost: f64::INFINITY };
        let model = MeasurementModel {
            whole: false,
            ..context.model(history, self.pivot, likelihood, CalibrationPrior::default())
        };
        let arm = history.pose(self.onset).compose(context.sensors[self.sensor].robot_from_whisker).position();
        let onset = ContactOnset {
            sensor: self.sensor,
            row: self.onset,
            from_free: self.from_free,
            approach: self.approach,
            rows: &self.rows,
            spacing: options.seed_spacing,
            turn: options.seed_turn,
            symmetries: self.by_symmetry.then_some(context.symmetries),
            near: options.prior.map(|region| {
                let slack = 2.0 * options.seed_spacing + arm.norm() * options.seed_turn;
                prior::around(region, arm, slack, context.sensors[self.sensor].length)
            }),
        };
        loop {
            match core::mem::replace(&mut self.stage, SearchStage::New) {
                SearchStage::New => {
                    let carried = core::mem::take(&mut self.found);
                    self.stage = SearchStage::GridSearch(GridSearch::new(&model, &onset, carried));
                }
                SearchStage::GridSearch(mut seeding) => {
                    let admits = |map_from_odom: Pose2| {
                        context.satisfies_prior(history, map_from_odom)
                            && context.origin_is_free(history, map_from_odom, self.onset)
                    };
                    if !seeding.step(&model, &onset, &admits, work) {
                        self.stage = SearchStage::GridSearch(seeding);
                        return None;
                    }
                    self.found = seeding.into_found();
                    self.stage = SearchStage::Running(Box::new(self.bank(context, history)), 0);
                }
                SearchStage::Running(mut bank, mut next) => {
                    while next < bank.hypotheses.len() && *work > 0 {
                        bank.relinearise_all(context, history, next..next + 1);
                        *work = work.saturating_sub(bank.used.len());
                        next += 1;
                    }
                    if next < bank.hypotheses.len() {
                        self.stage = SearchStage::Running(bank, next);
                        return None;
                    }
                    bank.prune_outside(context, history, bank.used.last().copied().unwrap_or(self.onset));
                    bank.update_reference_costs(context, history);
                    bank.merge(history, false);
                    bank.prune(context, history);
                    return Some(*bank);
                }
            }
        }
    }

    /// The bank of what was found: the best of those that meet, and no more than can be carried on.
    fn bank(&self, context: &BankContext<'_>, history: &LogWindow) -> HypothesisBank {
        let gain = context.options.shared_gain.unwrap_or(context.sensors[self.sensor].gain_std());
        let to = |seed: &PackedHypothesis, gain: f64| {
            let (cost, d) = seed.place(gain).least(DAMPING);
            PredictedOptimum { at: moved(seed.map_from_odom, self.pivot, trust_region_step(d)), cost }
        };
        // Those that begin free are judged anew from there, so that none of them has cost anything yet.
        let prospect = |seed: &PackedHypothesis| {
            if self.from_free { PredictedOptimum { cost: 0.0, ..to(seed, 0.0) } } else { to(seed, gain) }
        };
        let kept = best_of_cells(
            self.found.iter().map(prospect),
            self.pivot,
            history.pose(history.len() - 1),
            merge_cell_size(self.found.len()),
        );
        let mut chosen: Vec<&PackedHypothesis> =
            self.found.iter().zip(kept).filter_map(|(seed, kept)| kept.then_some(seed)).collect();
        if !self.from_free || chosen.len() > MOST_SEEDS {
            chosen.sort_by(|a, b| a.told.constant.total_cmp(&b.told.constant));
        }
        chosen.truncate(MOST_SEEDS);
        let hypothesis = |seed: &PackedHypothesis| {
            let h = seed.clone().into_hypothesis(self.onset);
            if self.from_free { h.free_at(to(seed, 0.0).at) } else { h }
        };
        let mut bank = HypothesisBank {
            hypotheses: chosen.into_iter().map(hypothesis).collect(),
            used: (0..self.onset).chain(self.rows.iter().copied()).collect(),
            next: self.seen,
            pivot: self.pivot,
            shared: CalibrationPrior::new(gain, &context.robot.odometry),
            row_update: None,
            work_saved: 0,
            cursor: 0,
            rows_since_merge: 0,
            reference_costs: Vec::new(),
            recent_costs: Vec::new(),
            dropped: super::pruning::PrunedHypotheses::default(),
            thinned_log: self.from_free.then(ThinnedLog::default),
            marginalised: false,
            by_symmetry: self.by_symmetry,
        };
        bank.hypotheses.iter_mut().for_each(|h| h.update_prediction(DAMPING, bank.shared));
        bank
    }
}

/// The rows that judge seeds: the onset, then one for every `step` of the base's travel; of three neighbours always
/// that with the middle reading, so that no single false one is taken.
fn test_rows(history: &LogWindow, sensor: usize, onset: usize, step: f64) -> Vec<usize> {
    let last = history.len() - 1;
    let mut rows = vec![onset];
    let mut travelled = 0.0;
    for row in onset + 1..last {
        travelled += history.pose(row).position().distance(history.pose(row - 1).position());
        if travelled >= step {
            let mut three = [row - 1, row, row + 1];
            three.sort_by(|&a, &b| history.readings(a)[sensor].total_cmp(&history.readings(b)[sensor]));
            if three[1] > rows[rows.len() - 1] {
                rows.push(three[1]);
                travelled = 0.0;
            }
        }
    }
    rows
}
