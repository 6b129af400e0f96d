//! A map's boundaries as chains of one-sided pieces with corners between them: what a continuation along them asks for,
//! precomputed.
//!
//! A place on a boundary is the number of a piece and the parameter along it. A piece says on which side the whisker
//! is; thin walls have pieces for both sides.

use super::clearance::Clearance;
use super::corner::Corner;
use super::hold::Support;
use super::simplification::simplified;
use crate::plane::{Segment, Vec2, wrap_angle};
use crate::world::{Boundary, Map, NearestPiece, PieceCourse};
use core::f64::consts::{FRAC_PI_2, PI};

/// Corners that turn by no more than this are hopped over while an equilibrium is still looked for (rad).
const SLIGHT: f64 = 0.2;
/// Pieces that one hop may pass.
const MOST_HOPPED: usize = 16;

/// One smooth piece of a boundary, seen from the side on which a whisker is.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    segment: Segment,
    side: f64,
    normal: f64,
    length: f64,
    before: Option<u32>,
    /// The corner at its end.
    corner: Option<Corner>,
    /// At the ends of a wall, start and end: which of them.
    tails: [Option<u32>; 2],
    /// How exactly its course is known, if not exactly.
    course: Option<KnownCourse>,
}

/// What is known of a piece: what its boundary says of it, and where it lies along that.
#[derive(Clone, Copy, Debug)]
struct KnownCourse {
    piece: PieceCourse,
    boundary: u32,
    /// Arc length of the boundary before it (m).
    begins: f64,
    correlation_length: f64,
}

/// How exactly a boundary is known at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallKnowledge {
    /// Exactly.
    Exact,
    /// Within a band.
    Band {
        /// Standard deviation across the wall (m).
        std: f64,
        /// The stretch of boundary, among all, along which the error is taken to be one.
        stretch: (u32, u32),
    },
    /// Not at all.
    Unknown,
}

/// Errors that are alike over a length `l`, by `exp(-|s| / l)`, carry as much information along a wall as those that are one over each
/// stretch of so many `l`: both have the same integral of their autocorrelation.
const STRETCH: f64 = 2.0;

/// The boundary at a place of a piece, map frame.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// The place (m).
    pub position: Vec2,
    /// Derivative of the position by the parameter (m).
    pub velocity: Vec2,
    /// Direction of the normal towards the whisker (rad).
    pub normal: f64,
    /// Derivative of the normal by the parameter (rad).
    pub turning: f64,
}

impl Piece {
    /// The boundary at the parameter `at`, on the piece's continuation beyond \[0, 1\].
    #[must_use]
    pub fn spot(&self, at: f64) -> Spot {
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

    /// 1 when the whisker is left of the direction of travel, -1 on a wall's right.
    #[must_use]
    pub fn side(&self) -> f64 {
        self.side
    }

    /// Its length (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Whether a place is behind the tangent at the parameter `at`, seen from where the whisker is.
    fn is_behind(&self, at: f64, place: Vec2) -> bool {
        let spot = self.spot(at);
        self.side * spot.velocity.cross(place - spot.position) < 0.0
    }

    /// Whether it is a line.
    #[must_use]
    pub fn is_straight(&self) -> bool {
        matches!(self.segment, Segment::Line(_))
    }

    /// Whether the parameter has left what the piece can be continued to: anywhere for lines, little for Béziers.
    #[must_use]
    pub fn is_lost(&self, at: f64) -> bool {
        !matches!(self.segment, Segment::Line(_)) && !(-0.5..=1.5).contains(&at)
    }

    /// The parameter nearest to `point`.
    #[must_use]
    pub fn nearest(&self, point: Vec2) -> f64 {
        self.segment.nearest(point)
    }

    /// The parameter at the arc length `s` from the piece's start.
    #[must_use]
    pub fn parameter_at(&self, s: f64) -> f64 {
        self.segment.parameter_at(s)
    }
}

/// All boundaries of a map as one-sided pieces; walls are there twice, once for each side.
#[derive(Clone, Debug)]
pub struct Boundaries {
    pub(crate) pieces: Vec<Piece>,
    /// How far places are from all of them.
    pub(super) clearance: Clearance,
    /// The ends of walls.
    tails: Vec<Corner>,
    /// For each boundary its first piece, and for walls the first of their right side.
    first: Vec<(u32, u32)>,
    /// For each boundary which piece, counted from its first, stands for each of its segments; nothing where each has its own.
    stands_for: Vec<Vec<u32>>,
}

impl Boundaries {
    /// The boundaries of a map.
    #[must_use]
    pub fn new(map: &Map) -> Self {
        Self::of(map, |_| None)
    }

    /// The same with runs of short edges as single ones where nothing is said of how exactly they are known.
    pub(crate) fn simplified(map: &Map) -> Self {
        Self::of(map, |boundary| match boundary.course() {
            Some(_) => None,
            None => simplified(boundary.curve().segments()),
        })
    }

    /// The boundaries of a map, each with its segments or with others, and which of these stands for each segment.
    fn of(map: &Map, others: impl Fn(&Boundary) -> Option<(Vec<Segment>, Vec<u32>)>) -> Self {
        let (mut pieces, mut first, mut tails) = (Vec::new(), Vec::new(), Vec::new());
        let mut stands_for = Vec::new();
        for boundary in map.boundaries() {
            let left = pieces.len() as u32;
            let (simpler, whose) = others(boundary).unzip();
            let segments = simpler.as_deref().unwrap_or(boundary.curve().segments());
            stands_for.push(whose.unwrap_or_default());
            add_side(&mut pieces, segments, boundary.curve().is_closed(), 1.0);
            add_course(&mut pieces[left as usize..], boundary, first.len() as u32);
            let right = if boundary.is_two_sided() { pieces.len() as u32 } else { left };
            if boundary.is_two_sided() {
                add_side(&mut pieces, segments, boundary.curve().is_closed(), -1.0);
                add_course(&mut pieces[right as usize..], boundary, first.len() as u32);
            }
            if boundary.is_two_sided() && !boundary.curve().is_closed() && right > left {
                let count = right - left;
                tail(&mut pieces, &mut tails, (right, left), false);
                tail(&mut pieces, &mut tails, (left + count - 1, right + count - 1), true);
            }
            first.push((left, right));
        }
        Self { pieces, clearance: Clearance::default(), tails, first, stands_for }
    }

    /// The same with a grid of how far places are from them all, for the many looks of [`super::follow`].
    pub(crate) fn with_clearance(self, map: &Map) -> Self {
        Self { clearance: Clearance::new(map), ..self }
    }

    /// The piece of this number.
    #[must_use]
    pub fn piece(&self, piece: u32) -> &Piece {
        &self.pieces[piece as usize]
    }

    /// The boundary at a place: the number of a piece and the parameter.
    #[must_use]
    pub fn spot(&self, (piece, at): (u32, f64)) -> Spot {
        self.piece(piece).spot(at)
    }

    /// The corner at the start (`forward` false) or the end of a piece, and its number; none at the end of an open
    /// outline.
    #[must_use]
    pub fn corner_of(&self, piece: u32, forward: bool) -> Option<(u32, Corner)> {
        let here = &self.pieces[piece as usize];
        let before = if forward { Some(piece) } else { here.before };
        let id = match before.filter(|&b| self.pieces[b as usize].corner.is_some()) {
            Some(before) => before,
            None => self.pieces.len() as u32 + here.tails[usize::from(forward)]?,
        };
        Some((id, self.corner(id)?))
    }

    /// The corner of this number: that of the piece before it, and for the ends of walls numbers beyond those of the
    /// pieces.
    #[must_use]
    pub fn corner(&self, id: u32) -> Option<Corner> {
        match self.pieces.get(id as usize) {
            Some(piece) => piece.corner,
            None => self.tails.get(id as usize - self.pieces.len()).copied(),
        }
    }

    /// How exactly the boundary is known where a whisker rests; at a corner as the piece before it ends.
    #[must_use]
    pub fn knowledge(&self, on: Support) -> WallKnowledge {
        let (piece, at) = match on {
            Support::Piece(piece, at) => (piece, at),
            Support::Corner(id) => self.corner(id).map_or((id, 1.0), |corner| corner.before),
        };
        let Some(here) = self.pieces.get(piece as usize) else { return WallKnowledge::Exact };
        let Some(known) = here.course else { return WallKnowledge::Exact };
        match known.piece {
            PieceCourse::Unknown(_) => WallKnowledge::Unknown,
            PieceCourse::Band([from, to]) => {
                let share = at.clamp(0.0, 1.0);
                let std = from.std + (to.std - from.std) * share;
                let along = (known.begins + share * here.length) / (STRETCH * known.correlation_length);
                WallKnowledge::Band { std, stretch: (known.boundary, along.max(0.0) as u32) }
            }
        }
    }

    /// Whether all of them are known exactly.
    pub(crate) fn are_exact(&self) -> bool {
        self.pieces.iter().all(|piece| piece.course.is_none())
    }

    /// Whether there are walls with ends.
    pub(crate) fn has_ends(&self) -> bool {
        !self.tails.is_empty()
    }

    /// The place that lies beyond an end of a piece by as much as the parameter `at` says, if only slight corners lie
    /// between: piece and parameter.
    pub(super) fn hop(&self, mut piece: u32, mut at: f64) -> (u32, f64) {
        for _ in 0..MOST_HOPPED {
            let here = &self.pieces[piece as usize];
            let forward = at > 1.0;
            let across = if forward { Some(piece) } else { here.before };
            let corner = across.and_then(|before| self.pieces[before as usize].corner.as_ref());
            let (Some(before), Some(corner)) = (across, corner) else { break };
            if corner.turn.abs() > SLIGHT || !at.is_finite() {
                break;
            }
            let over = here.length * if forward { at - 1.0 } else { -at };
            let next = if forward { corner.after.0 } else { before };
            let share = over / self.pieces[next as usize].length;
            (piece, at) = (next, if forward { share } else { 1.0 - share });
            if (0.0..=1.0).contains(&at) {
                break;
            }
        }
        (piece, at)
    }

    /// The place nearest to `point` within `reach` (m), on the side on which `base` is: piece, parameter, distance.
    #[must_use]
    pub fn nearest(&self, map: &Map, point: Vec2, base: Vec2, reach: f64) -> Option<(u32, f64, f64)> {
        let NearestPiece { boundary, segment, distance, on_line } = map.nearest_piece(point, reach)?;
        let curve = map.boundaries()[boundary].curve();
        let piece = |segment: usize, left: bool| self.piece_of(boundary, segment, left);
        let Some(at) = on_line else {
            let near = curve.nearest_near_segment(segment, point);
            let left = Vec2::from_angle(near.tangent).cross(base - near.position) >= 0.0;
            let piece = piece(curve.segment_at(near.arc_length), left);
            return Some((piece, self.pieces[piece as usize].nearest(point), near.position.distance(point)));
        };
        let here = &self.pieces[piece(segment, true) as usize];
        let joined = !self.stands_for[boundary].is_empty();
        let at = if joined { here.nearest(point).clamp(0.0, 1.0) } else { at };
        let spot = here.spot(at);
        let left = spot.velocity.cross(base - spot.position) >= 0.0;
        // Where two meet it is the later one.
        let is_end = at >= 1.0 && segment + 1 < curve.segments().len();
        let (own, after) = (piece(segment, left), piece(segment + usize::from(is_end), left));
        Some(if after == own { (own, at, distance) } else { (after, 0.0, distance) })
    }

    /// The piece that stands for a segment of a boundary, on its left side or its right one.
    fn piece_of(&self, boundary: usize, segment: usize, left: bool) -> u32 {
        let (left_first, right_first) = self.first[boundary];
        let index = self.stands_for[boundary].get(segment).copied().unwrap_or(segment as u32);
        index + if left { left_first } else { right_first }
    }

    /// Whether a place is behind the boundary, where this place of it is the nearest, seen from where the whisker is.
    #[must_use]
    pub fn is_behind(&self, (piece, at): (u32, f64), place: Vec2) -> bool {
        let corner = if at <= 0.0 || at >= 1.0 { self.corner_of(piece, at > 0.5) } else { None };
        match corner.filter(|(_, corner)| !corner.is_smooth()) {
            Some((_, corner)) => (place - corner.position).dot(Vec2::from_angle(corner.outward())) < 0.0,
            None => self.piece(piece).is_behind(at, place),
        }
    }

    /// The place nearest to `point` within `reach` (m), touched from the side to which `away` points: piece and
    /// parameter.
    #[must_use]
    pub fn nearest_facing(&self, map: &Map, point: Vec2, away: Vec2, reach: f64) -> Option<(u32, f64)> {
        let NearestPiece { boundary, segment, .. } = map.nearest_piece(point, reach)?;
        let here = &self.pieces[self.piece_of(boundary, segment, true) as usize];
        let at = here.nearest(point);
        let left = Vec2::from_angle(here.segment.tangent(at)).cross(away) >= 0.0;
        Some((self.piece_of(boundary, segment, left), at))
    }

    /// The piece on the other side of a wall; none for outlines.
    #[must_use]
    pub fn other_side(&self, piece: u32) -> Option<u32> {
        let boundary = self.first.partition_point(|&(left, _)| left <= piece).checked_sub(1)?;
        let (left, right) = self.first[boundary];
        (right > left).then(|| if piece >= right { piece - right + left } else { piece - left + right })
    }
}

/// Tells the pieces of one side what is known of them.
fn add_course(pieces: &mut [Piece], boundary: &Boundary, number: u32) {
    let Some(course) = boundary.course() else { return };
    let correlation_length = course.correlation_length();
    for (index, (piece, known)) in pieces.iter_mut().zip(course.pieces()).enumerate() {
        let begins = boundary.curve().segment_start(index);
        piece.course = Some(KnownCourse { piece: *known, boundary: number, begins, correlation_length });
    }
}

/// Appends one side of a curve.
fn add_side(pieces: &mut Vec<Piece>, segments: &[Segment], closed: bool, side: f64) {
    let (start, count) = (pieces.len(), segments.len());
    let normal = |segment: &Segment, at: f64| wrap_angle(segment.tangent(at) + side * FRAC_PI_2);
    for (i, segment) in segments.iter().enumerate() {
        let neighbour = |inside: bool, index: usize| (inside || closed).then_some((start + index % count) as u32);
        let next = neighbour(i + 1 < count, i + 1);
        let corner = next.map(|next| {
            let (before, after) = (((start + i) as u32, 1.0), (next, 0.0));
            let at_end = normal(segment, 1.0);
            let turn = wrap_angle(normal(&segments[(i + 1) % count], 0.0) - at_end);
            Corner { position: segment.end(), before, after, normal: at_end, turn, side, end: false }
        });
        let before = neighbour(i > 0, i + count - 1);
        pieces.push(Piece {
            segment: *segment,
            side,
            normal: normal(segment, 0.0),
            length: segment.length(),
            before,
            corner,
            tails: [None, None],
            course: None,
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
