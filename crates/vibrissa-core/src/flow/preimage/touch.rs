//! Places of the boundary that a whisker can touch, with the directions that the boundary has there.

use crate::plane::{Segment, Vec2, wrap_angle};
use crate::world::Map;
use core::f64::consts::{PI, TAU};

/// Parameters at which a curved piece is looked at before it is cut.
const LOOKS: usize = 17;
/// Turns of the outline smaller than this are rounding (rad).
const NO_TURN: f64 = 1e-9;

/// A short stretch of the boundary, or some of the directions in which a corner can be touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoundaryTouch {
    /// The middle (m), map frame.
    pub(super) position: Vec2,
    /// Direction of the boundary in the middle, free space on its left (rad).
    pub(super) tangent: f64,
    /// How far the direction differs from that within the stretch (rad).
    pub(super) half_turn: f64,
    /// How far the stretch reaches from its middle (m).
    pub(super) spread: f64,
    /// Whether it is a corner that turns towards free space, where only a tip finds room.
    pub(super) inner: bool,
}

/// All of the boundary that a whisker can touch, in stretches over which a body with its contact within
/// `reach` (m) moves by at most half of `spacing` (m) from its middle position.
///
/// Corners at which the boundary turns away from free space are touched at every direction in between, ends of walls over half a
/// turn. In corners that turn towards free space only a tip finds room, held by both walls.
pub(super) fn touches(map: &Map, spacing: f64, reach: f64) -> Vec<BoundaryTouch> {
    let mut found = Vec::new();
    for boundary in map.boundaries() {
        let segments: Vec<Segment> = boundary.curve().segments().to_vec();
        along(&segments, boundary.curve().is_closed(), spacing, reach, &mut found);
        if boundary.is_two_sided() {
            let back: Vec<Segment> = segments.iter().rev().map(Segment::reversed).collect();
            along(&back, boundary.curve().is_closed(), spacing, reach, &mut found);
            if !boundary.curve().is_closed() {
                for way in [&segments, &back] {
                    if let Some(last) = way.last() {
                        cone(last.end(), last.tangent(1.0), PI, spacing, reach, &mut found);
                    }
                }
            }
        }
    }
    found
}

fn along(segments: &[Segment], closed: bool, spacing: f64, reach: f64, found: &mut Vec<BoundaryTouch>) {
    for (index, segment) in segments.iter().enumerate() {
        let before = if index > 0 { segments.get(index - 1) } else { segments.last().filter(|_| closed) };
        if let Some(before) = before {
            let turn = wrap_angle(segment.tangent(0.0) - before.tangent(1.0));
            if turn < -NO_TURN {
                cone(segment.start(), before.tangent(1.0), -turn, spacing, reach, found);
            } else if turn > NO_TURN {
                let from = found.len();
                cone(segment.start(), segment.tangent(0.0), turn, spacing, reach, found);
                found[from..].iter_mut().for_each(|touch| touch.inner = true);
            }
        }
        stretches(segment, spacing, reach, found);
    }
}

fn stretches(segment: &Segment, spacing: f64, reach: f64, found: &mut Vec<BoundaryTouch>) {
    // How far a body moves by parameter: along with the place, and turned by the curvature.
    let rate = |t: f64| segment.derivatives(t).0.norm() * (1.0 + reach * segment.curvature(t).abs());
    let looks = if matches!(segment, Segment::Line(_)) { 1 } else { LOOKS };
    let most = (0..looks).map(|i| rate((i as f64 + 0.5) / looks as f64)).fold(0.0, f64::max);
    let slack = if looks > 1 { 1.3 } else { 1.0 };
    let count = (slack * most / spacing).ceil().clamp(1.0, 1e6) as usize;
    for i in 0..count {
        let at = |share: f64| (i as f64 + share) / count as f64;
        let (from, middle, to) = (at(0.0), at(0.5), at(1.0));
        let (position, tangent) = (segment.point(middle), segment.tangent(middle));
        let turn = |t: f64| wrap_angle(segment.tangent(t) - tangent).abs();
        let way = |t: f64| segment.point(t).distance(position);
        found.push(BoundaryTouch {
            position,
            tangent,
            half_turn: turn(from).max(turn(to)),
            spread: way(from).max(way(to)),
            inner: false,
        });
    }
}

/// A corner touched at every direction from `tangent` on, `turn` (rad) to the right.
fn cone(position: Vec2, tangent: f64, turn: f64, spacing: f64, reach: f64, found: &mut Vec<BoundaryTouch>) {
    let step = (spacing / reach).min(TAU / 8.0);
    let count = (turn / step).ceil().max(1.0) as usize;
    let half = 0.5 * turn / count as f64;
    found.extend((0..count).map(|i| BoundaryTouch {
        position,
        tangent: tangent - (2.0 * i as f64 + 1.0) * half,
        half_turn: half,
        spread: 0.0,
        inner: false,
    }));
}
