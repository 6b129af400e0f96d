//! Axis-parallel rectangles.

use super::Vec2;

/// A closed axis-parallel rectangle, or the empty set when a minimum exceeds a maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower left corner (m).
    pub min: Vec2,
    /// Upper right corner (m).
    pub max: Vec2,
}

impl Bounds {
    /// The empty set.
    pub const EMPTY: Self =
        Self { min: Vec2::new(f64::INFINITY, f64::INFINITY), max: Vec2::new(f64::NEG_INFINITY, f64::NEG_INFINITY) };

    /// The smallest rectangle that holds all points; empty when there is none.
    #[must_use]
    pub fn of(points: &[Vec2]) -> Self {
        points.iter().fold(Self::EMPTY, |b, &p| b.including(p))
    }

    /// The rectangle grown to hold `point`.
    #[must_use]
    pub fn including(self, point: Vec2) -> Self {
        Self {
            min: Vec2::new(self.min.x.min(point.x), self.min.y.min(point.y)),
            max: Vec2::new(self.max.x.max(point.x), self.max.y.max(point.y)),
        }
    }

    /// The smallest rectangle that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        self.including(other.min).including(other.max)
    }

    /// The rectangle larger by `margin` (m) on all sides.
    #[must_use]
    pub fn inflated(self, margin: f64) -> Self {
        let by = Vec2::new(margin, margin);
        Self { min: self.min - by, max: self.max + by }
    }

    /// Whether no point is in the set.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.min.x > self.max.x || self.min.y > self.max.y
    }

    /// Whether `point` is in the set.
    #[must_use]
    pub fn contains(self, point: Vec2) -> bool {
        self.min.x <= point.x && point.x <= self.max.x && self.min.y <= point.y && point.y <= self.max.y
    }

    /// Whether the two sets have a point in common.
    #[must_use]
    pub fn overlaps(self, other: Self) -> bool {
        self.min.x <= other.max.x && other.min.x <= self.max.x && self.min.y <= other.max.y && other.min.y <= self.max.y
    }

    /// The squared distance from `point` to the nearest point of the set (m²); 0 inside.
    #[must_use]
    pub fn distance_squared(self, point: Vec2) -> f64 {
        let dx = (self.min.x - point.x).max(point.x - self.max.x).max(0.0);
        let dy = (self.min.y - point.y).max(point.y - self.max.y).max(0.0);
        dx * dx + dy * dy
    }

    /// Width and height (m); zero for the empty set.
    #[must_use]
    pub fn size(self) -> Vec2 {
        if self.is_empty() { Vec2::ZERO } else { self.max - self.min }
    }
}
