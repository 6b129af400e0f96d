//! What a chart is inverted for: the tip's position, or the direction of the force and the base moment.

use super::state::TipState;
use super::table::{Jet, MOMENT, SLOPE, Table, X, Y};

/// Residuals below this share of their scale are rounding.
const ROUNDING: f64 = 1e-14;

/// Two quantities that name an equilibrium up to its branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Image {
    /// x and y of the tip (m).
    Position,
    /// Tilt plus slope (rad), which is the direction of a positive force less a quarter turn, and base moment (N m).
    Reading,
}

/// The two quantities and their derivatives by `u` and `v`.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImagePoint {
    pub(super) value: [f64; 2],
    pub(super) by_u: [f64; 2],
    pub(super) by_v: [f64; 2],
    /// Residuals below these are rounding.
    rounding: [f64; 2],
}

impl ImagePoint {
    pub(super) fn det(&self) -> f64 {
        self.by_u[0] * self.by_v[1] - self.by_u[1] * self.by_v[0]
    }

    /// Whether the image is `target` within rounding.
    pub(super) fn is_at(&self, target: [f64; 2]) -> bool {
        (0..2).all(|k| (target[k] - self.value[k]).abs() <= self.rounding[k])
    }

    /// The step in `(u, v)` that a linear image takes to `target`.
    pub(super) fn step(&self, target: [f64; 2]) -> Option<[f64; 2]> {
        let det = self.det();
        let (a, b) = (target[0] - self.value[0], target[1] - self.value[1]);
        let (du, dv) = ((a * self.by_v[1] - b * self.by_v[0]) / det, (b * self.by_u[0] - a * self.by_u[1]) / det);
        (du.is_finite() && dv.is_finite()).then_some([du, dv])
    }
}

impl Image {
    /// Of a table over tilt and force, at the tilt `u`; of a table over other numbers, only [`Image::Position`].
    #[inline]
    pub(super) fn of(self, jet: &Jet, u: f64, scale: [f64; 2]) -> ImagePoint {
        let [value, by_u, by_v] = [0, 1, 2].map(|kind| jet.row(kind));
        match self {
            Self::Position => ImagePoint {
                value: [value[X], value[Y]],
                by_u: [by_u[X], by_u[Y]],
                by_v: [by_v[X], by_v[Y]],
                rounding: self.rounding(scale),
            },
            Self::Reading => ImagePoint {
                value: [u + value[SLOPE], value[MOMENT]],
                by_u: [1.0 + by_u[SLOPE], by_u[MOMENT]],
                by_v: [by_v[SLOPE], by_v[MOMENT]],
                rounding: self.rounding(scale),
            },
        }
    }

    /// As [`Image::of`], of a state.
    #[inline]
    pub(super) fn of_state(self, state: &TipState, scale: [f64; 2]) -> ImagePoint {
        let (u, v) = (&state.by_tilt, &state.by_force);
        match self {
            Self::Position => ImagePoint {
                value: [state.position.x, state.position.y],
                by_u: [u.position.x, u.position.y],
                by_v: [v.position.x, v.position.y],
                rounding: self.rounding(scale),
            },
            Self::Reading => ImagePoint {
                value: [state.tilt + state.slope, state.moment],
                by_u: [1.0 + u.slope, u.moment],
                by_v: [v.slope, v.moment],
                rounding: self.rounding(scale),
            },
        }
    }

    #[inline]
    fn rounding(self, scale: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Position => [ROUNDING * scale[0]; 2],
            Self::Reading => [ROUNDING, ROUNDING * scale[1]],
        }
    }

    /// Bernstein coefficients of the two quantities in the cell `(i, j)`.
    pub(super) fn nets(self, table: &Table, i: usize, j: usize) -> [[[f64; 4]; 4]; 2] {
        match self {
            Self::Position => [table.bernstein(i, j, X), table.bernstein(i, j, Y)],
            Self::Reading => {
                let mut turned = table.bernstein(i, j, SLOPE);
                for (p, row) in turned.iter_mut().enumerate() {
                    let tilt = table.u.knots[i] + table.u.width(i) * (p as f64 / 3.0);
                    for c in row {
                        *c += tilt;
                    }
                }
                [turned, table.bernstein(i, j, MOMENT)]
            }
        }
    }

    /// Bounds of the image of a cell: `[lo, lo, hi, hi]`, with a little slack.
    pub(super) fn bounds(self, table: &Table, i: usize, j: usize) -> [f64; 4] {
        let hull = |net: &[[f64; 4]; 4]| {
            let fold = |(lo, hi): (f64, f64), x: &f64| (lo.min(*x), hi.max(*x));
            let (lo, hi) = net.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), fold);
            let slack = 1e-6 * (hi - lo);
            (lo - slack, hi + slack)
        };
        let [a, b] = self.nets(table, i, j).map(|net| hull(&net));
        [a.0, b.0, a.1, b.1]
    }
}
