//! From readings to moments: the arithmetic that a sensor head and the program on the host share, bit by bit.

/// Coefficients of a surface: all products of two signals up to the third degree.
pub const SURFACE_TERMS: usize = 10;

/// The excursion of readings from rest along a direction: `sum (reading - rest) direction`.
#[must_use]
pub fn excursion(readings: &[f64], rest: &[f64], direction: &[f64]) -> f64 {
    let terms = readings.iter().zip(rest).zip(direction);
    terms.fold(0.0, |sum, ((reading, rest), direction)| sum + (reading - rest) * direction)
}

/// A polynomial by rising power.
#[must_use]
pub fn polynomial(coefficients: &[f64], z: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * z + c)
}

/// The products of two signals that a surface is made of: `1, u, v, u², uv, v², u³, u²v, uv², v³`.
#[must_use]
pub fn surface_terms([u, v]: [f64; 2]) -> [f64; SURFACE_TERMS] {
    [1.0, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v]
}

/// A polynomial of two signals, its coefficients in the order of [`surface_terms`].
#[must_use]
pub fn surface(coefficients: &[f64; SURFACE_TERMS], signals: [f64; 2]) -> f64 {
    coefficients.iter().zip(surface_terms(signals)).fold(0.0, |sum, (c, term)| sum + c * term)
}
