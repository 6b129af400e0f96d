//! What the standard library has and `core` has not.

use fearless_simd::Level;

/// Shared numbers: counted by one thread where the target cannot count for several (Cortex-M0).
#[cfg(not(target_has_atomic = "ptr"))]
pub(crate) use alloc::rc::Rc as Shared;
#[cfg(target_has_atomic = "ptr")]
pub(crate) use alloc::sync::Arc as Shared;

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
