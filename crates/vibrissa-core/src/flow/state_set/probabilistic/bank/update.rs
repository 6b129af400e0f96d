//! Measurement update of all hypotheses, in slices.
//!
//! Many hypotheses do not take every row, and one that they do take is handed to a share of them at a time, until the next one comes: then
//! no row costs much more than others.

use super::super::log_window::LogWindow;
use super::super::sensor::LikelihoodOptions;
use super::tempering::MOST_TEMPERED_A_ROW;
use super::{BankContext, DAMPING, HypothesisBank, TEMPERING_COST, TEMPERING_ROWS};

/// So many hypotheses share one row; twice as many take every second one, and so on up to the last.
const LOAD: usize = 80;
const SPARSEST: usize = 8;
/// Rows between two merges.
const MERGE_EVERY: usize = 8;

/// A row that is being taken in.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowUpdate {
    row: usize,
    /// The first hypothesis that has not taken it, how many take it at once, and rows until the next that is used.
    first: usize,
    share: usize,
    stride: usize,
    /// The least cost before it.
    before: f64,
}

impl HypothesisBank {
    /// Takes in the rows that have come since the last call, so many of them that are used. With many hypotheses not every row
    /// is used, and one that is takes until the next of them comes.
    pub(in super::super) fn step(&mut self, context: &BankContext<'_>, history: &LogWindow, most: usize) {
        let full = self.used.len().saturating_add(most);
        if most == usize::MAX {
            self.complete(context, history);
        }
        loop {
            if let Some(row_update) = self.row_update
                && !self.continue_row(context, history, row_update)
            {
                // The rows until the next that is used are not looked at.
                self.next = history.len().min(row_update.row + row_update.stride);
                return;
            }
            if self.next >= history.len() || self.used.len() >= full {
                return;
            }
            let active = self.hypotheses.iter().filter(|h| !h.is_pending).count();
            let stride = (active / LOAD).clamp(1, SPARSEST);
            if self.next >= self.used.last().copied().unwrap_or(0) + stride {
                // Where rows are caught up with there is no next row to wait for.
                let behind = most == usize::MAX || history.len() - self.next > stride;
                let share = if behind { usize::MAX } else { active.div_ceil(stride) };
                self.row_update = Some(RowUpdate { row: self.next, first: 0, share, stride, before: self.least() });
            }
            self.next += 1;
        }
    }

    /// Finishes the row that is under way, if one is.
    pub(in super::super) fn complete(&mut self, context: &BankContext<'_>, history: &LogWindow) {
        if let Some(row_update) = self.row_update {
            self.continue_row(context, history, RowUpdate { share: usize::MAX, ..row_update });
        }
    }

    /// Goes on with a row for a share of the hypotheses; whether it is finished.
    fn continue_row(&mut self, context: &BankContext<'_>, history: &LogWindow, row_update: RowUpdate) -> bool {
        let RowUpdate { row, first, share, .. } = row_update;
        let model = context.model(history, self.pivot, LikelihoodOptions::DECLARED, self.shared);
        let rest = self.hypotheses.iter_mut().enumerate().skip(first).filter(|(_, h)| !h.is_pending);
        let mut last = None;
        for (index, h) in rest.take(share) {
            h.add_row(&model, row);
            h.update_prediction(DAMPING, self.shared);
            h.cooldown = h.cooldown.saturating_sub(1);
            last = Some(index);
        }
        let next = last.map_or(self.hypotheses.len(), |index| index + 1);
        if self.hypotheses[next..].iter().any(|h| !h.is_pending) {
            self.row_update = Some(RowUpdate { first: next, ..row_update });
            return false;
        }
        self.row_update = None;
        self.finish_row(context, history, row, row_update.before);
        true
    }

    /// All hypotheses have taken in a row, before which the best one had cost `before`.
    fn finish_row(&mut self, context: &BankContext<'_>, history: &LogWindow, row: usize, before: f64) {
        self.used.push(row);
        let taken = self.hypotheses.iter().filter(|h| !h.is_pending).map(|h| h.predicted.0);
        let least = taken.fold(f64::INFINITY, f64::min);
        self.reference_costs.push(if least.is_finite() { least } else { before });
        let more = least - before;
        // Those that wait are taken to fare as the best one does.
        for h in self.hypotheses.iter_mut().filter(|h| h.is_pending) {
            h.age += 1;
            h.predicted.0 += if more.is_finite() { more.max(0.0) } else { 0.0 };
        }
        self.prune(context, history);
        self.relinearise_moved(context, history);
        self.recent_costs.push(self.least());
        if self.recent_costs.len() > TEMPERING_ROWS {
            if self.recent_costs[TEMPERING_ROWS] - self.recent_costs[0] > TEMPERING_COST * TEMPERING_ROWS as f64 {
                self.refit_tempered(context, history, MOST_TEMPERED_A_ROW);
            }
            self.recent_costs.remove(0);
        }
        self.rows_since_merge += 1;
        if self.rows_since_merge >= MERGE_EVERY {
            self.rows_since_merge = 0;
            self.prune_outside(context, history, row);
            self.merge(history, true);
            let drop = self.prune_threshold(history);
            self.recover_at_corners(context, history, drop);
        }
    }
}
