//! What befalls a moment on its way to a reading, besides bounded noise.

use super::{Stream, in_range, normal, signed, stream, unit};
use crate::Result;
use chacha20::ChaCha8Rng;

/// Disturbances of the moments; 0 switches each off.
///
/// In this order: hysteresis, gain, offset and drift, then the bounded noise of [`super::SweepNoise`], then Gaussian
/// noise and outliers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbances {
    /// Width of the loop between rising and falling moments (N m): the reading lags by half of it.
    pub hysteresis: f64,
    /// Bound on each whisker's gain error; drawn once, uniform.
    pub gain_error: f64,
    /// Bound on each whisker's constant offset (N m); drawn once, uniform.
    pub offset: f64,
    /// Bound on the rate at which each whisker's offset drifts (N m/s); drawn once, uniform.
    pub drift: f64,
    /// Standard deviation of Gaussian noise relative to the reading.
    pub gaussian_relative: f64,
    /// Standard deviation of Gaussian noise (N m).
    pub gaussian_absolute: f64,
    /// Share of the readings that are outliers, at least 0 and below 1.
    pub outlier_share: f64,
    /// An outlier is off by up to this (N m), uniform.
    pub outlier_size: f64,
}

impl Disturbances {
    pub(super) fn check(&self) -> Result<()> {
        for (name, value, below) in [
            ("hysteresis", self.hysteresis, f64::INFINITY),
            ("gain_error", self.gain_error, 1.0),
            ("offset", self.offset, f64::INFINITY),
            ("drift", self.drift, f64::INFINITY),
            ("gaussian_relative", self.gaussian_relative, f64::INFINITY),
            ("gaussian_absolute", self.gaussian_absolute, f64::INFINITY),
            ("outlier_share", self.outlier_share, 1.0),
            ("outlier_size", self.outlier_size, f64::INFINITY),
        ] {
            in_range(name, value, below)?;
        }
        Ok(())
    }
}

/// One whisker's disturbances with what they remember.
pub(super) struct Distorted {
    options: Disturbances,
    gain: f64,
    offset: f64,
    drift: f64,
    /// The end of the play that hysteresis leaves.
    held: f64,
    gaussian: ChaCha8Rng,
    outliers: ChaCha8Rng,
}

impl Distorted {
    pub(super) fn new(options: &Disturbances, seed: u64, whisker: usize) -> Self {
        let mut once = stream(seed, Stream::Gain, whisker);
        let [gain, offset, drift] = [0; 3].map(|_| signed(&mut once));
        Self {
            options: *options,
            gain: 1.0 + options.gain_error * gain,
            offset: options.offset * offset,
            drift: options.drift * drift,
            held: 0.0,
            gaussian: stream(seed, Stream::Gaussian, whisker),
            outliers: stream(seed, Stream::Outliers, whisker),
        }
    }

    /// The moment (N m) that the sensor turns into a reading at the time `t` (s).
    pub(super) fn before_noise(&mut self, t: f64, moment: f64) -> f64 {
        let lag = 0.5 * self.options.hysteresis;
        self.held = self.held.clamp(moment - lag, moment + lag);
        self.gain * self.held + self.offset + self.drift * t
    }

    /// The reading (N m) that is recorded for one with bounded noise.
    pub(super) fn after_noise(&mut self, reading: f64) -> f64 {
        let Disturbances { gaussian_relative, gaussian_absolute, outlier_share, outlier_size, .. } = self.options;
        let mut out = reading;
        if gaussian_relative > 0.0 || gaussian_absolute > 0.0 {
            let (a, b) = (normal(&mut self.gaussian), normal(&mut self.gaussian));
            out += gaussian_relative * reading * a + gaussian_absolute * b;
        }
        if outlier_share > 0.0 {
            let (chance, size) = (unit(&mut self.outliers), signed(&mut self.outliers));
            if chance < outlier_share {
                out += outlier_size * size;
            }
        }
        out
    }
}
