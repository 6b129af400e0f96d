//! Where on a boundary a tip stands, and what comes next along it.

use crate::plane::{Segment, Vec2, wrap_angle};
use crate::world::Map;
use core::f64::consts::FRAC_PI_2;

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
        self.turn * self.before.side > SMOOTH
    }
}

/// A turn below this is no corner (rad).
const SMOOTH: f64 = 1e-9;

impl Foothold {
    /// The foothold nearest to `point`, reached from `base`, and its distance; none for an empty map.
    pub(super) fn nearest(map: &Map, point: Vec2, base: Vec2) -> Option<(Self, f64)> {
        let near = map.nearest(point)?;
        let boundary = &map.boundaries()[near.boundary];
        let curve = boundary.curve();
        let after = (1..curve.segments().len()).find(|&i| curve.segment_start(i) > near.arc_length);
        let segment = after.map_or(curve.segments().len(), |i| i) - 1;
        let at = curve.segments()[segment].nearest(point);
        let left = Vec2::from_angle(near.tangent).cross(base - near.position) >= 0.0;
        let side = if boundary.is_two_sided() && !left { -1.0 } else { 1.0 };
        Some((Self { boundary: near.boundary, segment, at, side }, near.distance))
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

    /// The joint at the start (`forward` false) or the end of the piece; none at the end of an open wall.
    pub(super) fn joint(&self, map: &Map, forward: bool) -> Option<Joint> {
        let curve = map.boundaries()[self.boundary].curve();
        let count = curve.segments().len();
        let (before, after) = match (forward, self.segment) {
            (true, s) if s + 1 < count => (s, s + 1),
            (true, s) if curve.is_closed() => (s, 0),
            (false, s) if s > 0 => (s - 1, s),
            (false, 0) if curve.is_closed() => (count - 1, 0),
            _ => return None,
        };
        let before = Self { segment: before, at: 1.0, ..*self };
        let after = Self { segment: after, at: 0.0, ..*self };
        let (a, b) = (before.ground(map), after.ground(map));
        let turn = wrap_angle(b.normal - a.normal);
        Some(Joint { position: a.position, before, after, normal: a.normal, turn })
    }
}
