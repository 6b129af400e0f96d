//! Stiffness and rest curvature along a rod, as power series about any arc length.

use super::super::pair::Pair;
use super::super::stretch::Stretch;
use super::march::{INVERSE, ORDER};
use crate::error::{Error, Result};
use alloc::format;
use alloc::vec::Vec;

/// A stretch of a rod made of one wire: its length, material and cross section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Arc length of the stretch (m), positive.
    pub length: f64,
    /// Young's modulus E (Pa), positive.
    pub young_modulus: f64,
    /// Second moment of area I (m⁴), positive.
    pub second_moment: f64,
}

/// A stretch over which the flexural rigidity is `rigidity (1 - narrowing (s - start))^4`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RodPiece {
    /// Arc length at which the stretch starts (m).
    pub(super) start: f64,
    /// Arc length at which the stretch ends (m).
    pub(super) end: f64,
    /// E I at the start (N m²).
    pub(super) rigidity: f64,
    /// How fast the radius falls, as a share of the radius at the start (1/m); 0 for a uniform stretch.
    pub(super) narrowing: f64,
}

impl RodPiece {
    /// The radius at arc length `s` as a share of the radius at the start.
    pub(super) fn radius(&self, s: f64) -> f64 {
        1.0 - self.narrowing * (s - self.start)
    }

    /// `1 / EI` at arc length `s` (1/(N m²)).
    pub(super) fn compliance(&self, s: f64) -> f64 {
        let radius = self.radius(s);
        1.0 / (self.rigidity * (radius * radius) * (radius * radius))
    }
}

/// The coefficients of a polynomial in `s` about arc length `s`, the rest zero.
pub(super) fn shifted(polynomial: &[f64], s: f64, series: &mut [f64; ORDER]) {
    *series = [0.0; ORDER];
    let n = polynomial.len().min(ORDER);
    series[..n].copy_from_slice(&polynomial[..n]);
    for start in 0..n.saturating_sub(1) {
        for k in (start..n - 1).rev() {
            series[k] += s * series[k + 1];
        }
    }
}

/// The series of `r kappa_0` by `t` about arc length `s`, each coefficient twice; `r` and `t` as a step counts, `w` the narrowing.
///
/// With `P_j = r^(j+1) times the j-th derivative of kappa_0` by `s`, `P_j' = P_(j+1) - (j + 1) w P_j`.
#[inline(always)]
pub(super) fn rest_series(polynomial: &[f64], s: f64, w: f64, series: &mut [Pair; ORDER]) {
    match polynomial {
        [] => {}
        [constant] => {
            let mut p = *constant;
            for (coefficient, n) in series.iter_mut().zip(&INVERSE[1..]) {
                *coefficient = Pair::both(p);
                p *= -w * n;
            }
        }
        _ => general_series(polynomial, s, w, series),
    }
}

/// The same for a polynomial of any degree.
#[inline(never)]
fn general_series(polynomial: &[f64], s: f64, w: f64, series: &mut [Pair; ORDER]) {
    let terms = polynomial.len().min(ORDER);
    let mut p = [0.0; ORDER];
    shifted(polynomial, s, &mut p);
    let mut factorial = 1.0;
    for (j, p) in p.iter_mut().enumerate().take(terms) {
        factorial *= j.max(1) as f64;
        *p *= factorial;
    }
    for (k, coefficient) in series.iter_mut().enumerate() {
        *coefficient = Pair::both(p[0]);
        let (n, nw) = (INVERSE[k + 1], INVERSE[k + 1] * w);
        for j in 0..terms {
            let next = if j + 1 < terms { n * p[j + 1] } else { 0.0 };
            p[j] = next - ((j + 1) as f64 * nw) * p[j];
        }
    }
}

/// Pieces of stretches that were checked.
pub(super) fn tapered(stretches: &[Stretch]) -> Vec<RodPiece> {
    let mut start = 0.0;
    let piece = |stretch: &Stretch| {
        let narrowing = (1.0 - stretch.tip_ratio) / stretch.length;
        let end = start + stretch.length;
        let piece = RodPiece { start, end, rigidity: stretch.flexural_rigidity, narrowing };
        start = end;
        piece
    };
    stretches.iter().map(piece).collect()
}

/// The stretches of a rod made of `segments`, joined in order from the base.
pub(super) fn pieces(segments: &[Segment]) -> Result<Vec<RodPiece>> {
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let mut end = 0.0;
    let mut pieces = Vec::with_capacity(segments.len());
    for (i, segment) in segments.iter().enumerate() {
        let checks = [
            ("length", segment.length, "m"),
            ("young_modulus", segment.young_modulus, "Pa"),
            ("second_moment", segment.second_moment, "m⁴"),
        ];
        for (name, value, unit) in checks {
            if !positive(value) {
                return Err(Error::data(format!("segment {i}: {name}"))
                    .value(value)
                    .allowed(format!("above 0 {unit}")));
            }
        }
        let start = end;
        end += segment.length;
        pieces.push(RodPiece { start, end, rigidity: segment.young_modulus * segment.second_moment, narrowing: 0.0 });
    }
    if pieces.is_empty() {
        return Err(Error::data("a rod needs at least one segment"));
    }
    Ok(pieces)
}
