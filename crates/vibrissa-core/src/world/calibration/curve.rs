//! From raw readings to the moment about the base, and from moments to the tip's retreat.

use crate::sensing::{excursion, polynomial};
use crate::{Error, Result};

/// How far beyond the calibrated range a reading may lie, as a share of the range.
pub(super) const OVERREACH: f64 = 0.05;

/// The moment as a polynomial of one signal, the readings' excursion along a fixed direction
/// \[routray, section "Sensor Calibration"\].
#[derive(Clone, Debug, PartialEq)]
pub struct MomentCurve {
    /// The columns that are read, such as `bx,by,bz` (T) or `ax,ay,az` (counts).
    pub inputs: Vec<String>,
    /// Their values without contact.
    pub rest: Vec<f64>,
    /// The unit vector along which contact moves them.
    pub direction: Vec<f64>,
    /// Middle and half width of the calibrated range of the signal (unit of the inputs).
    pub range: [f64; 2],
    /// Moment (N m) by rising power of `(signal - middle) / half width`.
    pub coefficients: Vec<f64>,
    /// Root mean square of the residuals (N m).
    pub residual_rms: f64,
    /// Widest gap between the curves of rising and of falling load (N m); 0 where only one of them was recorded.
    pub hysteresis: f64,
    /// Bound on the error of a moment, for estimators that work with sets (N m): no reading of the calibration, each
    /// judged by a curve that was fitted without its neighbours, is off by more.
    pub bound: f64,
    /// How many labelled contacts it rests on.
    pub samples: usize,
}

impl MomentCurve {
    /// The readings' excursion along the direction of contact.
    #[must_use]
    pub fn signal(&self, readings: &[f64]) -> f64 {
        excursion(readings, &self.rest, &self.direction)
    }

    /// The moment (N m) for a signal, also beyond the calibrated range.
    #[must_use]
    pub fn at(&self, signal: f64) -> f64 {
        let z = (signal - self.range[0]) / self.range[1];
        polynomial(&self.coefficients, z)
    }

    /// The moment (N m) for readings of the inputs, in their order.
    ///
    /// # Errors
    ///
    /// Data: a reading more than 5 % beyond the calibrated range.
    pub fn moment(&self, readings: &[f64]) -> Result<f64> {
        let signal = self.signal(readings);
        let z = (signal - self.range[0]) / self.range[1];
        if z.abs() <= 1.0 + 2.0 * OVERREACH {
            return Ok(self.at(signal));
        }
        let [lo, hi] = self.valid();
        Err(Error::data(format!("{} beyond the calibrated range", self.inputs.join(",")))
            .value(format!("{signal:.6e}"))
            .allowed(format!("{lo:.6e} to {hi:.6e} along the direction of contact"))
            .remedy("calibrate over a wider range, or look for a jump of the sensor's zero"))
    }

    /// Least and largest calibrated signal (unit of the inputs).
    #[must_use]
    pub fn valid(&self) -> [f64; 2] {
        [self.range[0] - self.range[1], self.range[0] + self.range[1]]
    }
}

/// How far the tip retreats along the undeflected whisker under a moment: `delta_x = c0 M² + c1 M⁴`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipDeflection {
    /// Coefficients of M² and M⁴ (m/(N m)², m/(N m)⁴).
    pub coefficients: [f64; 2],
    /// Largest moment that it was fitted to (N m), either sign.
    pub largest_moment: f64,
    /// Root mean square of the residuals (m): large where contacts lie at many places along the whisker, because then
    /// the moment alone does not tell.
    pub residual_rms: f64,
}

impl TipDeflection {
    /// The retreat of the tip (m) under `moment` (N m); none beyond the fitted range.
    #[must_use]
    pub fn at(&self, moment: f64) -> Option<f64> {
        let square = moment * moment;
        let [c0, c1] = self.coefficients;
        (moment.abs() <= self.largest_moment).then_some(square * (c0 + c1 * square))
    }
}

/// Constants of the whisker that were fitted, and how well the data fix them.
#[derive(Clone, Debug, PartialEq)]
pub struct WhiskerConstants {
    /// Flexural rigidity at the base (N m²).
    pub flexural_rigidity: f64,
    /// Rotational stiffness of the base (N m/rad); infinite when clamped.
    pub base_stiffness: f64,
    /// Tip radius over base radius.
    pub tip_ratio: f64,
    /// The names of the constants that were fitted, in the order of the covariance; of a base stiffness its inverse.
    pub free: Vec<String>,
    /// Their covariance.
    pub covariance: Vec<Vec<f64>>,
    /// Root mean square of the residuals (N m; of the raw signal where no moments were measured).
    pub residual_rms: f64,
    /// How many labelled contacts they rest on.
    pub samples: usize,
}
