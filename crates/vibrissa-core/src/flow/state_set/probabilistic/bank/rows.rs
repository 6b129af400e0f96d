//! Rows, handed to the hypotheses.
//!
//! Many hypotheses do not take every row, and one that they do take is handed to a share of them at a time, until the next one comes: then
//! no row costs much more than others.

use super::super::feeler::Judge;
use super::super::history::History;
use super::rescue::RESCUED_A_ROW;
use super::{Bank, Field, LOOSE, RESCUE_COST, RESCUE_ROWS};

/// So many hypotheses share one row; twice as many take every second one, and so on up to the last.
const LOAD: usize = 80;
const SPARSEST: usize = 8;
/// Rows between two merges.
const MERGE_EVERY: usize = 8;

/// A row that is being taken in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Underway {
    row: usize,
    /// The first hypothesis that has not taken it, how many take it at once, and rows until the next that is used.
    first: usize,
    share: usize,
    stride: usize,
    /// The least cost before it.
    before: f64,
}

impl Bank {
    /// Takes in the rows that have come since the last call, so many of them that are used. With many hypotheses not every row
    /// is used, and one that is takes until the next of them comes.
    pub(in super::super) fn step(&mut self, field: &Field<'_>, history: &History, most: usize) {
        let full = self.used.len().saturating_add(most);
        if most == usize::MAX {
            self.complete(field, history);
        }
        loop {
            if let Some(underway) = self.underway
                && !self.go_on(field, history, underway)
            {
                // The rows until the next that is used are not looked at.
                self.next = history.len().min(underway.row + underway.stride);
                return;
            }
            if self.next >= history.len() || self.used.len() >= full {
                return;
            }
            let active = self.hypotheses.iter().filter(|h| !h.waits).count();
            let stride = (active / LOAD).clamp(1, SPARSEST);
            if self.next >= self.used.last().copied().unwrap_or(0) + stride {
                // Where rows are caught up with there is no next row to wait for.
                let behind = most == usize::MAX || history.len() - self.next > stride;
                let share = if behind { usize::MAX } else { active.div_ceil(stride) };
                self.underway = Some(Underway { row: self.next, first: 0, share, stride, before: self.least() });
            }
            self.next += 1;
        }
    }

    /// Finishes the row that is under way, if one is.
    pub(in super::super) fn complete(&mut self, field: &Field<'_>, history: &History) {
        if let Some(underway) = self.underway {
            self.go_on(field, history, Underway { share: usize::MAX, ..underway });
        }
    }

    /// Goes on with a row for a share of the hypotheses; whether it is finished.
    fn go_on(&mut self, field: &Field<'_>, history: &History, underway: Underway) -> bool {
        let Underway { row, first, share, .. } = underway;
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let rest = self.hypotheses.iter_mut().enumerate().skip(first).filter(|(_, h)| !h.waits);
        let mut last = None;
        for (index, h) in rest.take(share) {
            h.take(&scene, row);
            h.look(LOOSE, self.shared);
            h.rests = h.rests.saturating_sub(1);
            last = Some(index);
        }
        let next = last.map_or(self.hypotheses.len(), |index| index + 1);
        if self.hypotheses[next..].iter().any(|h| !h.waits) {
            self.underway = Some(Underway { first: next, ..underway });
            return false;
        }
        self.underway = None;
        self.taken(field, history, row, underway.before);
        true
    }

    /// All hypotheses have taken in a row, before which the best one had cost `before`.
    fn taken(&mut self, field: &Field<'_>, history: &History, row: usize, before: f64) {
        self.used.push(row);
        let taken = self.hypotheses.iter().filter(|h| !h.waits).map(|h| h.promise.0);
        let least = taken.fold(f64::INFINITY, f64::min);
        self.usual.push(if least.is_finite() { least } else { before });
        let more = least - before;
        // Those that wait are taken to fare as the best one does.
        for h in self.hypotheses.iter_mut().filter(|h| h.waits) {
            h.age += 1;
            h.promise.0 += if more.is_finite() { more.max(0.0) } else { 0.0 };
        }
        self.drop_unlikely(field, history);
        self.linearise(field, history);
        self.recent.push(self.least());
        if self.recent.len() > RESCUE_ROWS {
            if self.recent[RESCUE_ROWS] - self.recent[0] > RESCUE_COST * RESCUE_ROWS as f64 {
                self.rescue(field, history, RESCUED_A_ROW);
            }
            self.recent.remove(0);
        }
        self.since_merge += 1;
        if self.since_merge >= MERGE_EVERY {
            self.since_merge = 0;
            self.drop_outside(field, history, row);
            self.merge(history, true);
            let drop = self.drop(history);
            self.recall(field, history, drop);
        }
    }
}
