//! Where a whisker meets boundaries: the straight one on its way, the bent one with its side.

use super::equilibrium::Stance;
use super::foothold::Foothold;
use crate::beam::Bend;
use crate::config::limits::FLATTEN_TOLERANCE;
use crate::plane::{Pose2, Twist2, Vec2};
use crate::world::Map;

/// The free whisker is looked at every so much of its tip's travel (m).
const LOOK_EVERY: f64 = 1e-4;
/// A boundary no further from the tip than this is met by the tip (m).
const AT_TIP: f64 = 3.0 * FLATTEN_TOLERANCE;
/// Points of the bent whisker that are looked at.
const SHAPE_POINTS: usize = 60;
/// Share of the length before the tip that is not looked at, for it ends on the boundary.
const TIP_SHARE: f64 = 0.01;

/// The pose a share of the way from `a` to `b`, on the geodesic of SE(2).
pub(super) fn between(a: Pose2, b: Pose2, share: f64) -> Pose2 {
    let step = a.between(b).log();
    a.compose(Pose2::exp(Twist2 { x: share * step.x, y: share * step.y, theta: share * step.theta }))
}

/// How a free whisker ends a stretch of its way.
pub(super) enum FreeWay {
    /// Without touching.
    Clear,
    /// With its tip at a foothold, this share of the way.
    Tip(f64, Foothold),
    /// With its side or its base, this share of the way.
    Side(f64),
}

/// Looks for the first touch of the straight whisker from `from` to `to`, both `map_from_whisker`.
pub(super) fn first_touch(map: &Map, length: f64, from: Pose2, to: Pose2) -> FreeWay {
    let tip = |pose: Pose2| pose.transform_point(Vec2::new(length, 0.0));
    let touches = |share: f64| {
        let pose = between(from, to, share);
        map.crosses(pose.position(), tip(pose))
    };
    let travel = tip(from).distance(tip(to)).max(from.position().distance(to.position()));
    let looks = ((travel / LOOK_EVERY).ceil() as usize).max(1);
    let share_of = |look: usize| look as f64 / looks as f64;
    let Some(hit) = (0..=looks).find(|&look| touches(share_of(look))) else { return FreeWay::Clear };
    let (mut free, mut touching) = (share_of(hit.saturating_sub(1)), share_of(hit));
    for _ in 0..50 {
        let middle = 0.5 * (free + touching);
        if touches(middle) { touching = middle } else { free = middle }
    }
    let pose = between(from, to, touching);
    match Foothold::nearest(map, tip(pose), pose.position()) {
        Some((foothold, distance)) if distance <= AT_TIP => FreeWay::Tip(touching, foothold),
        _ => FreeWay::Side(touching),
    }
}

/// Where the bent whisker touches a boundary elsewhere than with its tip, map frame; none when it does not.
///
/// The whisker must also come to the tip from the free side of the boundary.
pub(super) fn side_touch(stance: &Stance<'_>, bend: &Bend, normal: f64) -> Option<Vec2> {
    let length = stance.beam.length;
    let place = |p: Vec2| stance.map_from_whisker.transform_point(p);
    let along = Vec2::from_angle(stance.map_from_whisker.theta + bend.phi_a);
    if along.dot(Vec2::from_angle(normal)) >= 0.0 {
        return Some(place(bend.contact));
    }
    let mut points = bend.shape(length, SHAPE_POINTS);
    if let Some(last) = points.last_mut() {
        *last = bend.point_at((1.0 - TIP_SHARE) * length).position;
    }
    let crossing = points.windows(2).find(|w| stance.map.crosses(place(w[0]), place(w[1])));
    crossing.map(|w| place(w[0]))
}
