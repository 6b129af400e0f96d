//! Where a whisker meets boundaries: the unloaded one on its way, the bent one elsewhere than at its contact.

use super::{Equilibrium, PointLoad, WhiskerOnMap};
use crate::beam::Bend;
use crate::config::limits::FLATTEN_TOLERANCE;
use crate::contact::{Hold, Push, Support};
use crate::math;
use crate::plane::{Bounds, Pose2, Twist2, Vec2, segment_contact, wrap_angle};
use crate::world::Map;
use core::f64::consts::FRAC_PI_2;

/// The free whisker is looked at every so much of its tip's travel (m).
const LOOK_EVERY: f64 = 1e-4;
/// A boundary no further from the tip than this is met by the tip (m).
const AT_TIP: f64 = 3.0 * FLATTEN_TOLERANCE;
/// Chords of the bent whisker that are looked at, up to its contact and as many beyond, and parts of those that come
/// close to a boundary.
const CHORDS: usize = 12;
const PARTS: usize = 8;
/// Share of the length before a tip in contact that is not looked at, for it touches.
const AT_CONTACT: f64 = 2e-3;
/// The bent whisker is looked at this far to the free side (m), so that what it lies on does not count.
const ASIDE: f64 = 2.0 * FLATTEN_TOLERANCE;
/// Force with which the search for the first equilibrium starts, over `EI / L²`.
const FIRST_FORCE: f64 = 1e-6;

/// The pose a share of the way from `a` to `b`, on the geodesic of SE(2).
#[must_use]
pub fn between(a: Pose2, b: Pose2, share: f64) -> Pose2 {
    if share >= 1.0 {
        return b;
    }
    let step = a.between(b).log();
    a.compose(Pose2::exp(Twist2 { x: share * step.x, y: share * step.y, theta: share * step.theta }))
}

/// Where the unloaded whisker at this pose meets a boundary, map frame; none when it is clear of all.
#[must_use]
pub fn meets(map: &Map, rest: &[Vec2], map_from_whisker: Pose2) -> Option<Vec2> {
    rest.windows(2).find_map(|chord| {
        let (a, b) = (map_from_whisker.transform_point(chord[0]), map_from_whisker.transform_point(chord[1]));
        if !map.crosses(a, b) {
            return None;
        }
        let mut place = a;
        map.for_each_edge_in(Bounds::of(&[a, b]).inflated(0.0), |[c, d]| match segment_contact(a, b, c, d) {
            Some(point) => {
                place = point;
                true
            }
            None => false,
        });
        Some(place)
    })
}

/// The share of the way from `from` to `to`, both `map_from_whisker`, at which the unloaded whisker first touches; none
/// when the way is clear.
#[must_use]
pub fn first_touch(map: &Map, rest: &[Vec2], from: Pose2, to: Pose2) -> Option<f64> {
    let touches = |share: f64| {
        let pose = between(from, to, share);
        rest.windows(2).any(|chord| map.crosses(pose.transform_point(chord[0]), pose.transform_point(chord[1])))
    };
    let tip = rest[rest.len() - 1];
    let travel = from.transform_point(tip).distance(to.transform_point(tip));
    let travel = travel.max(from.position().distance(to.position()));
    let looks = ((travel / LOOK_EVERY).ceil() as usize).max(1);
    let share_of = |look: usize| look as f64 / looks as f64;
    let hit = (0..=looks).find(|&look| touches(share_of(look)))?;
    let (mut free, mut touching) = (share_of(hit.saturating_sub(1)), share_of(hit));
    for _ in 0..50 {
        let middle = 0.5 * (free + touching);
        if touches(middle) { touching = middle } else { free = middle }
    }
    Some(touching)
}

/// The contact, still without force, of the unloaded whisker that touches at this pose; none where its place is not
/// understood.
#[must_use]
pub fn onset(on: &WhiskerOnMap<'_>) -> Option<Equilibrium> {
    let (boundaries, whisker, pose) = (on.boundaries, on.whisker, on.stance.map_from_whisker());
    let tip = pose.transform_point(whisker.rest[whisker.rest.len() - 1]);
    if let Some((piece, at)) = boundaries.nearest_facing(on.map, tip, pose.position() - tip, AT_TIP) {
        let spot = boundaries.spot((piece, at));
        let slope = whisker.at(PointLoad { q: 0.0, s: 1.0, beta: 0.0 })?.slope;
        let beta = wrap_angle(spot.normal - pose.theta - slope - FRAC_PI_2);
        let load = PointLoad { q: 0.0, s: 1.0, beta };
        let (state, hold) = (whisker.at(load)?, Hold::Tip(Support::Piece(piece, at)));
        return Some(Equilibrium { load, state, hold, place: spot.position, stuck: true, sliding: 0.0 });
    }
    let place = meets(on.map, &whisker.rest, pose)?;
    let s = along(&whisker.rest, pose.inverse_transform_point(place)) / whisker.beam.length;
    let (near, at) = boundaries.nearest_facing(on.map, place, Vec2::ZERO, 2.0 * AT_TIP)?;
    for piece in core::iter::once(near).chain(boundaries.other_side(near)) {
        for push in [Push::Left, Push::Right] {
            let load = PointLoad { q: FIRST_FORCE, s, beta: push.tilt() };
            let Some(state) = whisker.at(load) else { continue };
            if let Some(hold) = side_hold(on, (piece, at), push, on.stance.heading(state.slope)) {
                return Some(Equilibrium { load, state, hold, place, stuck: true, sliding: 0.0 });
            }
        }
    }
    None
}

/// What a side that points along `heading` (rad) touches at a place of a piece: a corner whose normals it fits, or the
/// piece itself.
#[must_use]
pub fn side_hold(on: &WhiskerOnMap<'_>, (piece, at): (u32, f64), push: Push, heading: f64) -> Option<Hold> {
    let across = heading + push.tilt() + FRAC_PI_2;
    let spot = on.boundaries.spot((piece, at));
    let near = on.boundaries.corner_of(piece, at > 0.5).filter(|(_, corner)| {
        corner.position.distance(spot.position) <= AT_TIP && !corner.is_concave() && !corner.is_smooth()
    });
    if let Some((id, corner)) = near {
        return (0.0..=1.0).contains(&corner.lean(across)).then_some(Hold::Side(Support::Corner(id), push));
    }
    (math::cos(across - spot.normal) > 0.999).then_some(Hold::Side(Support::Piece(piece, at), push))
}

/// Arc length of the point of a polyline nearest to `point` (m).
fn along(line: &[Vec2], point: Vec2) -> f64 {
    let (mut best, mut found, mut start) = (f64::INFINITY, 0.0, 0.0);
    for chord in line.windows(2) {
        let way = chord[1] - chord[0];
        let length = way.norm();
        let at = ((point - chord[0]).dot(way) / (length * length)).clamp(0.0, 1.0);
        let off = (chord[0] + way * at).distance(point);
        if off < best {
            (best, found) = (off, start + at * length);
        }
        start += length;
    }
    found
}

/// Where the bent whisker meets a boundary elsewhere than at its contact, map frame; none when it does not.
///
/// Looked at `ASIDE` to the side to which it is pushed. Between the ends of the chords the whisker is a cubic with
/// their directions, within 0.1 µm of the true one.
#[must_use]
pub fn blocked(on: &WhiskerOnMap<'_>, bend: &Bend, push: Push) -> Option<Vec2> {
    let (length, pose) = (on.whisker.beam.length, on.stance.map_from_whisker());
    let aside = ASIDE * push.sign();
    let last = if bend.s_a < length { length } else { (1.0 - AT_CONTACT) * length };
    // A whisker that touches near its base bends all of its way within a small part of itself.
    let even = |from: f64, to: f64| (1..=CHORDS).map(move |i| from + (to - from) * (i as f64 / CHORDS as f64));
    let arcs = core::iter::once(0.0).chain(even(0.0, bend.s_a.min(length)));
    let beyond = even(bend.s_a, length).filter(|_| bend.s_a < length);
    let ends: Vec<(f64, Vec2, Vec2)> = bend
        .points_at(arcs.chain(beyond))
        .into_iter()
        .map(|(s, point)| {
            let along = Vec2::from_angle(point.slope + pose.theta);
            (s, pose.transform_point(point.position) + along.perp() * aside, along)
        })
        .collect();
    ends.windows(2).find_map(|pair| {
        let ((s0, p0, t0), (s1, p1, t1)) = (pair[0], pair[1]);
        // The arc stays within an eighth of its turn times the chord; a quarter is safe.
        let sag = 0.25 * t0.distance(t1) * (s1 - s0) + ASIDE;
        let mut near = false;
        on.map.for_each_edge_in(Bounds::of(&[p0, p1]).inflated(sag), |edge| {
            near = passes(edge, p0, p1, sag);
            near
        });
        if !near {
            return None;
        }
        let width = s1 - s0;
        let place = |s: f64| {
            let u = (s - s0) / width;
            let (v, uv) = (1.0 - u, u * (1.0 - u) * width);
            p0 * (v * v * (1.0 + 2.0 * u)) + t0 * (uv * v) + p1 * (u * u * (1.0 + 2.0 * v)) - t1 * (uv * u)
        };
        let crossed = |from: f64, to: f64| {
            if to <= from {
                return None;
            }
            let parts = (PARTS as f64 * (to - from) / width).ceil().max(1.0);
            let at = |i: f64| place(from + (to - from) * i / parts);
            (0..parts as usize).find_map(|i| {
                let (a, b) = (at(i as f64), at(i as f64 + 1.0));
                on.map.crosses(a, b).then_some(a)
            })
        };
        crossed(s0, s1.min(last))
    })
}

/// Whether an edge comes within `reach` of the line through the chord: cheap, and never wrong when it says no.
fn passes([c, d]: [Vec2; 2], a: Vec2, b: Vec2, reach: f64) -> bool {
    let along = b - a;
    let limit = reach * along.norm();
    let (left, right) = (along.cross(c - a), along.cross(d - a));
    !((left > limit && right > limit) || (left < -limit && right < -limit))
}
