//! Bicubic tables: five smooth quantities over a chart, once continuously differentiable.
//!
//! Each knot keeps value, both first derivatives and the mixed one; between knots each quantity is the bicubic Hermite
//! polynomial of the four corners, kept by powers for look-ups. Its Bernstein coefficients enclose it.
use super::axis::{Axis, AxisPlace};
use super::bicubic::{Bicubics, Powers, coefficients, lanes, slide};
use crate::platform::vector_level;
use alloc::vec::Vec;
use fearless_simd::{Level, Simd, SimdInto, dispatch, f64x4};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// How many quantities a table holds: slope, x, y, moment, energy.
pub(super) const QUANTITIES: usize = 5;
pub(super) const SLOPE: usize = 0;
pub(super) const X: usize = 1;
pub(super) const Y: usize = 2;
pub(super) const MOMENT: usize = 3;
pub(super) const ENERGY: usize = 4;

/// All quantities at once.
pub(super) type Row = [f64; QUANTITIES];

/// Value, derivative by `u`, derivative by `v`, mixed derivative, of each quantity.
pub(super) type TableNode = [Row; 4];

/// The quantities (0), their derivatives by `u` (1) and their derivatives by `v` (2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Jet {
    /// Slope and moment, which the mirrored whisker has with the opposite sign; energy and x, which it shares.
    pub(super) four: [[f64; 4]; 3],
    /// y, which is odd.
    pub(super) last: [f64; 3],
}

/// Coefficients of a cell by the powers of the distances from its least corner: ten lines of cache.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub(super) struct Patch {
    /// Slope, moment, energy and x.
    four: Bicubics,
    /// y, which is alone: the powers of `v` in rows.
    last: [[f64; 4]; 4],
}

#[derive(Clone, Debug)]
pub(super) struct Table {
    pub(super) u: Axis,
    pub(super) v: Axis,
    /// Knots, those of one `u` in a row.
    nodes: Vec<TableNode>,
    /// Cells, those of one `u` in a row.
    patches: Vec<Patch>,
    /// What the processor has registers for: four numbers, or two. The results are the same to the last bit.
    pub(super) level: Level,
}

/// Value and both slopes of the bicubic that stands alone.
#[inline(always)]
fn jet_alone<S: Simd>(simd: S, s: f64, t: &Powers<f64x4<S>>, rows: &[[f64; 4]; 4]) -> [f64; 3] {
    let (value, by_t) = slide(t, lanes(simd, *rows));
    let (((ab, cd), (ab_t, cd_t)), square) =
        ((simd.split_f64x4(value), simd.split_f64x4(by_t)), simd.splat_f64x2(s * s));
    // a + b s + (c + d s) s², and the same of the slopes by t.
    let (even, even_t) = (cd * square + ab, cd_t * square + ab_t);
    let value = simd.zip_high_f64x2(even, even_t) * s + simd.zip_low_f64x2(even, even_t);
    [value[0], ab[1] + s * (2.0 * cd[0] + 3.0 * (s * cd[1])), value[1]]
}

impl Patch {
    /// Everything at distances from the least corner, or, with `side` -1, that of the mirrored whisker: what is odd changes its
    /// sign, and so does what it is differentiated by. Values and slopes at once, row by row, which needs no weights, and by
    /// distances, which need no scales.
    #[inline(always)]
    pub(super) fn jet<S: Simd>(&self, simd: S, s: f64, t: f64, side: f64) -> Jet {
        let t = &Powers::of(t, |x| simd.splat_f64x4(x));
        let [value, by_s, by_t] = self.four.jet(simd, s, t);
        let [last, last_s, last_t] = jet_alone(simd, s, t, &self.last);
        let (odd, even) = ([side, side, 1.0, 1.0], [1.0, 1.0, side, side]);
        let (odd, even): (f64x4<S>, f64x4<S>) = (odd.simd_into(simd), even.simd_into(simd));
        Jet {
            four: [(value * odd).into(), (by_s * even).into(), (by_t * even).into()],
            last: [last * side, last_s, last_t],
        }
    }
}

impl Jet {
    /// The quantities or their derivatives, in the order of a row.
    #[inline(always)]
    pub(super) fn row(&self, kind: usize) -> Row {
        let [slope, moment, energy, x] = self.four[kind];
        [slope, x, self.last[kind], moment, energy]
    }
}

impl Table {
    /// The table over knots whose values and derivatives are known, those of one `u` in a row.
    pub(super) fn new(u: Axis, v: Axis, nodes: Vec<TableNode>) -> Self {
        let mut patches = Vec::with_capacity(u.cells() * v.cells());
        for i in 0..u.cells() {
            for j in 0..v.cells() {
                patches.push(patch(&nodes, v.knots.len(), (i, j), (u.width(i), v.width(j))));
            }
        }
        Self { u, v, nodes, patches, level: vector_level() }
    }

    /// Everything at `(u, v)`, by the polynomial of the cell that holds it or, outside, of the nearest one.
    #[inline]
    pub(super) fn jet(&self, u: f64, v: f64) -> Jet {
        self.jet_at(&self.u.place(u), &self.v.place(v))
    }

    /// Everything at `(u, v)` by the polynomial of the cell `(i, j)`.
    #[inline]
    pub(super) fn jet_in(&self, i: usize, j: usize, u: f64, v: f64) -> Jet {
        self.jet_at(&self.u.place_in(i, u), &self.v.place_in(j, v))
    }

    fn jet_at(&self, u: &AxisPlace, v: &AxisPlace) -> Jet {
        let Some(patch) = self.patch(u.cell, v.cell) else { return Jet::default() };
        dispatch!(self.level, simd => patch.jet(simd, u.along, v.along, 1.0))
    }

    /// The polynomials of the cell.
    #[inline(always)]
    pub(super) fn patch(&self, u: usize, v: usize) -> Option<&Patch> {
        self.patches.get(u * self.v.cells() + v)
    }

    /// The sixteen Bernstein coefficients of one quantity in the cell `(i, j)`: their hull holds all its values there.
    pub(super) fn bernstein(&self, i: usize, j: usize, k: usize) -> [[f64; 4]; 4] {
        let (hu, hv) = (self.u.width(i) / 3.0, self.v.width(j) / 3.0);
        let stride = self.v.knots.len();
        let mut out = [[0.0; 4]; 4];
        for p in 0..2 {
            for q in 0..2 {
                let node = &self.nodes[(i + p) * stride + j + q];
                let (su, sv) = (if p == 0 { hu } else { -hu }, if q == 0 { hv } else { -hv });
                let [f, fu, fv, fuv] = [0, 1, 2, 3].map(|kind| node[kind][k]);
                let (outer_u, inner_u, outer_v, inner_v) = (3 * p, 1 + p, 3 * q, 1 + q);
                out[outer_u][outer_v] = f;
                out[inner_u][outer_v] = f + su * fu;
                out[outer_u][inner_v] = f + sv * fv;
                out[inner_u][inner_v] = f + su * fu + sv * fv + su * sv * fuv;
            }
        }
        out
    }
}

/// The polynomials of one cell with sides `h`.
fn patch(nodes: &[TableNode], stride: usize, (i, j): (usize, usize), h: (f64, f64)) -> Patch {
    let at = |p: usize, q: usize, k: usize| nodes[(i + p) * stride + j + q].map(|row| row[k]);
    let of = |k: usize| {
        let mut all = coefficients([at(0, 0, k), at(0, 1, k), at(1, 0, k), at(1, 1, k)], h);
        for (p, row) in all.iter_mut().enumerate() {
            for (q, c) in row.iter_mut().enumerate() {
                *c /= h.0.powi(p as i32) * h.1.powi(q as i32);
            }
        }
        all
    };
    let y = of(Y);
    Patch {
        four: Bicubics::new([SLOPE, MOMENT, ENERGY, X].map(of)),
        last: [0, 1, 2, 3].map(|q: usize| [0, 1, 2, 3].map(|p: usize| y[p][q])),
    }
}

/// The coefficients over the part `[s0, s1] x [t0, t1]` of the cell, both in \[0, 1\].
pub(super) fn restricted(c: [[f64; 4]; 4], s: (f64, f64), t: (f64, f64)) -> [[f64; 4]; 4] {
    let mut rows = c.map(|row| cut(row, t));
    for q in 0..4 {
        let column = cut([rows[0][q], rows[1][q], rows[2][q], rows[3][q]], s);
        for (row, value) in rows.iter_mut().zip(column) {
            row[q] = value;
        }
    }
    rows
}

/// A cubic's Bernstein coefficients over `[s0, s1]`, by its blossom.
fn cut(c: [f64; 4], (s0, s1): (f64, f64)) -> [f64; 4] {
    let blossom = |a: f64, b: f64, d: f64| {
        let mix = |x: f64, y: f64, s: f64| (1.0 - s) * x + s * y;
        let one = [mix(c[0], c[1], a), mix(c[1], c[2], a), mix(c[2], c[3], a)];
        let two = [mix(one[0], one[1], b), mix(one[1], one[2], b)];
        mix(two[0], two[1], d)
    };
    [blossom(s0, s0, s0), blossom(s0, s0, s1), blossom(s0, s1, s1), blossom(s1, s1, s1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bicubic is its own interpolant, with all derivatives and within its Bernstein hull.
    #[test]
    fn a_bicubic_is_reproduced() {
        let f = |u: f64, v: f64| (1.0 + u - 2.0 * u * u + 3.0 * u * u * u) * (2.0 - v + v * v * v);
        let fu = |u: f64, v: f64| (1.0 - 4.0 * u + 9.0 * u * u) * (2.0 - v + v * v * v);
        let fv = |u: f64, v: f64| (1.0 + u - 2.0 * u * u + 3.0 * u * u * u) * (3.0 * v * v - 1.0);
        let fuv = |u: f64, v: f64| (1.0 - 4.0 * u + 9.0 * u * u) * (3.0 * v * v - 1.0);
        let (u, v) = (Axis::new([-1.0, -0.5, 0.0, 0.75, 1.5].into()), Axis::new([0.0, 0.5, 1.1, 2.0].into()));
        let mut nodes = Vec::new();
        for a in &u.knots {
            for b in &v.knots {
                nodes.push([f(*a, *b), fu(*a, *b), fv(*a, *b), fuv(*a, *b)].map(|x| [x; QUANTITIES]));
            }
        }
        let table = Table::new(u, v, nodes);
        for (a, b) in [(-0.9, 0.1), (0.3, 1.9), (1.4, 0.7), (-0.5, 2.0), (1.5, 0.0)] {
            let jet = table.jet(a, b);
            for (kind, want) in [f(a, b), fu(a, b), fv(a, b)].into_iter().enumerate() {
                let got = jet.row(kind);
                assert!(got.iter().all(|g| (g - want).abs() < 1e-12), "{got:?} {want}");
            }
        }
        // Four lanes give what two give.
        let bits = |jet: Jet| (jet.four.map(|row| row.map(f64::to_bits)), jet.last.map(f64::to_bits));
        for (s, t, side) in [(0.1, 0.2, 1.0), (0.33, 0.07, -1.0)] {
            for patch in &table.patches {
                let (two, here) = (Level::baseline(), table.level);
                let two = dispatch!(two, simd => patch.jet(simd, s, t, side));
                assert_eq!(bits(two), bits(dispatch!(here, simd => patch.jet(simd, s, t, side))));
            }
        }
        let (i, j) = (table.u.cell(0.3), table.v.cell(1.9));
        let part = restricted(table.bernstein(i, j, X), (0.2, 0.6), (0.5, 1.0));
        let (lo, hi) =
            part.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        for a in 0..=20 {
            for b in 0..=20 {
                let s = table.u.knots[i] + table.u.width(i) * (0.2 + 0.4 * f64::from(a) / 20.0);
                let t = table.v.knots[j] + table.v.width(j) * (0.5 + 0.5 * f64::from(b) / 20.0);
                assert!(f(s, t) >= lo - 1e-12 && f(s, t) <= hi + 1e-12);
            }
        }
        let corner = f(table.u.knots[i] + 0.6 * table.u.width(i), table.v.knots[j] + table.v.width(j));
        assert!((part[3][3] - corner).abs() < 1e-12);
    }
}
