//! Bands of boundaries: what a map does not say of them.

/// Over which length of wall the error of a band is alike where the map does not say (m): drawn walls are off as a whole, and outlines
/// that a whisker felt by a few centimetres at a time, as far as one contact slides.
pub const CORRELATION_LENGTH: f64 = 0.05;
/// The bound of a band whose standard deviation alone is told: a normal error is beyond three of them once in 370 times.
pub const STDS_IN_BOUND: f64 = 3.0;
