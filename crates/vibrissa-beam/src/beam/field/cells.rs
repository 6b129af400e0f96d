//! Every place of a table at which two quantities have given values.
//!
//! A cell's Bernstein coefficients, seen through the inverse of the cell's mean derivative, enclose the cell's image in all but its
//! own shape, however thin: what does not hold the target is dropped. Where the derivative varies little over the cell there is one
//! place at most, and Newton's method finds it. Anything else (a fold, the degenerate neighbourhood of rest) is quartered.
use super::image::Image;
use super::index::{Held, Index};
use super::table::{Table, restricted};
use alloc::vec::Vec;

/// Bernstein coefficients of one quantity.
type Net = [[f64; 4]; 4];

/// Most quarterings of a cell: a fold is then told from a miss to 4e-6 of the cell's size in the image.
const DEEPEST: usize = 9;
/// Most Newton steps.
const MOST_STEPS: usize = 24;
/// A step below this share of a cell is the last: what it leaves is its square.
const LAST_STEP: f64 = 1e-7;
/// How far outside its cell a solution may lie, as a share of the cell: neighbours find it, too.
const SLACK: f64 = 1e-7;
/// How much the preconditioned derivative may differ from one where a single solution is taken for granted.
const REGULAR: f64 = 0.5;

/// The search for one target.
pub(super) struct TargetSearch<'a> {
    pub(super) table: &'a Table,
    pub(super) image: Image,
    pub(super) target: [f64; 2],
    /// Sizes by which residuals are judged: length (m) and moment (N m).
    pub(super) scale: [f64; 2],
}

/// A part of a cell, in shares of its sides.
#[derive(Clone, Copy)]
struct CellPart {
    s: (f64, f64),
    t: (f64, f64),
}

impl TargetSearch<'_> {
    /// The chart coordinates of all solutions in the cells of `index` for which `of_side` holds at a `v` within.
    pub(super) fn all(&self, index: &Index, of_side: impl Fn(f64) -> bool) -> Vec<[f64; 2]> {
        let mut found = Vec::new();
        for cell in index.at(self.target) {
            if of_side(0.5 * (self.table.v.knots[cell.j] + self.table.v.knots[cell.j + 1])) {
                let nets = self.image.nets(self.table, cell.i, cell.j);
                self.within(cell, nets, CellPart { s: (0.0, 1.0), t: (0.0, 1.0) }, 0, &mut found);
            }
        }
        found
    }

    fn within(&self, cell: &Held, nets: [Net; 2], part: CellPart, depth: usize, found: &mut Vec<[f64; 2]>) {
        let off = [0, 1].map(|k| nets[k].map(|row| row.map(|c| c - self.target[k])));
        let seen = preconditioned(&off);
        if !may_vanish(&seen.unwrap_or(off)) {
            return;
        }
        let regular = seen.is_some_and(|nets| is_regular(&nets));
        if regular || depth == DEEPEST {
            found.extend(self.newton(cell, part, seen.as_ref().map_or([0.5; 2], linear_root)));
            return;
        }
        let (s, t) = (0.5 * (part.s.0 + part.s.1), 0.5 * (part.t.0 + part.t.1));
        let halves = [(0.0, 0.5), (0.5, 1.0)];
        for (i, low_s) in halves.into_iter().enumerate() {
            for (j, low_t) in halves.into_iter().enumerate() {
                let quarter = nets.map(|net| restricted(net, low_s, low_t));
                let s = if i == 0 { (part.s.0, s) } else { (s, part.s.1) };
                let t = if j == 0 { (part.t.0, t) } else { (t, part.t.1) };
                self.within(cell, quarter, CellPart { s, t }, depth + 1, found);
            }
        }
    }

    /// Newton's method from a place in a part, in shares of the part; the table's coordinates, when it ends inside the part.
    fn newton(&self, cell: &Held, part: CellPart, start: [f64; 2]) -> Option<[f64; 2]> {
        let (hu, hv) = (self.table.u.width(cell.i), self.table.v.width(cell.j));
        let (u0, v0) = (self.table.u.knots[cell.i], self.table.v.knots[cell.j]);
        let clamp = |x: f64, (lo, hi): (f64, f64)| x.clamp(lo - 0.5 * (hi - lo), hi + 0.5 * (hi - lo));
        let inside = |x: f64, (lo, hi): (f64, f64)| x >= lo - SLACK && x <= hi + SLACK;
        let from = |x: f64, (lo, hi): (f64, f64)| lo + (hi - lo) * x;
        let (mut s, mut t) = (from(start[0], part.s), from(start[1], part.t));
        for _ in 0..MOST_STEPS {
            let (u, v) = (u0 + s * hu, v0 + t * hv);
            let here = self.image.of(&self.table.jet_in(cell.i, cell.j, u, v), u, self.scale);
            let [du, dv] = here.step(self.target)?;
            let (ds, dt) = (du / hu, dv / hv);
            if here.is_at(self.target) {
                return (inside(s, part.s) && inside(t, part.t)).then_some([u, v]);
            }
            if ds.abs().max(dt.abs()) < LAST_STEP {
                return (inside(s + ds, part.s) && inside(t + dt, part.t)).then_some([u + du, v + dv]);
            }
            (s, t) = (clamp(s + ds, part.s), clamp(t + dt, part.t));
        }
        None
    }
}

/// The nets seen through the inverse of their mean derivative; `None` where that is singular.
fn preconditioned(nets: &[Net; 2]) -> Option<[Net; 2]> {
    let mean = |net: &Net| {
        let along: f64 = (0..4).map(|q| net[3][q] - net[0][q]).sum();
        let across: f64 = (0..4).map(|p| net[p][3] - net[p][0]).sum();
        (0.25 * along, 0.25 * across)
    };
    let ((a, b), (c, d)) = (mean(&nets[0]), mean(&nets[1]));
    let det = a * d - b * c;
    let size = (a.abs() + b.abs()) * (c.abs() + d.abs());
    if det.abs() <= 1e-12 * size || !size.is_finite() {
        return None;
    }
    let mut seen = *nets;
    for p in 0..4 {
        for q in 0..4 {
            let (x, y) = (nets[0][p][q], nets[1][p][q]);
            seen[0][p][q] = (x * d - y * b) / det;
            seen[1][p][q] = (y * a - x * c) / det;
        }
    }
    Some(seen)
}

/// Where preconditioned nets, taken for linear, vanish: shares of their part.
fn linear_root(nets: &[Net; 2]) -> [f64; 2] {
    const MIDDLE: [f64; 4] = [0.125, 0.375, 0.375, 0.125];
    let middle = |net: &Net| -> f64 {
        net.iter().zip(MIDDLE).map(|(row, w)| w * row.iter().zip(MIDDLE).map(|(c, w)| w * c).sum::<f64>()).sum()
    };
    [0, 1].map(|k| (0.5 - middle(&nets[k])).clamp(0.0, 1.0))
}

/// Whether both nets have coefficients on both sides of zero, a little slack given.
fn may_vanish(nets: &[Net; 2]) -> bool {
    nets.iter().all(|net| {
        let (lo, hi) =
            net.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), c| (lo.min(*c), hi.max(*c)));
        let slack = 1e-6 * (hi - lo);
        lo <= slack && hi >= -slack
    })
}

/// Whether the derivative of preconditioned nets stays near one.
fn is_regular(nets: &[Net; 2]) -> bool {
    let mut worst = [0.0_f64; 2];
    for (k, net) in nets.iter().enumerate() {
        let (mut along, mut across) = (0.0_f64, 0.0_f64);
        let (one, other) = if k == 0 { (1.0, 0.0) } else { (0.0, 1.0) };
        for row in net {
            for pair in row.windows(2) {
                across = across.max((3.0 * (pair[1] - pair[0]) - other).abs());
            }
        }
        for rows in net.windows(2) {
            for (below, above) in rows[0].iter().zip(&rows[1]) {
                along = along.max((3.0 * (above - below) - one).abs());
            }
        }
        worst[k] = along + across;
    }
    worst[0].max(worst[1]) < REGULAR
}
