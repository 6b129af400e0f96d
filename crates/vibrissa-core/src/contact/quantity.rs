//! What of a whisker in contact is read.

use crate::beam::TipChart;
use crate::math;
use crate::world::{MountedWhisker, ReadingNoise};

/// What of a whisker is read; readings are dimensionless, as [`crate::beam::TipModel`] has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensedQuantity {
    /// The moment at the base, `M0 L / EI`.
    Moment,
    /// The contact force `F L² / EI`, negative when it pushes towards -y.
    Force,
    /// The slope at the contact (rad).
    Slope,
}

impl SensedQuantity {
    /// The declared bound on its readings (N m, N, rad).
    pub(crate) fn noise(self, whisker: &MountedWhisker) -> ReadingNoise {
        match self {
            Self::Moment => whisker.noise.into(),
            Self::Force => whisker.force_noise,
            Self::Slope => whisker.slope_noise,
        }
    }

    /// The reading of a whisker with its tip under this load, and its derivatives by force and tilt.
    pub(super) fn at_tip(self, tip: &TipChart, q: f64, beta: f64) -> (f64, [f64; 2]) {
        match self {
            Self::Moment => (tip.moment, [tip.by_force.moment, tip.by_tilt.moment]),
            Self::Force => {
                let side = 1.0_f64.copysign(math::cos(beta));
                (side * q, [side, 0.0])
            }
            Self::Slope => (tip.slope, [tip.by_force.slope, tip.by_tilt.slope]),
        }
    }

    /// The reading of a uniform whisker that is touched at the share `s` of its length, normal to it and from the side
    /// that `beta` says; `tip` is the part up to there at its own scale, under `q`. Derivatives by `q` and `s`.
    pub(super) fn at_side(self, tip: &TipChart, q: f64, s: f64, beta: f64) -> (f64, [f64; 2]) {
        match self {
            Self::Moment => (tip.moment / s, [tip.by_force.moment / s, -tip.moment / (s * s)]),
            Self::Force => {
                let per = 1.0_f64.copysign(math::cos(beta)) / (s * s);
                (per * q, [per, -2.0 * per * q / s])
            }
            Self::Slope => (tip.slope, [tip.by_force.slope, 0.0]),
        }
    }
}
