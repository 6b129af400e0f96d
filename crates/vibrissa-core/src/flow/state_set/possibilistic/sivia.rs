//! SIVIA \[jaulin2001applied, ch. 3\] with a bounded amount of work for each row: which cell meets which reading, and bisection.

use super::agenda::Task;
use super::contact_tables::TABLES;
use super::parallelotope::Parallelotope;
use super::{CHECK_BASE_EVERY, FIRST_WORK_FACTOR, PossibleSet};
use crate::WorkBudget;
use crate::world::Map;

/// Most of the kept readings that a new half meets at once.
const READINGS_AT_ONCE: usize = 4;
/// Bisection is worth its while when the halves together are smaller than the whole by this.
const GAIN: f64 = 0.8;
/// Cells longer than this are bisected in any case (m).
pub(super) const COARSE: f64 = 6e-3;
/// A cell that a reading leaves larger than this share of it is stuck.
const STUCK: f64 = 0.9;
/// Cells are bisected once the robot has moved this far from the first contact (m): before, readings tell little apart.
const FIRST_WAY: f64 = 5e-3;
/// In the final refinement cells longer than this share of the longest are bisected in one go: the large ones come first.
pub(super) const LARGE: f64 = 0.7;
/// Stages of the final refinement: how many of the kept readings a half meets, and the share of the work left.
pub(super) const STAGES: [(usize, f64); 3] = [(4, 0.5), (16, 0.5), (32, 1.0)];
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
pub(super) const LARGE_SET: usize = 2_000;
/// Beyond the resolution all cells are bisected as long as that leaves less than this share of their volume, down to this
/// share of the resolution: how large the cover is must be the set's doing, not that of the way to it. Where that took no
/// more than so much work, less will do.
pub(super) const PAYS: f64 = 0.9;
pub(super) const CHEAP: usize = 20_000;
pub(super) const CHEAPLY_PAYS: f64 = 0.97;
/// Where it took no more than this (a millisecond), it ends only after as many bisections in vain as a cell has sides: what two of
/// them rule out, one may not.
pub(super) const TRIFLE: usize = 2_000;
pub(super) const SIDES: usize = 3;
pub(super) const FINEST: f64 = 1.0 / 32.0;
/// One part in so many of the last work may go into that, but no more than went into the bisection before or into so many halves
/// for each kept reading, squared: few readings leave little to gain. Each half meets so many of the kept readings, and what is
/// left at the end meets all of them, for which one part in so many of the work is kept.
pub(super) const REFINE_WORK_SHARE: usize = 8;
pub(super) const REFINE_WORK_PER_READING: usize = 10;
pub(super) const REFINE_READINGS: usize = 24;
/// Kept readings are met in steps of this share of all of them, which spreads any number of them.
const STRIDE: f64 = 0.618_033_988_75;
/// Cells that are bisected in one row when there is little work for each.
const AT_ONCE: usize = 4;
/// Longest rest between two attempts at bisection (records).
const LONGEST_REST: u16 = 512;

impl PossibleSet {
    /// Lets the newest record meet the cells, in turn, as far as the row's work goes; wide cells are bisected at once,
    /// and what is left is spent on bisecting the others. Whether that is done.
    pub(super) fn take_turns(&mut self, map: &Map, turns: &mut Turns, budget: &mut WorkBudget) -> bool {
        while turns.left > 0 && turns.work > 0 {
            if budget.is_spent() {
                return false;
            }
            let before = turns.work;
            self.take_turn(map, turns);
            budget.spend(1 + before - turns.work);
        }
        if turns.left == 0 {
            let bisection = Bisection::new(self, turns.work);
            self.agenda.push(Task::Bisection(Box::new(bisection)));
        }
        true
    }

    fn take_turn(&mut self, map: &Map, turns: &mut Turns) {
        let newest = self.records.len() as u32 - 1;
        let work = &mut turns.work;
        turns.left -= 1;
        self.untried = self.untried.saturating_sub(1);
        if self.cursor >= self.cells.len() {
            self.cursor = 0;
        }
        let cell = self.cells[self.cursor];
        let look = cell.is_fresh || (newest / CHECK_BASE_EVERY) != (cell.seen / CHECK_BASE_EVERY);
        let kept = self.contracted_by(map, cell, newest, look, work);
        let Some(kept) = kept.and_then(|cell| self.contracted_by_first(map, cell, work)) else {
            return self.drop();
        };
        self.cells[self.cursor] = kept;
        let (side, length) = longest(&kept);
        let stuck = length > COARSE && kept.volume() > STUCK * cell.volume();
        if stuck && self.cells.len() < self.options.most_cells && self.way_since_start() > FIRST_WAY {
            let [a, b] = kept.bisected(side);
            let [a, b] = [a, b].map(|half| self.contracted_by_order(map, half, READINGS_AT_ONCE, work));
            match (a, b) {
                (Some(a), Some(b)) => {
                    self.cells[self.cursor] = a;
                    self.cells.push(b);
                }
                (Some(one), None) | (None, Some(one)) => self.cells[self.cursor] = one,
                (None, None) => return self.drop(),
            }
        }
        self.cursor += 1;
    }

    /// Drops the cell whose turn it is; the last cell takes its place.
    fn drop(&mut self) {
        self.cells.swap_remove(self.cursor);
    }

    /// The robot's way since the first cells (m).
    fn way_since_start(&self) -> f64 {
        let at = |record: usize| self.records[record].stand.path();
        at(self.records.len() - 1) - at(self.started_at as usize)
    }

    /// Bisects the longest cells and lets the halves meet some of what is remembered; whether that is done.
    pub(super) fn bisect_some(&mut self, map: &Map, bisection: &mut Bisection, budget: &mut WorkBudget) -> bool {
        let newest = self.records.len() as u32 - 1;
        let Bisection { work, order, at, recalled, gone, born } = bisection;
        let cost = 2 * (*recalled + 1);
        while let Some(&index) = order.get(*at) {
            if *work < cost || self.cells.len() + born.len() >= self.options.most_cells + gone.len() {
                break;
            }
            if budget.is_spent() {
                return false;
            }
            *at += 1;
            let (cell, before) = (self.cells[index], *work);
            let (side, length) = longest(&cell);
            let halves: Vec<Parallelotope> = cell
                .bisected(side)
                .into_iter()
                .filter_map(|half| self.contracted_by_order(map, half, *recalled, work))
                .collect();
            budget.spend(1 + before - *work);
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
        for &index in gone.iter().rev() {
            self.cells.swap_remove(index);
        }
        self.cells.append(born);
        true
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
        let foremost = self.constraint_order.last().filter(|_| count > 0);
        let mut next = foremost;
        for k in 0..=most.min(count) {
            // It need not be met again in its turn.
            let record = next.filter(|_| k == 0 || next != foremost);
            next = if k < told {
                self.constraint_order.at(k)
            } else if k < most.min(count) {
                self.kept.get(first + (start + k * stride) % count).copied()
            } else {
                None
            };
            let Some(record) = record else { continue };
            // Where a robot has gone through a wall between two contacts its base tells.
            let Some(left) = self.contracted_by(map, cell, record, true, work) else {
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

    /// The final refinement, when no more rows come: cells meet what is remembered and are bisected, as far as the work goes.
    pub fn finish(&mut self, map: &Map) {
        self.begin_last_effort();
        self.advance(map, &mut WorkBudget::unlimited());
    }

    /// Most cells of the final refinement.
    pub(super) fn last_cells(&self) -> usize {
        (FEW_READINGS_CELLS / self.kept.len().max(1)).max(LAST_CELLS)
    }

    /// A pass that bisects every cell longer than this, as far as the work goes, gain or not: what two bisections rule out, one may
    /// not. None where there is no room for more cells.
    pub(super) fn longer_than(&mut self, limit: f64, readings: usize) -> Option<CellPass> {
        let room = self.options.most_cells.max(self.last_cells()).saturating_sub(self.cells.len());
        if room == 0 {
            // In place: there may be hundreds of thousands.
            let long = self.cells.iter_mut().filter(|cell| cell.rest_until == 0 && longest(cell).1 > limit);
            long.for_each(|cell| cell.rest_until = u32::MAX);
            return None;
        }
        Some(CellPass { kind: PassKind::Longer { limit, room }, readings, at: 0, kept: 0, cells: Vec::new() })
    }

    /// Goes on with a pass; whether it has gone over all cells.
    pub(super) fn pass_some(
        &mut self,
        map: &Map,
        pass: &mut CellPass,
        work: &mut usize,
        budget: &mut WorkBudget,
    ) -> bool {
        while pass.at < self.cells.len() {
            if budget.is_spent() {
                return false;
            }
            let before = *work;
            self.pass_cell(map, pass, work);
            pass.at += 1;
            budget.spend(1 + before - *work);
        }
        match pass.kind {
            PassKind::All => self.cells.truncate(pass.kept),
            _ => self.cells = std::mem::take(&mut pass.cells),
        }
        true
    }

    fn pass_cell(&mut self, map: &Map, pass: &mut CellPass, work: &mut usize) {
        let mut cell = self.cells[pass.at];
        let (side, length) = longest(&cell);
        let readings = pass.readings;
        match &mut pass.kind {
            PassKind::All => {
                let met = if *work > 0 { self.contracted_by_order(map, cell, readings, work) } else { Some(cell) };
                if let Some(met) = met {
                    // In place: what is passed lies behind.
                    self.cells[pass.kept] = met;
                    pass.kept += 1;
                }
            }
            PassKind::Halves { finest } if *work == 0 || length <= *finest => pass.cells.push(cell),
            PassKind::Longer { limit, .. } if *work == 0 || cell.rest_until > 0 || length <= *limit => {
                pass.cells.push(cell);
            }
            PassKind::Longer { room: 0, .. } => {
                cell.rest_until = u32::MAX;
                pass.cells.push(cell);
            }
            kind => {
                let halves = cell.bisected(side).into_iter();
                let before = pass.cells.len();
                pass.cells.extend(halves.filter_map(|half| self.contracted_by_order(map, half, readings, work)));
                if let PassKind::Longer { room, .. } = kind {
                    *room = *room + 1 - (pass.cells.len() - before).min(*room + 1);
                }
            }
        }
    }
}

/// The newest record on its way around the cells: turns and work that are left.
#[derive(Clone, Debug)]
pub(super) struct Turns {
    left: usize,
    work: usize,
}

impl Turns {
    /// A turn for each cell, and the work of a row.
    pub(super) fn new(set: &PossibleSet) -> Self {
        let factor = if set.untried > 0 { FIRST_WORK_FACTOR } else { 1 };
        Self { left: set.cells.len(), work: set.options.work * factor }
    }
}

/// The bisection of the longest cells: in which order, and what has come of it.
#[derive(Clone, Debug)]
pub(super) struct Bisection {
    work: usize,
    order: Vec<usize>,
    at: usize,
    /// How many of the kept readings a half meets.
    recalled: usize,
    gone: Vec<usize>,
    born: Vec<Parallelotope>,
}

impl Bisection {
    fn new(set: &PossibleSet, work: usize) -> Self {
        let newest = set.records.len() as u32 - 1;
        let mut order: Vec<usize> = (0..set.cells.len()).filter(|&i| set.may_bisect(&set.cells[i], newest)).collect();
        order.sort_by(|&a, &b| longest(&set.cells[b]).1.total_cmp(&longest(&set.cells[a]).1).then(a.cmp(&b)));
        // Few cells can be compared with much that is remembered, many with little.
        let most = set.kept.len().max(READINGS_AT_ONCE);
        let recalled = (work / 2 / order.len().clamp(1, AT_ONCE)).clamp(READINGS_AT_ONCE, most);
        Self { work, order, at: 0, recalled, gone: Vec::new(), born: Vec::new() }
    }
}

/// A pass over all cells.
#[derive(Clone, Debug)]
pub(super) struct CellPass {
    kind: PassKind,
    /// How many of the kept readings a cell or a half meets.
    readings: usize,
    at: usize,
    /// Cells that are kept in place, or the new ones.
    kept: usize,
    cells: Vec<Parallelotope>,
}

#[derive(Clone, Debug)]
enum PassKind {
    /// Each cell meets readings.
    All,
    /// Cells longer than this are bisected, as long as there is room for more.
    Longer { limit: f64, room: usize },
    /// Cells longer than this are bisected.
    Halves { finest: f64 },
}

impl CellPass {
    /// Each cell meets so many of the kept readings.
    pub(super) fn all(readings: usize) -> Self {
        Self { kind: PassKind::All, readings, at: 0, kept: 0, cells: Vec::new() }
    }

    /// All cells that are longer than `finest` are bisected.
    pub(super) fn halves(finest: f64, readings: usize) -> Self {
        Self { kind: PassKind::Halves { finest }, ..Self::all(readings) }
    }
}

/// How a stage of the final refinement gets on, by counts alone.
#[derive(Clone, Debug, Default)]
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
pub(super) fn longest(cell: &Parallelotope) -> (usize, f64) {
    let mut best = (0, cell.length(0));
    for side in 1..3 {
        let length = cell.length(side);
        if length > best.1 {
            best = (side, length);
        }
    }
    best
}
