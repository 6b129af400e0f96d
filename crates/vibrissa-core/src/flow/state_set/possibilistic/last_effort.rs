//! The final refinement, when no more rows come: cells meet what is remembered and are bisected, as far as the work goes.

use super::PossibleSet;
use super::sivia::{
    CHEAP, CHEAPLY_PAYS, COARSE, CellPass, FINEST, LARGE, LARGE_SET, PAYS, REFINE_READINGS, REFINE_WORK_PER_READING,
    REFINE_WORK_SHARE, SIDES, STAGES, StageProgress, TRIFLE, longest,
};
use crate::WorkBudget;
use crate::world::Map;

/// Where the refinement stands, and what is left of its work.
#[derive(Clone, Debug)]
pub(super) struct LastEffort {
    next: Next,
    /// The pass over the cells that is going on.
    pass: Option<CellPass>,
    /// Work for the stages, for all kept readings at the end, and for the stage or the bisection that is going on.
    work: usize,
    rest: usize,
    own: usize,
    /// Work for the stages, and for this stage, at their beginnings.
    all: usize,
    begun: usize,
    progress: StageProgress,
    /// Volume and work before a pass of further bisection, and how many of these were in vain.
    before: (f64, usize),
    in_vain: usize,
}

/// What comes after the pass that is going on.
#[derive(Clone, Copy, Debug)]
enum Next {
    /// A stage begins: all cells meet some readings.
    Stage(usize),
    /// In a stage the longest cells are bisected.
    Longest(usize),
    /// Finer tables may be worth it.
    Tables(usize),
    /// All cells are bisected, as long as it pays.
    Further,
    /// Whether it did.
    Pays,
    /// What is left meets all readings.
    Rest,
    Done,
}

impl LastEffort {
    /// Before the first pass, with so much work.
    pub(super) fn new(work: usize) -> Self {
        let rest = work / REFINE_WORK_SHARE;
        Self {
            next: Next::Stage(0),
            pass: None,
            work: work - rest,
            all: work - rest,
            rest,
            own: 0,
            begun: 0,
            progress: StageProgress::default(),
            before: (0.0, 0),
            in_vain: 0,
        }
    }
}

impl PossibleSet {
    /// Goes on with the refinement; whether it is done. It pauses, too, where tables are to be added first.
    pub(super) fn refine_some(&mut self, map: &Map, effort: &mut LastEffort, budget: &mut WorkBudget) -> bool {
        loop {
            if let Some(mut pass) = effort.pass.take() {
                let work = if matches!(effort.next, Next::Done) { &mut effort.rest } else { &mut effort.own };
                if !self.pass_some(map, &mut pass, work, budget) {
                    effort.pass = Some(pass);
                    return false;
                }
            }
            if budget.is_spent() {
                return false;
            }
            let pending = self.agenda.len();
            match effort.next {
                Next::Stage(stage) => self.begin_stage(effort, stage),
                Next::Longest(stage) => self.begin_longest(effort, stage),
                Next::Tables(stage) => {
                    effort.next = Next::Longest(stage);
                    if self.cells.len() > LARGE_SET && self.has_first_tables() {
                        self.begin_tables();
                    }
                }
                Next::Further => self.begin_further(effort),
                Next::Pays => self.judge_further(effort),
                Next::Rest => {
                    effort.next = Next::Done;
                    // Of few readings the halves have met all.
                    let kept = self.kept.len();
                    effort.pass = (kept > REFINE_READINGS).then(|| CellPass::all(kept));
                }
                Next::Done => return true,
            }
            if self.agenda.len() > pending {
                return false;
            }
        }
    }

    fn begin_stage(&mut self, effort: &mut LastEffort, stage: usize) {
        let Some((readings, share)) = STAGES.get(stage).copied() else {
            self.is_cut_short = effort.work == 0 && !self.stop.is_asked();
            let (spent, kept) = (effort.all - effort.work, self.kept.len());
            let least = REFINE_WORK_PER_READING * kept * kept;
            let most = spent.max(least).min(self.options.last_work / REFINE_WORK_SHARE);
            effort.own = effort.work.min(most);
            effort.next = Next::Further;
            return;
        };
        effort.own = (effort.work as f64 * share) as usize;
        effort.work -= effort.own;
        self.cells.iter_mut().for_each(|cell| cell.rest_until = 0);
        (effort.begun, effort.progress) = (effort.own, StageProgress::default());
        effort.pass = Some(CellPass::all(readings));
        effort.next = Next::Longest(stage);
    }

    /// The longest cells are bisected first. A stage ends when no cell is longer than the resolution, when that is not worth its
    /// while any more, or with the work.
    fn begin_longest(&mut self, effort: &mut LastEffort, stage: usize) {
        let is_last = stage + 1 == STAGES.len();
        if effort.own > 0 {
            let waiting = self.cells.iter().filter(|cell| cell.rest_until == 0);
            let longest_side = waiting.map(|cell| longest(cell).1).fold(0.0, f64::max);
            let done = effort.begun - effort.own;
            let (grows, stalls) = effort.progress.note(self.cells.len(), done, self.volume());
            let is_over = longest_side <= COARSE && (stalls || (grows && !is_last));
            if longest_side > self.options.resolution && !is_over {
                let limit = (LARGE * longest_side).max(self.options.resolution);
                effort.pass = self.longer_than(limit, STAGES[stage].0);
                effort.next = Next::Tables(stage);
                return;
            }
        }
        effort.work += effort.own;
        effort.next = Next::Stage(stage + 1);
    }

    /// Bisects all cells, whatever their size.
    fn begin_further(&mut self, effort: &mut LastEffort) {
        if effort.own == 0 || self.cells.is_empty() || 2 * self.cells.len() > self.last_cells() {
            effort.next = Next::Rest;
            return;
        }
        effort.before = (self.volume(), effort.own);
        let finest = FINEST * self.options.resolution;
        effort.pass = Some(CellPass::halves(finest, REFINE_READINGS.min(self.kept.len())));
        effort.next = Next::Pays;
    }

    /// Whether further bisection goes on.
    fn judge_further(&self, effort: &mut LastEffort) {
        let (volume, left) = effort.before;
        let cost = left - effort.own;
        let pays = if cost > CHEAP { PAYS } else { CHEAPLY_PAYS };
        effort.in_vain = if self.volume() > pays * volume { effort.in_vain + 1 } else { 0 };
        let ends = effort.in_vain == SIDES || (effort.in_vain > 0 && cost > TRIFLE);
        effort.next = if ends { Next::Rest } else { Next::Further };
    }
}
