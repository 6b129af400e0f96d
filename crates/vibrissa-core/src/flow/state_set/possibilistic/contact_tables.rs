//! The tables of contacts that readings are sliced from: how fine, for which whisker, and one for all alike.

use super::PossibleSet;
use super::errors::UncertainWhisker;
use crate::WorkBudget;
use crate::beam::press::{ContactTable, LeaningPressTable, PressTable, PressTableBuilder, RodContacts};
use crate::config::PossibilisticOptions;
use crate::math;
use crate::world::Lean;

/// Columns (a quarter turn) and rows of the tables that first cells meet, from fine to coarse: each has half as many of both
/// as the one before.
pub(super) const FIRST_TABLE: (usize, usize) = (16, 32);
pub(super) const TABLES: usize = 2;
/// Cells are born from this one of them.
pub(super) const START_TABLE: usize = 1;
/// The same of finer ones, which are added when so many readings since the first contact are remembered: few readings leave
/// more open than coarse tables do.
pub(super) const NEXT_TABLE: (usize, usize) = (64, 64);
pub(super) const NEXT_TABLES: usize = 2;
pub(super) const WORTH_NEXT: usize = 10;
/// The same of the table that the final refinement adds where this many readings are remembered: a twentieth of a second to build.
pub(super) const LAST_TABLE: (usize, usize) = (128, 96);
pub(super) const WORTH_LAST: usize = 20;
/// What patches of the tables of rods leave, over the length and times the columns, and how much more in the next coarser ones:
/// patches are counted by its inverse.
const ROD_WIDTH: f64 = 0.3;
const ROD_COARSER: f64 = 2.5;
/// What those of the last table leave, over the length.
const ROD_LAST_WIDTH: f64 = 1.5e-3;
const ROD_FINE: usize = 32;

/// What each whisker needs, made once for those of the same friction, if they are uniform: tables know of those no more.
pub(super) fn each_table<'a>(
    whiskers: impl Iterator<Item = &'a UncertainWhisker>,
    make: impl Fn(&UncertainWhisker) -> Vec<ContactTable>,
) -> Vec<Vec<ContactTable>> {
    let mut made: Vec<(&UncertainWhisker, Vec<ContactTable>)> = Vec::new();
    for whisker in whiskers {
        let same = made.iter().find(|(other, _)| alike(whisker, other)).map(|(_, tables)| tables.clone());
        made.push((whisker, same.unwrap_or_else(|| make(whisker))));
    }
    made.into_iter().map(|(_, tables)| tables).collect()
}

/// Whether the tables of one whisker are those of another: tables of uniform ones know of friction and lean alone.
fn alike(one: &UncertainWhisker, other: &UncertainWhisker) -> bool {
    let bits = |whisker: &UncertainWhisker| {
        let Lean { elevation, roll } = whisker.lean;
        [whisker.friction, elevation, roll].map(f64::to_bits)
    };
    one.rod.is_none() && other.rod.is_none() && bits(one) == bits(other)
}

/// Tables of a whisker, from fine to coarse: so many, the first with `columns` and `rows`.
pub(super) fn tables(
    (columns, rows): (usize, usize),
    count: usize,
    whisker: &UncertainWhisker,
    options: &PossibilisticOptions,
) -> Vec<ContactTable> {
    if let Some(rod) = &whisker.rod {
        let mut contacts = (**rod).clone();
        contacts.refine(rod_fineness(columns).1);
        return rod_tables(&contacts, columns, count);
    }
    let finest = PressTable::new(columns, rows, math::atan(whisker.friction), options.largest_slope);
    let all = core::iter::successors(Some(finest), |table| Some(table.coarser())).take(count);
    if whisker.lean.is_level() {
        return all.map(ContactTable::from).collect();
    }
    let Lean { elevation, roll } = whisker.lean;
    let of = |(k, table)| ContactTable::from(LeaningPressTable::new(table, elevation, roll, columns >> k));
    all.enumerate().map(of).collect()
}

/// Columns of the finest table of a rod, and what its patches leave.
fn rod_fineness(columns: usize) -> (usize, f64) {
    // Patches are many: the finest tables are half as fine as those of uniform whiskers.
    let columns = if columns > ROD_FINE { columns / 2 } else { columns };
    // The patches of the last table end the refinement, and are cut once.
    let is_last = columns == LAST_TABLE.0 / 2;
    (columns, if is_last { ROD_LAST_WIDTH } else { ROD_WIDTH / columns as f64 })
}

/// The tables of a rod whose patches are as fine as the finest of them needs.
fn rod_tables(contacts: &RodContacts, columns: usize, count: usize) -> Vec<ContactTable> {
    let (columns, width) = rod_fineness(columns);
    let table = |k: usize| contacts.table(columns >> k, width * ROD_COARSER.powi(k as i32));
    (0..count).map(|k| ContactTable::Rod(table(k))).collect()
}

/// What the tables of a rod or of a leaning whisker cost, once a rod's patches are fine enough, and the comparison of a reading with a table, of a
/// uniform whisker or of a rod.
const ROD_COST: usize = 5_000;
const COMPARISON_COST: usize = 100;
const ROD_COMPARISON_COST: usize = 1000;

/// What it costs to compare a reading of a whisker with a table.
pub(super) fn comparison_cost(whisker: &UncertainWhisker) -> usize {
    if whisker.rod.is_some() { ROD_COMPARISON_COST } else { COMPARISON_COST }
}

/// Bisections of a rod's patches at once, and what one costs.
const BISECTED: usize = 16;
const BISECTION_COST: usize = 500;
/// What it costs to copy a table, or to make one of one that is twice as fine.
const COPY_COST: usize = 600;

/// Finer tables in the making, and how many of the records have been compared with them.
#[derive(Clone, Debug)]
pub(super) struct FinerTables {
    size: (usize, usize),
    count: usize,
    /// Whether readings to come are compared with them, too.
    stay: bool,
    builder: Option<PressTableBuilder>,
    /// Those that are made of the whisker whose turn it is, or its patches.
    chain: Vec<PressTable>,
    rod: Option<Box<RodContacts>>,
    /// Those of the first whiskers.
    made: Vec<Vec<ContactTable>>,
    compared: usize,
}

impl FinerTables {
    /// So many tables, the first with `size` columns and rows, before any work.
    pub(super) fn new(size: (usize, usize), count: usize, stay: bool) -> Self {
        Self { size, count, stay, builder: None, chain: Vec::new(), rod: None, made: Vec::new(), compared: 0 }
    }

    /// Makes a part of the tables of the next of the whiskers.
    fn make_some(&mut self, whiskers: &[&UncertainWhisker], options: &PossibilisticOptions, budget: &mut WorkBudget) {
        let whisker = whiskers[self.made.len()];
        let same = whiskers[..self.made.len()].iter().position(|other| alike(whisker, other));
        if let Some(same) = same {
            self.made.push(self.made[same].clone());
            return budget.spend(COPY_COST * self.count);
        }
        let (columns, rows) = self.size;
        if let Some(rod) = &whisker.rod {
            let contacts = self.rod.get_or_insert_with(|| Box::new((**rod).clone()));
            let done = contacts.refine_some(rod_fineness(columns).1, BISECTED);
            if done == BISECTED {
                return budget.spend(BISECTION_COST * done);
            }
            self.made.push(rod_tables(contacts, columns, self.count));
            self.rod = None;
            return budget.spend(ROD_COST);
        }
        if !whisker.lean.is_level() {
            self.made.push(tables(self.size, self.count, whisker, options));
            return budget.spend(ROD_COST);
        }
        // The finest by parts, then one coarser table after the other.
        if let Some(finer) = self.chain.last() {
            if self.chain.len() == self.count {
                let chain = std::mem::take(&mut self.chain);
                return self.made.push(chain.into_iter().map(ContactTable::from).collect());
            }
            let coarser = finer.coarser();
            self.chain.push(coarser);
            return budget.spend(COPY_COST);
        }
        let new = || PressTableBuilder::new(columns, rows, math::atan(whisker.friction), options.largest_slope);
        let looked_at = self.builder.get_or_insert_with(new).advance();
        if looked_at > 0 {
            budget.spend(looked_at);
        } else if let Some(builder) = self.builder.take() {
            self.chain.push(builder.finish());
            budget.spend(COPY_COST);
        }
    }
}

impl PossibleSet {
    /// Goes on with the making of tables and compares the kept readings with them; whether that is done.
    pub(super) fn add_some_tables(&mut self, finer: &mut FinerTables, budget: &mut WorkBudget) -> bool {
        let whiskers: Vec<&UncertainWhisker> = self.probes.iter().map(|probe| &probe.whisker).collect();
        while finer.made.len() < whiskers.len() {
            if budget.is_spent() {
                return false;
            }
            finer.make_some(&whiskers, &self.options, budget);
        }
        while let Some(record) = self.records.get_mut(finer.compared) {
            if budget.is_spent() {
                return false;
            }
            finer.compared += 1;
            for ((touch, probe), tables) in record.touches.iter_mut().zip(&self.probes).zip(&finer.made) {
                tables.iter().rev().for_each(|table| touch.add_finer(&probe.whisker, table));
                budget.spend(comparison_cost(&probe.whisker) * tables.len());
            }
        }
        if finer.stay {
            for (probe, mut finer) in self.probes.iter_mut().zip(std::mem::take(&mut finer.made)) {
                finer.append(&mut probe.tables);
                probe.tables = finer;
            }
        }
        true
    }
}
