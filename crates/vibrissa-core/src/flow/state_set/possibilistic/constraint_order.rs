//! Order of the constraints: readings that ruled out cells before come first (as conflict-driven variable ordering does).

/// Once a reading ruled out so many cells, all counts are bisected: what told much long ago counts less.
const MOST: u32 = 1 << 12;
/// The order is made anew after so many cells.
const ANEW: u32 = 64;

/// The kept readings by how many cells each ruled out of late.
#[derive(Clone, Debug, Default)]
pub(super) struct ConstraintOrder {
    /// Cells ruled out, by record.
    counts: Vec<u32>,
    /// Records, those that ruled out most first, and the first and last of those that they were taken from.
    order: Vec<u32>,
    taken: (usize, u32),
    since: u32,
    /// The record that ruled out the newest cell, plus one.
    last: u32,
}

impl ConstraintOrder {
    /// Makes the order of these records anew if it is old.
    pub(super) fn sort(&mut self, kept: &[u32]) {
        let taken = (kept.len(), kept.last().copied().unwrap_or(0));
        self.since += 1;
        if self.taken == taken && self.since < ANEW {
            return;
        }
        (self.taken, self.since) = (taken, 0);
        if self.order.len() != kept.len() || self.order.iter().max() != kept.last() {
            self.order = kept.to_vec();
        }
        let counts = &self.counts;
        let count = |record: u32| counts.get(record as usize).copied().unwrap_or(0);
        self.order.sort_by(|&a, &b| count(b).cmp(&count(a)).then(a.cmp(&b)));
    }

    /// The record at a place of the order.
    pub(super) fn at(&self, place: usize) -> Option<u32> {
        self.order.get(place).copied()
    }

    /// The record that ruled out a cell last: neighbours often go for the same reason.
    pub(super) fn last(&self) -> Option<u32> {
        self.last.checked_sub(1)
    }

    /// Notes that a record ruled out a cell.
    pub(super) fn note(&mut self, record: u32) {
        let at = record as usize;
        self.last = record + 1;
        if self.counts.len() <= at {
            self.counts.resize(at + 1, 0);
        }
        self.counts[at] += 1;
        if self.counts[at] > MOST {
            self.counts.iter_mut().for_each(|count| *count /= 2);
        }
    }
}
