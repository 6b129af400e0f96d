//! Degenerate, huge, tiny, collinear and self-touching shapes, against slow and plain searches.

use super::{Verdict, promise, read, size};
use crate::random::Random;
use vibrissa::plane::{Bounds, Curve, Segment, SegmentTree, Vec2, segment_contact};
use vibrissa::world::{Boundary, Map, Role};

/// Points as text, a point a line: on few grid points, on a line, far away, tiny, repeated, or anywhere.
pub(crate) fn draw_points(random: &mut Random) -> Vec<u8> {
    let most = 2 << random.below(6);
    let count = random.below(most);
    let kind = random.below(8);
    let scale = 10f64.powi(random.below(16) as i32 - 10);
    let origin = if random.one_in(3) { 10f64.powi(random.below(7) as i32) } else { 0.0 };
    let wild = [0.0, -0.0, 1e-300, 5e-324, 1e154, -1e154, 1e300, f64::MAX, f64::NAN, f64::INFINITY, 1.0];
    let mut text = String::new();
    for _ in 0..count {
        let grid = |n: usize, r: &mut Random| r.below(n) as f64 * scale;
        let (x, y) = match kind {
            0 => (grid(3, random), grid(3, random)),
            1 => (grid(9, random), 0.0),
            2 => (scale * random.signed(), 1e-17 * scale * random.signed()),
            3 => {
                let x = random.signed();
                (x * scale, x * scale * (1.0 / 3.0))
            }
            4 => (*random.pick(&wild).unwrap_or(&0.0), *random.pick(&wild).unwrap_or(&0.0)),
            5 => (grid(5, random), scale * random.signed()),
            _ => (scale * random.signed(), scale * random.signed()),
        };
        text += &format!("{:?} {:?}\n", x + origin, y - origin);
    }
    text.into_bytes()
}

fn points(bytes: &[u8]) -> Vec<Vec2> {
    let text = String::from_utf8_lossy(bytes);
    let point = |line: &str| {
        let (x, y) = line.split_once(' ')?;
        Some(Vec2::new(x.parse().ok()?, y.parse().ok()?))
    };
    text.lines().filter_map(point).collect()
}

/// Places to ask about: corners, middles, and next to them.
fn queries(points: &[Vec2]) -> Vec<Vec2> {
    let mut queries: Vec<Vec2> = points.iter().take(6).copied().collect();
    queries.extend(points.windows(2).take(6).map(|w| w[0] + (w[1] - w[0]) * 0.5));
    queries.extend([Vec2::new(0.0, 0.0), Vec2::new(1e-3, -2e5), Vec2::new(f64::NAN, 0.0)]);
    queries
}

/// A closed outline as a map: never a panic, and answers that are numbers.
pub(crate) fn outline(bytes: &[u8]) -> Verdict {
    let points = points(bytes);
    let Some(curve) = Curve::polyline(&points, true) else { return Ok(super::Outcome { read: false, mark: 0 }) };
    let boundary = match Boundary::new(Role::Arena, curve, None) {
        Ok(boundary) => boundary,
        Err(error) => return super::refused(&error),
    };
    let map = Map::new(vec![boundary]).map_err(|error| error.to_string())?;
    let mut free = 0;
    for query in queries(&points) {
        let near = map.nearest(query);
        promise(near.is_some() == query.is_finite(), || format!("nearest of {query:?}: {near:?}"))?;
        if let Some(near) = near {
            let boxed = map.bounds().distance_squared(query).sqrt();
            let sound = near.distance >= boxed * (1.0 - 1e-9) && near.tangent.is_finite() && near.position.is_finite();
            promise(sound, || format!("nearest of {query:?}: {near:?}"))?;
        }
        free += usize::from(map.is_free(query));
        let _ = map.concave_corner(query, 1e9);
        let _ = map.crosses(query, Vec2::new(0.0, 0.0));
    }
    let samples = map.samples(map.total_length() / 100.0);
    promise(samples.iter().all(|s| s.position.is_finite() && s.tangent.is_finite()), || "samples".into())?;
    read((size(points.len()), free))
}

/// The tree of segments against a plain search over all of them.
pub(crate) fn edges(bytes: &[u8]) -> Verdict {
    let points = points(bytes);
    let finite: Vec<Vec2> = points.iter().filter(|p| p.is_finite() && p.norm() < 1e150).copied().collect();
    let edges: Vec<[Vec2; 2]> = finite.windows(2).map(|w| [w[0], w[1]]).collect();
    let tree = SegmentTree::new(&edges);
    promise(tree.len() == edges.len(), || format!("{} of {} edges", tree.len(), edges.len()))?;
    for query in queries(&points).into_iter().filter(|q| q.norm() < 1e150) {
        let plain = edges.iter().map(|[a, b]| distance(*a, *b, query)).fold(f64::INFINITY, f64::min);
        let found = tree.nearest(query).map_or(f64::INFINITY, |hit| hit.distance);
        // Below 1e-150 squares vanish.
        let near = (found - plain).abs() <= 1e-9 * plain + 1e-14 * query.norm() + 1e-150 || edges.is_empty();
        promise(near, || format!("nearest of {query:?}: {found} by tree, {plain} by search"))?;
        for other in finite.iter().take(4) {
            let by_search = edges.iter().any(|[c, d]| segment_contact(query, *other, *c, *d).is_some());
            let clearly = edges.iter().any(|[c, d]| crosses_clearly(query, *other, *c, *d));
            let by_tree = tree.crosses(query, *other);
            let right = (by_search || !by_tree) && (by_tree || !clearly);
            promise(right, || format!("{query:?} to {other:?} crosses: {by_tree} by tree, {by_search} by search"))?;
        }
    }
    let meetings = tree.self_intersections();
    for meeting in &meetings {
        let (a, b) = (edges[meeting.first], edges[meeting.second]);
        let both = Bounds::of(&a).hull(Bounds::of(&b));
        let slack = 1e-9 * both.size().norm() + 1e-14 * both.min.norm() + 1e-150;
        let inside = meeting.point.is_finite() && both.distance_squared(meeting.point).sqrt() <= slack;
        promise(inside, || format!("{a:?} and {b:?} meet at {:?}", meeting.point))?;
    }
    let whole = tree.nearest(Vec2::new(f64::NAN, 0.0)).is_none();
    promise(whole, || "something is nearest to no place".into())?;
    read((size(edges.len()), size(meetings.len())))
}

/// Whether two segments cross by more than any rounding.
fn crosses_clearly(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let size = [a, b, c, d].iter().map(|p| p.norm()).fold(0.0, f64::max);
    let side = |a: Vec2, b: Vec2, p: Vec2| {
        let turn = (b - a).cross(p - a);
        if turn.abs() > 1e-11 * size * size { turn.signum() } else { 0.0 }
    };
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

fn distance(a: Vec2, b: Vec2, p: Vec2) -> f64 {
    let (along, to) = (b - a, p - a);
    let squared = along.norm_squared();
    let t = if squared > 0.0 { (to.dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + along * t)
}

/// Chains of lines and Béziers: arc length, points, nearest points and flattening.
pub(crate) fn curve(bytes: &[u8]) -> Verdict {
    let points = points(bytes);
    let kind = bytes.len() % 3;
    let segments: Vec<Segment> = match kind {
        0 => points.windows(2).map(|w| Segment::Line([w[0], w[1]])).collect(),
        1 => points.windows(3).step_by(2).map(|w| Segment::Quadratic([w[0], w[1], w[2]])).collect(),
        _ => points.windows(4).step_by(3).map(|w| Segment::Cubic([w[0], w[1], w[2], w[3]])).collect(),
    };
    let Some(curve) = Curve::from_segments(segments, false) else {
        return Ok(super::Outcome { read: false, mark: kind as u64 });
    };
    // Maps beyond 100 km are refused by their readers.
    let bounds = curve.bounds();
    if bounds.min.norm().max(bounds.max.norm()) > 1e6 {
        return Ok(super::Outcome { read: false, mark: 9 });
    }
    let (length, extent) = (curve.length(), bounds.size().norm());
    // A control polygon of at most three times the extent bounds the length of each segment.
    let sane = length.is_finite() && length <= 20.0 * extent * curve.segments().len() as f64;
    promise(sane && length > 0.0, || format!("a length of {length} m over an extent of {extent} m"))?;
    for share in [-0.1, 0.0, 0.3, 0.999, 1.0, 2.0, f64::NAN] {
        let at = curve.at(share * length);
        if !share.is_nan() {
            promise(at.position.is_finite() && at.tangent.is_finite(), || format!("at {share}: {at:?}"))?;
        }
    }
    for query in queries(&points).into_iter().filter(|q| q.is_finite()) {
        let near = curve.nearest(query);
        let ends = [curve.at(0.0), curve.at(length)].map(|end| end.position.distance(query));
        let found = near.position.distance(query);
        let best = ends.into_iter().fold(f64::INFINITY, f64::min);
        // Below 1e-150 squares vanish.
        let slack = 1e-9 * (extent + best) + 1e-14 * query.norm() + 1e-150;
        promise(found <= best + slack, || format!("nearest of {query:?}: {found}, an end: {best}"))?;
    }
    let flat = curve.flatten((extent * 1e-4).max(1e-6));
    promise(flat.iter().all(|p| p.is_finite()) && flat.len() > 1, || "flattened to no line".into())?;
    let back = curve.reversed();
    promise((back.length() - length).abs() <= 1e-9 * length, || "another length backwards".into())?;
    let _ = (curve.signed_area(), curve.samples(length / 50.0).len());
    read((kind, size(curve.segments().len()), size(flat.len())))
}
