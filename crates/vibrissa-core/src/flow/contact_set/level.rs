//! Curves of equal reading on a contact sheet.
//!
//! A curve passes between knots that read less and knots that read more. It is followed from cell to cell, every branch and
//! every loop that the knots can see; then contacts at equal distances along it are brought to the reading by Newton's method
//! on the sheet's own polynomials.

use super::family::{PROBES, stepped};
use super::{Contact, ContactModel};
use crate::beam::field::{BLOCK, ContactSheet, Read, SheetCell, SheetContact};
use crate::plane::Vec2;
use fearless_simd::{Simd, dispatch};
use std::cell::Cell as Slot;

/// Most Newton steps to the reading; the last one is at most `LAST_STEP` of a cell long and leaves at most `LEFT`.
const STEPS: usize = 10;
const LAST_STEP: f64 = 0.25;
const LEFT: f64 = 1e-4;
/// How far out of its cell a place may be, as a share, before the next cell takes it.
const OUT: f64 = 0.1;

/// The piece of a curve within one cell: its ends, in shares of the cell, and how far along the curve it starts (m).
#[derive(Clone, Copy, Debug)]
struct LevelSegment {
    cell: SheetCell,
    from: [f64; 2],
    to: [f64; 2],
    start: f64,
    length: f64,
    /// One over the length; 0 where there is none.
    per_length: f64,
}

/// Where a value lies between knots: bits for each row of knots.
struct Crossings<'a> {
    sheet: &'a ContactSheet,
    readings: &'a [f64],
    read: Read,
    value: f64,
    /// The cells of a row in which the value can be read in the first mode.
    side: u128,
    /// Between a knot and the next one along the loads; bit `j` is the edge from column `j`.
    across: Vec<u128>,
    /// Between a knot and the next one along the whisker.
    along: Vec<u128>,
}

/// An edge of a cell by its number around it: 0 at the start of the whisker's share, 1 at the end of the load's, 2 and 3 opposite.
type CellEdge = usize;

/// All branches on which a sheet's contacts read `value`, within the limits, and how far they may be from the beam's (m).
pub(super) fn level(
    model: &ContactModel,
    sheet: &ContactSheet,
    read: Read,
    value: f64,
    nodes: usize,
) -> (Vec<Vec<Contact>>, f64) {
    let (mut error, mut pieces) = (0.0_f64, Vec::new());
    for chain in Crossings::new(sheet, read, value).chains() {
        let Some(last) = chain.last().map(|link| link.start + link.length) else { continue };
        let trail = LevelWalk { sheet, read, value, chain: &chain, near: Slot::new(0), error: Slot::new(0.0) };
        let at = |d: f64| dispatch!(sheet.level(), simd => trail.at(simd, d, model));
        // Within a cell the first mode hardly ends twice.
        pieces.extend(stepped([0.0, last], nodes, PROBES.min(2 * chain.len()), &at));
        error = error.max(trail.error.get());
    }
    (pieces, sheet.position_error() + error)
}

/// A sheet's spot as a contact.
#[inline(always)]
pub(super) fn contact(spot: &SheetContact, tilt: f64) -> Contact {
    let SheetContact { force, s_a, phi_a, contact, moment } = *spot;
    Contact { force, s_a, phi_a, position: contact, moment, tilt }
}

/// A curve that is walked along, and what the last place has told about the next.
struct LevelWalk<'a> {
    sheet: &'a ContactSheet,
    read: Read,
    value: f64,
    chain: &'a [LevelSegment],
    /// The link of the last place.
    near: Slot<usize>,
    /// The largest distance of a place from the beam's own curve (m).
    error: Slot<f64>,
}

impl LevelWalk<'_> {
    /// The contact at distance `d` along the chain, if it is within the limits.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, d: f64, model: &ContactModel) -> Option<Contact> {
        let mut i = if self.chain[self.near.get()].start <= d { self.near.get() } else { 0 };
        while i + 1 < self.chain.len() && self.chain[i + 1].start <= d {
            i += 1;
        }
        self.near.set(i);
        let LevelSegment { cell, from, to, start, per_length, .. } = self.chain[i];
        let share = ((d - start) * per_length).clamp(0.0, 1.0);
        let at = [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
        // At the chart's ends only the load is free.
        let at_base = cell.0 == 0 && at[0] <= 0.0;
        let at_tip = cell.0 + 2 == self.sheet.rows() && at[0] >= 1.0;
        let (spot, off) = self.corrected(simd, cell, at, at_base || at_tip)?;
        let contact = Some(contact(&spot, model.sheet_tilt())).filter(|c| model.limits().admit(c));
        if contact.is_some() {
            self.error.set(self.error.get().max(off));
        }
        contact
    }

    /// The contact next to `at` that reads the value, and how far the beam's own curve may be from it (m).
    #[inline(always)]
    fn corrected<S: Simd>(
        &self,
        simd: S,
        mut cell: SheetCell,
        mut at: [f64; 2],
        mut pinned: bool,
    ) -> Option<(SheetContact, f64)> {
        let (sheet, read, value) = (self.sheet, self.read, self.value);
        for _ in 0..STEPS {
            let [excess, by_a, by_b] = sheet.excess(simd, read, value, cell, at);
            let by_a = if pinned { 0.0 } else { by_a };
            // One over the square of the reading's rise over a cell, and the square of the step, in shares of the cell.
            let per_square = 1.0 / (by_a * by_a + by_b * by_b);
            let square = excess * excess * per_square;
            if !square.is_finite() {
                return None;
            }
            let is_short = square < LAST_STEP * LAST_STEP;
            let most = if is_short { excess } else { excess / square.sqrt().max(1.0) } * per_square;
            at = [at[0] - most * by_a, at[1] - most * by_b];
            let ends = (cell.0 == 0 && at[0] < 0.0, cell.0 + 2 == sheet.rows() && at[0] > 1.0);
            if ends.0 || ends.1 {
                at[0] = f64::from(u8::from(ends.1));
                pinned = true;
            }
            (cell, at) = sheet.settled(cell, at, OUT);
            if ends.0 || ends.1 || !is_short {
                continue;
            }
            // What the step has left is read together with all else, and hardly ever too much.
            let per_rise = per_square.sqrt();
            match sheet.reading_spot(simd, read, value, cell, at) {
                Some((spot, excess)) if excess.abs() * per_rise < LEFT => {
                    return Some((spot, sheet.level_error(read, value, per_rise, excess.abs() * per_rise, cell.0)));
                }
                // Where there is none, a tenth of what a step leaves is read off the step.
                None if 0.1 * square < LEFT => return None,
                _ => {}
            }
        }
        None
    }
}

impl<'a> Crossings<'a> {
    fn new(sheet: &'a ContactSheet, read: Read, value: f64) -> Self {
        let (rows, readings) = (sheet.rows(), sheet.readings(read));
        let above = above(sheet, read, value);
        let side = sheet.side(value);
        let mut own = Self { sheet, readings, read, value, side, across: vec![0; rows], along: vec![0; rows] };
        for row in 0..rows {
            let (before, after) = (own.live(row.wrapping_sub(1)), own.live(row));
            own.across[row] = (above[row] ^ above[row] >> 1) & (before | after);
            if row + 1 < rows {
                own.along[row] = (above[row] ^ above[row + 1]) & (after | after << 1);
            }
        }
        own
    }

    fn live(&self, row: usize) -> u128 {
        if row < self.sheet.rows() - 1 { self.sheet.live(row) & self.side } else { 0 }
    }

    /// The curves: those that end, from their ends, then those that close, from anywhere.
    fn chains(mut self) -> Vec<Vec<LevelSegment>> {
        let mut chains = Vec::new();
        for ends_only in [true, false] {
            for row in 0..self.sheet.rows() {
                if self.across[row] | self.along[row] == 0 {
                    continue;
                }
                let (before, after) = (self.live(row.wrapping_sub(1)), self.live(row));
                let (across, along) =
                    if ends_only { (before ^ after, after ^ after << 1) } else { (before & after, after & after << 1) };
                while let Some(column) = first(self.across[row] & across) {
                    let enters_after = after >> column & 1 == 1;
                    let (cell, side) = if enters_after { ((row, column), 0) } else { ((row - 1, column), 2) };
                    chains.push(self.walk(cell, side));
                }
                while let Some(column) = first(self.along[row] & along) {
                    let enters_after = after >> column & 1 == 1;
                    let (cell, side) = if enters_after { ((row, column), 3) } else { ((row, column - 1), 1) };
                    chains.push(self.walk(cell, side));
                }
            }
        }
        chains
    }

    /// Takes the chain that enters `cell` by `side` out of the crossings.
    fn walk(&mut self, cell: SheetCell, side: CellEdge) -> Vec<LevelSegment> {
        let (mut chain, mut cell, mut side, mut start): (Vec<LevelSegment>, _, _, _) =
            (Vec::with_capacity(256), cell, side, 0.0);
        let (mut from, mut place) = self.crossing(cell, side);
        let first = (cell, side, from, place);
        self.take(cell, side);
        loop {
            let exit = self.exit(cell, side);
            // A loop ends at the edge by which it began, in the cell on its other side.
            let back = (exit.is_none() && chain.len() > 1).then(|| next(first.0, first.1)).filter(|end| end.0 == cell);
            let (to, end_place) = match (exit, back) {
                (Some(exit), _) => self.crossing(cell, exit),
                (None, Some((_, own))) => (on_side(own, along_side(first.1, first.2)), first.3),
                (None, None) => return chain,
            };
            let length = (end_place - place).norm_squared().sqrt();
            let per_length = if length > 0.0 { 1.0 / length } else { 0.0 };
            chain.push(LevelSegment { cell, from, to, start, length, per_length });
            start += length;
            let Some(exit) = exit else { return chain };
            self.take(cell, exit);
            let (ahead, entry) = next(cell, exit);
            if ahead.1 >= self.sheet.columns() || !is_set(self.live(ahead.0), ahead.1) {
                return chain;
            }
            (from, place) = (on_side(entry, along_side(exit, to)), end_place);
            (cell, side) = (ahead, entry);
        }
    }

    /// The side by which a curve that entered by `side` leaves; `None` where none is left.
    fn exit(&self, cell: SheetCell, side: CellEdge) -> Option<CellEdge> {
        let open = (0..4).fold(0u32, |open, k| open | u32::from(k != side && self.is_crossed(cell, k)) << k);
        if open & open.wrapping_sub(1) == 0 {
            return (open != 0).then(|| open.trailing_zeros() as usize);
        }
        // A saddle: the curve turns about the corner of its own side that the middle does not agree with.
        let (sheet, read, value) = (self.sheet, self.read, self.value);
        let [excess, ..] = dispatch!(sheet.level(), simd => sheet.excess(simd, read, value, cell, [0.5; 2]));
        let middle = excess > 0.0;
        let corner = self.readings[self.ends(cell, side)[0]] > self.value;
        Some(if corner == middle { (side + 1) % 4 } else { (side + 3) % 4 })
    }

    /// The knots at which a side starts and ends, going around the cell.
    #[inline(always)]
    fn ends(&self, (i, j): SheetCell, side: CellEdge) -> [usize; 2] {
        let columns = self.sheet.columns();
        let around = [0, 1, columns + 1, columns, 0];
        [i * columns + j + around[side], i * columns + j + around[side + 1]]
    }

    /// Where the value lies on a side: shares of the cell and place, both between corners.
    #[inline(always)]
    fn crossing(&self, cell: SheetCell, side: CellEdge) -> ([f64; 2], Vec2) {
        let [from, to] = self.ends(cell, side);
        let (a, b) = (self.readings[from], self.readings[to]);
        let share = ((self.value - a) / (b - a)).clamp(0.0, 1.0);
        let (from, to) = (self.sheet.knot(from), self.sheet.knot(to));
        let at = match side {
            0 => [0.0, share],
            1 => [share, 1.0],
            2 => [1.0, 1.0 - share],
            _ => [1.0 - share, 0.0],
        };
        (at, from + share * (to - from))
    }

    #[inline]
    fn word(&mut self, (i, j): SheetCell, side: CellEdge) -> (&mut u128, usize) {
        match side {
            0 => (&mut self.across[i], j),
            2 => (&mut self.across[i + 1], j),
            1 => (&mut self.along[i], j + 1),
            _ => (&mut self.along[i], j),
        }
    }

    #[inline]
    fn is_crossed(&self, (i, j): SheetCell, side: CellEdge) -> bool {
        match side {
            0 => is_set(self.across[i], j),
            2 => is_set(self.across[i + 1], j),
            1 => is_set(self.along[i], j + 1),
            _ => is_set(self.along[i], j),
        }
    }

    #[inline]
    fn take(&mut self, cell: SheetCell, side: CellEdge) {
        let (word, bit) = self.word(cell, side);
        *word &= !(1 << bit);
    }
}

/// Whether a bit of a word is set. A shift by a half at a time takes half the instructions.
#[inline(always)]
fn is_set(word: u128, bit: usize) -> bool {
    (if bit < 64 { word as u64 } else { (word >> 64) as u64 }) >> (bit & 63) & 1 == 1
}

fn first(word: u128) -> Option<usize> {
    (word != 0).then(|| word.trailing_zeros() as usize)
}

/// The cell beyond a side, and that side as it is there; beyond the chart's start a cell that no row has.
fn next((i, j): SheetCell, side: CellEdge) -> (SheetCell, CellEdge) {
    match side {
        0 => ((i.wrapping_sub(1), j), 2),
        1 => ((i, j + 1), 3),
        2 => ((i + 1, j), 0),
        _ => ((i, j.wrapping_sub(1)), 1),
    }
}

/// The share of the load's side, or of the whisker's, at which a place on a side is.
fn along_side(side: CellEdge, at: [f64; 2]) -> f64 {
    if side.is_multiple_of(2) { at[1] } else { at[0] }
}

fn on_side(side: CellEdge, share: f64) -> [f64; 2] {
    match side {
        0 => [0.0, share],
        1 => [share, 1.0],
        2 => [1.0, share],
        _ => [share, 0.0],
    }
}

/// Which knots read more than the value. Blocks of knots that all do, or all do not, are not looked into.
fn above(sheet: &ContactSheet, read: Read, value: f64) -> Vec<u128> {
    let (rows, columns, readings) = (sheet.rows(), sheet.columns(), sheet.readings(read));
    let mut words = Vec::with_capacity(rows);
    for (number, ranges) in sheet.blocks(read).chunks_exact(columns.div_ceil(BLOCK)).enumerate() {
        let bits = |inside: &dyn Fn(&[f64; 2]) -> bool, each: u128| {
            ranges
                .iter()
                .enumerate()
                .filter(|(_, range)| inside(range))
                .fold(0, |word, (k, _)| word | each << (k * BLOCK))
        };
        let (whole, mut part) =
            (bits(&|range| range[0] > value, 0xff), bits(&|[lo, hi]| *lo <= value && *hi > value, 1));
        let first = number * BLOCK;
        words.resize((first + BLOCK).min(rows), whole);
        while part != 0 {
            let column = part.trailing_zeros() as usize;
            part &= part - 1;
            for (word, line) in words[first..].iter_mut().zip(readings[first * columns..].chunks_exact(columns)) {
                let knots = line[column..].iter().take(BLOCK).enumerate();
                *word |= u128::from(knots.fold(0u32, |byte, (k, x)| byte | u32::from(*x > value) << k)) << column;
            }
        }
    }
    words
}
