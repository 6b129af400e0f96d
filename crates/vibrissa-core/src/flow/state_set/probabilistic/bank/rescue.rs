//! Pulling hypotheses back to readings that seem false.
//!
//! A reading that is many standard deviations off counts as a false one and pulls no more. When all new readings are, since
//! the estimate has crept along a ridge that earlier readings left open, or since a second wall is met by a row of hypotheses
//! along the first none of which stands near enough, they have to be pulled to the readings before they are given up.

use super::super::feeler::Judge;
use super::super::history::History;
use super::super::hypothesis::{Hypothesis, moved};
use super::{Bank, Field, LOOSE, PROMISE, RESCUE_ROWS, cut};

/// So many are pulled back at most, in all and with one row.
pub(in super::super) const RESCUED: usize = 64;
pub(super) const RESCUED_A_ROW: usize = 2;
/// Steps with standard deviations enlarged so much.
const TEMPERS: [f64; 5] = [8.0, 8.0, 8.0, 4.0, 2.0];
/// One that has been tried is left alone for so many rows.
const REST: usize = 32;
/// So many of the rows, evenly spread, and the last few of them are asked first.
const ASKED: usize = 48;
const NEWEST: usize = 2 * RESCUE_ROWS;

impl Bank {
    /// Fits so many of the hypotheses anew with all readings believed: the best of those that stand apart, other ones at every
    /// call until all have had their turn, since hypotheses along a straight wall cost the same, wherever they are.
    pub(in super::super) fn rescue(&mut self, field: &Field<'_>, history: &History, most: usize) {
        let mut order: Vec<(f64, usize)> =
            self.hypotheses.iter().enumerate().map(|(index, h)| (h.promise.0, index)).collect();
        order.retain(|&(_, index)| self.hypotheses[index].rests == 0);
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
            self.hypotheses[index].rests = REST;
            self.hypotheses.extend(self.pulled(field, history, index, &rows));
        }
    }

    /// A hypothesis pulled to its readings, if that explains them better.
    fn pulled(&self, field: &Field<'_>, history: &History, index: usize, rows: &[usize]) -> Option<Hypothesis> {
        let own = &self.hypotheses[index];
        let fair = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let mut h = own.clone();
        for temper in TEMPERS {
            let judge = Judge { temper, outlier_cost: f64::INFINITY };
            let scene = field.scene(history, self.pivot, judge, self.shared);
            h.run(&scene, h.map_from_odom, rows.iter().copied());
            let (_, d) = h.best(LOOSE, self.shared);
            h.map_from_odom = moved(h.map_from_odom, self.pivot, cut(d));
        }
        let mut before = own.clone();
        before.run(&fair, own.map_from_odom, rows.iter().copied());
        h.run(&fair, h.map_from_odom, rows.iter().copied());
        if h.best(LOOSE, self.shared).0 > before.best(LOOSE, self.shared).0 - PROMISE {
            return None;
        }
        h.run(&fair, h.map_from_odom, self.used.iter().copied());
        h.look(LOOSE, self.shared);
        (h.promise.0 < own.promise.0 - PROMISE).then_some(h)
    }
}
