//! Noise of a magnetometer, the same on every machine.

use vibrissa_beam::sensing::Vec3;

/// Independent errors of the three axes with a triangular law: within √6 standard deviations.
#[derive(Clone, Debug)]
pub struct FluxNoise {
    deviation: f64,
    state: u64,
}

impl FluxNoise {
    /// Errors of this standard deviation (T).
    #[must_use]
    pub fn new(deviation: f64, seed: u64) -> Self {
        Self { deviation, state: seed }
    }

    /// The largest error (T).
    #[must_use]
    pub fn most(deviation: f64) -> f64 {
        // The square root of 6.
        2.449_489_742_783_178 * deviation
    }

    /// The errors of the next reading (T).
    pub fn draw(&mut self) -> Vec3 {
        [0; 3].map(|_| Self::most(self.deviation) * 0.5 * (self.even() + self.even()))
    }

    /// An even number from -1 to 1 (the linear congruential generator of Knuth's MMIX).
    fn even(&mut self) -> f64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 11) as f64 * 2.0 / (1_u64 << 53) as f64 - 1.0
    }
}
