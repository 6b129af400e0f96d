//! The whisker as a beam: its length, stiffness and rest shape.

use crate::config::defaults;

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
