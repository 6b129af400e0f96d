//! A table in the making.

use super::sheet::{PressLimits, PressSheet};
use super::{PressNode, PressTable};
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A [`PressTable`] in the making, column by column: for those who cannot wait for all of it at once.
#[derive(Clone, Debug)]
pub struct PressTableBuilder {
    rows: usize,
    limits: PressLimits,
    directions: Vec<f64>,
    /// Half columns that are computed, and their nodes without an inflection and with one.
    half_columns: usize,
    grid: [Vec<PressNode>; 2],
    sheets: Vec<PressSheet>,
}

impl PressTableBuilder {
    /// Nothing yet of the table that [`PressTable::new`] makes.
    #[must_use]
    pub fn new(columns: usize, rows: usize, friction_angle: f64, steepest: f64) -> Self {
        let (slack, steepest) = (friction_angle.clamp(0.0, 1.0), steepest.clamp(0.1, PI));
        let step = (FRAC_PI_2 + slack) / columns as f64;
        // The half turn, where the sheet has an edge, is a column; beyond it the slope is twice the turn at least.
        let beyond = (0.5 * steepest / step).ceil().max((steepest - FRAC_PI_2) / step).ceil() as usize;
        // A number of columns that can be halved as often as a quarter turn's.
        let even = 1 << columns.trailing_zeros().min(3);
        let all = (columns + beyond).div_ceil(even) * even;
        let directions: Vec<f64> = (0..=all).map(|i| PI + (i as f64 - columns as f64) * step).collect();
        let count = (2 * all + 1) * (2 * rows + 1);
        let grid = [(); 2].map(|()| Vec::with_capacity(count));
        Self { rows, limits: (slack, steepest), directions, half_columns: 0, grid, sheets: Vec::new() }
    }

    /// Computes the next part: half a column, or the bounds of one sheet. How many nodes that looked at, none once all is done.
    pub fn advance(&mut self) -> usize {
        let columns = self.directions.len() - 1;
        if self.half_columns <= 2 * columns {
            let k = self.half_columns;
            let direction = 0.5 * (self.directions[k / 2] + self.directions[k.div_ceil(2)]);
            PressSheet::half_column(direction, self.rows, self.limits, &mut self.grid);
            self.half_columns += 1;
            return 2 * self.rows + 1;
        }
        let Some(grid) = self.grid.get(self.sheets.len()) else { return 0 };
        self.sheets.push(PressSheet::of(grid, columns, self.rows));
        columns * self.rows
    }

    /// The table, after what is left of the work.
    #[must_use]
    pub fn finish(mut self) -> PressTable {
        while self.advance() > 0 {}
        let (columns, rows) = (self.directions.len() - 1, self.rows);
        let mut sheets = self.sheets.into_iter();
        let sheets = self.grid.map(|grid| sheets.next().unwrap_or_else(|| PressSheet::of(&grid, columns, rows)));
        PressTable::of(sheets, self.directions, self.limits)
    }
}
