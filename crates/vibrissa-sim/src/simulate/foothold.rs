//! Where on a boundary a tip stands, and what comes next along it.

use crate::plane::{Segment, Vec2, wrap_angle};
use crate::world::{Map, NearestPiece};
use core::f64::consts::{FRAC_PI_2, PI};

/// A place on one piece of a boundary, touched from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Foothold {
    pub(super) boundary: usize,
    pub(super) segment: usize,
    /// Parameter along the piece; beyond \[0, 1\] on the piece's continuation.
    pub(super) at: f64,
    /// 1 when free space lies left of the direction of travel, -1 when the whisker is on a wall's right.
    pub(super) side: f64,
}

/// The boundary at a foothold, map frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    pub(super) position: Vec2,
    /// Derivative of the position by the parameter (m).
    pub(super) velocity: Vec2,
    /// Direction of the normal towards the whisker (rad).
    pub(super) normal: f64,
    /// Derivative of the normal by the parameter (rad).
    pub(super) turning: f64,
}

/// Where two pieces join.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    pub(super) position: Vec2,
    /// The foothold on the piece before, at its end nearest to the joint.
    pub(super) before: Foothold,
    /// The foothold on the piece after.
    pub(super) after: Foothold,
    /// The normal before (rad), and how far it turns to the one after (rad).
    pub(super) normal: f64,
    pub(super) turn: f64,
}

impl Joint {
    /// Whether a tip can be caught: free space closes in.
    pub(super) fn is_concave(&self) -> bool {
        !self.is_end() && self.turn * self.before.side > SMOOTH
    }

    /// Whether it is the end of a wall.
    pub(super) fn is_end(&self) -> bool {
        self.before.side * self.after.side < 0.0
    }

    /// Whether the boundary goes on without a corner.
    pub(super) fn is_smooth(&self) -> bool {
        self.turn.abs() <= SMOOTH
    }

    /// Where a direction of the force (rad) points within the corner: 0 along the normal before, 1 along the normal after.
    pub(super) fn lean(&self, direction: f64) -> f64 {
        0.5 + wrap_angle(direction - self.normal - 0.5 * self.turn) / self.turn
    }
}

/// A turn below this is no corner (rad).
const SMOOTH: f64 = 1e-9;

impl Foothold {
    /// The foothold nearest to `point` within `reach` (m), touched from the side to which `away` points, and its distance.
    pub(super) fn nearest(map: &Map, point: Vec2, away: Vec2, reach: f64) -> Option<(Self, f64)> {
        let NearestPiece { boundary, segment, distance, .. } = map.nearest_piece(point, reach)?;
        let piece = &map.boundaries()[boundary].curve().segments()[segment];
        let at = piece.nearest(point);
        let left = Vec2::from_angle(piece.tangent(at)).cross(away) >= 0.0;
        let side = if map.boundaries()[boundary].is_two_sided() && !left { -1.0 } else { 1.0 };
        Some((Self { boundary, segment, at, side }, distance))
    }

    fn piece<'m>(&self, map: &'m Map) -> &'m Segment {
        &map.boundaries()[self.boundary].curve().segments()[self.segment]
    }

    /// The boundary here.
    pub(super) fn ground(&self, map: &Map) -> Ground {
        let piece = self.piece(map);
        let (velocity, second) = piece.derivatives(self.at);
        let turning =
            if velocity.norm_squared() > 0.0 { velocity.cross(second) / velocity.norm_squared() } else { 0.0 };
        let normal = wrap_angle(piece.tangent(self.at) + self.side * FRAC_PI_2);
        Ground { position: piece.point(self.at), velocity, normal, turning }
    }

    /// Whether the parameter has left what the piece can be continued to: anywhere for lines, little for Béziers.
    pub(super) fn is_lost(&self, map: &Map) -> bool {
        !matches!(self.piece(map), Segment::Line(_)) && !(-0.5..=1.5).contains(&self.at)
    }

    /// The joint at the start (`forward` false) or the end of the piece; at the end of an open wall the other side follows.
    pub(super) fn joint(&self, map: &Map, forward: bool) -> Joint {
        let curve = map.boundaries()[self.boundary].curve();
        let count = curve.segments().len();
        let (before, after) = match (forward, self.segment) {
            (true, s) if s + 1 < count => (s, s + 1),
            (true, s) if curve.is_closed() => (s, 0),
            (false, s) if s > 0 => (s - 1, s),
            (false, 0) if curve.is_closed() => (count - 1, 0),
            _ => return self.end(map, forward),
        };
        let before = Self { segment: before, at: 1.0, ..*self };
        let after = Self { segment: after, at: 0.0, ..*self };
        let (a, b) = (before.ground(map), after.ground(map));
        let turn = wrap_angle(b.normal - a.normal);
        Joint { position: a.position, before, after, normal: a.normal, turn }
    }

    /// The end of a wall: a convex corner of half a turn.
    fn end(&self, map: &Map, forward: bool) -> Joint {
        let here = Self { at: if forward { 1.0 } else { 0.0 }, ..*self };
        let there = Self { side: -here.side, ..here };
        let (before, after) = if forward { (here, there) } else { (there, here) };
        let ground = before.ground(map);
        // Which way round: the normal turns over the far side of the end.
        let turn = -PI * here.side;
        Joint { position: ground.position, before, after, normal: ground.normal, turn }
    }
}
