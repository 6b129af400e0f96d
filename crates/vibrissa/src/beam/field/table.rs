//! Bicubic tables: five smooth quantities over a chart, once continuously differentiable.
//!
//! Each knot keeps value, both first derivatives and the mixed one; between knots each quantity is the bicubic Hermite
//! polynomial of the four corners. Its Bernstein coefficients enclose it.

extern crate alloc;
use super::axis::Axis;
use alloc::vec::Vec;

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
pub(super) type Node = [Row; 4];

/// The quantities and their first derivatives by the chart's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jet {
    pub(super) value: Row,
    pub(super) by_u: Row,
    pub(super) by_v: Row,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    pub(super) u: Axis,
    pub(super) v: Axis,
    /// Knots, those of one `u` in a row.
    pub(super) nodes: Vec<Node>,
}

/// Hermite weights of (value, derivative) at the start and the end of a cell, and their derivatives.
#[inline(always)]
fn weights(s: f64, h: f64) -> ([f64; 4], [f64; 4]) {
    let r = 1.0 - s;
    let rs = r * s;
    let one = s * s * (1.0 + 2.0 * r);
    ([1.0 - one, h * rs * r, one, -h * rs * s], [-6.0 * rs / h, r * (r - 2.0 * s), 6.0 * rs / h, s * (s - 2.0 * r)])
}

impl Table {
    /// Everything at `(u, v)`, by the polynomial of the cell that holds it or, outside, of the nearest one.
    #[inline]
    pub(super) fn jet(&self, u: f64, v: f64) -> Jet {
        self.jet_in(self.u.cell(u), self.v.cell(v), u, v)
    }

    /// Everything at `(u, v)` by the polynomial of the cell `(i, j)`.
    #[inline]
    pub(super) fn jet_in(&self, i: usize, j: usize, u: f64, v: f64) -> Jet {
        let (hu, hv) = (self.u.width(i), self.v.width(j));
        let (a, da) = weights((u - self.u.knots[i]) / hu, hu);
        let (b, db) = weights((v - self.v.knots[j]) / hv, hv);
        let mut jet = Jet { value: [0.0; QUANTITIES], by_u: [0.0; QUANTITIES], by_v: [0.0; QUANTITIES] };
        let stride = self.v.knots.len();
        let start = i * stride + j;
        for (p, column) in [start, start + stride].into_iter().enumerate() {
            let Some(pair) = self.nodes.get(column..column + 2) else { continue };
            for (q, node) in pair.iter().enumerate() {
                for kind in 0..4 {
                    let (m, n) = (2 * p + (kind & 1), 2 * q + (kind >> 1));
                    let (w, wu, wv) = (a[m] * b[n], da[m] * b[n], a[m] * db[n]);
                    for k in 0..QUANTITIES {
                        jet.value[k] += w * node[kind][k];
                        jet.by_u[k] += wu * node[kind][k];
                        jet.by_v[k] += wv * node[kind][k];
                    }
                }
            }
        }
        jet
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
        let (u, v) = (Axis::new(&[-1.0, 0.0, 1.5], 2), Axis::new(&[0.0, 2.0], 3));
        let mut nodes = Vec::new();
        for a in &u.knots {
            for b in &v.knots {
                nodes.push([f(*a, *b), fu(*a, *b), fv(*a, *b), fuv(*a, *b)].map(|x| [x; QUANTITIES]));
            }
        }
        let table = Table { u, v, nodes };
        for (a, b) in [(-0.9, 0.1), (0.3, 1.9), (1.4, 0.7), (-0.5, 2.0), (1.5, 0.0)] {
            let jet = table.jet(a, b);
            for (got, want) in [(jet.value, f(a, b)), (jet.by_u, fu(a, b)), (jet.by_v, fv(a, b))] {
                assert!(got.iter().all(|g| (g - want).abs() < 1e-12), "{got:?} {want}");
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
