//! Four bicubic polynomials at once, or two of them, by powers.

use core::ops::{Add, Mul};
use fearless_simd::{Simd, SimdInto, f64x4};

/// Numbers that are added and multiplied as one.
pub(super) trait Lanes: Copy + Add<Output = Self> + Mul<Output = Self> {}

impl<T: Copy + Add<Output = Self> + Mul<Output = Self>> Lanes for T {}

/// Coefficients by powers from (start, slope, end, slope), slopes per share of the way.
pub(super) fn powers([a, da, b, db]: [f64; 4]) -> [f64; 4] {
    let rise = b - a;
    [a, da, 3.0 * rise - 2.0 * da - db, da + db - 2.0 * rise]
}

/// A number, twice it and its square, in each lane: a cubic by halves is three operations deep where Horner's scheme is six.
#[derive(Clone, Copy)]
pub(super) struct Powers<T> {
    one: T,
    two: T,
    square: T,
}

impl<T> Powers<T> {
    #[inline(always)]
    pub(super) fn of(x: f64, all: impl Fn(f64) -> T) -> Self {
        Self { one: all(x), two: all(x + x), square: all(x * x) }
    }
}

/// A cubic in each lane.
#[inline(always)]
pub(super) fn cubics<T: Lanes>(x: &Powers<T>, [c0, c1, c2, c3]: [T; 4]) -> T {
    (c3 * x.one + c2) * x.square + (c1 * x.one + c0)
}

/// A cubic and its slope in each lane.
#[inline(always)]
pub(super) fn slide<T: Lanes>(x: &Powers<T>, [c0, c1, c2, c3]: [T; 4]) -> (T, T) {
    let (high, low) = (c3 * x.one + c2, c1 * x.one + c0);
    (high * x.square + low, high * x.two + (c3 * x.square + c1))
}

/// A bicubic and its slopes by `s` and by `t` in each lane: the powers of `s` in rows.
#[inline(always)]
pub(super) fn jet<T: Lanes>(s: &Powers<T>, t: &Powers<T>, [a, b, c, d]: [[T; 4]; 4]) -> [T; 3] {
    let ((a, a_t), (b, b_t)) = (slide(t, a), slide(t, b));
    let ((c, c_t), (d, d_t)) = (slide(t, c), slide(t, d));
    let (value, by_s) = slide(s, [a, b, c, d]);
    [value, by_s, cubics(s, [a_t, b_t, c_t, d_t])]
}

/// The coefficients of four bicubics in `s` and `t`: the powers of `s` in rows. Lines of cache begin with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub(super) struct Bicubics(pub(super) [[[f64; 4]; 4]; 4]);

impl Bicubics {
    /// From the coefficients of each.
    pub(super) fn new(each: [[[f64; 4]; 4]; 4]) -> Self {
        Self([0, 1, 2, 3].map(|p| [0, 1, 2, 3].map(|q| [0, 1, 2, 3].map(|k: usize| each[k][p][q]))))
    }

    /// All four, their slopes by `s` and their slopes by `t`.
    #[inline(always)]
    pub(super) fn jet<S: Simd>(&self, simd: S, s: f64, t: &Powers<f64x4<S>>) -> [f64x4<S>; 3] {
        let [a, b, c, d] = self.0;
        let rows = [lanes(simd, a), lanes(simd, b), lanes(simd, c), lanes(simd, d)];
        jet(&Powers::of(s, |x| simd.splat_f64x4(x)), t, rows)
    }

    /// The first two, their slopes by `s` and their slopes by `t`.
    #[inline(always)]
    pub(super) fn jet_of_two<S: Simd>(&self, simd: S, s: f64, t: f64) -> [[f64; 2]; 3] {
        let all = |x: f64| simd.splat_f64x2(x);
        let two = |[a, b, c, d]: [[f64; 4]; 4]| {
            let low = |[x, y, ..]: [f64; 4]| [x, y].simd_into(simd);
            [low(a), low(b), low(c), low(d)]
        };
        let [a, b, c, d] = self.0;
        let [value, by_s, by_t] = jet(&Powers::of(s, all), &Powers::of(t, all), [two(a), two(b), two(c), two(d)]);
        [value.into(), by_s.into(), by_t.into()]
    }

    /// All four.
    #[inline(always)]
    pub(super) fn value<S: Simd>(&self, simd: S, s: f64, t: f64) -> [f64; 4] {
        let all = |x: f64| simd.splat_f64x4(x);
        let ([a, b, c, d], s, t) = (self.0, &Powers::of(s, all), &Powers::of(t, all));
        let (low, high) = ([lanes(simd, a), lanes(simd, b)], [lanes(simd, c), lanes(simd, d)]);
        cubics(s, [cubics(t, low[0]), cubics(t, low[1]), cubics(t, high[0]), cubics(t, high[1])]).into()
    }
}

/// Four lanes each.
#[inline(always)]
pub(super) fn lanes<S: Simd>(simd: S, [a, b, c, d]: [[f64; 4]; 4]) -> [f64x4<S>; 4] {
    [a.simd_into(simd), b.simd_into(simd), c.simd_into(simd), d.simd_into(simd)]
}

/// The sixteen coefficients by powers of a bicubic that has at the corners (0, 0), (0, 1), (1, 0), (1, 1) of a cell with sides `h`
/// these values, derivatives by the first number, by the second, and by both; in shares of the cell.
pub(super) fn coefficients(corners: [[f64; 4]; 4], h: (f64, f64)) -> [[f64; 4]; 4] {
    // Along the second number first: values and derivatives by the first, at both of its ends.
    let line = |p: usize, kind: usize| {
        let (a, b) = (corners[2 * p], corners[2 * p + 1]);
        powers([a[kind], a[kind + 2] * h.1, b[kind], b[kind + 2] * h.1])
    };
    let (start, start_slope, end, end_slope) = (line(0, 0), line(0, 1), line(1, 0), line(1, 1));
    let mut all = [[0.0; 4]; 4];
    for q in 0..4 {
        let column = powers([start[q], start_slope[q] * h.0, end[q], end_slope[q] * h.0]);
        for (row, c) in all.iter_mut().zip(column) {
            row[q] = c;
        }
    }
    all
}
