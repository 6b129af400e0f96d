//! How fast a reading changes when a whisker meets something at a known distance, and back.

use crate::beam::{Whisker, moment_per_travel, moment_per_turn};
use crate::math;
use crate::{Error, Result};

/// How the base moves while the whisker touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// It turns at a constant rate: slopes are readings per second.
    Turn,
    /// It travels sideways: slopes are readings per metre of travel.
    Travel,
}

impl Motion {
    /// The word in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Turn => "turn",
            Self::Travel => "travel",
        }
    }

    /// The motion of this word, where there is one.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        [Self::Turn, Self::Travel].into_iter().find(|motion| motion.as_str() == word)
    }
}

/// The slope of a reading as a function of the radial distance of the contact: small deflections of a tapered shaft on an
/// elastic base, times a gain.
///
/// Rigidity, sensor gain and rate of motion only appear as one product, so the model knows the base's compliance relative
/// to the shaft's rigidity: `EI / k_base`, a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceModel {
    /// How the base moves.
    pub motion: Motion,
    /// Slope of the reading times m: units per s for a turn, units for a travel, for each 1/m of the shaft's response.
    pub gain: f64,
    /// Length of the shaft (m).
    pub length: f64,
    /// Tip radius over base radius.
    pub tip_ratio: f64,
    /// `EI / k_base` (m); 0 when clamped.
    pub base_compliance: f64,
    /// Standard deviation of a slope relative to the model.
    pub scatter: f64,
    /// Least and largest distance that it was fitted to (m).
    pub fitted: [f64; 2],
}

/// A distance with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Radial distance from the base (m).
    pub distance: f64,
    /// Standard deviation (m), from the scatter of the calibration.
    pub std: f64,
}

impl DistanceModel {
    /// The shaft with unit rigidity.
    fn shaft(&self) -> Whisker {
        Whisker {
            length: self.length,
            flexural_rigidity: 1.0,
            tip_ratio: self.tip_ratio,
            base_stiffness: 1.0 / self.base_compliance,
            ..Whisker::default()
        }
    }

    /// The slope of the reading for a contact at `distance` (m), positive.
    ///
    /// # Errors
    ///
    /// A distance off the shaft, a shaft that makes no sense.
    pub fn slope(&self, distance: f64) -> Result<f64> {
        let response = match self.motion {
            Motion::Turn => moment_per_turn(&self.shaft(), distance),
            Motion::Travel => moment_per_travel(&self.shaft(), distance),
        };
        response.map(|response| self.gain * response)
    }

    /// The distance at which the reading changes with this slope, of either sign.
    ///
    /// The slope falls strictly with distance. None when it is steeper than at a hundredth of the length or flatter than
    /// at the tip by more than four standard deviations; between, the nearer end.
    #[must_use]
    pub fn distance(&self, slope: f64) -> Option<Distance> {
        let target = slope.abs();
        let (mut near, mut far) = (0.01 * self.length, self.length);
        let at = |distance: f64| self.slope(distance).unwrap_or(f64::NAN);
        let slack = 1.0 + 4.0 * self.scatter;
        if !(target <= at(near) && target * slack >= at(far)) {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (near + far);
            if at(middle) > target { near = middle } else { far = middle }
        }
        let distance = 0.5 * (near + far);
        let (before, after) = (distance * (1.0 - 1e-4), (distance * (1.0 + 1e-4)).min(self.length));
        let fall = math::ln(at(before) / at(after)) / (after - before);
        Some(Distance { distance, std: self.scatter / fall })
    }

    /// Checks every number.
    ///
    /// # Errors
    ///
    /// Data: names what is out of range.
    pub fn check(&self) -> Result<()> {
        let named = [
            ("gain", self.gain, self.gain > 0.0, "above 0"),
            ("base_compliance", self.base_compliance, self.base_compliance >= 0.0, "0 m or more"),
            ("scatter", self.scatter, self.scatter >= 0.0, "0 or more"),
        ];
        for (name, value, right, allowed) in named {
            if !right || !value.is_finite() {
                return Err(Error::data(name).value(value).allowed(allowed));
            }
        }
        self.slope(self.length).map(drop)
    }
}
