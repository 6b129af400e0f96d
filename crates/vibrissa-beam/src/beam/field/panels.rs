//! Samples of a chart at Chebyshev points, panel by panel, and the table that they give.
//!
//! All that is tabulated is analytic, so that few samples tell values and derivatives to ten digits: each exact shape
//! costs microseconds, each knot of the table nanoseconds.
use super::axis::Axis;
use super::chart::BendKind;
use super::table::{QUANTITIES, Row, Table, TableNode};
use crate::math;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Samples along each side of a panel.
pub(super) const SIDE: usize = 16;

/// How a chart is cut into panels, and each panel into cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) u_breaks: Vec<f64>,
    pub(super) v_breaks: Vec<f64>,
    /// Cells along each side of a panel.
    pub(super) u_cells: usize,
    pub(super) v_cells: usize,
    /// From the samples' coordinates to the table's.
    pub(super) bends: [BendKind; 2],
}

/// One row of numbers for each sample: those of one panel together.
pub(super) type Samples = Vec<Row>;

/// The weights of the samples of one side for the value and the derivative at `x` in \[-1, 1\].
fn basis(x: f64) -> ([f64; SIDE], [f64; SIDE]) {
    let (mut value, mut slope) = ([1.0 / SIDE as f64; SIDE], [0.0; SIDE]);
    for (j, (value, slope)) in value.iter_mut().zip(&mut slope).enumerate() {
        let y = node(j);
        // Chebyshev polynomials: first kind at y and x, second kind at x.
        let (mut ty, mut tx, mut ux) = ((1.0, y), (1.0, x), (0.0, 1.0));
        for k in 1..SIDE {
            *value += 2.0 / SIDE as f64 * ty.1 * tx.1;
            *slope += 2.0 / SIDE as f64 * k as f64 * ty.1 * ux.1;
            ty = (ty.1, 2.0 * y * ty.1 - ty.0);
            tx = (tx.1, 2.0 * x * tx.1 - tx.0);
            ux = (ux.1, 2.0 * x * ux.1 - ux.0);
        }
    }
    (value, slope)
}

/// The `j`-th Chebyshev point of \[-1, 1\].
fn node(j: usize) -> f64 {
    -math::cos((2 * j + 1) as f64 * PI / (2 * SIDE) as f64)
}

fn between(lo: f64, hi: f64, x: f64) -> f64 {
    0.5 * (lo + hi) + 0.5 * (hi - lo) * x
}

impl Layout {
    fn panels(&self) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
        let pair = |w: &[f64]| [w[0], w[1]];
        self.u_breaks.windows(2).flat_map(move |u| self.v_breaks.windows(2).map(move |v| (pair(u), pair(v))))
    }

    /// How many samples the layout takes.
    pub(super) fn count(&self) -> usize {
        self.panels().count() * SIDE * SIDE
    }

    /// The samples of `f`, a function of the table's coordinates; `None` when it has none somewhere.
    pub(super) fn sample(&self, f: impl Fn(f64, f64) -> Option<Row>) -> Option<Samples> {
        let mut samples = Vec::with_capacity(self.count());
        for (u, v) in self.panels() {
            for i in 0..SIDE {
                for j in 0..SIDE {
                    let (a, b) = (between(u[0], u[1], node(i)), between(v[0], v[1], node(j)));
                    samples.push(f(self.bends[0].at(a), self.bends[1].at(b))?);
                }
            }
        }
        Some(samples)
    }

    /// The table of what was sampled, over the coordinates that `bends` make of the samples'.
    pub(super) fn table(&self, samples: &Samples) -> Table {
        let (u, v, nodes) = self.knots(samples);
        Table::new(u, v, nodes)
    }

    /// Both axes of the table and what it holds at its knots, those of one `u` in a row.
    pub(super) fn knots(&self, samples: &Samples) -> (Axis, Axis, Vec<TableNode>) {
        let axis = |breaks: &[f64], cells: usize, bend: BendKind| {
            let knots = cut(breaks, cells).into_iter().map(|x| bend.at(x)).collect::<Vec<_>>();
            let rates = knots.iter().map(|y| bend.back_rate(*y)).collect::<Vec<_>>();
            (Axis::new(knots), rates)
        };
        let (u, u_rates) = axis(&self.u_breaks, self.u_cells, self.bends[0]);
        let (v, v_rates) = axis(&self.v_breaks, self.v_cells, self.bends[1]);
        let mut nodes: Vec<TableNode> = vec![[[0.0; QUANTITIES]; 4]; u.knots.len() * v.knots.len()];
        let of = |cells: usize| (0..=cells).map(|i| basis(2.0 * i as f64 / cells as f64 - 1.0)).collect::<Vec<_>>();
        let (u_basis, v_basis) = (of(self.u_cells), of(self.v_cells));
        let v_panels = self.v_breaks.len() - 1;
        for (number, ((pu, pv), panel)) in self.panels().zip(samples.chunks_exact(SIDE * SIDE)).enumerate() {
            let (du, dv) = (2.0 / (pu[1] - pu[0]), 2.0 / (pv[1] - pv[0]));
            let (first_u, first_v) = (number / v_panels * self.u_cells, number % v_panels * self.v_cells);
            for (i, (value, slope)) in u_basis.iter().enumerate() {
                let (along, across) = (rows(panel, value), rows(panel, slope));
                for (j, (v_value, v_slope)) in v_basis.iter().enumerate() {
                    let scaled = |row: Row, by: f64| row.map(|x| x * by);
                    let (by_u, by_v) = (du * u_rates[first_u + i], dv * v_rates[first_v + j]);
                    nodes[(first_u + i) * v.knots.len() + first_v + j] = [
                        sum(&along, v_value),
                        scaled(sum(&across, v_value), by_u),
                        scaled(sum(&along, v_slope), by_v),
                        scaled(sum(&across, v_slope), by_u * by_v),
                    ];
                }
            }
        }
        (u, v, nodes)
    }

    /// Calls `f` with cell, numbers of the shares, the table's `(u, v)` and the polynomials there (value, derivatives by `u` and `v`)
    /// at all `shares` of all edges that start at the least corner of a wanted cell; the first share is 0.
    pub(super) fn visit(
        &self,
        samples: &Samples,
        shares: &[f64],
        wanted: impl Fn(usize, usize) -> bool,
        mut f: impl FnMut((usize, usize), (usize, usize), (f64, f64), [Row; 3]),
    ) {
        let at = |cells: usize, i: usize, a: usize| 2.0 * (i as f64 + shares[a]) / cells as f64 - 1.0;
        let of = |cells: usize| {
            let one = |i: usize| (0..shares.len()).map(move |a| (a, basis(at(cells, i, a)))).collect::<Vec<_>>();
            (0..cells).map(one).collect::<Vec<_>>()
        };
        let (u_basis, v_basis) = (of(self.u_cells), of(self.v_cells));
        let v_panels = self.v_breaks.len() - 1;
        for (number, ((pu, pv), panel)) in self.panels().zip(samples.chunks_exact(SIDE * SIDE)).enumerate() {
            let first = (number / v_panels * self.u_cells, number % v_panels * self.v_cells);
            for (i, (a, u_weights)) in u_basis.iter().enumerate().flat_map(|(i, list)| list.iter().map(move |w| (i, w)))
            {
                let u = self.bends[0].at(between(pu[0], pu[1], at(self.u_cells, i, *a)));
                let by_u = 2.0 / (pu[1] - pu[0]) * self.bends[0].back_rate(u);
                let (along, across) = (rows(panel, &u_weights.0), rows(panel, &u_weights.1));
                for (j, list) in v_basis.iter().enumerate().filter(|(j, _)| wanted(first.0 + i, first.1 + j)) {
                    for (b, v_weights) in list.iter().take(if *a > 0 { 1 } else { list.len() }) {
                        let v = self.bends[1].at(between(pv[0], pv[1], at(self.v_cells, j, *b)));
                        let by_v = 2.0 / (pv[1] - pv[0]) * self.bends[1].back_rate(v);
                        let slopes = (sum(&across, &v_weights.0), sum(&along, &v_weights.1));
                        let rows = [sum(&along, &v_weights.0), slopes.0.map(|x| x * by_u), slopes.1.map(|x| x * by_v)];
                        f((first.0 + i, first.1 + j), (*a, *b), (u, v), rows);
                    }
                }
            }
        }
    }

    /// The polynomials through the samples at the table's `(u, v)`.
    pub(super) fn polynomial(&self, samples: &Samples, u: f64, v: f64) -> Row {
        let (i, u_share, _) = panel(&self.u_breaks, self.bends[0].back(u));
        let (j, v_share, _) = panel(&self.v_breaks, self.bends[1].back(v));
        let first = (i * (self.v_breaks.len() - 1) + j) * SIDE * SIDE;
        sum(&rows(&samples[first..first + SIDE * SIDE], &basis(u_share).0), &basis(v_share).0)
    }

    /// What takes derivatives over \[-1, 1\], a panel's own coordinates, to the table's.
    pub(super) fn panel_rates(&self, u: f64, v: f64) -> [f64; 2] {
        [(&self.u_breaks, self.bends[0], u), (&self.v_breaks, self.bends[1], v)]
            .map(|(breaks, bend, x)| 2.0 / panel(breaks, bend.back(x)).2 * bend.back_rate(x))
    }
}

/// The panel that holds `x`, the place in it over \[-1, 1\], and its width.
fn panel(breaks: &[f64], x: f64) -> (usize, f64, f64) {
    let i = breaks.partition_point(|b| *b <= x).saturating_sub(1).min(breaks.len() - 2);
    let width = breaks[i + 1] - breaks[i];
    (i, 2.0 * (x - breaks[i]) / width - 1.0, width)
}

/// Stretches between `breaks`, each cut into `cells` equal cells.
fn cut(breaks: &[f64], cells: usize) -> Vec<f64> {
    let part = |pair: &[f64], i: usize| pair[0] + (pair[1] - pair[0]) * (i as f64 / cells as f64);
    let starts = breaks.windows(2).flat_map(|pair| (0..cells).map(move |i| part(pair, i)));
    starts.chain(breaks.last().copied()).collect()
}

/// One line of samples: those of a panel summed over `u`.
fn rows(panel: &[Row], weights: &[f64; SIDE]) -> [Row; SIDE] {
    let mut out = [[0.0; QUANTITIES]; SIDE];
    for (line, w) in panel.chunks_exact(SIDE).zip(weights) {
        for (o, row) in out.iter_mut().zip(line) {
            for (x, y) in o.iter_mut().zip(row) {
                *x += w * y;
            }
        }
    }
    out
}

fn sum(line: &[Row; SIDE], weights: &[f64; SIDE]) -> Row {
    let mut out = [0.0; QUANTITIES];
    for (row, w) in line.iter().zip(weights) {
        for (x, y) in out.iter_mut().zip(row) {
            *x += w * y;
        }
    }
    out
}
