//! SIVIA \[jaulin2001applied, ch. 3\] with a bounded amount of work for each row: which cell meets which reading, and bisection.

use super::contact_tables::{LAST_TABLE, NEXT_TABLE, NEXT_TABLES, TABLES, WORTH_LAST, each_table, tables};
use super::parallelotope::Parallelotope;
use super::{CHECK_BASE_EVERY, FIRST_WORK_FACTOR, PossibleSet};
use crate::beam::press::ContactTable;
use crate::world::Map;

/// Most of the kept readings that a new half meets at once.
const READINGS_AT_ONCE: usize = 4;
/// Bisection is worth its while when the halves together are smaller than the whole by this.
const GAIN: f64 = 0.8;
/// Cells longer than this are bisected in any case (m).
const COARSE: f64 = 6e-3;
/// A cell that a reading leaves larger than this share of it is stuck.
const STUCK: f64 = 0.9;
/// Cells are bisected once the robot has moved this far from the first contact (m): before, readings tell little apart.
const FIRST_WAY: f64 = 5e-3;
/// In the final refinement cells longer than this share of the longest are bisected in one go: the large ones come first.
const LARGE: f64 = 0.7;
/// Stages of the final refinement: how many of the kept readings a half meets, and the share of the work left.
const STAGES: [(usize, f64); 3] = [(4, 0.5), (16, 0.5), (32, 1.0)];
/// A stage is over when halves of cells no longer than [`COARSE`] outlive the readings that they meet, so that there are so many
/// times more cells than there were at the fewest: more readings tell more than more halves.
const GROWN: f64 = 1.5;
/// A stage is over, too, when the second half of its work so far left more than this share of the volume, once it has
/// done so much work (some 10 ms): what is left then is the set itself, or too much for the rest of the work to tell.
const STALLED: f64 = 0.75;
const STALLED_AFTER: usize = 20_000;
/// Most cells of the final refinement: a few MB. Of few readings, which leave a large set but are soon met, each allows more.
const LAST_CELLS: usize = 20_000;
const FEW_READINGS_CELLS: usize = 100_000;
/// Sets of more cells than this after few readings are worth the tables that otherwise come with more readings.
const LARGE_SET: usize = 2_000;
/// Beyond the resolution all cells are bisected as long as that leaves less than this share of their volume, down to this
/// share of the resolution: how large the cover is must be the set's doing, not that of the way to it. Where that took no
/// more than so much work, less will do.
const PAYS: f64 = 0.9;
const CHEAP: usize = 20_000;
const CHEAPLY_PAYS: f64 = 0.97;
/// Where it took no more than this (a millisecond), it ends only after as many bisections in vain as a cell has sides: what two of
/// them rule out, one may not.
const TRIFLE: usize = 2_000;
const SIDES: usize = 3;
const FINEST: f64 = 1.0 / 32.0;
/// One part in so many of the last work may go into that, but no more than went into the bisection before or into so many halves
/// for each kept reading, squared: few readings leave little to gain. Each half meets so many of the kept readings, and what is
/// left at the end meets all of them, for which one part in so many of the work is kept.
const REFINE_WORK_SHARE: usize = 8;
const REFINE_WORK_PER_READING: usize = 10;
const REFINE_READINGS: usize = 24;
/// Kept readings are met in steps of this share of all of them, which spreads any number of them.
const STRIDE: f64 = 0.618_033_988_75;
/// Cells that are bisected in one row when there is little work for each.
const AT_ONCE: usize = 4;
/// Longest rest between two attempts at bisection (records).
const LONGEST_REST: u16 = 512;

impl PossibleSet {
    /// Lets the newest record meet the cells, in turn, as far as the row's work goes; wide cells are bisected at once,
    /// and what is left is spent on bisecting the others.
    pub(super) fn contract_by_newest(&mut self, map: &Map) {
        let newest = self.records.len() as u32 - 1;
        let mut work = self.options.work * if self.untried > 0 { FIRST_WORK_FACTOR } else { 1 };
        let mut turns = self.cells.len();
        let mut cells = std::mem::take(&mut self.cells);
        while turns > 0 && work > 0 {
            turns -= 1;
            self.untried = self.untried.saturating_sub(1);
            if self.cursor >= cells.len() {
                self.cursor = 0;
            }
            let cell = cells[self.cursor];
            let look = cell.is_fresh || (newest / CHECK_BASE_EVERY) != (cell.seen / CHECK_BASE_EVERY);
            let kept = self.contracted_by(map, cell, newest, look, &mut work);
            let Some(kept) = kept.and_then(|cell| self.contracted_by_first(map, cell, &mut work)) else {
                self.drop(&mut cells);
                continue;
            };
            cells[self.cursor] = kept;
            let (side, length) = longest(&kept);
            let stuck = length > COARSE && kept.volume() > STUCK * cell.volume();
            if stuck && cells.len() < self.options.most_cells && self.way_since_start() > FIRST_WAY {
                let [a, b] = kept.bisected(side);
                let [a, b] = [a, b].map(|half| self.contracted_by_order(map, half, READINGS_AT_ONCE, &mut work));
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
            self.bisect_some(map, work);
        }
    }

    /// Drops the cell whose turn it is; the last cell takes its place.
    fn drop(&self, cells: &mut Vec<Parallelotope>) {
        cells.swap_remove(self.cursor);
    }

    /// The robot's way since the first cells (m).
    fn way_since_start(&self) -> f64 {
        let at = |record: usize| self.records[record].stand.path();
        at(self.records.len() - 1) - at(self.started_at as usize)
    }

    /// Bisects the longest cells and lets the halves meet some of what is remembered.
    pub(super) fn bisect_some(&mut self, map: &Map, mut work: usize) {
        let newest = self.records.len() as u32 - 1;
        let mut order: Vec<usize> =
            (0..self.cells.len()).filter(|&i| self.may_bisect(&self.cells[i], newest)).collect();
        order.sort_by(|&a, &b| longest(&self.cells[b]).1.total_cmp(&longest(&self.cells[a]).1).then(a.cmp(&b)));
        // Few cells can be compared with much that is remembered, many with little.
        let recalled =
            (work / 2 / order.len().clamp(1, AT_ONCE)).clamp(READINGS_AT_ONCE, self.kept.len().max(READINGS_AT_ONCE));
        let cost = 2 * (recalled + 1);
        let mut gone = Vec::new();
        let mut born = Vec::new();
        for index in order {
            if work < cost || self.cells.len() + born.len() >= self.options.most_cells + gone.len() {
                break;
            }
            let cell = self.cells[index];
            let (side, length) = longest(&cell);
            let halves: Vec<Parallelotope> = cell
                .bisected(side)
                .into_iter()
                .filter_map(|half| self.contracted_by_order(map, half, recalled, &mut work))
                .collect();
            if length > COARSE || is_gain(&cell, &halves) {
                gone.push(index);
                born.extend(halves);
            } else {
                let rest = &mut self.cells[index];
                rest.rest_until = newest + u32::from(rest.patience);
                rest.patience = (2 * rest.patience).min(LONGEST_REST);
            }
        }
        gone.sort_unstable();
        for index in gone.into_iter().rev() {
            self.cells.swap_remove(index);
        }
        self.cells.extend(born);
    }

    fn may_bisect(&self, cell: &Parallelotope, newest: u32) -> bool {
        cell.rest_until <= newest && longest(cell).1 > self.options.resolution
    }

    /// A half that meets the newest record and some of those since the first contact: those that ruled out most before,
    /// and others spread over all of them; what it meets is taken from the work.
    fn contracted_by_order(
        &mut self,
        map: &Map,
        half: Parallelotope,
        most: usize,
        work: &mut usize,
    ) -> Option<Parallelotope> {
        let newest = self.records.len() as u32 - 1;
        let first = self.kept.partition_point(|&k| k < self.started_at);
        let count = self.kept.len() - first;
        self.constraint_order.sort(&self.kept[first..]);
        // What is left of the work starts the row of readings: each half meets others.
        let (start, stride) = (*work, stride(count));
        let mut cell = self.contracted_by(map, half, newest, true, work)?;
        let told = if most >= count { count } else { most.div_ceil(2) };
        // First what ruled out another cell last.
        let mut next = self.constraint_order.last().filter(|_| count > 0);
        for k in 0..=most.min(count) {
            let record = next;
            next = if k < told {
                self.constraint_order.at(k)
            } else if k < most.min(count) {
                self.kept.get(first + (start + k * stride) % count).copied()
            } else {
                None
            };
            let Some(record) = record else { continue };
            let Some(left) = self.contracted_by(map, cell, record, false, work) else {
                self.constraint_order.note(record);
                return None;
            };
            cell = left;
        }
        self.contracted_by_first(map, cell, work)
    }

    /// How many of the kept readings are no older than the first contact.
    pub(super) fn kept_since_start(&self) -> usize {
        if self.has_started() { self.kept.len() - self.kept.partition_point(|&k| k < self.started_at) } else { 0 }
    }

    /// Whether finer tables have not been added yet.
    pub(super) fn has_first_tables(&self) -> bool {
        self.probes.iter().all(|probe| probe.tables.len() == TABLES)
    }

    /// Compares all readings with finer tables from now on, those to come among them.
    pub(super) fn add_tables(&mut self) {
        let finer = self.add_finer(NEXT_TABLE, NEXT_TABLES);
        for (probe, mut finer) in self.probes.iter_mut().zip(finer) {
            finer.append(&mut probe.tables);
            probe.tables = finer;
        }
    }

    /// Compares the kept readings with so many finer tables from now on; gives these, from fine to coarse.
    fn add_finer(&mut self, size: (usize, usize), count: usize) -> Vec<Vec<ContactTable>> {
        let whiskers = self.probes.iter().map(|probe| &probe.whisker);
        let all = each_table(whiskers, |whisker| tables(size, count, whisker, &self.options));
        for record in &mut self.records {
            for ((touch, probe), tables) in record.touches.iter_mut().zip(&self.probes).zip(&all) {
                tables.iter().rev().for_each(|table| touch.add_finer(&probe.whisker, table));
            }
        }
        all
    }

    /// The final refinement, when no more rows come: cells meet what is remembered and are bisected, as far as the work goes.
    pub fn finish(&mut self, map: &Map) {
        if self.records.is_empty() {
            return;
        }
        let mut work = self.options.last_work;
        if work > 0 && self.kept.len() >= WORTH_LAST {
            self.add_finer(LAST_TABLE, 1);
        }
        let mut rest = work / REFINE_WORK_SHARE;
        work -= rest;
        let all = work;
        for (stage, (readings, share)) in STAGES.into_iter().enumerate() {
            let mut own = (work as f64 * share) as usize;
            work -= own;
            self.sivia(map, readings, stage + 1 == STAGES.len(), &mut own);
            work += own;
        }
        let (spent, kept) = (all - work, self.kept.len());
        let most = spent.max(REFINE_WORK_PER_READING * kept * kept).min(self.options.last_work / REFINE_WORK_SHARE);
        self.refine_further(map, &mut work.min(most));
        // Of few readings the halves have met all.
        if kept > REFINE_READINGS {
            self.contract_by_kept(map, kept, &mut rest);
        }
    }

    /// Lets every cell meet so many of the kept readings, as far as the work goes.
    fn contract_by_kept(&mut self, map: &Map, readings: usize, work: &mut usize) {
        let all = std::mem::take(&mut self.cells);
        let met = |cell: Parallelotope| {
            if *work > 0 { self.contracted_by_order(map, cell, readings, work) } else { Some(cell) }
        };
        self.cells = all.into_iter().filter_map(met).collect();
    }

    /// Most cells of the final refinement.
    fn last_cells(&self) -> usize {
        (FEW_READINGS_CELLS / self.kept.len().max(1)).max(LAST_CELLS)
    }

    /// Bisects all cells, whatever their size, as long as it pays.
    fn refine_further(&mut self, map: &Map, work: &mut usize) {
        let (finest, readings) = (FINEST * self.options.resolution, REFINE_READINGS.min(self.kept.len()));
        let mut in_vain = 0;
        while *work > 0 && !self.cells.is_empty() && 2 * self.cells.len() <= self.last_cells() {
            let (before, left) = (self.volume(), *work);
            let mut cells = Vec::with_capacity(2 * self.cells.len());
            for cell in std::mem::take(&mut self.cells) {
                let (side, length) = longest(&cell);
                if *work == 0 || length <= finest {
                    cells.push(cell);
                } else {
                    cells.extend(
                        cell.bisected(side)
                            .into_iter()
                            .filter_map(|half| self.contracted_by_order(map, half, readings, work)),
                    );
                }
            }
            self.cells = cells;
            let cost = left - *work;
            let pays = if cost > CHEAP { PAYS } else { CHEAPLY_PAYS };
            in_vain = if self.volume() > pays * before { in_vain + 1 } else { 0 };
            if in_vain == SIDES || (in_vain > 0 && cost > TRIFLE) {
                return;
            }
        }
    }

    /// Lets every cell and every half meet so many of the kept readings; the longest cells are bisected first. It ends when no
    /// cell is longer than the resolution, when that is not worth its while any more, or with the work.
    fn sivia(&mut self, map: &Map, readings: usize, is_last: bool, work: &mut usize) {
        self.cells.iter_mut().for_each(|cell| cell.rest_until = 0);
        let begun = *work;
        self.contract_by_kept(map, readings, work);
        let mut progress = StageProgress::default();
        while *work > 0 {
            let waiting = self.cells.iter().filter(|cell| cell.rest_until == 0);
            let longest_side = waiting.map(|cell| longest(cell).1).fold(0.0, f64::max);
            let (grows, stalls) = progress.note(self.cells.len(), begun - *work, self.volume());
            let is_over = longest_side <= COARSE && (stalls || (grows && !is_last));
            if longest_side <= self.options.resolution || is_over {
                return;
            }
            self.sivia_pass(map, (LARGE * longest_side).max(self.options.resolution), readings, work);
            if self.cells.len() > LARGE_SET && self.has_first_tables() {
                self.add_tables();
            }
        }
    }

    /// Bisects every cell longer than this, as far as the work goes, gain or not: what two bisections rule out, one may not.
    fn sivia_pass(&mut self, map: &Map, limit: f64, most: usize, work: &mut usize) {
        let mut room = self.options.most_cells.max(self.last_cells()).saturating_sub(self.cells.len());
        if room == 0 {
            // In place: there may be hundreds of thousands.
            let long = self.cells.iter_mut().filter(|cell| cell.rest_until == 0 && longest(cell).1 > limit);
            long.for_each(|cell| cell.rest_until = u32::MAX);
            return;
        }
        let all = std::mem::take(&mut self.cells);
        let mut cells = Vec::with_capacity(all.len());
        for mut cell in all {
            let (side, length) = longest(&cell);
            if *work == 0 || cell.rest_until > 0 || length <= limit {
                cells.push(cell);
            } else if room == 0 {
                cell.rest_until = u32::MAX;
                cells.push(cell);
            } else {
                let before = cells.len();
                cells.extend(
                    cell.bisected(side).into_iter().filter_map(|half| self.contracted_by_order(map, half, most, work)),
                );
                room = room + 1 - (cells.len() - before).min(room + 1);
            }
        }
        self.cells = cells;
    }
}

/// How a stage of the final refinement gets on, by counts alone.
#[derive(Default)]
pub(super) struct StageProgress {
    /// The fewest cells so far.
    fewest: Option<usize>,
    /// Work done and volume left (m² rad).
    marks: Vec<(usize, f64)>,
}

impl StageProgress {
    /// Notes cells, work done and volume left; whether the cells grow in number, and whether the volume no longer shrinks.
    pub(super) fn note(&mut self, cells: usize, done: usize, volume: f64) -> (bool, bool) {
        let fewest = self.fewest.map_or(cells, |fewest| fewest.min(cells));
        self.fewest = Some(fewest);
        let halfway = self.marks.iter().rev().find(|&&(earlier, _)| earlier <= done / 2);
        let stalls = done > STALLED_AFTER && halfway.is_some_and(|&(_, before)| volume > STALLED * before);
        self.marks.push((done, volume));
        (cells as f64 > GROWN * fewest as f64, stalls)
    }
}

/// Whether what is left of the halves is worth taking the place of the whole.
fn is_gain(whole: &Parallelotope, halves: &[Parallelotope]) -> bool {
    halves.len() < 2 || halves.iter().map(Parallelotope::volume).sum::<f64>() < GAIN * whole.volume()
}

/// A step that visits all of so many readings before it comes back.
fn stride(count: usize) -> usize {
    let share = |a: usize, b: usize| {
        let (mut a, mut b) = (a, b);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let least = ((count as f64 * STRIDE) as usize).max(1);
    (least..least + count).find(|&step| share(step, count) == 1).unwrap_or(1)
}

/// The longest side of a cell and its length (m).
fn longest(cell: &Parallelotope) -> (usize, f64) {
    let mut best = (0, cell.length(0));
    for side in 1..3 {
        let length = cell.length(side);
        if length > best.1 {
            best = (side, length);
        }
    }
    best
}
