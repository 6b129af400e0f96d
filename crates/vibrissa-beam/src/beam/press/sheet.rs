//! One sheet of tip contacts over the wall's direction and the share of the range of slopes, with bounds between the nodes.

use super::{PressNode, ROUNDING, SAFETY, SheetError};
use crate::beam::pendulum::{Pendulum, Tilt};
use crate::math;
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Below this swing, or this slope before an inflection (rad), a whisker is straight.
const STILL: f64 = 1e-9;
const NO_SLOPE: f64 = 1e-12;
/// The whisker without a load.
const STRAIGHT: PressNode = PressNode { moment: 0.0, tip: Vec2::new(1.0, 0.0) };

/// How the whisker is bent between base and tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PressBend {
    /// One way: the base lies within the pendulum's first half swing.
    Plain,
    /// With one inflection: within its second. The moment has the other sign.
    Inflected,
}

impl PressBend {
    /// The tip contact with the tilt `beta` and the slope `u`.
    pub(super) fn tip(self, beta: f64, u: f64) -> PressNode {
        let [plain, inflected] = tips(beta, u);
        match self {
            Self::Plain => plain,
            Self::Inflected => inflected,
        }
    }
}

/// A sheet: nodes for every direction and every step of the slope, by columns.
#[derive(Clone, Debug)]
pub(super) struct PressSheet {
    pub(super) rows: usize,
    nodes: Vec<PressNode>,
    gaps: Vec<SheetError>,
    /// Least and largest moment of each cell, and of so many that follow each other in a column.
    ranges: Vec<(f64, f64)>,
    blocks: Vec<(f64, f64)>,
}

/// Cells of a column whose moments are known together.
const BLOCK: usize = 8;

/// Friction angle and largest slope (rad).
pub(super) type PressLimits = (f64, f64);

impl PressSheet {
    /// The largest moment of any cell.
    pub(super) fn largest(&self) -> f64 {
        self.ranges.iter().map(|range| range.1).fold(0.0, f64::max)
    }

    /// The values of shapes without an inflection and with one along a half column, by half rows: each pendulum passes the
    /// contact's slope twice.
    pub(super) fn half_column(
        direction: f64,
        rows: usize,
        limits: PressLimits,
        [plain, inflected]: &mut [Vec<PressNode>; 2],
    ) {
        // The moment grows like the root of the slope where it starts from nothing.
        let share = |half_row: usize| (0.5 * half_row as f64 / rows as f64).powi(2);
        for half_row in 0..=2 * rows {
            let [one, other] = at_share(direction, share(half_row), limits);
            plain.push(one);
            inflected.push(other);
        }
    }

    /// From its values at the nodes, at the middles of the edges, and at the middles of the cells, by half columns.
    pub(super) fn of(grid: &[PressNode], columns: usize, rows: usize) -> Self {
        let at = |half_column: usize, half_row: usize| grid[half_column * (2 * rows + 1) + half_row];
        let mut sheet = Self {
            rows,
            nodes: (0..=columns).flat_map(|c| (0..=rows).map(move |r| at(2 * c, 2 * r))).collect(),
            gaps: Vec::with_capacity(columns * rows),
            ranges: Vec::with_capacity(columns * rows),
            blocks: Vec::with_capacity(columns * rows.div_ceil(BLOCK)),
        };
        for column in 0..columns {
            for row in 0..rows {
                let gap = sheet.measure(column, row, |c, r| at(2 * column + c, 2 * row + r));
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(c, r)| sheet.node(column + c, row + r).moment);
                let (least, most) = corners.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &m| (a.min(m), b.max(m)));
                sheet.gaps.push(gap);
                sheet.ranges.push((least - gap.moment, most + gap.moment));
            }
        }
        let together = |cells: &[(f64, f64)]| {
            cells.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |all, one| (all.0.min(one.0), all.1.max(one.1)))
        };
        for column in sheet.ranges.chunks(rows) {
            sheet.blocks.extend(column.chunks(BLOCK).map(together));
        }
        sheet
    }

    /// The sheet with every second node, whose deviation in between the others tell; rows and columns must be even.
    pub(super) fn coarser(&self) -> Self {
        let columns = self.nodes.len() / (self.rows + 1) - 1;
        Self::of(&self.nodes, columns / 2, self.rows / 2)
    }

    pub(super) fn node(&self, column: usize, row: usize) -> PressNode {
        self.nodes[column * (self.rows + 1) + row]
    }

    /// The gaps of some cells of a column.
    pub(super) fn gaps(&self, column: usize, first: usize, end: usize) -> &[SheetError] {
        &self.gaps[column * self.rows + first..column * self.rows + end]
    }

    /// Whether a cell may hold a moment of the interval.
    pub(super) fn reaches(&self, column: usize, row: usize, (lo, hi): (f64, f64)) -> bool {
        let (least, most) = self.ranges[column * self.rows + row];
        least <= hi && most >= lo
    }

    /// The first row from this one on that may hold a moment of the interval, or one before it; the number of rows where there
    /// is none.
    pub(super) fn next(&self, column: usize, row: usize, (lo, hi): (f64, f64)) -> usize {
        let of_column = self.rows.div_ceil(BLOCK);
        let blocks = &self.blocks[column * of_column..(column + 1) * of_column];
        let reaching = blocks[row / BLOCK..].iter().position(|&(least, most)| least <= hi && most >= lo);
        reaching.map_or(self.rows, |ahead| row.max((row / BLOCK + ahead) * BLOCK))
    }

    /// The gap of one cell, from the sheet at the cell's middle and at the middles of its edges; `at` takes half columns
    /// and half rows from the cell's first corner on.
    fn measure(&self, column: usize, row: usize, at: impl Fn(usize, usize) -> PressNode) -> SheetError {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(c, r)| self.node(column + c, row + r));
        let probes = [
            (1, 1, [0.25; 4]),
            (1, 0, [0.5, 0.5, 0.0, 0.0]),
            (1, 2, [0.0, 0.0, 0.5, 0.5]),
            (0, 1, [0.5, 0.0, 0.5, 0.0]),
            (2, 1, [0.0, 0.5, 0.0, 0.5]),
        ];
        let mut gap = SheetError { moment: 0.0, tip: 0.0 };
        for (half_column, half_row, weights) in probes {
            let at = at(half_column, half_row);
            let moment: f64 = corners.iter().zip(weights).map(|(n, w)| w * n.moment).sum();
            let place = corners.iter().zip(weights).fold(Vec2::ZERO, |sum, (n, w)| sum + n.tip * w);
            gap.moment = gap.moment.max((at.moment - moment).abs());
            gap.tip = gap.tip.max(at.tip.distance(place));
        }
        SheetError { moment: SAFETY * gap.moment + ROUNDING, tip: SAFETY * gap.tip + ROUNDING }
    }
}

/// The tip contacts with the force in `direction` (rad), at this share of the range of slopes, as [`tips`] gives them.
fn at_share(direction: f64, share: f64, (slack, steepest): PressLimits) -> [PressNode; 2] {
    let least = (2.0 * (direction - PI)).max(0.0);
    let most = (direction - FRAC_PI_2 + slack).min(steepest).max(least);
    let u = least + share * (most - least);
    tips(direction - FRAC_PI_2 - u, u)
}

/// The tip contacts with the tilt `beta` and the slope `u`, without an inflection and with one: the first and the second time
/// that the pendulum comes by. The straight whisker where that is no load at all.
fn tips(beta: f64, u: f64) -> [PressNode; 2] {
    let beta = beta.clamp(-FRAC_PI_2, FRAC_PI_2);
    let u = u.clamp(0.0, PI - 2.0 * beta);
    let is_still = FRAC_PI_2 - beta < STILL;
    if is_still && u < NO_SLOPE {
        return [STRAIGHT; 2];
    }
    let pendulum = Pendulum::new(Tilt::from_gap(beta + FRAC_PI_2));
    let there = pendulum.at(pendulum.time_of(u).clamp(0.0, pendulum.half_period()));
    let (sin, cos) = math::sin_cos(u);
    let node = |t: f64, (along, across): (f64, f64)| PressNode {
        moment: t * there.du,
        tip: Vec2::new(along * cos + across * sin, along * sin - across * cos) * (1.0 / t),
    };
    let plain = if u < NO_SLOPE || there.t <= 0.0 { STRAIGHT } else { node(there.t, (there.along, there.across)) };
    if is_still {
        return [plain, STRAIGHT];
    }
    // The way back mirrors the way there.
    let turn = pendulum.turn();
    let back = (2.0 * turn.along - there.along, 2.0 * turn.across - there.across);
    let PressNode { moment, tip } = node(2.0 * turn.t - there.t, back);
    [plain, PressNode { moment: moment.max(0.0), tip }]
}
