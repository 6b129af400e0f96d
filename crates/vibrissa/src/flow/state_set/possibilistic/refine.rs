//! Which cell meets which reading when: a bounded amount of work for each row.

use super::LOOK_EVERY;
use super::PossibleSet;
use super::cell::Cell;
use crate::world::Map;

/// Most of the kept readings that a new half meets at once.
const RECALLED: usize = 4;
/// Halving is worth its while when the halves together are smaller than the whole by this.
const GAIN: f64 = 0.8;
/// Cells longer than this are halved in any case (m).
const COARSE: f64 = 6e-3;
/// A cell that a reading leaves larger than this share of it is stuck.
const STUCK: f64 = 0.9;
/// Cells are halved once the robot has moved this far from the first contact (m): before, readings tell little apart.
const FIRST_WAY: f64 = 5e-3;
/// Rounds of the last effort, and when they stop: a round that leaves more of the volume than this.
const ROUNDS: usize = 12;
const DONE: f64 = 0.97;
/// Cells that are halved in one row when there is little work for each.
const AT_ONCE: usize = 4;
/// Longest rest between two attempts at halving (records).
const LONGEST_REST: u32 = 512;

impl PossibleSet {
    /// Lets the newest record meet the cells, in turn, as far as the row's work goes; wide cells are halved at once,
    /// and what is left is spent on halving the others.
    pub(super) fn meet_newest(&mut self, map: &Map) {
        let newest = self.records.len() as u32 - 1;
        let mut work = self.options.work;
        let mut turns = self.cells.len();
        let mut cells = std::mem::take(&mut self.cells);
        while turns > 0 && work > 0 {
            turns -= 1;
            work -= 1;
            if self.cursor >= cells.len() {
                self.cursor = 0;
            }
            let cell = cells[self.cursor];
            let look = (newest / LOOK_EVERY) != (cell.seen / LOOK_EVERY);
            let Some(kept) = self.meet(map, cell, newest, look) else {
                self.drop(&mut cells);
                continue;
            };
            cells[self.cursor] = kept;
            let (side, length) = longest(&kept);
            let stuck = length > COARSE && kept.volume() > STUCK * cell.volume();
            if stuck && cells.len() < self.options.most_cells && self.way_since_birth() > FIRST_WAY {
                let [a, b] = kept.halves(side).map(|half| self.recall(map, half, newest, RECALLED));
                work = work.saturating_sub(2 * RECALLED);
                match (a, b) {
                    (Some(a), Some(b)) => {
                        cells[self.cursor] = a;
                        cells.push(b);
                    }
                    (Some(one), None) | (None, Some(one)) => cells[self.cursor] = one,
                    (None, None) => {
                        self.drop(&mut cells);
                        continue;
                    }
                }
            }
            self.cursor += 1;
        }
        self.cells = cells;
        if turns == 0 {
            self.halve(map, work);
        }
    }

    /// Drops the cell whose turn it is; the last cell takes its place.
    fn drop(&self, cells: &mut Vec<Cell>) {
        cells.swap_remove(self.cursor);
    }

    /// The robot's way since the first cells (m).
    fn way_since_birth(&self) -> f64 {
        let at = |record: usize| self.records[record].stand.path();
        at(self.records.len() - 1) - at(self.born_at as usize)
    }

    /// Halves the longest cells and lets the halves meet some of what is remembered.
    pub(super) fn halve(&mut self, map: &Map, mut work: usize) {
        let newest = self.records.len() as u32 - 1;
        let mut order: Vec<usize> = (0..self.cells.len()).filter(|&i| self.may_halve(&self.cells[i], newest)).collect();
        order.sort_by(|&a, &b| longest(&self.cells[b]).1.total_cmp(&longest(&self.cells[a]).1).then(a.cmp(&b)));
        // Few cells can be compared with much that is remembered, many with little.
        let recalled = (work / 2 / order.len().clamp(1, AT_ONCE)).clamp(RECALLED, self.kept.len().max(RECALLED));
        let cost = 2 * (recalled + 1);
        let mut gone = Vec::new();
        let mut born = Vec::new();
        for index in order {
            if work < cost || self.cells.len() + born.len() >= self.options.most_cells + gone.len() {
                break;
            }
            work -= cost;
            let cell = self.cells[index];
            let (side, length) = longest(&cell);
            let halves: Vec<Cell> =
                cell.halves(side).into_iter().filter_map(|half| self.recall(map, half, newest, recalled)).collect();
            let volume: f64 = halves.iter().map(Cell::volume).sum();
            if halves.len() < 2 || length > COARSE || volume < GAIN * cell.volume() {
                gone.push(index);
                born.extend(halves);
            } else {
                let rest = &mut self.cells[index];
                rest.rest_until = newest + rest.patience;
                rest.patience = (2 * rest.patience).min(LONGEST_REST);
            }
        }
        gone.sort_unstable();
        for index in gone.into_iter().rev() {
            self.cells.swap_remove(index);
        }
        self.cells.extend(born);
    }

    fn may_halve(&self, cell: &Cell, newest: u32) -> bool {
        cell.rest_until <= newest && longest(cell).1 > self.options.resolution
    }

    /// A half that meets the newest record and some of those since the first contact, as far apart as can be.
    fn recall(&self, map: &Map, half: Cell, newest: u32, most: usize) -> Option<Cell> {
        let mut cell = self.meet(map, half, newest, true)?;
        let first = self.kept.partition_point(|&k| k < self.born_at);
        let since = &self.kept[first..];
        let count = most.min(since.len());
        for k in 0..count {
            let at = k * (since.len() - 1) / (count - 1).max(1);
            cell = self.meet(map, cell, since[at], false)?;
        }
        Some(cell)
    }

    /// The last effort, when no more rows come: cells meet what is remembered and are halved, as far as the work goes.
    pub fn finish(&mut self, map: &Map) {
        let Some(newest) = self.records.len().checked_sub(1) else { return };
        let share = self.options.last_work / ROUNDS;
        for _ in 0..ROUNDS {
            if self.cells.is_empty() || share == 0 {
                return;
            }
            let (count, before) = (self.cells.len(), self.volume());
            let each = (share / count).clamp(1, self.kept.len().max(1));
            let cells = std::mem::take(&mut self.cells);
            self.cells = cells.into_iter().filter_map(|cell| self.recall(map, cell, newest as u32, each)).collect();
            self.cells.iter_mut().for_each(|cell| cell.rest_until = 0);
            self.halve(map, share);
            if self.cells.len() == count && self.volume() > DONE * before {
                return;
            }
        }
    }
}

/// The longest side of a cell and its length (m).
fn longest(cell: &Cell) -> (usize, f64) {
    let mut best = (0, cell.length(0));
    for side in 1..3 {
        let length = cell.length(side);
        if length > best.1 {
            best = (side, length);
        }
    }
    best
}
