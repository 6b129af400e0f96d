//! What a set still has to do, so that it can pause in between: a stack of tasks, the one that comes next on top.
//!
//! Between two calls the cells enclose all that explains the readings so far: a task that makes a new list leaves the old one
//! in place until it is whole.

use super::contact_tables::{
    FinerTables, LAST_TABLE, NEXT_TABLE, NEXT_TABLES, WORTH_LAST, WORTH_NEXT, comparison_cost,
};
use super::initial_cover::InitialCover;
use super::last_effort::LastEffort;
use super::record::ReadingContacts;
use super::sivia::{Bisection, Turns};
use super::{LogRecord, PossibleSet};
use crate::WorkBudget;
use crate::sets::Interval;
use crate::world::Map;

/// What a cell at the end costs beside its meetings (as so many of them): it is gone over, drawn and measured several times.
const LAST_CELL_COST: usize = 6;
/// The readings of a row, and how far the robot may have been when they were taken.
#[derive(Clone, Debug)]
pub(super) struct RowReading {
    moments: Vec<Interval>,
    heading: Option<Interval>,
    late: (f64, f64),
}

/// A piece of work that can pause.
#[derive(Clone, Debug)]
pub(super) enum Task {
    /// Finer tables for the readings that are kept.
    Tables(Box<FinerTables>),
    /// The readings of the row that comes next become a record.
    Record(RowReading),
    /// The first cells.
    Cover(Box<InitialCover>),
    /// The newest record meets the cells in turn.
    Turns(Turns),
    /// The longest cells are bisected.
    Bisection(Box<Bisection>),
    /// The final refinement.
    LastEffort(Box<LastEffort>),
}

impl PossibleSet {
    /// As [`PossibleSet::read`], but for the work, which [`PossibleSet::advance`] does.
    pub(crate) fn begin_reading(&mut self, moments: &[Interval], heading: Option<Interval>, late: (f64, f64)) {
        if self.ahead.is_empty() {
            return;
        }
        self.forget();
        self.agenda.push(Task::Record(RowReading { moments: moments.to_vec(), heading, late }));
        if self.has_first_tables() && self.kept_since_start() >= WORTH_NEXT {
            self.begin_tables();
        }
    }

    /// What of the final refinement's work the cells take beside their meetings.
    pub(crate) fn cost_of_cells(&self) -> usize {
        LAST_CELL_COST * self.cells.len()
    }

    /// As [`PossibleSet::finish`], but for the work.
    pub(crate) fn begin_last_effort(&mut self) {
        let work = self.options.last_work.saturating_sub(self.cost_of_cells());
        if self.records.is_empty() || work == 0 {
            self.is_cut_short = self.options.last_work > 0 && !self.cells.is_empty();
            return;
        }
        self.agenda.push(Task::LastEffort(Box::new(LastEffort::new(work))));
        if self.kept.len() >= WORTH_LAST {
            self.agenda.push(Task::Tables(Box::new(FinerTables::new(LAST_TABLE, 1, false))));
        }
    }

    /// Goes on with what was begun, as far as the budget goes; whether all of it is done.
    pub(crate) fn advance(&mut self, map: &Map, budget: &mut WorkBudget) -> bool {
        while let Some(mut task) = self.agenda.pop() {
            // What a task asks for first comes on top of it.
            let at = self.agenda.len();
            let is_done = match &mut task {
                // Finer tables only refine.
                Task::Tables(_) if self.stop.is_asked() => true,
                Task::Tables(tables) => self.add_some_tables(tables, budget),
                Task::Record(reading) => {
                    budget.spend(self.probes.iter().map(|probe| comparison_cost(&probe.whisker)).sum());
                    self.add_record(reading);
                    true
                }
                Task::Cover(cover) => self.lay_some(map, cover, budget),
                Task::Turns(turns) => self.take_turns(map, turns, budget),
                Task::Bisection(bisection) => self.bisect_some(map, bisection, budget),
                Task::LastEffort(effort) => self.refine_some(map, effort, budget),
            };
            if !is_done {
                self.agenda.insert(at, task);
            }
            if budget.is_spent() {
                return self.agenda.is_empty();
            }
        }
        true
    }

    /// Begins with finer tables for all readings, those to come among them.
    pub(super) fn begin_tables(&mut self) {
        self.agenda.push(Task::Tables(Box::new(FinerTables::new(NEXT_TABLE, NEXT_TABLES, true))));
    }

    /// Notes a row; it then lays the first cells, or meets them.
    fn add_record(&mut self, reading: &RowReading) {
        let Some(stand) = self.ahead.pop_front() else { return };
        let late = self.odometry.at_most(reading.late);
        let moments = &reading.moments;
        // Readings that may be none are worth nothing before the set starts, unless they are remembered.
        let idle = !self.has_started() && moments.iter().all(|m| m.contains(0.0));
        let touches = if idle && !self.is_apart(stand.path()) {
            Vec::new()
        } else {
            let touch = |(probe, m): (&super::TabledWhisker, &Interval)| {
                ReadingContacts::new(&probe.whisker, &probe.tables, m.lo(), m.hi())
            };
            self.probes.iter().zip(moments).map(touch).collect()
        };
        self.records.push(LogRecord { stand, touches, heading: reading.heading, late });
        if self.has_started() {
            self.begin_turns();
        } else {
            self.agenda.push(Task::Cover(Box::new(InitialCover::new(moments))));
        }
    }

    /// Lets the newest record meet the cells.
    pub(super) fn begin_turns(&mut self) {
        let turns = Turns::new(self);
        self.agenda.push(Task::Turns(turns));
    }
}
