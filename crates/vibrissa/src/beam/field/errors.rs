//! How far a table is from the beam: measured at build, everywhere.
//!
//! The distance has two parts. Between the table and the polynomials through the samples, a bicubic Hermite cell errs by
//! `E_u + E_v` to leading order, where `E_u = h⁴ |f_uuuu| / 384` is the error half way along a cell edge in `u`: it is
//! measured at the middle of every edge of every cell that the field holds, and the two maxima are added. Between the
//! polynomials and the beam it is measured by exact shapes where Chebyshev interpolation errs the most.

extern crate alloc;
use super::panels::{Layout, SIDE, Samples};
use super::state::FieldErrors;
use super::table::{QUANTITIES, Row, Table};
use alloc::vec::Vec;
use core::f64::consts::PI;

/// What is measured is multiplied by this: fourth derivatives vary a little within a cell.
const MARGIN: f64 = 1.25;
/// Every how many extrema of the last Chebyshev polynomial the beam itself is asked, along each side of a panel.
const EVERY: usize = 3;

/// The bounds, over the cells that are held.
pub(super) fn measured(
    layout: &Layout,
    samples: &Samples,
    table: &Table,
    is_held: impl Fn(usize, usize) -> bool,
    exact: impl Fn(f64, f64) -> Option<Row>,
) -> FieldErrors {
    let hermite = between_knots(layout, samples, table, &is_held);
    let polynomial = from_samples(layout, samples, table, &is_held, exact);
    let mut bound = [0.0; QUANTITIES];
    for k in 0..QUANTITIES {
        bound[k] = MARGIN * (hermite[0][k] + hermite[1][k] + polynomial[k]);
    }
    FieldErrors { slope: bound[0], position: bound[1].max(bound[2]), moment: bound[3], energy: bound[4] }
}

fn widen(worst: &mut Row, a: &Row, b: &Row) {
    for k in 0..QUANTITIES {
        worst[k] = worst[k].max((a[k] - b[k]).abs());
    }
}

/// The largest errors at the middles of cell edges along `u` and along `v`.
fn between_knots(
    layout: &Layout,
    samples: &Samples,
    table: &Table,
    is_held: impl Fn(usize, usize) -> bool,
) -> [Row; 2] {
    let mut worst = [[0.0; QUANTITIES]; 2];
    for i in 0..table.u.cells() {
        for j in 0..table.v.cells() {
            let (u0, u1) = (table.u.knots[i], table.u.knots[i + 1]);
            let (v0, v1) = (table.v.knots[j], table.v.knots[j + 1]);
            if !is_held(i, j) {
                continue;
            }
            for (direction, (u, v)) in [(0, (0.5 * (u0 + u1), v0)), (1, (u0, 0.5 * (v0 + v1)))] {
                let want = layout.polynomial(samples, u, v)[0];
                widen(&mut worst[direction], &table.jet_in(i, j, u, v).value, &want);
            }
        }
    }
    worst
}

/// The largest errors of the polynomials through the samples.
fn from_samples(
    layout: &Layout,
    samples: &Samples,
    table: &Table,
    is_held: impl Fn(usize, usize) -> bool,
    exact: impl Fn(f64, f64) -> Option<Row>,
) -> Row {
    let mut worst = [0.0; QUANTITIES];
    let places = |breaks: &[f64], k: usize| {
        let x = 0.5 - 0.5 * (PI * k as f64 / SIDE as f64).cos();
        breaks.windows(2).map(move |w| w[0] + (w[1] - w[0]) * x).collect::<Vec<_>>()
    };
    for k in (0..=SIDE).step_by(EVERY) {
        for l in (0..=SIDE).step_by(EVERY) {
            for &u in &places(&layout.u_breaks, k) {
                for &v in &places(&layout.v_breaks, l) {
                    if !is_held(table.u.cell(u), table.v.cell(v)) {
                        continue;
                    }
                    if let Some(want) = exact(u, v) {
                        widen(&mut worst, &layout.polynomial(samples, u, v)[0], &want);
                    }
                }
            }
        }
    }
    worst
}
