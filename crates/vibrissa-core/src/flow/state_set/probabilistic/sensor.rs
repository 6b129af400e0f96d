//! Measurement model of one sensor: the quantity, its noise, and the robust cost of a residual \[triggs2000bundle, sec. 3\].

use crate::beam::{TipModel, TipReading};
use crate::contact::SensedQuantity;
use crate::contact::follow::{ElasticBase, Mechanics};
use crate::plane::Pose2;
use crate::world::MountedWhisker;

/// One sense of one whisker as the estimator needs it.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    pub(super) tip: TipModel,
    /// What yields under it, if it is uniform otherwise.
    pub(super) base: Option<ElasticBase>,
    pub(super) quantity: SensedQuantity,
    pub(super) robot_from_whisker: Pose2,
    /// Length (m).
    pub(super) length: f64,
    /// Dimensionless reading per N m, N or rad.
    pub(super) per_reading: f64,
    relative: f64,
    absolute: f64,
    /// How much further from 0 than that a free whisker's reading may be, since its zero was taken from a few readings.
    slack: f64,
    /// How fast the zero may drift (1/s).
    drift: f64,
    /// What the logarithm of the ratio that [`Sensor::variance_stabilised`] takes is at the mean.
    mean_log: f64,
}

/// A reading against a prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Residual {
    /// In standard deviations, of one law whatever the moment.
    pub(super) value: f64,
    /// In standard deviations.
    pub(super) plain: f64,
    /// The standard deviation (dimensionless reading).
    pub(super) std: f64,
    /// Whether the prediction's derivatives count.
    pub(super) informs: bool,
}

impl Sensor {
    pub(super) fn new(whisker: &MountedWhisker, tip: TipModel, quantity: SensedQuantity) -> Self {
        let (length, rigidity) = (whisker.beam.length, tip.rigidity());
        let noise = quantity.noise(whisker);
        let per_reading = match quantity {
            SensedQuantity::Moment => length / rigidity,
            SensedQuantity::Force => length * length / rigidity,
            SensedQuantity::Slope => 1.0,
        };
        Self {
            base: ElasticBase::of(&tip, quantity),
            tip,
            quantity,
            robot_from_whisker: whisker.robot_from_whisker,
            length: whisker.beam.length,
            per_reading,
            relative: noise.relative,
            mean_log: mean_log(noise.relative),
            absolute: (noise.absolute * per_reading).max(LEAST_ABSOLUTE),
            slack: 0.0,
            drift: match quantity {
                SensedQuantity::Moment => whisker.errors.zero_drift * per_reading,
                SensedQuantity::Force | SensedQuantity::Slope => 0.0,
            },
        }
    }

    /// A dimensionless reading as it is measured.
    pub(super) fn reading(&self, z: f64) -> TipReading {
        let value = z / self.per_reading;
        match self.quantity {
            SensedQuantity::Moment => TipReading::Moment(value),
            SensedQuantity::Force => TipReading::Force(value),
            SensedQuantity::Slope => TipReading::Slope(value),
        }
    }

    /// How its equilibria are solved, if those of a uniform whisker are solved like this.
    pub(super) fn solver<'a>(&'a self, uniform: Mechanics<'a>) -> Mechanics<'a> {
        if self.tip.is_uniform() || self.base.is_some() { uniform } else { Mechanics::Model(&self.tip) }
    }

    /// Whether a reading is more than noise on a free whisker.
    pub(super) fn is_contact(&self, z: f64) -> bool {
        self.is_contact_within(z, self.slack)
    }

    /// The same of a sensor whose zero may be off by so much (dimensionless reading).
    pub(super) fn is_contact_within(&self, z: f64, slack: f64) -> bool {
        z.abs() * (1.0 - self.relative) > self.absolute + slack
    }

    /// The declared bound of the noise of a reading of 0.
    pub(super) fn absolute_bound(&self) -> f64 {
        self.absolute
    }

    /// The same sensor with its zero taken from a few readings.
    pub(super) fn tared(&mut self) {
        self.slack = self.absolute;
    }

    /// Whether readings around this one, so far apart, may be those of a free whisker whose zero is within this bound.
    pub(super) fn is_steady(&self, middle: f64, bound: f64, spread: f64) -> bool {
        self.quantity == SensedQuantity::Moment
            && middle.abs() * (1.0 - self.relative) <= bound + self.absolute
            && spread <= 2.0 * (self.absolute + self.relative * middle.abs())
    }

    /// Mean and standard deviation of the readings of a moment: they lie evenly where `|h - z| <= r |z| + a`.
    pub(super) fn expected(&self, h: f64) -> (f64, f64) {
        let per = 1.0 / (1.0 - self.relative * self.relative);
        if h.abs() < self.absolute {
            return (h, self.absolute * per / SQRT_3);
        }
        let mean = (h.abs() + self.relative * self.absolute) * per;
        (mean.copysign(h), (self.relative * h.abs() + self.absolute) * per / SQRT_3)
    }

    /// By how much a reading like this one may have changed while the base went from one place to another (standard deviations of its noise).
    pub(super) fn wander(&self, from: Pose2, to: Pose2, z: f64) -> f64 {
        let step = from.between(to);
        let way = step.position().norm().max(step.theta.abs() * self.length);
        READING_OVER_WAY * way / self.length / self.expected(z).1
    }

    /// The residual in standard deviations as a logarithm's, for a moment of this sign, above the absolute error.
    ///
    /// Errors grow with the moment, so that in plain residuals a larger moment explains all readings better, all the more
    /// where a shared gain makes up for it. The ratio of the bound's width at the reading to that at the moment lies evenly
    /// between `1 - r` and `1 + r` whatever the moment, so its logarithm has the same law everywhere; its mean is taken
    /// off, and what is far below is continued in a straight line.
    fn variance_stabilised(&self, normalised_residual: f64, sign: f64) -> f64 {
        let r = self.relative;
        if r < LEAST_RELATIVE {
            return normalised_residual;
        }
        let ratio = 1.0 - r * sign * normalised_residual / SQRT_3;
        let log = if ratio > 0.5 { ratio.ln() } else { 0.5_f64.ln() + 2.0 * ratio - 1.0 };
        sign * SQRT_3 / r * (self.mean_log - log)
    }

    /// A reading against what is predicted; `pressed` where the whisker is held by a boundary, `glued` where it almost is and `h` is
    /// what a pull would make.
    pub(super) fn residual(&self, h: f64, z: f64, pressed: bool, glued: bool) -> Residual {
        let wanted = glued && self.is_contact(z);
        let (mean, std) = if pressed {
            self.expected(h)
        } else if wanted {
            (h, self.expected(z).1)
        } else {
            (if glued { 0.0 } else { h }, self.expected(0.0).1)
        };
        let plain = (mean - z) / std;
        let value =
            if pressed && h.abs() >= self.absolute { self.variance_stabilised(plain, h.signum()) } else { plain };
        Residual { value, plain, std, informs: pressed || wanted || !glued }
    }
}

/// What a sensor reads while its whisker is free, followed as fast as its zero may drift.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FreeLevel {
    reading: f64,
    /// When the whisker was last free (s).
    t: Option<f64>,
}

impl FreeLevel {
    /// Whether a reading at this time is that of a whisker in contact; otherwise the level follows it.
    pub(super) fn is_contact(&mut self, sensor: &Sensor, t: f64, z: f64) -> bool {
        let drifted = sensor.drift * (t - *self.t.get_or_insert(t)).max(0.0);
        let off = z - self.reading;
        if sensor.is_contact_within(off, sensor.slack + drifted) {
            return true;
        }
        self.reading += off.clamp(-drifted, drifted);
        self.t = Some(t);
        false
    }
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;
/// Readings are never taken to be more exact than this (dimensionless moment): a tip known to about a micrometre.
const LEAST_ABSOLUTE: f64 = 2e-5;

/// How much a dimensionless reading changes over a way of one length: the moment of a cantilever whose tip is moved sideways.
const READING_OVER_WAY: f64 = 3.0;

/// Below this relative bound residuals are taken plain: the logarithm's are the same, but for rounding.
const LEAST_RELATIVE: f64 = 1e-5;

/// The mean of the logarithm of what lies evenly between `1 - r` and `1 + r`.
fn mean_log(r: f64) -> f64 {
    ((1.0 + r) * r.ln_1p() - (1.0 - r) * (-r).ln_1p()) / (2.0 * r) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_and_noise_at_their_bounds_are_those_of_a_free_whisker() {
        let whisker = MountedWhisker::default();
        let tip = TipModel::new(&whisker.beam).unwrap_or_else(|error| panic!("{error}"));
        let sensor = Sensor::new(&whisker, tip, SensedQuantity::Moment);
        for zero in [1e-3, 0.02, 0.3] {
            // As far as a reading may be from the zero whose noise is relative to it.
            let farthest = (zero + sensor.absolute) / (1.0 - sensor.relative);
            for sign in [-1.0, 1.0] {
                assert!(sensor.is_steady(sign * farthest * (1.0 - 1e-12), zero, 0.0));
                assert!(!sensor.is_steady(sign * farthest * 1.001, zero, 0.0));
                assert!(!sensor.is_contact_within(sign * farthest * (1.0 - 1e-12), zero));
            }
        }
    }
}
