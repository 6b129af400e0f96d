//! Sets of robot states on a grid of places and headings.

use crate::plane::{Bounds, Pose2, Vec2};
use core::f64::consts::TAU;

/// Square cells over a rectangle, row by row from the lower left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// Lower left corner (m).
    pub origin: Vec2,
    /// Side of a cell (m).
    pub cell: f64,
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
}

impl Raster {
    /// The raster over `bounds` with cells of side `cell` (m).
    #[must_use]
    pub fn over(bounds: Bounds, cell: f64) -> Self {
        let size = bounds.size();
        let count = |length: f64| (length / cell).ceil().max(1.0) as usize;
        Self { origin: bounds.min, cell, columns: count(size.x), rows: count(size.y) }
    }

    /// The cell that holds `point`; none outside.
    #[inline]
    #[must_use]
    pub fn index(&self, point: Vec2) -> Option<usize> {
        // The same for every point of a loop, so that it is divided once.
        let per_cell = 1.0 / self.cell;
        let (x, y) = ((point.x - self.origin.x) * per_cell, (point.y - self.origin.y) * per_cell);
        let inside = x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < self.rows as f64;
        // Inside both fit 32 bits, to which a conversion takes a third of the instructions.
        inside.then(|| y as u32 as usize * self.columns + x as u32 as usize)
    }

    /// The lower left corner of a cell (m).
    #[must_use]
    pub fn corner(&self, column: usize, row: usize) -> Vec2 {
        self.origin + Vec2::new(column as f64, row as f64) * self.cell
    }
}

/// A set of robot states: for each cell of a raster, the headings that are in it.
#[derive(Clone, Debug, PartialEq)]
pub struct StateGrid {
    raster: Raster,
    bins: usize,
    words: usize,
    bits: Vec<u64>,
}

impl StateGrid {
    /// The empty set with `bins` headings.
    #[must_use]
    pub fn empty(raster: Raster, bins: usize) -> Self {
        let words = bins.div_ceil(64).max(1);
        Self { raster, bins, words, bits: vec![0; raster.columns * raster.rows * words] }
    }

    /// The cells.
    #[must_use]
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// How many headings make a turn; the first bin starts at 0 rad.
    #[must_use]
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// The bin of a heading (rad).
    #[must_use]
    pub fn bin(&self, theta: f64) -> usize {
        let turns = theta / TAU;
        (((turns - turns.floor()) * self.bins as f64) as usize).min(self.bins - 1)
    }

    /// The bins of the headings from `lo` to `hi` (rad, any turn): the first, and how many.
    pub(super) fn bins_of(&self, lo: f64, hi: f64) -> (usize, usize) {
        let scale = self.bins as f64 / TAU;
        let (first, last) = ((lo * scale).floor(), (hi * scale).floor());
        let count = ((last - first) as usize + 1).min(self.bins);
        (first.rem_euclid(self.bins as f64) as usize % self.bins, count)
    }

    /// Adds `count` headings from the bin `first` on at the cell `index`.
    #[inline]
    pub(super) fn add_bins(&mut self, index: usize, (first, count): (usize, usize)) {
        let cell = &mut self.bits[index * self.words..(index + 1) * self.words];
        let mut bin = first;
        for _ in 0..count {
            cell[bin / 64] |= 1 << (bin % 64);
            bin = if bin + 1 == self.bins { 0 } else { bin + 1 };
        }
    }

    /// Adds one heading at the cell `index`.
    #[inline]
    pub(super) fn add_bin(&mut self, index: usize, bin: usize) {
        self.bits[index * self.words + bin / 64] |= 1 << (bin % 64);
    }

    /// Drops the cells for which `keep` is false.
    pub(super) fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let words = self.words;
        for (index, headings) in self.bits.chunks_exact_mut(words).enumerate() {
            if !keep(index) {
                headings.fill(0);
            }
        }
    }

    /// The set grown by `cells` in x and y.
    pub(super) fn grown(&mut self, cells: usize) {
        let (w, stride) = (self.words, self.raster.columns * self.words);
        for _ in 0..cells {
            let mut own = vec![0; stride];
            for row in self.bits.chunks_exact_mut(stride) {
                own.copy_from_slice(row);
                row[w..].iter_mut().zip(&own).for_each(|(h, left)| *h |= left);
                row.iter_mut().zip(&own[w..]).for_each(|(h, right)| *h |= right);
            }
            let mut before = vec![0; stride];
            for start in (0..self.bits.len()).step_by(stride) {
                own.copy_from_slice(&self.bits[start..start + stride]);
                let (here, rest) = self.bits[start..].split_at_mut(stride);
                match rest.get(..stride) {
                    Some(next) => here.iter_mut().zip(&before).zip(next).for_each(|((h, b), n)| *h |= b | n),
                    None => here.iter_mut().zip(&before).for_each(|(h, b)| *h |= b),
                }
                core::mem::swap(&mut before, &mut own);
            }
        }
    }

    /// Whether a state is in the set.
    #[must_use]
    pub fn contains(&self, state: Pose2) -> bool {
        self.raster.index(state.position()).is_some_and(|cell| {
            let bin = self.bin(state.theta);
            self.bits[cell * self.words + bin / 64] >> (bin % 64) & 1 == 1
        })
    }

    /// Whether a cell has any heading, by column and row.
    #[must_use]
    pub fn holds(&self, column: usize, row: usize) -> bool {
        self.headings(row * self.raster.columns + column).iter().any(|&w| w != 0)
    }

    /// Whether a cell has the heading of a bin.
    #[must_use]
    pub fn holds_bin(&self, column: usize, row: usize, bin: usize) -> bool {
        self.headings(row * self.raster.columns + column)[bin / 64] >> (bin % 64) & 1 == 1
    }

    fn headings(&self, cell: usize) -> &[u64] {
        &self.bits[cell * self.words..(cell + 1) * self.words]
    }

    /// Whether no state is in the set.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bits.iter().all(|&w| w == 0)
    }

    /// How many cells have any heading.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.bits.chunks_exact(self.words).filter(|c| c.iter().any(|&w| w != 0)).count()
    }

    /// The area of the projection to places (m²).
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area_of(|_| true)
    }

    /// The area of the places among the cells that count (m²).
    pub(super) fn area_of(&self, counts: impl Fn(usize) -> bool) -> f64 {
        let held = |(index, cell): (usize, &[u64])| cell.iter().any(|&w| w != 0) && counts(index);
        let cells = self.bits.chunks_exact(self.words).enumerate().filter(|&c| held(c)).count();
        cells as f64 * self.raster.cell * self.raster.cell
    }

    /// The volume (m² rad).
    #[must_use]
    pub fn volume(&self) -> f64 {
        let states: u64 = self.bits.iter().map(|w| u64::from(w.count_ones())).sum();
        states as f64 * self.raster.cell * self.raster.cell * TAU / self.bins as f64
    }

    /// The area of the slice at a heading (m²).
    #[must_use]
    pub fn slice_area(&self, theta: f64) -> f64 {
        let bin = self.bin(theta);
        let inside = |c: &[u64]| c[bin / 64] >> (bin % 64) & 1 == 1;
        let count = self.bits.chunks_exact(self.words).filter(|c| inside(c)).count();
        count as f64 * self.raster.cell * self.raster.cell
    }

    /// The states in both sets; none when their grids differ.
    ///
    /// This intersects what is left of two preimages when the shape is forgotten. Readings of one contact are better
    /// combined before, as contacts: that set is smaller.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        if self.raster != other.raster || self.bins != other.bins {
            return None;
        }
        let bits = self.bits.iter().zip(&other.bits).map(|(a, b)| a & b).collect();
        Some(Self { bits, ..self.clone() })
    }

    /// The states as boxes `x_min, x_max, y_min, y_max` (m), `theta_min, theta_max` (rad), row by row: cells along x that hold
    /// the same headings are one.
    #[must_use]
    pub fn boxes(&self) -> Vec<[f64; 6]> {
        let (raster, step) = (*self.raster(), TAU / self.bins() as f64);
        let mut boxes = Vec::new();
        for row in 0..raster.rows {
            let mut column = 0;
            while column < raster.columns {
                let headings = self.heading_runs(column, row);
                let mut end = column + 1;
                while end < raster.columns && self.heading_runs(end, row) == headings {
                    end += 1;
                }
                let (lo, hi) = (raster.corner(column, row), raster.corner(end, row + 1));
                for (first, last) in headings {
                    boxes.push([lo.x, hi.x, lo.y, hi.y, first as f64 * step, last as f64 * step]);
                }
                column = end;
            }
        }
        boxes
    }

    /// Runs of cells along x that have any heading (or one bin): row, first column, one past the last column.
    #[must_use]
    pub fn runs(&self, bin: Option<usize>) -> Vec<(usize, usize, usize)> {
        let inside = |column: usize, row: usize| match bin {
            Some(bin) => self.holds_bin(column, row, bin),
            None => self.holds(column, row),
        };
        let mut runs = Vec::new();
        for row in 0..self.raster.rows {
            let mut start = None;
            for column in 0..=self.raster.columns {
                match (start, column < self.raster.columns && inside(column, row)) {
                    (None, true) => start = Some(column),
                    (Some(from), false) => {
                        runs.push((row, from, column));
                        start = None;
                    }
                    _ => {}
                }
            }
        }
        runs
    }

    /// The headings of a cell as ranges of bins, first and one past the last.
    #[must_use]
    pub fn heading_runs(&self, column: usize, row: usize) -> Vec<(usize, usize)> {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for bin in (0..self.bins).filter(|&bin| self.holds_bin(column, row, bin)) {
            match runs.last_mut() {
                Some(run) if run.1 == bin => run.1 = bin + 1,
                _ => runs.push((bin, bin + 1)),
            }
        }
        runs
    }
}
