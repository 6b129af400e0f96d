//! Polygonal approximation of outlines with many short edges \[sklansky1980fast\]: fewer edges within a micrometre.
//!
//! A tip that moves a millimetre over edges of ten micrometres is on a hundred of them, and a Newton step asks for each. What a whisker
//! feels does not change by a micrometre of wall.

use crate::math;
use crate::plane::{Segment, Vec2};
use core::f64::consts::FRAC_PI_3;

/// How far an edge may be from the ends of those that it stands for (m).
const TOLERANCE: f64 = 1e-6;
/// Longer edges stay as they are (m).
const SHORT: f64 = 0.25e-3;
/// Corners that turn by more than this (rad) stay, too, and an edge differs from the first that it stands for by no more than a sixth of a turn.
const SHARP: f64 = 0.2;
const WIDEST: f64 = FRAC_PI_3;

/// The segments of a curve with runs of short lines as single ones, and which of these stands for each; none where there are none to be joined.
pub(super) fn simplified(segments: &[Segment]) -> Option<(Vec<Segment>, Vec<u32>)> {
    segments.windows(2).any(|pair| pair.iter().all(|segment| short(segment).is_some())).then_some(())?;
    let (mut few, mut stands_for) = (Vec::new(), Vec::with_capacity(segments.len()));
    while stands_for.len() < segments.len() {
        let rest = &segments[stands_for.len()..];
        let (edge, count) = longest(rest);
        stands_for.extend(core::iter::repeat_n(few.len() as u32, count));
        few.push(edge);
    }
    Some((few, stands_for))
}

/// The ends of a short line.
fn short(segment: &Segment) -> Option<[Vec2; 2]> {
    match segment {
        Segment::Line([a, b]) if a.distance(*b) < SHORT => Some([*a, *b]),
        _ => None,
    }
}

/// The longest edge from the first segment's start that is near all ends of those that it stands for, and how many these are: the directions from
/// the start that pass each end within the tolerance are a wedge.
fn longest(segments: &[Segment]) -> (Segment, usize) {
    let Some([start, mut end]) = short(&segments[0]) else { return (segments[0], 1) };
    let first = end - start;
    let (mut low, mut high) = wedge(first, 0.0);
    let (mut before, mut farthest, mut count) = (first, first.norm(), 1);
    for segment in &segments[1..] {
        let Some([a, b]) = short(segment) else { break };
        let (along, to) = (b - a, b - start);
        let (distance, direction) = (to.norm(), angle(first, to));
        if angle(before, along).abs() > SHARP || distance <= farthest || direction < low || direction > high {
            break;
        }
        let own = wedge(to, direction);
        (low, high) = (low.max(own.0), high.min(own.1));
        (before, farthest, count, end) = (along, distance, count + 1, b);
    }
    (Segment::Line([start, end]), count)
}

/// The directions (rad) that pass a place in this direction within the tolerance.
fn wedge(to: Vec2, direction: f64) -> (f64, f64) {
    let distance = to.norm();
    let slack = if distance > TOLERANCE { math::asin(TOLERANCE / distance) } else { WIDEST };
    ((direction - slack).max(-WIDEST), (direction + slack).min(WIDEST))
}

/// The angle from one vector to another (rad).
fn angle(from: Vec2, to: Vec2) -> f64 {
    math::atan2(from.cross(to), from.dot(to))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(points: &[Vec2]) -> Vec<Segment> {
        points.windows(2).map(|ends| Segment::Line([ends[0], ends[1]])).collect()
    }

    /// How far a place is from a line's ends and what is between.
    fn off(place: Vec2, line: &Segment) -> f64 {
        line.point(line.nearest(place).clamp(0.0, 1.0)).distance(place)
    }

    #[test]
    fn short_edges_become_fewer_within_a_micrometre() {
        // A wavy wall in edges of 10 micrometres, an edge of its own, a step, and straight on.
        let wave = |k: usize| Vec2::new(1e-5 * k as f64, 1e-3 * (1e-5 * k as f64 * 100.0).sin());
        let mut points: Vec<Vec2> = (0..5000).map(wave).collect();
        let last = points[4999];
        points.extend([Vec2::new(0.01, 0.0), Vec2::new(0.01, 1e-4)].map(|by| last + by));
        points.extend((1..2000).map(|k| last + Vec2::new(0.01 + 1e-5 * f64::from(k), 1e-4)));
        let all = lines(&points);
        let (few, of) = simplified(&all).unwrap_or_else(|| unreachable!());
        assert!(few.len() < 150 && of.len() == all.len(), "{}", few.len());
        assert!(of.windows(2).all(|pair| pair[1] == pair[0] || pair[1] == pair[0] + 1));
        let worst = all.iter().zip(&of).map(|(edge, &of)| off(edge.end(), &few[of as usize])).fold(0.0, f64::max);
        assert!(worst <= TOLERANCE && worst > 0.3 * TOLERANCE, "{worst}");
        // They are a chain, from the first place to the last, and what is long or sharp is as it was.
        assert!(few.windows(2).all(|pair| pair[0].end() == pair[1].start()));
        assert_eq!((few[0].start(), few[few.len() - 1].end()), (points[0], points[points.len() - 1]));
        assert!([4999, 5000].iter().all(|&at| few.contains(&all[at])));
        // The straight end is one.
        assert_eq!(few.len() - 1, of[5001] as usize);
    }

    #[test]
    fn what_has_no_short_edges_stays() {
        let square = [[0.0, 0.0], [0.1, 0.0], [0.1, 1e-4], [0.0, 1e-4]].map(|[x, y]| Vec2::new(x, y));
        assert!(simplified(&lines(&square)).is_none());
    }
}
