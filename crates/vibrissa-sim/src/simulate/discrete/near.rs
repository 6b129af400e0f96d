//! Points near segments: distances, and when a moving point first meets a moving segment.

use crate::plane::Vec2;

/// What a pair is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pair {
    /// A node of the rod beside an edge of the map.
    Node { node: usize, edge: [Vec2; 2] },
    /// A vertex of the map beside a link of the rod, from the node of this index on.
    Vertex { vertex: Vec2, link: usize },
    /// A node of the rod beside a vertex of the map, which the others have counted so many times too often.
    Corner { node: usize, vertex: Vec2, excess: f64 },
}

/// A point and a segment: the point, the segment's ends.
pub(super) type Figure = (Vec2, Vec2, Vec2);

impl Pair {
    /// The point and the segment when the nodes are here.
    #[inline]
    pub(super) fn figure(&self, nodes: &[Vec2]) -> Figure {
        match *self {
            Self::Node { node, edge } => (nodes[node], edge[0], edge[1]),
            Self::Vertex { vertex, link } => (vertex, nodes[link], nodes[link + 1]),
            Self::Corner { node, vertex, .. } => (nodes[node], vertex, vertex),
        }
    }

    /// How often its energy counts.
    #[inline]
    pub(super) fn weight(&self) -> f64 {
        if let Self::Corner { excess, .. } = *self { -excess } else { 1.0 }
    }

    /// The same when the nodes have moved by `share` of `step`.
    #[inline]
    fn moved(&self, nodes: &[Vec2], step: &[Vec2], share: f64) -> Figure {
        let at = |i: usize| nodes[i] + step[i] * share;
        match *self {
            Self::Node { node, edge } => (at(node), edge[0], edge[1]),
            Self::Vertex { vertex, link } => (vertex, at(link), at(link + 1)),
            Self::Corner { node, vertex, .. } => (at(node), vertex, vertex),
        }
    }

    /// How far its parts move towards each other at most.
    #[inline]
    fn travel(&self, step: &[Vec2]) -> f64 {
        match *self {
            Self::Node { node, .. } | Self::Corner { node, .. } => step[node].norm(),
            Self::Vertex { link, .. } => step[link].norm().max(step[link + 1].norm()),
        }
    }
}

/// Distance of the point, place of the nearest point along the segment in \[0, 1\], and the unit vector from it to the point.
#[inline]
pub(super) fn distance((p, a, b): Figure) -> (f64, f64, Vec2) {
    let along = b - a;
    let squared = along.norm_squared();
    let at = if squared > 0.0 { ((p - a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    if at > 0.0 && at < 1.0 {
        // Across the segment's line, so that tiny distances keep their digits.
        let normal = along.perp() * (1.0 / squared.sqrt());
        let signed = normal.dot(p - a);
        return (signed.abs(), at, normal * 1.0_f64.copysign(signed));
    }
    let arm = p - if at > 0.0 { b } else { a };
    let length = arm.norm();
    (length, at, arm * (1.0 / length.max(f64::MIN_POSITIVE)))
}

/// The share of the distance that may be used up in one step.
const KEPT: f64 = 0.1;

/// The largest share of `step`, up to `most`, for which the pair keeps a tenth of its distance and the point does not pass
/// through the segment.
pub(super) fn safe_share(pair: &Pair, nodes: &[Vec2], step: &[Vec2], most: f64) -> f64 {
    if matches!(pair, Pair::Corner { .. }) {
        return most;
    }
    let start = distance(pair.figure(nodes)).0;
    if pair.travel(step) * most < (1.0 - KEPT) * start {
        return most;
    }
    let mut share = first_meeting(pair, nodes, step, most).map_or(most, |meeting| (1.0 - KEPT) * meeting);
    for _ in 0..60 {
        if distance(pair.moved(nodes, step, share)).0 >= KEPT * start {
            return share;
        }
        share *= 0.5;
    }
    0.0
}

/// The first share of the step in \[0, most\] at which the point lies on the segment.
fn first_meeting(pair: &Pair, nodes: &[Vec2], step: &[Vec2], most: f64) -> Option<f64> {
    let (p, a, b) = pair.figure(nodes);
    let (p1, a1, b1) = pair.moved(nodes, step, 1.0);
    let (u, v) = (b - a, p - a);
    let (du, dv) = ((b1 - a1) - u, (p1 - a1) - v);
    // The area of the triangle is a quadratic of the share.
    let (c0, c1, c2) = (u.cross(v), u.cross(dv) + du.cross(v), du.cross(dv));
    let mut roots = quadratic_roots(c2, c1, c0);
    roots.sort_by(f64::total_cmp);
    roots.into_iter().find(|&share| {
        if !(share >= 0.0 && share <= most) {
            return false;
        }
        let (p, a, b) = pair.moved(nodes, step, share);
        let along = b - a;
        let squared = along.norm_squared();
        let at = if squared > 0.0 { (p - a).dot(along) / squared } else { 0.0 };
        (-1e-12..=1.0 + 1e-12).contains(&at)
    })
}

/// The real roots of `a x² + b x + c`; those that do not exist are not numbers.
fn quadratic_roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let root = (b * b - 4.0 * a * c).sqrt();
    let sum = -0.5 * (b + root.copysign(b));
    [sum / a, c / sum]
}
