//! What befalls odometry besides bounded errors of its increments.

use super::{Stream, TrueErrors, in_range, signed, stream};
use crate::flow::pose::StampedPose;
use crate::plane::Pose2;
use crate::world::increments;
use crate::{Error, Result};

/// A stretch of time in which the wheels slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// When it starts (s).
    pub t: f64,
    /// How long it lasts (s), at least 0.
    pub duration: f64,
    /// How much further the wheels turn than the robot goes: 1 counts every way twice; above -1.
    pub share: f64,
}

/// Systematic errors of odometry; the default has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OdometryErrors {
    /// Bound on the error of the wheels' scale; drawn once, uniform.
    pub scale_error: f64,
    /// Bound on the heading's drift (rad for each m of way); drawn once, uniform.
    pub heading_drift: f64,
    /// Slips of the wheels.
    pub slips: Vec<Slip>,
}

impl OdometryErrors {
    pub(super) fn check(&self) -> Result<()> {
        in_range("scale_error", self.scale_error, 1.0)?;
        in_range("heading_drift", self.heading_drift, f64::INFINITY)?;
        let odd = |s: &&Slip| !(s.t.is_finite() && s.duration >= 0.0 && s.share > -1.0 && s.share.is_finite());
        match self.slips.iter().find(odd) {
            Some(slip) => Err(Error::usage("a slip of the wheels")
                .value(format!("{slip:?}"))
                .allowed("a finite time, a duration of at least 0 s and a share above -1")),
            None => Ok(()),
        }
    }

    /// The path that the wheels count, from the true start on.
    pub(super) fn felt_path(&self, seed: u64, truth: &[StampedPose], errors: &TrueErrors) -> Vec<Pose2> {
        let poses = || truth.iter().map(|pose| pose.map_from_robot);
        let scaled = errors.odometry_translation.abs() > 0.0 || errors.odometry_rotation.abs() > 0.0;
        if *self == Self::default() && !scaled {
            return poses().collect();
        }
        let mut rng = stream(seed, Stream::Odometry, 0);
        let scale = 1.0 + self.scale_error * signed(&mut rng);
        let drift = self.heading_drift * signed(&mut rng);
        let mut felt: Vec<Pose2> = poses().take(1).collect();
        for (pair, step) in truth.windows(2).zip(increments(poses())) {
            let middle = 0.5 * (pair[0].t + pair[1].t);
            let slips = |s: &&Slip| (s.t..s.t + s.duration).contains(&middle);
            let slip: f64 = self.slips.iter().filter(slips).map(|s| 1.0 + s.share).product();
            let step = errors.counted(step);
            let way = step.position() * (scale * slip);
            let turned = Pose2::new(way.x, way.y, step.theta + drift * way.norm());
            felt.extend(felt.last().map(|last| last.compose(turned)));
        }
        felt
    }
}
