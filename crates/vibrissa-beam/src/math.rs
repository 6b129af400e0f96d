//! Elementary functions that give the same bits on every platform.
//!
//! The functions of [`f64`] are those of the platform: a browser, glibc and macOS differ in the last bit now and then, and a
//! search that compares numbers makes another choice from one bit. These are the functions of the crate `libm`
//! everywhere, so that a log gives the same answer in the page, in the command and on a robot. Errors are below one unit in
//! the last place. Square roots, remainders and powers by whole numbers are exact or made of products: they are taken
//! from [`f64`].
//!
//! In WebAssembly the functions of [`f64`] are the same code, and are taken from there so that they are not there twice.

macro_rules! functions {
    ($($(#[$words:meta])* $name:ident ($($argument:ident),+) = $libm:ident;)+) => {
        $(
            $(#[$words])*
            #[inline]
            #[must_use]
            pub fn $name($($argument: f64),+) -> f64 {
                #[cfg(all(feature = "std", target_family = "wasm"))]
                return f64::$name($($argument),+);
                #[cfg(not(all(feature = "std", target_family = "wasm")))]
                return libm::$libm($($argument),+);
            }
        )+
    };
}

functions! {
    /// The sine of an angle (rad).
    sin(angle) = sin;
    /// The cosine of an angle (rad).
    cos(angle) = cos;
    /// The tangent of an angle (rad).
    tan(angle) = tan;
    /// The angle in \[-π/2, π/2\] (rad) whose sine is given.
    asin(sine) = asin;
    /// The angle in \[-π/2, π/2\] (rad) whose tangent is given.
    atan(tangent) = atan;
    /// The angle in \[-π, π\] (rad) of the direction `(x, y)`.
    atan2(y, x) = atan2;
    /// e to the power of a number.
    exp(exponent) = exp;
    /// [`exp`] less 1, exact near 0.
    exp_m1(exponent) = expm1;
    /// The natural logarithm.
    ln(number) = log;
    /// The natural logarithm of 1 and a number more, exact near 0.
    ln_1p(number) = log1p;
    /// A power.
    powf(base, exponent) = pow;
    /// The hyperbolic sine.
    sinh(number) = sinh;
    /// The length of `(x, y)`, without overflow.
    hypot(x, y) = hypot;
}

/// Sine and cosine of an angle (rad).
#[inline]
#[must_use]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    #[cfg(all(feature = "std", target_family = "wasm"))]
    return (angle.sin(), angle.cos());
    #[cfg(not(all(feature = "std", target_family = "wasm")))]
    return libm::sincos(angle);
}

/// The inverse of [`sinh`], which the standard library would compose of others.
#[inline]
#[must_use]
pub fn asinh(number: f64) -> f64 {
    libm::asinh(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Another library's functions, which may differ by two units in the last place.
    #[cfg(feature = "std")]
    #[test]
    fn functions_are_those_of_the_system_but_for_rounding() {
        for k in 1..2000 {
            let x = 1e-3 * f64::from(k) * f64::from(k % 7 + 1);
            let pairs = [
                (sin(x), x.sin()),
                (cos(x), x.cos()),
                (tan(x), x.tan()),
                (asin(x % 1.0), (x % 1.0).asin()),
                (atan(x), x.atan()),
                (atan2(x, 1.0 - x), x.atan2(1.0 - x)),
                (exp(-x), (-x).exp()),
                (exp_m1(-x), (-x).exp_m1()),
                (ln(x), x.ln()),
                (ln_1p(x), x.ln_1p()),
                (powf(x, 0.3), x.powf(0.3)),
                (sinh(x), x.sinh()),
                (asinh(x), x.asinh()),
                (hypot(x, 1.0), x.hypot(1.0)),
            ];
            for (i, (ours, other)) in pairs.into_iter().enumerate() {
                assert!(
                    (ours - other).abs() <= 1e-15 * other.abs().max(1e-3),
                    "function {i} of {x}: {ours} and {other}"
                );
            }
        }
    }

    /// The bits that every platform has.
    #[test]
    fn functions_give_the_bits_of_every_platform() {
        let angle = 0.7 * core::f64::consts::PI;
        let (s, c) = sin_cos(angle);
        assert_eq!([s, c].map(f64::to_bits), [sin(angle), cos(angle)].map(f64::to_bits));
        let mixed = (1..2000).fold(0_u64, |bits, k| {
            let x = 1e-3 * f64::from(k) * f64::from(k % 7 + 1);
            let values = [
                sin(x),
                cos(x),
                tan(x),
                asin(x % 1.0),
                atan(x),
                atan2(x, 1.0 - x),
                exp(-x),
                exp_m1(-x),
                ln(x),
                ln_1p(x),
                powf(x, 0.3),
                sinh(x),
                asinh(x),
                hypot(x, 1.0),
            ];
            values.iter().fold(bits, |bits, v| bits.rotate_left(5) ^ v.to_bits())
        });
        assert_eq!(mixed, 14_885_049_453_727_122_648, "the functions changed in a bit: answers of searches will");
    }
}
