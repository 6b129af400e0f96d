//! Roots and extrema of a function of one variable, bracketed and bounded in steps.

const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The root of `f` between `a` and `b`, to the last place of the argument; `None` when the signs do not differ or a value is
/// not a number.
///
/// Inverse quadratic interpolation where it is safe, bisection elsewhere \[chandrupatla1997\]; at most 200 steps.
pub(super) fn root(f: impl Fn(f64) -> f64, a: f64, b: f64) -> Option<f64> {
    let (mut x2, mut f2) = (a, f(a));
    let (mut x1, mut f1) = (b, f(b));
    if f1.is_nan() || f2.is_nan() || (f1 > 0.0 && f2 > 0.0) || (f1 < 0.0 && f2 < 0.0) {
        return None;
    }
    let mut fraction = 0.5;
    for _ in 0..200 {
        let x = x1 + fraction * (x2 - x1);
        let fx = f(x);
        let (x3, f3);
        if (fx > 0.0) == (f1 > 0.0) {
            (x3, f3) = (x1, f1);
        } else {
            (x3, f3) = (x2, f2);
            (x2, f2) = (x1, f1);
        }
        (x1, f1) = (x, fx);
        let (best, f_best) = if f1.abs() < f2.abs() { (x1, f1) } else { (x2, f2) };
        let least = (f64::EPSILON * best.abs() + f64::MIN_POSITIVE) / (x2 - x1).abs();
        if f_best.abs() <= 0.0 || least > 0.5 {
            return Some(best);
        }
        let xi = (x1 - x2) / (x3 - x2);
        let phi = (f1 - f2) / (f3 - f2);
        fraction = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        } else {
            0.5
        };
        fraction = fraction.clamp(least, 1.0 - least);
    }
    Some(if f1.abs() < f2.abs() { x1 } else { x2 })
}

/// The root of a rising `f` between the first and the last of `points`, looked for in the piece in which it lies.
pub(super) fn root_through(f: impl Fn(f64) -> f64, points: &[f64]) -> Option<f64> {
    let (first, rest) = points.split_first()?;
    let mut lo = *first;
    for &hi in rest {
        if f(hi) >= 0.0 {
            return root(f, lo, hi);
        }
        lo = hi;
    }
    None
}

/// Where `f`, which rises and then falls between `a` and `b`, is highest, to about the square root of rounding.
pub(super) fn highest(f: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let (mut lo, mut hi) = (a, b);
    let (mut left, mut right) = (hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo));
    let (mut f_left, mut f_right) = (f(left), f(right));
    for _ in 0..60 {
        if f_left > f_right {
            (hi, right, f_right) = (right, left, f_left);
            left = hi - GOLDEN * (hi - lo);
            f_left = f(left);
        } else {
            (lo, left, f_left) = (left, right, f_right);
            right = lo + GOLDEN * (hi - lo);
            f_right = f(right);
        }
        if hi - lo <= 1e-9 * (lo.abs() + hi.abs()) {
            break;
        }
    }
    let middle = 0.5 * (lo + hi);
    // A function that only rises is highest at its end.
    if f(b) > f(middle) { b } else { middle }
}
