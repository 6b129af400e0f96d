//! Samples of a chart at Chebyshev points, panel by panel, and the table that they give.
//!
//! All that is tabulated is analytic, so that few samples tell values and derivatives to ten digits: each exact shape
//! costs microseconds, each knot of the table nanoseconds.

extern crate alloc;
use super::axis::Axis;
use super::table::{Node, QUANTITIES, Row, Table};
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
    -((2 * j + 1) as f64 * PI / (2 * SIDE) as f64).cos()
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

    /// The samples of `f`; `None` when it has none somewhere.
    pub(super) fn sample(&self, f: impl Fn(f64, f64) -> Option<Row>) -> Option<Samples> {
        let mut samples = Vec::with_capacity(self.count());
        for (u, v) in self.panels() {
            for i in 0..SIDE {
                for j in 0..SIDE {
                    samples.push(f(between(u[0], u[1], node(i)), between(v[0], v[1], node(j)))?);
                }
            }
        }
        Some(samples)
    }

    /// The table of what was sampled.
    pub(super) fn table(&self, samples: &Samples) -> Table {
        let (u, v) = (Axis::new(&self.u_breaks, self.u_cells), Axis::new(&self.v_breaks, self.v_cells));
        let mut nodes: Vec<Node> = vec![[[0.0; QUANTITIES]; 4]; u.knots.len() * v.knots.len()];
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
                    nodes[(first_u + i) * v.knots.len() + first_v + j] = [
                        sum(&along, v_value),
                        scaled(sum(&across, v_value), du),
                        scaled(sum(&along, v_slope), dv),
                        scaled(sum(&across, v_slope), du * dv),
                    ];
                }
            }
        }
        Table::new(u, v, nodes)
    }

    /// The polynomials through the samples at `(u, v)`, with the derivatives by `u` and `v`.
    pub(super) fn polynomial(&self, samples: &Samples, u: f64, v: f64) -> [Row; 3] {
        let place = |breaks: &[f64], x: f64| {
            let i = breaks.partition_point(|b| *b <= x).saturating_sub(1).min(breaks.len() - 2);
            let width = breaks[i + 1] - breaks[i];
            let (value, slope) = basis(2.0 * (x - breaks[i]) / width - 1.0);
            (i, value, slope.map(|w| w * 2.0 / width))
        };
        let (i, u_value, u_slope) = place(&self.u_breaks, u);
        let (j, v_value, v_slope) = place(&self.v_breaks, v);
        let first = (i * (self.v_breaks.len() - 1) + j) * SIDE * SIDE;
        let panel = &samples[first..first + SIDE * SIDE];
        let along = rows(panel, &u_value);
        [sum(&along, &v_value), sum(&rows(panel, &u_slope), &v_value), sum(&along, &v_slope)]
    }
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
