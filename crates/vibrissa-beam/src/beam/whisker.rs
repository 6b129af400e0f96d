//! The whisker as a beam: its length, stiffness and rest shape.

use super::rod::Rod;
use super::stretch::{Stretch, Stretches};
use crate::config as defaults;
use crate::error::{Error, Result};
use alloc::string::ToString;
use core::cmp::Ordering;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Coefficients that the rest curvature may have beyond the constant one.
pub const CURVATURE_TERMS: usize = 5;

/// A thin elastic beam on a base, in its own frame: base at the origin, undeflected along +x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whisker {
    /// Arc length from base to tip (m), positive.
    pub length: f64,
    /// Flexural rigidity E I at the base (N m²), positive.
    pub flexural_rigidity: f64,
    /// Tip radius over base radius, from 0.001 to 1; the radius falls linearly.
    pub tip_ratio: f64,
    /// Intrinsic curvature at the base (1/m), counter-clockwise positive.
    pub curvature: f64,
    /// How it changes on the way: coefficients of `s, s², …` (1/m², 1/m³, …), zero for a constant curvature.
    pub curvature_rise: [f64; CURVATURE_TERMS],
    /// Rotational stiffness of the base (N m/rad); infinite when clamped.
    pub base_stiffness: f64,
    /// Several wires in a row; when there are any, they say rigidity and taper, and `length` is theirs together.
    pub stretches: Stretches,
    /// Diameter of the wire at the base (m), where it is known; for strains only.
    pub diameter: Option<f64>,
    /// Strain of the surface up to which the whisker springs back.
    pub strain_limit: f64,
}

impl Default for Whisker {
    /// The paper's whisker: 75 mm of straight 0.58 mm Nitinol wire, clamped.
    fn default() -> Self {
        Self {
            length: defaults::LENGTH,
            flexural_rigidity: defaults::FLEXURAL_RIGIDITY,
            tip_ratio: defaults::TIP_RATIO,
            curvature: defaults::CURVATURE,
            curvature_rise: [0.0; CURVATURE_TERMS],
            base_stiffness: defaults::BASE_STIFFNESS,
            stretches: Stretches::default(),
            diameter: Some(defaults::DIAMETER),
            strain_limit: defaults::STRAIN_LIMIT,
        }
    }
}

impl Whisker {
    /// A straight clamped whisker of several wires, joined in order from the base.
    ///
    /// # Errors
    /// Data: as [`Stretches::new`].
    pub fn of_stretches(stretches: &[Stretch]) -> Result<Self> {
        let list = Stretches::new(stretches)?;
        let first = stretches.first().copied().unwrap_or_default();
        Ok(Self {
            length: list.length(),
            flexural_rigidity: first.flexural_rigidity,
            diameter: first.diameter,
            stretches: list,
            ..Self::default()
        })
    }

    /// The rod that integrates this whisker, whatever it is made of.
    ///
    /// The closed form covers uniform whiskers better; the modes choose by themselves.
    ///
    /// # Errors
    /// Data: a whisker that makes no sense, see [`Rod::new`].
    pub fn rod(&self) -> Result<Rod> {
        Rod::new(self)
    }

    /// Whether the closed form covers this whisker: one wire, no taper, straight at rest, clamped.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        let is = |value: f64, only: f64| value.partial_cmp(&only) == Some(Ordering::Equal);
        is(self.tip_ratio, 1.0)
            && self.stretches.as_slice().is_empty()
            && self.curvature_terms().iter().all(|&term| is(term, 0.0))
            && is(self.base_stiffness, f64::INFINITY)
    }

    /// The rest curvature's coefficients by rising power of `s`: 1/m, 1/m², ….
    #[must_use]
    pub fn curvature_terms(&self) -> [f64; CURVATURE_TERMS + 1] {
        let mut terms = [self.curvature; CURVATURE_TERMS + 1];
        terms[1..].copy_from_slice(&self.curvature_rise);
        terms
    }

    /// The wire's radius at arc length `s` (m), where the diameter is known.
    #[must_use]
    pub fn radius_at(&self, s: f64) -> Option<f64> {
        if self.stretches.as_slice().is_empty() {
            let share = 1.0 - (1.0 - self.tip_ratio) * (s / self.length).clamp(0.0, 1.0);
            return self.diameter.map(|diameter| 0.5 * diameter * share);
        }
        self.stretches.radius_at(s)
    }

    /// The flexural rigidity at arc length `s` (N m²); at a joint that of the outer wire.
    #[must_use]
    pub fn rigidity_at(&self, s: f64) -> f64 {
        if self.stretches.as_slice().is_empty() {
            return self.flexural_rigidity * (1.0 - (1.0 - self.tip_ratio) * s / self.length).powi(4);
        }
        self.stretches.rigidity_at(s)
    }

    /// The rest curvature at arc length `s` (1/m).
    #[must_use]
    pub fn curvature_at(&self, s: f64) -> f64 {
        self.curvature_terms().iter().rev().fold(0.0, |sum, term| sum * s + term)
    }

    /// Checks that the whisker is straight at rest.
    ///
    /// # Errors
    /// Data: a term of the rest curvature that is not 0.
    pub fn require_straight(&self) -> Result<()> {
        match self.curvature_terms().into_iter().find(|term| term.partial_cmp(&0.0) != Some(Ordering::Equal)) {
            Some(term) => Err(Error::data("curvature")
                .value(term)
                .allowed("0")
                .remedy("this takes whiskers that are straight at rest")),
            None => Ok(()),
        }
    }

    /// Checks that the closed form covers this whisker: uniform, straight, clamped, with positive length and rigidity.
    ///
    /// # Errors
    /// Data: names the property at fault, its value and what can be done.
    pub fn require_uniform(&self) -> Result<()> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if !positive(self.length) {
            return Err(Error::data("whisker length").value(self.length).allowed("above 0 m"));
        }
        if !positive(self.flexural_rigidity) {
            return Err(Error::data("flexural_rigidity").value(self.flexural_rigidity).allowed("above 0 N m²"));
        }
        if !self.stretches.as_slice().is_empty() {
            return Err(Error::data("segments")
                .value(self.stretches.as_slice().len())
                .allowed("none")
                .remedy("whiskers of several wires have no closed form; give one flexural_rigidity"));
        }
        if let Some(term) = self.curvature_rise.iter().find(|term| term.partial_cmp(&&0.0) != Some(Ordering::Equal)) {
            return Err(Error::data("curvature")
                .value(term)
                .allowed("0 for every power of s")
                .remedy("curved whiskers have no closed form; use curvature = 0"));
        }
        let checks = [
            ("tip_ratio", self.tip_ratio, 1.0, "tapered whiskers have no closed form; use tip_ratio = 1"),
            ("curvature", self.curvature, 0.0, "curved whiskers have no closed form; use curvature = 0"),
            (
                "base_stiffness",
                self.base_stiffness,
                f64::INFINITY,
                "whiskers on elastic bases have no closed form; use base_stiffness = inf",
            ),
        ];
        for (name, value, only, remedy) in checks {
            // Written so that a value that is not a number is refused too.
            if value.partial_cmp(&only) != Some(Ordering::Equal) {
                return Err(Error::data(name).value(value).allowed(only.to_string()).remedy(remedy));
            }
        }
        Ok(())
    }
}
