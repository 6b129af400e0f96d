//! Rigid motions of the plane, the group SE(2).

use super::Vec2;
use crate::math;
use core::f64::consts::{PI, TAU};

/// Angles below this (rad) are brought into range by one turn.
const NEAR: f64 = 9.0;

/// The angle brought into (-pi, pi] (rad).
///
/// Exact for angles already in the range; not a number stays not a number.
#[must_use]
pub fn wrap_angle(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    // Less than one and a half turns, which is exact as it is.
    if angle.abs() < NEAR {
        return angle - TAU.copysign(angle);
    }
    // The remainder is exact; subtracting the rounded multiple of a turn is not, for angles beyond 1e15.
    let rest = angle % TAU;
    if rest > PI {
        rest - TAU
    } else if rest <= -PI {
        rest + TAU
    } else {
        rest
    }
}

/// A pose or rigid motion of the plane: `world_from_body` maps body coordinates to world coordinates.
///
/// Frames are right-handed, x forward, y left, angles counter-clockwise (REP 103). The heading is kept in (-pi, pi].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose2 {
    /// Origin of the body in the world, first coordinate (m).
    pub x: f64,
    /// Origin of the body in the world, second coordinate (m).
    pub y: f64,
    /// Heading of the body in the world (rad).
    pub theta: f64,
}

/// A velocity of the plane times a time: the tangent space of [`Pose2`] at the identity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist2 {
    /// Forward part (m).
    pub x: f64,
    /// Leftward part (m).
    pub y: f64,
    /// Turn (rad), not wrapped.
    pub theta: f64,
}

impl Pose2 {
    /// The pose that changes nothing.
    pub const IDENTITY: Self = Self { x: 0.0, y: 0.0, theta: 0.0 };

    /// The pose at `(x, y)` (m) with heading `theta` (rad), which is wrapped into (-pi, pi].
    #[must_use]
    pub fn new(x: f64, y: f64, theta: f64) -> Self {
        Self { x, y, theta: wrap_angle(theta) }
    }

    /// The origin of the body in the world (m).
    #[must_use]
    pub fn position(self) -> Vec2 {
        Vec2::new(self.x, self.y)
    }

    /// The composition: `world_from_b = world_from_a.compose(a_from_b)`.
    ///
    /// This is the paper's motion model `T_k' = T_k T_local` \[routray, section "Motion Model"\].
    #[must_use]
    pub fn compose(self, other: Self) -> Self {
        let p = self.transform_point(other.position());
        Self::new(p.x, p.y, self.theta + other.theta)
    }

    /// The inverse motion: `body_from_world` of `world_from_body`.
    #[must_use]
    pub fn inverse(self) -> Self {
        let p = (-self.position()).rotated(-self.theta);
        Self::new(p.x, p.y, -self.theta)
    }

    /// The pose from which a motion leads to this one: `self.compose(motion.inverse())`.
    #[must_use]
    pub fn before(self, motion: Self) -> Self {
        let theta = wrap_angle(self.theta - motion.theta);
        let place = self.position() - motion.position().rotated(theta);
        Self { x: place.x, y: place.y, theta }
    }

    /// The motion from this pose to `other`, seen from this pose: `self.inverse().compose(other)`.
    #[must_use]
    pub fn between(self, other: Self) -> Self {
        self.inverse().compose(other)
    }

    /// A point of the body in world coordinates (m).
    #[must_use]
    pub fn transform_point(self, point: Vec2) -> Vec2 {
        self.position() + point.rotated(self.theta)
    }

    /// A point of the world in body coordinates (m).
    #[must_use]
    pub fn inverse_transform_point(self, point: Vec2) -> Vec2 {
        (point - self.position()).rotated(-self.theta)
    }

    /// The exponential map: where a body ends that moves with the constant twist for unit time.
    ///
    /// Exact to rounding for every turn, including none.
    #[must_use]
    pub fn exp(twist: Twist2) -> Self {
        let half = 0.5 * twist.theta;
        // sin(t)/t and (1-cos(t))/t, both without cancellation.
        let sinc = if half == 0.0 { 1.0 } else { math::sin(half) / half };
        let (a, b) = (sinc * math::cos(half), sinc * math::sin(half));
        Self::new(a * twist.x - b * twist.y, b * twist.x + a * twist.y, twist.theta)
    }

    /// The logarithm: the twist with the smallest turn whose exponential is this pose.
    #[must_use]
    pub fn log(self) -> Twist2 {
        let half = 0.5 * self.theta;
        // half * cot(half), which is 1 at zero and 0 at a half turn.
        let a = if half == 0.0 { 1.0 } else { half * math::cos(half) / math::sin(half) };
        Twist2 { x: a * self.x + half * self.y, y: a * self.y - half * self.x, theta: self.theta }
    }
}
