//! Where two pieces of a boundary meet, or the two sides of a wall at its end.

use crate::plane::{Vec2, wrap_angle};
use core::f64::consts::PI;

/// A turn below this is no corner (rad).
const SMOOTH: f64 = 1e-9;

/// Where two pieces meet, or the two sides of a wall at its end.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Map frame (m).
    pub position: Vec2,
    /// The piece before, and the parameter of its end here.
    pub before: (u32, f64),
    /// The piece after, and the parameter of its end here.
    pub after: (u32, f64),
    /// Direction of the normal before (rad, map frame).
    pub normal: f64,
    /// How far the normal turns to the one after (rad).
    pub turn: f64,
    /// 1 when the whisker is left of the direction of travel, -1 on a wall's right.
    pub(super) side: f64,
    /// Whether it is the end of a wall.
    pub(super) end: bool,
}

impl Corner {
    /// Whether a tip can be caught: free space closes in.
    #[must_use]
    pub fn is_concave(&self) -> bool {
        !self.end && self.turn * self.side > SMOOTH && self.turn.abs() < PI
    }

    /// Whether a side can lie on it.
    #[must_use]
    pub fn is_convex(&self) -> bool {
        self.end || self.turn * self.side < -SMOOTH
    }

    /// Whether it is the end of a wall.
    #[must_use]
    pub fn is_end(&self) -> bool {
        self.end
    }

    /// Whether the boundary goes on without a corner.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        self.turn.abs() <= SMOOTH
    }

    /// The direction half way between both normals (rad, map frame). What is nearest to a corner is on the free side of the boundary where
    /// it lies on this side of the corner \[baerentzen2005signed\]; the normal of one of the pieces alone tells it wrongly where the turn is
    /// above a right angle.
    #[must_use]
    pub fn outward(&self) -> f64 {
        self.normal + 0.5 * self.turn
    }

    /// Where a direction (rad, map frame) points within the corner: 0 along the normal before, 1 along the normal
    /// after.
    #[must_use]
    pub fn lean(&self, direction: f64) -> f64 {
        0.5 + wrap_angle(direction - self.outward()) / self.turn
    }

    /// The place across the corner from its end at the end (`forward`) or the start of `piece`.
    #[must_use]
    pub fn across(&self, piece: u32, forward: bool) -> (u32, f64) {
        // The two sides of a wall are travelled in one direction.
        let leaves = if self.end { self.before.0 == piece } else { forward };
        if leaves { self.after } else { self.before }
    }
}
