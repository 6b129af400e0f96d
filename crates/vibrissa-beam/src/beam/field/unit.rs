//! The unit of load of a side field, by the contact's place.

use crate::beam::rod::Rod;
use crate::math;
use core::f64::consts::PI;

/// Coefficients of the logarithm of the unit times the squared arc length, over the place.
pub(super) const TERMS: usize = 8;

/// The unit of load (N) with the contact at `u` lengths.
pub(super) fn unit(scale: &[f64; TERMS], u: f64, length: f64) -> f64 {
    let x = 2.0 * u - 1.0;
    let s_a = u * length;
    math::exp(scale.iter().rev().fold(0.0, |sum, c| sum * x + c)) / (s_a * s_a)
}

/// The derivative of the unit's logarithm by `u`.
pub(super) fn log_slope(scale: &[f64; TERMS], u: f64) -> f64 {
    let x = 2.0 * u - 1.0;
    let slope = scale.iter().enumerate().skip(1).rev().fold(0.0, |sum, (k, c)| sum * x + k as f64 * c);
    2.0 * slope - 2.0 / u
}

/// The polynomial of the load's unit: through the logarithm at Chebyshev points, by Newton's divided differences.
pub(super) fn scale(rod: &Rod) -> [f64; TERMS] {
    let node = |i: usize| math::cos((2 * i + 1) as f64 * PI / (2 * TERMS) as f64);
    let length = rod.length();
    let mut differences: [f64; TERMS] = core::array::from_fn(|i| {
        let s_a = (0.5 * (1.0 + node(i))).max(0.05) * length;
        math::ln(rod.unit_force(s_a) * s_a * s_a)
    });
    for k in 1..TERMS {
        for i in (k..TERMS).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (node(i) - node(i - k));
        }
    }
    let mut power = [0.0; TERMS];
    for i in (0..TERMS).rev() {
        for k in (1..TERMS).rev() {
            power[k] = power[k - 1] - node(i) * power[k];
        }
        power[0] = differences[i] - node(i) * power[0];
    }
    power
}
