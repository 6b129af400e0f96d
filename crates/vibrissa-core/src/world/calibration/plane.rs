//! From raw readings to the moments about both transverse axes of a whisker.

use super::curve::OVERREACH;
use crate::math;
use crate::sensing::{SURFACE_TERMS, excursion, surface};
use crate::{Error, Result};

/// The moments about both transverse axes, each a polynomial of two signals: excursions of the readings along two directions, by which the
/// cross-talk of a sensor that stands askew is undone.
///
/// The first moment is the one in the whisker's x-y plane, positive for a push towards +y; the second is across it, positive for a push
/// towards +z.
#[derive(Clone, Debug, PartialEq)]
pub struct MomentPlane {
    /// The columns that are read, two or more of `bx,by,bz` (T) or `ax,ay,az` (counts).
    pub inputs: Vec<String>,
    /// Their values without contact.
    pub rest: Vec<f64>,
    /// For each signal, how readings are summed (N m per unit of the inputs): the signal is nearly its moment.
    pub directions: [Vec<f64>; 2],
    /// For each signal, middle and half width of its calibrated range (N m).
    pub ranges: [[f64; 2]; 2],
    /// How far from the middle of both ranges contacts were recorded, in half widths: between 1 and the root of 2.
    pub reach: f64,
    /// For each moment (N m), the coefficients of [`surface`] of `(signal - middle) / half width`.
    pub coefficients: [[f64; SURFACE_TERMS]; 2],
    /// Root mean square of the residuals of each moment (N m).
    pub residual_rms: [f64; 2],
    /// Widest gap between the sizes of the moments of rising and of falling load (N m); 0 where only one of them was recorded.
    pub hysteresis: f64,
    /// Bounds on the errors of both moments (N m): no reading of the calibration, each judged by a surface that was fitted without its
    /// neighbours, is off by more.
    pub bound: [f64; 2],
    /// How many labelled contacts it rests on.
    pub samples: usize,
}

impl MomentPlane {
    /// Both signals, from -1 to 1 over their calibrated ranges.
    #[must_use]
    pub fn signals(&self, readings: &[f64]) -> [f64; 2] {
        [0, 1].map(|k| (excursion(readings, &self.rest, &self.directions[k]) - self.ranges[k][0]) / self.ranges[k][1])
    }

    /// Both moments (N m) for two signals, also beyond the calibrated range.
    #[must_use]
    pub fn at(&self, signals: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| surface(&self.coefficients[k], signals))
    }

    /// Both moments (N m) for readings of the inputs, in their order.
    ///
    /// # Errors
    ///
    /// Data: a reading more than 5 % beyond the calibrated range.
    pub fn moments(&self, readings: &[f64]) -> Result<[f64; 2]> {
        let signals = self.signals(readings);
        let most = 1.0 + 2.0 * OVERREACH;
        let size = math::hypot(signals[0], signals[1]);
        if signals.iter().all(|z| z.abs() <= most) && size <= most * self.reach {
            return Ok(self.at(signals));
        }
        let [[middle, half], [across_middle, across_half]] = self.ranges;
        let [u, v] = [middle + half * signals[0], across_middle + across_half * signals[1]];
        let [lo, hi, across_lo, across_hi] =
            [middle - half, middle + half, across_middle - across_half, across_middle + across_half];
        Err(Error::data(format!("{} beyond the calibrated range", self.inputs.join(",")))
            .value(format!("moments near {u:.3e} and {v:.3e} N m"))
            .allowed(format!("{lo:.3e} to {hi:.3e} and {across_lo:.3e} to {across_hi:.3e} N m, not both ends at once"))
            .remedy("calibrate over a wider range, or look for a jump of the sensor's zero"))
    }

    /// Checks every number.
    ///
    /// # Errors
    ///
    /// Data: names what is out of range.
    pub fn check(&self) -> Result<()> {
        let n = self.inputs.len();
        if n < 2 || self.rest.len() != n || self.directions.iter().any(|direction| direction.len() != n) {
            return Err(Error::data("inputs, rest and both directions must be of one length, 2 or more").value(n));
        }
        let numbers = self.rest.iter().chain(self.directions.iter().flatten()).chain(self.ranges.iter().flatten());
        if !numbers.chain(self.coefficients.iter().flatten()).all(|value| value.is_finite()) {
            return Err(Error::data("a number that is not finite"));
        }
        let widths = self.ranges.iter().all(|range| range[1] > 0.0);
        if !(widths && self.reach > 0.0 && self.bound.iter().all(|bound| *bound >= 0.0)) {
            return Err(Error::data("half widths and reach must be above 0 and the bounds not negative"));
        }
        Ok(())
    }
}
