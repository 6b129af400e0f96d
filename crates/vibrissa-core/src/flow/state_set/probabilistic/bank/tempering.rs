//! Likelihood tempering: refitting with inflated standard deviations where all new readings look like outliers
//! (graduated non-convexity, \[yang2020graduated\]).
//!
//! A reading that is many standard deviations off counts as a false one and pulls no more. When all new readings are, since
//! the estimate has crept along an unobservable direction that earlier readings left open, or since a second wall is met by a row of hypotheses
//! along the first none of which stands near enough, they have to be pulled to the readings before they are given up.

use super::super::hypothesis::{GaussianHypothesis, moved};
use super::super::log_window::LogWindow;
use super::super::sensor::LikelihoodOptions;
use super::{BankContext, DAMPING, HypothesisBank, LEAST_DECREASE, TEMPERING_ROWS, trust_region_step};

/// So many are refitted with tempering at most, in all and with one row.
pub(in super::super) const MOST_TEMPERED: usize = 64;
pub(super) const MOST_TEMPERED_A_ROW: usize = 2;
/// Steps with standard deviations enlarged so much.
const STD_INFLATIONS: [f64; 5] = [8.0, 8.0, 8.0, 4.0, 2.0];
/// One that has been tried is left alone for so many rows.
const REST: usize = 32;
/// So many of the rows, evenly spread, and the last few of them are asked first.
const ASKED: usize = 48;
const NEWEST: usize = 2 * TEMPERING_ROWS;

impl HypothesisBank {
    /// Fits so many of the hypotheses anew with all readings believed: the best of those that stand apart, other ones at every
    /// call until all have had their turn, since hypotheses along a straight wall cost the same, wherever they are.
    pub(in super::super) fn refit_tempered(&mut self, context: &BankContext<'_>, history: &LogWindow, most: usize) {
        let mut order: Vec<(f64, usize)> =
            self.hypotheses.iter().enumerate().map(|(index, h)| (h.predicted.0, index)).collect();
        order.retain(|&(_, index)| self.hypotheses[index].cooldown == 0);
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut chosen = self.apart(order.iter().map(|&(_, index)| index), most);
        for &(_, index) in &order {
            if chosen.len() < most && !chosen.contains(&index) {
                chosen.push(index);
            }
        }
        let old = self.used.len().saturating_sub(NEWEST);
        let stride = old.div_ceil(ASKED).max(1);
        let rows: Vec<usize> = self.used[..old].iter().step_by(stride).chain(&self.used[old..]).copied().collect();
        for index in chosen {
            self.hypotheses[index].cooldown = REST;
            self.hypotheses.extend(self.tempered_fit(context, history, index, &rows));
        }
    }

    /// A hypothesis pulled to its readings, if that explains them better.
    fn tempered_fit(
        &self,
        context: &BankContext<'_>,
        history: &LogWindow,
        index: usize,
        rows: &[usize],
    ) -> Option<GaussianHypothesis> {
        let own = &self.hypotheses[index];
        let fair = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let mut h = own.clone();
        for std_inflation in STD_INFLATIONS {
            let likelihood = LikelihoodOptions { std_inflation, outlier_cost: f64::INFINITY };
            let model = context.model(history, self.pivot, likelihood, self.shared);
            h.relinearise(&model, h.map_from_odom, rows.iter().copied());
            let (_, d) = h.damped_step(DAMPING, self.shared);
            h.map_from_odom = moved(h.map_from_odom, self.pivot, trust_region_step(d));
        }
        let mut before = own.clone();
        before.relinearise(&fair, own.map_from_odom, rows.iter().copied());
        h.relinearise(&fair, h.map_from_odom, rows.iter().copied());
        if h.damped_step(DAMPING, self.shared).0 > before.damped_step(DAMPING, self.shared).0 - LEAST_DECREASE {
            return None;
        }
        h.relinearise(&fair, h.map_from_odom, self.used.iter().copied());
        h.update_prediction(DAMPING, self.shared);
        (h.predicted.0 < own.predicted.0 - LEAST_DECREASE).then_some(h)
    }
}
