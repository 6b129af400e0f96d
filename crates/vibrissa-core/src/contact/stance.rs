//! How a whisker's base stands on a map.

use crate::math;
use crate::plane::{Pose2, Vec2};
use core::f64::consts::FRAC_PI_2;

/// The pose of a whisker's base, and the map as the whisker sees it: over its length.
#[derive(Clone, Copy, Debug)]
pub struct Stance {
    map_from_whisker: Pose2,
    sin: f64,
    cos: f64,
    per_length: f64,
}

impl Stance {
    /// A whisker of this length (m) at this pose.
    #[must_use]
    pub fn new(map_from_whisker: Pose2, length: f64) -> Self {
        let (sin, cos) = math::sin_cos(map_from_whisker.theta);
        Self { map_from_whisker, sin, cos, per_length: 1.0 / length }
    }

    /// The pose of the base.
    #[must_use]
    pub fn map_from_whisker(&self) -> Pose2 {
        self.map_from_whisker
    }

    /// The base, map frame (m).
    #[must_use]
    pub fn base(&self) -> Vec2 {
        self.map_from_whisker.position()
    }

    /// The heading of the base (rad).
    #[must_use]
    pub fn theta(&self) -> f64 {
        self.map_from_whisker.theta
    }

    /// A place of the map (m) in the whisker's frame, over the length.
    #[must_use]
    pub fn seen(&self, place: Vec2) -> Vec2 {
        self.turned(place - self.base())
    }

    /// A vector of the map (m) in the whisker's frame, over the length.
    #[must_use]
    pub fn turned(&self, v: Vec2) -> Vec2 {
        Vec2::new(self.cos * v.x + self.sin * v.y, self.cos * v.y - self.sin * v.x) * self.per_length
    }

    /// A place in the whisker's frame, over the length, in the map (m).
    #[must_use]
    pub fn placed(&self, p: Vec2) -> Vec2 {
        let length = 1.0 / self.per_length;
        self.base() + Vec2::new(self.cos * p.x - self.sin * p.y, self.sin * p.x + self.cos * p.y) * length
    }

    /// The direction of the whisker where it has this slope (rad, map frame).
    #[must_use]
    pub fn heading(&self, slope: f64) -> f64 {
        self.theta() + slope
    }

    /// The direction of a force with this tilt from the whisker's normal where it has this slope (rad, map frame).
    #[must_use]
    pub fn direction(&self, slope: f64, tilt: f64) -> f64 {
        self.theta() + slope + tilt + FRAC_PI_2
    }

    /// The derivatives by the base's x, y (1/m) and heading (1/rad) of what the adjoint `l` of the three equations
    /// stands for: the contact is at `target` (whisker frame, over the length), the force has its direction.
    #[must_use]
    pub fn gradient(&self, l: [f64; 3], target: Vec2) -> [f64; 3] {
        let (a, b) = (l[0] * self.per_length, l[1] * self.per_length);
        let turned = target.perp();
        [-(a * self.cos - b * self.sin), -(a * self.sin + b * self.cos), -(l[0] * turned.x + l[1] * turned.y + l[2])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_seen_is_where_it_was_placed() {
        let pose = Pose2::new(0.3, -0.2, 2.1);
        let stance = Stance::new(pose, 0.08);
        let place = pose.transform_point(Vec2::new(0.06, 0.02));
        let seen = stance.seen(place);
        assert!(seen.distance(Vec2::new(0.75, 0.25)) < 1e-14, "{seen:?}");
        assert!(stance.placed(seen).distance(place) < 1e-15);
        let along = Vec2::from_angle(stance.heading(0.4));
        assert!((Vec2::from_angle(stance.direction(0.4, 0.0)) - along.perp()).norm() < 1e-15);
    }
}
