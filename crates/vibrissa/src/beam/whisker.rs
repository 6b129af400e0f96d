//! The whisker as a beam: its length, stiffness and rest shape.

use crate::config::defaults;
use crate::error::{Error, Result};
use core::cmp::Ordering;

/// A thin elastic beam on a base, in its own frame: base at the origin, undeflected along +x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whisker {
    /// Arc length from base to tip (m), positive.
    pub length: f64,
    /// Flexural rigidity E I at the base (N m²), positive.
    pub flexural_rigidity: f64,
    /// Tip radius over base radius, in (0, 1]; the radius falls linearly.
    pub tip_ratio: f64,
    /// Intrinsic curvature (1/m), counter-clockwise positive.
    pub curvature: f64,
    /// Rotational stiffness of the base (N m/rad); infinite when clamped.
    pub base_stiffness: f64,
}

impl Default for Whisker {
    /// The paper's whisker: 75 mm of straight 0.58 mm Nitinol wire, clamped.
    fn default() -> Self {
        Self {
            length: defaults::LENGTH,
            flexural_rigidity: defaults::FLEXURAL_RIGIDITY,
            tip_ratio: defaults::TIP_RATIO,
            curvature: defaults::CURVATURE,
            base_stiffness: defaults::BASE_STIFFNESS,
        }
    }
}

impl Whisker {
    /// Whether the closed form covers this whisker: no taper, straight at rest, clamped.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        let is = |value: f64, only: f64| value.partial_cmp(&only) == Some(Ordering::Equal);
        is(self.tip_ratio, 1.0) && is(self.curvature, 0.0) && is(self.base_stiffness, f64::INFINITY)
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
