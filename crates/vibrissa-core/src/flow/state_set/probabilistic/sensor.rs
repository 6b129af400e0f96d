//! Measurement model of one sensor: the quantity, its noise, and the robust cost of a residual \[triggs2000bundle, sec. 3\].

use crate::beam::{TipModel, TipReading};
use crate::contact::SensedQuantity;
use crate::contact::follow::Mechanics;
use crate::plane::Pose2;
use crate::world::MountedWhisker;

/// The most that one reading can speak against a place: a false reading costs this, not more.
pub(super) const OUTLIER_COST: f64 = 6.0;
/// What a reading costs while the whisker is in a contact that the model does not cover.
const UNKNOWN_COST: f64 = 3.0;

/// One sense of one whisker as the estimator needs it.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    pub(super) tip: TipModel,
    pub(super) quantity: SensedQuantity,
    pub(super) robot_from_whisker: Pose2,
    /// Length (m).
    pub(super) length: f64,
    /// Dimensionless reading per N m, N or rad.
    pub(super) per_reading: f64,
    relative: f64,
    absolute: f64,
    /// What the logarithm of the ratio that [`Sensor::variance_stabilised`] takes is at the mean.
    mean_log: f64,
}

/// How readings are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LikelihoodOptions {
    /// Standard deviations are enlarged by this.
    pub(super) std_inflation: f64,
    /// The most that one reading costs.
    pub(super) outlier_cost: f64,
}

impl LikelihoodOptions {
    /// As declared.
    pub(super) const DECLARED: Self = Self { std_inflation: 1.0, outlier_cost: OUTLIER_COST };
}

/// A reading against a prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WeightedResidual {
    /// Cost: minus the logarithm of the likelihood.
    pub(super) cost: f64,
    /// Residual (dimensionless moment).
    pub(super) residual: f64,
    /// Weight of its square in the normal equations.
    pub(super) weight: f64,
    /// The residual in standard deviations.
    pub(super) normalised_residual: f64,
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
            tip,
            quantity,
            robot_from_whisker: whisker.robot_from_whisker,
            length: whisker.beam.length,
            per_reading,
            relative: noise.relative,
            mean_log: mean_log(noise.relative),
            absolute: (noise.absolute * per_reading).max(LEAST_ABSOLUTE),
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
        if self.tip.is_uniform() { uniform } else { Mechanics::Model(&self.tip) }
    }

    /// Whether a reading is more than noise on a free whisker.
    pub(super) fn is_contact(&self, z: f64) -> bool {
        z.abs() * (1.0 - self.relative) > self.absolute
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

    /// Standard deviation of the relative error that all readings share, where nothing is said: a quarter of the bound.
    pub(super) fn gain_std(&self) -> f64 {
        0.25 * self.relative
    }

    /// The residual of a reading in standard deviations, once a shared relative error has been taken out.
    pub(super) fn normalised_without_gain(&self, h: f64, gain: f64, z: f64) -> f64 {
        let (mean, std) = self.expected(h);
        (mean + gain * h - z) / std
    }

    /// A reading against a moment; `pressed` where the whisker is held by
    /// a boundary, `glued` where it almost is and `h` is what a pull would make.
    pub(super) fn weighted_residual(
        &self,
        h: f64,
        z: f64,
        pressed: bool,
        glued: bool,
        likelihood: LikelihoodOptions,
    ) -> WeightedResidual {
        let wanted = glued && self.is_contact(z);
        let (mean, std) = if pressed {
            self.expected(h)
        } else if wanted {
            (h, self.expected(z).1)
        } else {
            (0.0, self.expected(0.0).1)
        };
        let normalised_residual = (mean - z) / std;
        let even = if pressed && h.abs() >= self.absolute {
            self.variance_stabilised(normalised_residual, h.signum())
        } else {
            normalised_residual
        };
        let std = std * likelihood.std_inflation;
        let residual = even * std / likelihood.std_inflation;
        let normalised_residual = normalised_residual / likelihood.std_inflation;
        let (cost, trust) = robust(even / likelihood.std_inflation, likelihood.outlier_cost);
        let weight = if pressed || wanted { trust / (std * std) } else { 0.0 };
        WeightedResidual { cost, residual, weight, normalised_residual }
    }

    /// The cost of a reading that the model cannot predict.
    pub(super) fn uncovered() -> WeightedResidual {
        WeightedResidual { cost: UNKNOWN_COST, normalised_residual: f64::INFINITY, ..WeightedResidual::default() }
    }
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;
/// Readings are never taken to be more exact than this (dimensionless moment): a tip known to about a micrometre.
const LEAST_ABSOLUTE: f64 = 2e-5;

/// Below this relative bound residuals are taken plain: the logarithm's are the same, but for rounding.
const LEAST_RELATIVE: f64 = 1e-5;

/// The mean of the logarithm of what lies evenly between `1 - r` and `1 + r`.
fn mean_log(r: f64) -> f64 {
    ((1.0 + r) * r.ln_1p() - (1.0 - r) * (-r).ln_1p()) / (2.0 * r) - 1.0
}

/// Cost and weight of a residual in standard deviations: Gaussian with a floor for false readings.
fn robust(normalised_residual: f64, outlier_cost: f64) -> (f64, f64) {
    if outlier_cost.is_infinite() {
        return (0.5 * normalised_residual * normalised_residual, 1.0);
    }
    let kernel = (-0.5 * normalised_residual * normalised_residual).exp();
    let floor = (-outlier_cost).exp();
    (-((kernel + floor) / (1.0 + floor)).ln(), kernel / (kernel + floor))
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;
    use crate::beam::Whisker;

    /// The paper's whisker with this noise, read in its own units.
    pub(in super::super) fn sensor(relative: f64, absolute: f64) -> Sensor {
        let tip = TipModel::new(&Whisker::default()).unwrap();
        let quantity = SensedQuantity::Moment;
        Sensor {
            tip,
            quantity,
            robot_from_whisker: Pose2::IDENTITY,
            length: 0.075,
            per_reading: 1.0,
            relative,
            absolute,
            mean_log: mean_log(relative),
        }
    }

    /// The readings that the declared bound allows, evenly: from `|h - z| <= r |z| + a` by hand, for `z` of `h`'s sign.
    fn readings(h: f64, r: f64, a: f64) -> impl Iterator<Item = f64> {
        let (low, high) = ((h.abs() - a) / (1.0 + r), (h.abs() + a) / (1.0 - r));
        (0..2000).map(move |i| (low + (f64::from(i) + 0.5) / 2000.0 * (high - low)).copysign(h))
    }

    #[test]
    fn residuals_have_one_law_whatever_the_moment() {
        for (r, a) in [(0.05, 1e-3), (0.2, 1e-4), (1e-3, 2e-2), (0.0, 1e-2), (0.4, 0.0)] {
            for h in [0.03, -0.3, 2.5] {
                let sensor = sensor(r, a);
                let all: Vec<WeightedResidual> = readings(h, r, a)
                    .map(|z| sensor.weighted_residual(h, z, true, true, LikelihoodOptions::DECLARED))
                    .collect();
                let std = sensor.expected(h).1;
                let mean = all.iter().map(|m| m.residual / std).sum::<f64>() / all.len() as f64;
                let square = all.iter().map(|m| (m.residual / std).powi(2)).sum::<f64>() / all.len() as f64;
                assert!(mean.abs() < 1e-3, "{r} {a} {h}: {mean}");
                assert!((square - 1.0).abs() < 1e-3 + r * r, "{r} {a} {h}: {square}");
            }
        }
    }

    #[test]
    fn moments_that_are_all_too_large_explain_no_better() {
        // With relative errors alone, moments and readings that are larger by the same share cost the same: nothing is won
        // by scaling both, as a shared gain does. Moments that are too large and too small by as much cost alike.
        let sensor = sensor(0.05, 1e-9);
        let cost = |h: f64, scale: f64| {
            readings(h, 0.05, 0.0)
                .map(|z| sensor.weighted_residual(h * scale, z, true, true, LikelihoodOptions::DECLARED).cost)
                .sum::<f64>()
                / 2000.0
        };
        for h in [0.1, -1.0] {
            assert!((cost(h, 1.0) - cost(2.0 * h, 1.0)).abs() < 1e-6);
            let (more, less) = (cost(h, 1.02), cost(h, 1.0 / 1.02));
            assert!(more > cost(h, 1.0) + 0.1 && (more - less).abs() < 0.02, "{more} {less}");
        }
    }
}
