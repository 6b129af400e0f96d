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
        if self.is_empty() {
            return Self::point(state);
        }
        let middle = 0.5 * (self.theta.lo() + self.theta.hi());
        let theta = middle + wrap_angle(state.theta - middle);
        Self {
            x: self.x.hull(Interval::point(state.x)),
            y: self.y.hull(Interval::point(state.y)),
            theta: self.theta.hull(Interval::point(theta)),
        }
    }
}
