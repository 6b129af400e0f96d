//! Four functions of one number that hold all shapes under a normal load, as Taylor polynomials that the compiler derives.
//!
//! With `q = F s_a² / (2 EI)` and `y = q²` write slope, sine and cosine of the slope, and the contact seen along and across
//! the tangent at the contact as
//!
//! ```text
//! phi_a = q P,   cos(phi_a) = C,   sin(phi_a) = q S,   along = s_a A,   across = s_a q B,   S = A²
//! ```
//!
//! From the pendulum `u'' = cos u` (see the module on it) follow equations with no root and no angle in them:
//!
//! ```text
//! P + 2 y P' = A,   A + 4 y A' = C,   2 C' = -S A,   S + 2 y S' = C A,   3 B + 4 y B' = S
//! ```
//!
//! with `P = A = C = S = 1, B = 1/3` at `y = 0`; that `S = A²` is the pendulum's energy, `u'²/2 = sin u`. The nearest singularity is at `y = -11.82`, so pieces of length 1 in `y`
//! need eleven terms for 3e-14. Constant evaluation does all of it: there is no table of numbers to trust.

use fearless_simd::{Simd, SimdInto, f64x4};

/// Terms of each polynomial.
const TERMS: usize = 11;
/// Pieces of length 1 in `y`; the first mode ends at `y` = 47.27.
pub(super) const PIECES: usize = 48;
/// Functions that are stored: `P, A, C, B`, in this order; two fill a vector of the smallest processor.
pub(super) const STORED: usize = 4;
pub(super) const P: usize = 0;
pub(super) const A: usize = 1;
pub(super) const C: usize = 2;
pub(super) const B: usize = 3;
/// The fifth, which only the derivation carries.
const S: usize = 4;
const CARRIED: usize = 5;

/// Polynomials of all functions about one centre, by rising power.
pub(super) type SeriesPiece = [[f64; STORED]; TERMS];

/// Terms carried while marching from piece to piece.
const LONG: usize = 40;
type Long = [[f64; CARRIED]; LONG];
/// Pieces that are taken from the series about zero; from there on each gives the next.
const NEAR_ZERO: usize = 4;

/// A table that the compiler derives. In a browser the page derives it when it is first asked for, by the same code to the
/// same bits: numbers do not compress, and four such tables are a twentieth of the page.
macro_rules! derived {
    ($($(#[$words:meta])* $name:ident: $kind:ty = $value:expr;)+) => {
        $(
            $(#[$words])*
            #[cfg(not(all(feature = "std", target_family = "wasm")))]
            pub(super) static $name: $kind = $value;
            $(#[$words])*
            #[cfg(all(feature = "std", target_family = "wasm"))]
            pub(super) static $name: std::sync::LazyLock<$kind> = std::sync::LazyLock::new(|| $value);
        )+
    };
}
pub(super) use derived;

derived! {
    /// The polynomials, piece `i` about `y = i + 1/2`.
    FORWARD: [SeriesPiece; PIECES] = derive();
}

const fn product(f: &Long, a: usize, b: usize, n: usize) -> f64 {
    let (mut sum, mut i) = (0.0, 0);
    while i <= n {
        sum += f[i][a] * f[n - i][b];
        i += 1;
    }
    sum
}

/// The series about `y = 0`.
const fn about_zero() -> Long {
    let mut f = [[0.0; CARRIED]; LONG];
    let mut n = 0;
    while n < LONG {
        let order = n as f64;
        f[n][C] = if n == 0 { 1.0 } else { -0.5 * product(&f, S, A, n - 1) / order };
        f[n][A] = f[n][C] / (1.0 + 4.0 * order);
        f[n][P] = f[n][A] / (1.0 + 2.0 * order);
        f[n][S] = product(&f, C, A, n) / (1.0 + 2.0 * order);
        f[n][B] = f[n][S] / (3.0 + 4.0 * order);
        n += 1;
    }
    f
}

/// The series about `centre > 0` where the functions are `values`.
const fn about(centre: f64, values: [f64; CARRIED]) -> Long {
    let mut f = [[0.0; CARRIED]; LONG];
    f[0] = values;
    let mut n = 0;
    while n + 1 < LONG {
        let order = n as f64;
        let next = centre * (order + 1.0);
        f[n + 1][P] = (f[n][A] - (1.0 + 2.0 * order) * f[n][P]) / (2.0 * next);
        f[n + 1][A] = (f[n][C] - (1.0 + 4.0 * order) * f[n][A]) / (4.0 * next);
        f[n + 1][C] = -0.5 * product(&f, S, A, n) / (order + 1.0);
        f[n + 1][S] = (product(&f, C, A, n) - (1.0 + 2.0 * order) * f[n][S]) / (2.0 * next);
        f[n + 1][B] = (f[n][S] - (3.0 + 4.0 * order) * f[n][B]) / (4.0 * next);
        n += 1;
    }
    f
}

/// The values of the series at distance `x` from its centre.
const fn sum(f: &Long, x: f64) -> [f64; CARRIED] {
    let mut values = [0.0; CARRIED];
    let mut n = LONG;
    while n > 0 {
        n -= 1;
        let mut lane = 0;
        while lane < CARRIED {
            values[lane] = values[lane] * x + f[n][lane];
            lane += 1;
        }
    }
    values
}

/// The series about `x` instead of its centre.
const fn shifted(mut f: Long, x: f64) -> Long {
    let mut start = 0;
    while start + 1 < LONG {
        let mut n = LONG - 1;
        while n > start {
            n -= 1;
            let mut lane = 0;
            while lane < CARRIED {
                f[n][lane] += x * f[n + 1][lane];
                lane += 1;
            }
        }
        start += 1;
    }
    f
}

const fn shortened(f: &Long) -> SeriesPiece {
    let mut piece = [[0.0; STORED]; TERMS];
    let mut n = 0;
    while n < TERMS {
        piece[n] = [f[n][P], f[n][A], f[n][C], f[n][B]];
        n += 1;
    }
    piece
}

#[allow(long_running_const_eval)]
const fn derive() -> [SeriesPiece; PIECES] {
    let mut pieces = [[[0.0; STORED]; TERMS]; PIECES];
    let zero = about_zero();
    let mut long = zero;
    let mut i = 0;
    while i < PIECES {
        let centre = i as f64 + 0.5;
        long = if i < NEAR_ZERO { shifted(zero, centre) } else { about(centre, sum(&long, 1.0)) };
        pieces[i] = shortened(&long);
        i += 1;
    }
    pieces
}

/// The functions at `y` in \[0, 48\].
#[inline(always)]
pub(super) const fn forward(pieces: &[SeriesPiece; PIECES], y: f64) -> [f64; STORED] {
    let i = if y < PIECES as f64 { y as usize } else { PIECES - 1 };
    horner(&pieces[i], y - i as f64 - 0.5)
}

/// [`forward`] for batches, to the same bits.
#[inline(always)]
pub(super) fn forward_wide<S: Simd>(simd: S, y: f64) -> [f64; STORED] {
    let i = (y as usize).min(PIECES - 1);
    horner_wide(simd, &FORWARD[i], y - i as f64 - 0.5)
}

/// `a + x b` in every lane.
#[inline(always)]
const fn add<const LANES: usize>(a: &[f64; LANES], x: f64, b: &[f64; LANES]) -> [f64; LANES] {
    let mut sum = *a;
    let mut lane = 0;
    while lane < LANES {
        sum[lane] += x * b[lane];
        lane += 1;
    }
    sum
}

/// All functions of a piece at distance `x` from its centre: even and odd powers apart, so that they run side by side.
#[inline(always)]
pub(super) const fn horner<const LANES: usize, const N: usize>(piece: &[[f64; LANES]; N], x: f64) -> [f64; LANES] {
    let square = x * x;
    let (mut high, mut low) = (piece[N - 1], piece[N - 2]);
    let mut n = N - 2;
    while n >= 2 {
        high = add(&piece[n - 1], square, &high);
        low = add(&piece[n - 2], square, &low);
        n -= 2;
    }
    if n == 1 { add(&piece[0], x, &add(&low, x, &high)) } else { add(&low, x, &high) }
}

/// [`horner`] with all functions in one register where the processor has such: the same products and sums, so the same bits.
#[inline(always)]
pub(super) fn horner_wide<S: Simd, const N: usize>(simd: S, piece: &[[f64; STORED]; N], x: f64) -> [f64; STORED] {
    let at = |n: usize| -> f64x4<S> { piece[n].simd_into(simd) };
    let (x, square) = (simd.splat_f64x4(x), simd.splat_f64x4(x * x));
    let (mut high, mut low) = (at(N - 1), at(N - 2));
    let mut n = N - 2;
    while n >= 2 {
        (high, low) = (square * high + at(n - 1), square * low + at(n - 2));
        n -= 2;
    }
    let sum = x * high + low;
    if n == 1 { x * sum + at(0) } else { sum }.into()
}
