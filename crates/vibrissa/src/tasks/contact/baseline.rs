//! The closed forms of earlier work: one reading, the motion of the base since the first touch, small angles.

use super::reading::ContactReading;
use crate::plane::{Pose2, Vec2};

/// Contact distances along the undeflected whisker, for small angles (m); none where the formula has no answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Baseline {
    /// From the base's rotation alone, `d = 3 EI θ / M0` \[kaneko1998active\].
    pub rotation: Option<f64>,
    /// From the base's translation across the whisker alone, `d = sqrt(3 EI t_y / M0)` \[routray, eq. "distanceEquation"\].
    pub translation: Option<f64>,
    /// From both: the root of `M0 d² = 3 EI (t_y + θ d)`.
    pub both: Option<f64>,
}

impl Baseline {
    /// The estimates for a reading when the whisker was straight, and just touched, at `onset` (odometry frame).
    #[must_use]
    pub fn since(onset: Pose2, reading: &ContactReading) -> Self {
        let moved = onset.between(reading.odom_from_whisker);
        // What the base does to one side, the contact does to the other.
        let (across, turn) = (-moved.y, -moved.theta);
        let curvature = reading.moment / (3.0 * reading.whisker.flexural_rigidity);
        let sensible = |d: f64| (d.is_finite() && d > 0.0).then_some(d);
        let root = (turn * turn + 4.0 * curvature * across).sqrt();
        let both = (turn + root.copysign(curvature)) / (2.0 * curvature);
        Self {
            rotation: sensible(turn / curvature),
            translation: sensible((across / curvature).sqrt()),
            both: sensible(both),
        }
    }

    /// The contact that a distance stands for, whisker frame (m).
    #[must_use]
    pub fn contact(reading: &ContactReading, distance: f64) -> Vec2 {
        let y = reading.moment * distance * distance / (3.0 * reading.whisker.flexural_rigidity);
        Vec2::new(distance, y)
    }
}
