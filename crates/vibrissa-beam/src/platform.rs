//! What the standard library has and `core` has not.

use fearless_simd::Level;

/// The vector instructions that are used: those of the processor, or without `std` those that the target promises.
pub(crate) fn vector_level() -> Level {
    #[cfg(feature = "std")]
    return Level::new();
    #[cfg(not(feature = "std"))]
    return Level::baseline();
}

/// The remainder of `value / period` in \[0, period), as [`f64::rem_euclid`] has it.
pub(crate) fn rem_euclid(value: f64, period: f64) -> f64 {
    let rest = value % period;
    if rest < 0.0 { rest + period.abs() } else { rest }
}
