//! A map's boundaries as a chain of pieces that a tip slides along: what a step of the forward model asks, precomputed.

use super::clearance::Clearance;
use crate::plane::{Segment, Vec2, wrap_angle};
use crate::world::{Map, NearestPiece};
use core::f64::consts::{FRAC_PI_2, PI};

/// A turn below this is no corner (rad).
const SMOOTH: f64 = 1e-9;

/// Corners that turn by no more than this are hopped over while an equilibrium is still looked for (rad).
const SLIGHT: f64 = 0.2;
/// Corners that turn by more than this are sharp, by as much as this alike (rad), and those further along the boundary than this
/// (m) are none of a place's own.
const SHARP: f64 = 0.3;
const ALIKE: f64 = 0.02;
const FARTHEST: f64 = 1.0;
/// Pieces that one hop may pass.
const MOST_HOPPED: usize = 16;

/// Where one piece ends and the next begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    /// The piece after.
    pub(super) next: u32,
    /// The corner, map frame (m).
    pub(super) position: Vec2,
    /// Normal of the piece before at its end (rad), and how far it turns to the one after (rad).
    pub(super) normal: f64,
    pub(super) turn: f64,
}

/// Where two pieces meet, or the two sides of a wall at its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Map frame (m).
    pub(super) position: Vec2,
    /// The pieces before and after, and the parameters of their ends here.
    pub(super) before: (u32, f64),
    pub(super) after: (u32, f64),
    /// Normal before (rad), and how far it turns to the one after (rad).
    pub(super) normal: f64,
    pub(super) turn: f64,
    /// 1 when the whisker is left of the direction of travel, -1 on a wall's right.
    side: f64,
    end: bool,
}

impl Corner {
    /// Whether a tip can be caught: free space closes in.
    pub(super) fn is_concave(&self) -> bool {
        !self.end && self.turn * self.side > SMOOTH && self.turn.abs() < PI
    }

    /// Whether a side can lie on it.
    pub(super) fn is_convex(&self) -> bool {
        self.end || self.turn * self.side < -SMOOTH
    }

    /// Whether it is the end of a wall.
    pub(super) fn is_end(&self) -> bool {
        self.end
    }

    /// Where a direction (rad) points within the corner: 0 along the normal before, 1 along the normal after.
    pub(super) fn lean(&self, direction: f64) -> f64 {
        0.5 + wrap_angle(direction - self.normal - 0.5 * self.turn) / self.turn
    }
}

/// One smooth piece of a boundary, seen from the side on which a whisker is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    segment: Segment,
    /// 1 when the whisker is left of the direction of travel, -1 on a wall's right.
    pub(super) side: f64,
    normal: f64,
    pub(super) length: f64,
    pub(super) before: Option<u32>,
    pub(super) joint: Option<Joint>,
    /// At the ends of a wall, start and end: which of them.
    tails: [Option<u32>; 2],
}

/// The boundary at a place of a piece, map frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) position: Vec2,
    /// Derivative of the position by the parameter (m).
    pub(super) velocity: Vec2,
    /// Direction of the normal towards the whisker (rad).
    pub(super) normal: f64,
    /// Derivative of the normal by the parameter (rad).
    pub(super) turning: f64,
}

impl Piece {
    /// The boundary at the parameter `at`, on the piece's continuation beyond \[0, 1\].
    pub(super) fn spot(&self, at: f64) -> Spot {
        if let Segment::Line([a, b]) = self.segment {
            let velocity = b - a;
            return Spot { position: a + velocity * at, velocity, normal: self.normal, turning: 0.0 };
        }
        let (velocity, second) = self.segment.derivatives(at);
        let square = velocity.norm_squared();
        let turning = if square > 0.0 { velocity.cross(second) / square } else { 0.0 };
        let normal = wrap_angle(self.segment.tangent(at) + self.side * FRAC_PI_2);
        Spot { position: self.segment.point(at), velocity, normal, turning }
    }

    /// Whether a place is behind the tangent at the parameter `at`, seen from where the whisker is.
    pub(super) fn is_behind(&self, at: f64, place: Vec2) -> bool {
        let spot = self.spot(at);
        self.side * spot.velocity.cross(place - spot.position) < 0.0
    }

    /// Whether it is a line.
    pub(super) fn is_straight(&self) -> bool {
        matches!(self.segment, Segment::Line(_))
    }

    /// Whether the parameter has left what the piece can be continued to: anywhere for lines, little for Béziers.
    pub(super) fn is_lost(&self, at: f64) -> bool {
        !matches!(self.segment, Segment::Line(_)) && !(-0.5..=1.5).contains(&at)
    }

    /// The parameter nearest to `point`.
    pub(super) fn nearest(&self, point: Vec2) -> f64 {
        self.segment.nearest(point)
    }

    /// The parameter at the arc length `s` from the piece's start.
    pub(super) fn parameter_at(&self, s: f64) -> f64 {
        self.segment.parameter_at(s)
    }
}

/// All pieces of a map; walls are there twice, once for each side.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    pub(super) pieces: Vec<Piece>,
    /// How far places are from all of them.
    pub(super) clearance: Clearance,
    /// The ends of walls.
    tails: Vec<Corner>,
    /// For each boundary its first piece, and for walls the first of their right side.
    first: Vec<(u32, u32)>,
}

impl Ground {
    /// The pieces of a map.
    pub(super) fn new(map: &Map) -> Self {
        let (mut pieces, mut first, mut tails) = (Vec::new(), Vec::new(), Vec::new());
        for boundary in map.boundaries() {
            let left = pieces.len() as u32;
            add_side(&mut pieces, boundary.curve().segments(), boundary.curve().is_closed(), 1.0);
            let right = if boundary.is_two_sided() { pieces.len() as u32 } else { left };
            if boundary.is_two_sided() {
                add_side(&mut pieces, boundary.curve().segments(), boundary.curve().is_closed(), -1.0);
            }
            if boundary.is_two_sided() && !boundary.curve().is_closed() && right > left {
                let count = right - left;
                tail(&mut pieces, &mut tails, (right, left), false);
                tail(&mut pieces, &mut tails, (left + count - 1, right + count - 1), true);
            }
            first.push((left, right));
        }
        Self { pieces, clearance: Clearance::new(map), tails, first }
    }

    /// The corner at the start (`forward` false) or the end of a piece, and its number; none at the end of an open outline.
    pub(super) fn corner_of(&self, piece: u32, forward: bool) -> Option<(u32, Corner)> {
        let here = &self.pieces[piece as usize];
        let before = if forward { Some(piece) } else { here.before };
        let id = match before.filter(|&b| self.pieces[b as usize].joint.is_some()) {
            Some(before) => before,
            None => self.pieces.len() as u32 + here.tails[usize::from(forward)]?,
        };
        Some((id, self.corner(id)?))
    }

    /// The corner of this number.
    pub(super) fn corner(&self, id: u32) -> Option<Corner> {
        let Some(piece) = self.pieces.get(id as usize) else {
            return self.tails.get(id as usize - self.pieces.len()).copied();
        };
        let joint = piece.joint?;
        let (before, after) = ((id, 1.0), (joint.next, 0.0));
        let Joint { position, normal, turn, .. } = joint;
        Some(Corner { position, before, after, normal, turn, side: piece.side, end: false })
    }

    /// Whether there are walls with ends.
    pub(super) fn has_ends(&self) -> bool {
        !self.tails.is_empty()
    }

    /// The length of all pieces (m).
    pub(super) fn length(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.length).sum()
    }

    /// The place that lies beyond an end of a piece by as much as the parameter `at` says, if only slight corners lie
    /// between: piece and parameter.
    pub(super) fn hop(&self, mut piece: u32, mut at: f64) -> (u32, f64) {
        for _ in 0..MOST_HOPPED {
            let here = &self.pieces[piece as usize];
            let forward = at > 1.0;
            let across = if forward { Some(piece) } else { here.before };
            let joint = across.and_then(|before| self.pieces[before as usize].joint);
            let (Some(before), Some(joint)) = (across, joint) else { break };
            if joint.turn.abs() > SLIGHT || !at.is_finite() {
                break;
            }
            let over = here.length * if forward { at - 1.0 } else { -at };
            let next = if forward { joint.next } else { before };
            let share = over / self.pieces[next as usize].length;
            (piece, at) = (next, if forward { share } else { 1.0 - share });
            if (0.0..=1.0).contains(&at) {
                break;
            }
        }
        (piece, at)
    }

    /// The places that lie as far behind or before a sharp corner as this one behind or before its own: pieces and parameters.
    ///
    /// A whisker that snaps out of a corner does so within a millimetre: of places on a grid none would feel the same.
    pub(super) fn as_far_from_corners(&self, (piece, at): (u32, f64)) -> Vec<(u32, f64)> {
        let mut places = Vec::new();
        for forward in [false, true] {
            let Some((turn, way)) = self.to_corner(piece, at, forward) else { continue };
            for (index, other) in self.pieces.iter().enumerate() {
                let Some(joint) = other.joint.filter(|joint| (joint.turn - turn).abs() < ALIKE) else { continue };
                let (from, along) = if forward { (index as u32, other.length - way) } else { (joint.next, way) };
                places.extend(self.walked(from, along));
            }
        }
        places
    }

    /// The next sharp corner behind or before a place: how far the boundary turns there (rad), and the way to it (m).
    fn to_corner(&self, piece: u32, at: f64, forward: bool) -> Option<(f64, f64)> {
        let start = &self.pieces[piece as usize];
        let done = start.segment.length_to(at);
        let (mut here, mut way) = (piece, if forward { start.length - done } else { done });
        while way <= FARTHEST {
            let before = if forward { here } else { self.pieces[here as usize].before? };
            let joint = self.pieces[before as usize].joint?;
            if joint.turn.abs() > SHARP {
                return Some((joint.turn, way));
            }
            here = if forward { joint.next } else { before };
            way += self.pieces[here as usize].length;
        }
        None
    }

    /// The place this far (m) along the boundary from the start of a piece, negative before it: piece and parameter.
    fn walked(&self, mut piece: u32, mut along: f64) -> Option<(u32, f64)> {
        while along < 0.0 {
            piece = self.pieces[piece as usize].before?;
            along += self.pieces[piece as usize].length;
        }
        while along > self.pieces[piece as usize].length {
            along -= self.pieces[piece as usize].length;
            piece = self.pieces[piece as usize].joint?.next;
        }
        Some((piece, self.pieces[piece as usize].parameter_at(along)))
    }

    /// The place nearest to `point` within `reach` (m), on the side on which `base` is: piece, parameter, distance.
    pub(super) fn nearest(&self, map: &Map, point: Vec2, base: Vec2, reach: f64) -> Option<(u32, f64, f64)> {
        let NearestPiece { boundary, segment, distance, on_line } = map.nearest_piece(point, reach)?;
        let (left_first, right_first) = self.first[boundary];
        let curve = map.boundaries()[boundary].curve();
        let piece = |segment: usize, left: bool| segment as u32 + if left { left_first } else { right_first };
        let Some(at) = on_line else {
            let near = curve.nearest_near_segment(segment, point);
            let left = Vec2::from_angle(near.tangent).cross(base - near.position) >= 0.0;
            let piece = piece(curve.segment_at(near.arc_length), left);
            return Some((piece, self.pieces[piece as usize].nearest(point), near.position.distance(point)));
        };
        let spot = self.pieces[piece(segment, true) as usize].spot(at);
        let left = spot.velocity.cross(base - spot.position) >= 0.0;
        // Where two meet it is the later one.
        let next = at >= 1.0 && segment + 1 < curve.segments().len();
        Some(if next { (piece(segment + 1, left), 0.0, distance) } else { (piece(segment, left), at, distance) })
    }
}

/// Appends one side of a curve.
fn add_side(pieces: &mut Vec<Piece>, segments: &[Segment], closed: bool, side: f64) {
    let (start, count) = (pieces.len(), segments.len());
    let normal = |segment: &Segment, at: f64| wrap_angle(segment.tangent(at) + side * FRAC_PI_2);
    for (i, segment) in segments.iter().enumerate() {
        let neighbour = |inside: bool, index: usize| (inside || closed).then_some((start + index % count) as u32);
        let next = neighbour(i + 1 < count, i + 1);
        let joint = next.map(|next| {
            let before = normal(segment, 1.0);
            let turn = wrap_angle(normal(&segments[(i + 1) % count], 0.0) - before);
            Joint { next, position: segment.end(), normal: before, turn }
        });
        let before = neighbour(i > 0, i + count - 1);
        pieces.push(Piece {
            segment: *segment,
            side,
            normal: normal(segment, 0.0),
            length: segment.length(),
            before,
            joint,
            tails: [None, None],
        });
    }
}

/// Appends an end of a wall: the side before, whose normal turns by half a turn over the end to the one after.
fn tail(pieces: &mut [Piece], tails: &mut Vec<Corner>, (before, after): (u32, u32), forward: bool) {
    let at = if forward { 1.0 } else { 0.0 };
    let spot = pieces[before as usize].spot(at);
    let id = Some(tails.len() as u32);
    [before, after].into_iter().for_each(|piece| pieces[piece as usize].tails[usize::from(forward)] = id);
    let (before, after) = ((before, at), (after, at));
    tails.push(Corner { position: spot.position, before, after, normal: spot.normal, turn: -PI, side: 1.0, end: true });
}
