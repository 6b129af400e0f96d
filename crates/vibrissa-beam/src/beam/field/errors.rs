//! How far a table is from the beam: measured at build, everywhere.
//!
//! The distance has two parts. Between the table and the polynomials through the samples, a bicubic Hermite cell errs by
//! `E_u + E_v` to leading order, where `E_u = h⁴ |f_uuuu| / 384` is the error half way along a cell edge in `u`. Its derivative by
//! `u` errs by `h³ |f_uuuu| / (72 sqrt 3)`, most at Gauss's two points of the edge, and by `E_v` of that derivative. All are
//! measured on every edge of every cell that the field holds, and the two maxima are added. Between the polynomials and the
//! beam it is measured by exact shapes where Chebyshev interpolation errs the most; a polynomial's derivative is at most
//! `SIDE²` times as large as itself (Markov), in half a panel's width.
use super::chart::BendKind;
use super::panels::{Layout, SIDE, Samples};
use super::state::FieldErrors;
use super::table::{ENERGY, MOMENT, QUANTITIES, Row, SLOPE, Table, X, Y};
use crate::math;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// What is measured is multiplied by this: fourth derivatives vary a little within a cell.
const MARGIN: f64 = 1.25;
/// Every how many extrema of the last Chebyshev polynomial the beam itself is asked, along each side of a panel.
const EVERY: usize = 3;

/// The least and the greater of Gauss's two points.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Bounds on the values, and on the derivatives by the table's two coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ErrorBounds {
    pub(super) value: FieldErrors,
    pub(super) by_u: FieldErrors,
    pub(super) by_v: FieldErrors,
}

/// Value, derivative by `u` and derivative by `v`.
type ErrorRows = [Row; 3];

/// The bounds, over the cells that are held.
pub(super) fn measured(
    layout: &Layout,
    samples: &Samples,
    table: &Table,
    is_held: impl Fn(usize, usize) -> bool,
    exact: impl Fn(f64, f64) -> Option<Row>,
) -> ErrorBounds {
    let hermite = between_knots(layout, samples, table, &is_held);
    let polynomial = from_samples(layout, samples, table, &is_held, exact);
    let [value, by_u, by_v] = [0, 1, 2].map(|kind: usize| {
        let bound = |k: usize| MARGIN * (hermite[0][kind][k] + hermite[1][kind][k] + polynomial[kind][k]);
        FieldErrors {
            slope: bound(SLOPE),
            position: bound(X).max(bound(Y)),
            moment: bound(MOMENT),
            energy: bound(ENERGY),
        }
    });
    ErrorBounds { value, by_u, by_v }
}

fn widen(worst: &mut Row, a: &[f64], b: &Row, factor: f64) {
    for k in 0..QUANTITIES {
        worst[k] = worst[k].max(factor * (a[k] - b[k]).abs());
    }
}

/// The largest errors on cell edges along `u` and along `v`.
fn between_knots(
    layout: &Layout,
    samples: &Samples,
    table: &Table,
    is_held: impl Fn(usize, usize) -> bool,
) -> [ErrorRows; 2] {
    let mut worst = [[[0.0; QUANTITIES]; 3]; 2];
    let shares = [0.0, 0.5, GAUSS[0], GAUSS[1]];
    layout.visit(samples, &shares, is_held, |(i, j), (a, b), (u, v), want| {
        let jet = table.jet_in(i, j, u, v);
        for kind in 0..3 {
            let got = jet.row(kind);
            // Along u only what stands at a > 0 counts, along v what stands at b > 0; corners are exact.
            if (a == 0) != (b == 0) {
                widen(&mut worst[usize::from(a == 0)][kind], &got, &want[kind], 1.0);
            }
        }
    });
    worst
}

/// The largest errors of the polynomials through the samples.
fn from_samples(
    layout: &Layout,
    samples: &Samples,
    table: &Table,
    is_held: impl Fn(usize, usize) -> bool,
    exact: impl Fn(f64, f64) -> Option<Row>,
) -> ErrorRows {
    let mut worst = [[0.0; QUANTITIES]; 3];
    let places = |breaks: &[f64], bend: BendKind, k: usize| {
        let x = 0.5 - 0.5 * math::cos(PI * k as f64 / SIDE as f64);
        breaks.windows(2).map(move |w| bend.at(w[0] + (w[1] - w[0]) * x)).collect::<Vec<_>>()
    };
    for k in (0..=SIDE).step_by(EVERY) {
        for l in (0..=SIDE).step_by(EVERY) {
            for &u in &places(&layout.u_breaks, layout.bends[0], k) {
                for &v in &places(&layout.v_breaks, layout.bends[1], l) {
                    if !is_held(table.u.cell(u), table.v.cell(v)) {
                        continue;
                    }
                    if let Some(want) = exact(u, v) {
                        let (got, rates) = (layout.polynomial(samples, u, v), layout.panel_rates(u, v));
                        let markov = (SIDE * SIDE) as f64;
                        for (worst, factor) in worst.iter_mut().zip([1.0, markov * rates[0], markov * rates[1]]) {
                            widen(worst, &got, &want, factor);
                        }
                    }
                }
            }
        }
    }
    worst
}
