//! A point or a vector of the plane.

use crate::math;
use core::ops::{Add, AddAssign, Mul, Neg, Sub};

/// A point or a vector of the plane, in metres unless said otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec2 {
    /// First coordinate (forward in a body frame).
    pub x: f64,
    /// Second coordinate (left in a body frame).
    pub y: f64,
}

impl Vec2 {
    /// The origin.
    pub const ZERO: Self = Self { x: 0.0, y: 0.0 };

    /// The vector `(x, y)`.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// The unit vector at `angle` (rad, counter-clockwise from +x).
    #[must_use]
    pub fn from_angle(angle: f64) -> Self {
        let (sin, cos) = math::sin_cos(angle);
        Self { x: cos, y: sin }
    }

    /// The scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// The z component of the vector product; positive when `other` is counter-clockwise of `self`.
    #[must_use]
    pub fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// The Euclidean length.
    #[must_use]
    pub fn norm(self) -> f64 {
        math::hypot(self.x, self.y)
    }

    /// The squared length.
    #[must_use]
    pub fn norm_squared(self) -> f64 {
        self.dot(self)
    }

    /// The direction as an angle in (-pi, pi] (rad); 0 for the zero vector.
    #[must_use]
    pub fn angle(self) -> f64 {
        math::atan2(self.y, self.x)
    }

    /// The vector turned by a quarter turn counter-clockwise.
    #[must_use]
    pub fn perp(self) -> Self {
        Self { x: -self.y, y: self.x }
    }

    /// The vector turned by `angle` (rad, counter-clockwise).
    #[must_use]
    pub fn rotated(self, angle: f64) -> Self {
        let (sin, cos) = math::sin_cos(angle);
        Self { x: cos * self.x - sin * self.y, y: sin * self.x + cos * self.y }
    }

    /// The distance to another point.
    #[must_use]
    pub fn distance(self, other: Self) -> f64 {
        (self - other).norm()
    }

    /// Whether both coordinates are finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

impl Add for Vec2 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y }
    }
}

impl AddAssign for Vec2 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Vec2 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y }
    }
}

impl Neg for Vec2 {
    type Output = Self;
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y }
    }
}

impl Mul<f64> for Vec2 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self { x: self.x * factor, y: self.y * factor }
    }
}

impl Mul<Vec2> for f64 {
    type Output = Vec2;
    fn mul(self, vector: Vec2) -> Vec2 {
        vector * self
    }
}
