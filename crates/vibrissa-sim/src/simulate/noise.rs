//! Readings and odometry with bounded noise.

use crate::plane::Pose2;
use crate::world::{MomentNoise, increments};
use crate::{Error, Result};
use chacha20::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// How far readings and odometry stray from the exact ones: uniform, bounded and independent from row to row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepNoise {
    /// The seed; the same seed gives the same noise.
    pub seed: u64,
    /// Bounds on the moments' errors; none takes what each whisker declares.
    pub moment: Option<MomentNoise>,
    /// Bound on the error of each translation increment relative to it, at least 0 and below 1.
    pub translation_relative: f64,
    /// Bound on the error of each rotation increment relative to it, at least 0 and below 1.
    pub rotation_relative: f64,
}

impl SweepNoise {
    /// No noise at all.
    #[must_use]
    pub fn none() -> Self {
        Self { moment: Some(MomentNoise { moment_relative: 0.0, moment_absolute: 0.0 }), ..Self::default() }
    }

    /// The robot's declared moment noise from this seed, and exact odometry.
    #[must_use]
    pub fn seeded(seed: u64) -> Self {
        Self { seed, ..Self::default() }
    }

    pub(super) fn check(&self) -> Result<()> {
        let moment = self.moment.unwrap_or_default();
        for (name, value, below) in [
            ("moment_relative", moment.moment_relative, 1.0),
            ("moment_absolute", moment.moment_absolute, f64::INFINITY),
            ("translation_relative", self.translation_relative, 1.0),
            ("rotation_relative", self.rotation_relative, 1.0),
        ] {
            if !(value >= 0.0 && value < below) {
                return Err(Error::usage(format!("the noise's {name}"))
                    .value(value)
                    .allowed(format!("at least 0 and below {below}")));
            }
        }
        Ok(())
    }

    pub(super) fn dice(&self) -> Dice {
        Dice { noise: *self, rng: ChaCha8Rng::seed_from_u64(self.seed) }
    }
}

/// The noise with the random numbers drawn so far.
pub(super) struct Dice {
    noise: SweepNoise,
    rng: ChaCha8Rng,
}

impl Dice {
    /// Uniform in [-1, 1].
    fn signed(&mut self) -> f64 {
        self.rng.random_range(-1.0..=1.0)
    }

    /// A reading z of the moment `h` (N m): uniform among those with |h - z| <= relative |z| + absolute.
    pub(super) fn reading(&mut self, h: f64, declared: &MomentNoise) -> f64 {
        let noise = self.noise.moment.unwrap_or(*declared);
        let [low, high] = noise.readings(h.abs());
        let z = low + 0.5 * (1.0 + self.signed()) * (high - low);
        if h < 0.0 { -z } else { z }
    }

    /// The odometry of a robot with these poses, from the origin on.
    pub(super) fn odometry(&mut self, truth: impl Iterator<Item = Pose2>) -> Vec<Pose2> {
        let mut odom_from_robot = Pose2::IDENTITY;
        let mut poses = vec![odom_from_robot];
        for step in increments(truth) {
            odom_from_robot = odom_from_robot.compose(self.increment(step));
            poses.push(odom_from_robot);
        }
        poses
    }

    /// What odometry says of one increment (robot frame).
    pub(super) fn increment(&mut self, step: Pose2) -> Pose2 {
        let stretch = 1.0 + self.noise.translation_relative * self.signed();
        let turn = 1.0 + self.noise.rotation_relative * self.signed();
        Pose2::new(stretch * step.x, stretch * step.y, turn * step.theta)
    }
}
