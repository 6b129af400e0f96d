//! The same functions by moment and by polar angle, across the folds where two shapes meet.
//!
//! The moment `mu = M0 s_a / EI = 2 q A` and the half-angle tangent `w = tan(theta / 2)` of the contact both rise with `q` to
//! a fold and then fall. In `delta = ±sqrt(1 - mu / mu_max)` and `delta = ±sqrt(w_max - w)`, positive before the fold and
//! negative beyond, everything is smooth, both branches in one piece. Polynomials interpolate at Chebyshev's points of
//! equal pieces; the points come from Newton's method on the forward functions, all in constant evaluation.

use super::series::{A, B, C, FORWARD, P, PIECES, STORED, SeriesPiece, derived, forward, horner, horner_wide};
use fearless_simd::Simd;

/// Terms of each polynomial.
const TERMS: usize = 10;
/// In place of the forward function `A`: a function of `q` itself.
pub(super) const Q: usize = A;
/// By angle, in place of `B`: arc length over distance of the contact.
pub(super) const REACH: usize = B;
/// More by angle: `S`.
pub(super) const SINE: usize = 0;
/// More by angle: `A`.
pub(super) const ALONG: usize = 1;

/// The largest `q` of the first mode, `2 K(1/2)²`.
pub(super) const LAST_Q: f64 = 6.875_185_818_020_372;

/// A function of `delta` in equal pieces.
pub(super) struct Inverse<const LANES: usize, const N: usize> {
    first: f64,
    per_piece: f64,
    /// The coordinate at the fold.
    pub(super) top: f64,
    pieces: [[[f64; LANES]; TERMS]; N],
}

impl<const LANES: usize, const N: usize> Inverse<LANES, N> {
    /// The functions at `delta`; beyond the ends the nearest piece goes on.
    #[inline(always)]
    pub(super) fn at(&self, delta: f64) -> [f64; LANES] {
        let (i, x) = self.place(delta);
        horner(&self.pieces[i], x)
    }

    /// The piece that holds `delta`, and the distance from its centre in its lengths.
    #[inline(always)]
    fn place(&self, delta: f64) -> (usize, f64) {
        let place = (delta - self.first) * self.per_piece;
        let i = (place as usize).min(N - 1);
        (i, place - i as f64 - 0.5)
    }
}

impl<const N: usize> Inverse<STORED, N> {
    /// [`Inverse::at`] for batches, to the same bits.
    #[inline(always)]
    pub(super) fn at_wide<S: Simd>(&self, simd: S, delta: f64) -> [f64; STORED] {
        let (i, x) = self.place(delta);
        horner_wide(simd, &self.pieces[i], x)
    }
}

/// A coordinate of the shapes: its value and its derivative by `q`, from the forward functions.
#[derive(Clone, Copy)]
enum Coordinate {
    Moment,
    Angle,
}

const fn root(square: f64) -> f64 {
    let (mut x, mut i) = (0.5 * (1.0 + square), 0);
    while i < 40 {
        x = 0.5 * (x + square / x);
        i += 1;
    }
    x
}

/// The contact seen from the base, over `s_a`; the second coordinate over `q`.
#[inline]
pub(super) const fn contact(a: f64, b: f64, c: f64, y: f64) -> (f64, f64) {
    let s = a * a;
    (a * c + y * b * s, a * s - b * c)
}

impl Coordinate {
    const fn of(self, pieces: &[SeriesPiece; PIECES], q: f64) -> (f64, f64) {
        let f = forward(pieces, q * q);
        match self {
            Self::Moment => (2.0 * q * f[A], f[A] + f[C]),
            Self::Angle => {
                let (x, y) = contact(f[A], f[B], f[C], q * q);
                let square = x * x + q * q * y * y;
                let w = q * y / (root(square) + x);
                (w, 0.5 * (1.0 + w * w) * (f[A] - 0.5 * y / square))
            }
        }
    }

    /// Where the coordinate is largest.
    const fn fold(self, pieces: &[SeriesPiece; PIECES]) -> f64 {
        let (mut lo, mut hi, mut i) = (0.5 * LAST_Q * 0.5, LAST_Q, 0);
        while i < 60 {
            let middle = 0.5 * (lo + hi);
            if self.of(pieces, middle).1 > 0.0 {
                lo = middle;
            } else {
                hi = middle;
            }
            i += 1;
        }
        0.5 * (lo + hi)
    }

    /// The coordinate at `delta`.
    const fn at(self, top: f64, delta: f64) -> f64 {
        match self {
            Self::Moment => top * (1.0 - delta) * (1.0 + delta),
            Self::Angle => top - delta * delta,
        }
    }

    /// What the first lane holds: `q` over what vanishes with it, so that small shapes keep their digits.
    const fn divisor(self, top: f64, delta: f64) -> f64 {
        match self {
            Self::Moment => 1.0 - delta,
            Self::Angle => top - delta * delta,
        }
    }
}

/// `cos((2 k + 1) pi / (2 n))` for the ten points, the positive half from the outside.
const POINTS: [f64; TERMS / 2] = [
    0.987_688_340_595_137_8,
    0.891_006_524_188_367_9,
    core::f64::consts::FRAC_1_SQRT_2,
    0.453_990_499_739_546_8,
    0.156_434_465_040_230_92,
];

const fn point(k: usize) -> f64 {
    if k < TERMS / 2 { -POINTS[k] } else { POINTS[TERMS - 1 - k] }
}

/// `q` where the coordinate is `target`, by Newton's method from `start` that stays on one side of the fold.
const fn solve(coordinate: Coordinate, pieces: &[SeriesPiece; PIECES], target: f64, start: f64, fold: f64) -> f64 {
    let (mut q, mut i) = (start, 0);
    while i < 12 {
        let (value, slope) = coordinate.of(pieces, q);
        let next = q - (value - target) / slope;
        // Halfway to the fold at most: beyond it lies the other branch.
        let bound = 0.5 * (q + fold);
        q = if (next - bound) * (q - fold) < 0.0 { bound } else { next };
        i += 1;
    }
    q
}

#[allow(long_running_const_eval)]
const fn derive<const LANES: usize, const N: usize>(
    forward_pieces: &[SeriesPiece; PIECES],
    coordinate: Coordinate,
    first: f64,
) -> Inverse<LANES, N> {
    let fold = coordinate.fold(forward_pieces);
    let top = coordinate.of(forward_pieces, fold).0;
    let last = match coordinate {
        Coordinate::Moment => 1.0,
        Coordinate::Angle => root(top),
    };
    let width = (last - first) / N as f64;
    let mut pieces = [[[0.0; LANES]; TERMS]; N];
    let mut start = LAST_Q;
    let mut i = 0;
    while i < N {
        let mut values = [[0.0; LANES]; TERMS];
        let mut k = 0;
        while k < TERMS {
            let delta = first + width * (i as f64 + 0.5 + 0.5 * point(k));
            let mirrored = start > fold && delta > 0.0;
            let from = if mirrored { 2.0 * fold - start } else { start };
            let q = solve(coordinate, forward_pieces, coordinate.at(top, delta), from, fold);
            start = q;
            let f = forward(forward_pieces, q * q);
            (values[k][P], values[k][C]) = (f[P], f[C]);
            values[k][Q] = q / coordinate.divisor(top, delta);
            values[k][B] = f[B];
            if matches!(coordinate, Coordinate::Angle) {
                let (x, y) = contact(f[A], f[B], f[C], q * q);
                values[k][REACH] = 1.0 / root(x * x + q * q * y * y);
                values[k][STORED + SINE] = f[A] * f[A];
                values[k][STORED + ALONG] = f[A];
            }
            k += 1;
        }
        pieces[i] = interpolated(values);
        i += 1;
    }
    Inverse { first, per_piece: 1.0 / width, top, pieces }
}

/// The polynomials through the values at Chebyshev's points of \[-1/2, 1/2\], by rising power.
const fn interpolated<const LANES: usize>(mut values: [[f64; LANES]; TERMS]) -> [[f64; LANES]; TERMS] {
    // Newton's divided differences, and then the powers.
    let mut lane = 0;
    let mut powers = [[0.0; LANES]; TERMS];
    while lane < LANES {
        let mut order = 1;
        while order < TERMS {
            let mut k = TERMS - 1;
            while k >= order {
                let gap = 0.5 * (point(k) - point(k - order));
                values[k][lane] = (values[k][lane] - values[k - 1][lane]) / gap;
                k -= 1;
            }
            order += 1;
        }
        let mut k = TERMS;
        while k > 0 {
            k -= 1;
            // powers = powers * (x - point) + value
            let mut n = TERMS - 1;
            while n > 0 {
                powers[n][lane] = powers[n - 1][lane] - 0.5 * point(k) * powers[n][lane];
                n -= 1;
            }
            powers[0][lane] = values[k][lane] - 0.5 * point(k) * powers[0][lane];
        }
        lane += 1;
    }
    powers
}

derived! {
    /// By moment.
    BY_MOMENT: Inverse<STORED, 32> = derive(&FORWARD, Coordinate::Moment, -1.0);
    /// By polar angle; the other branch ends at a right angle, `w` = 1.
    ANGLE: Inverse<6, 32> = derive(&FORWARD, Coordinate::Angle, -0.44);
    /// By polar angle, the first four functions.
    BY_ANGLE: Inverse<STORED, 32> = taken(&ANGLE, 0);
    /// By polar angle, the others; apart, because compilers make vectors of two and four only.
    MORE_BY_ANGLE: Inverse<2, 32> = taken(&ANGLE, STORED);
}

/// The functions from `start` on.
const fn taken<const LANES: usize>(from: &Inverse<6, 32>, start: usize) -> Inverse<LANES, 32> {
    let mut pieces = [[[0.0; LANES]; TERMS]; 32];
    let mut i = 0;
    while i < 32 * TERMS * LANES {
        let (piece, term, lane) = (i / (TERMS * LANES), i / LANES % TERMS, i % LANES);
        pieces[piece][term][lane] = from.pieces[piece][term][start + lane];
        i += 1;
    }
    Inverse { first: from.first, per_piece: from.per_piece, top: from.top, pieces }
}
