//! Axis-parallel boxes of robot states.

use super::Interval;
use crate::plane::{Pose2, wrap_angle};

/// A box of robot states in (x, y, theta), map frame (m, m, rad).
///
/// `theta` is an interval of the unrolled circle: it may leave (-pi, pi] where the box crosses the half turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateBox {
    /// First coordinate (m).
    pub x: Interval,
    /// Second coordinate (m).
    pub y: Interval,
    /// Heading (rad).
    pub theta: Interval,
}

impl StateBox {
    /// The empty box.
    pub const EMPTY: Self = Self { x: Interval::EMPTY, y: Interval::EMPTY, theta: Interval::EMPTY };

    /// The box of one state.
    #[must_use]
    pub fn point(state: Pose2) -> Self {
        Self { x: Interval::point(state.x), y: Interval::point(state.y), theta: Interval::point(state.theta) }
    }

    /// Whether no state is in the box.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty() || self.y.is_empty() || self.theta.is_empty()
    }

    /// The box grown to hold `state`, its heading taken on the turn nearest to the box.
    #[must_use]
    pub fn including(&self, state: Pose2) -> Self {
        self.hull(&Self::point(state))
    }

    /// The smallest box that holds both, the other's headings taken on the turn nearest to this one.
    #[must_use]
    pub fn hull(&self, other: &Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return if self.is_empty() { *other } else { *self };
        }
        let middle = |i: Interval| 0.5 * (i.lo() + i.hi());
        let (own, there) = (middle(self.theta), middle(other.theta));
        let shift = own + wrap_angle(there - own) - there;
        let theta = Interval::new(other.theta.lo() + shift, other.theta.hi() + shift);
        Self { x: self.x.hull(other.x), y: self.y.hull(other.y), theta: self.theta.hull(theta) }
    }
}
