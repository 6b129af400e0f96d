//! Arcs and splines as chains of chords.

use crate::config::scenario::{CHORD, MOST_CHORDS};
use crate::plane::{Curve, Segment, Vec2};
use crate::{Error, Result};
use core::f64::consts::FRAC_PI_2;

/// How many chords a curve of this length gets.
fn chords(length: f64) -> usize {
    (length / CHORD).ceil().clamp(1.0, MOST_CHORDS) as usize
}

/// The arc from a point round a centre by an angle (rad), with the directions of travel.
pub(super) fn arc(from: Vec2, centre: Vec2, angle: f64) -> Vec<(Vec2, f64)> {
    let spoke = from - centre;
    let count = chords(spoke.norm() * angle.abs());
    let at = |k: usize| {
        let turned = angle * k as f64 / count as f64;
        (centre + spoke.rotated(turned), spoke.angle() + turned + FRAC_PI_2 * angle.signum())
    };
    (0..=count).map(at).collect()
}

/// The smooth curve from a point through others, with the directions of travel.
///
/// Cubic pieces; at each inner point the curve is parallel to the line between its neighbours.
pub(super) fn spline(from: Vec2, through: &[Vec2]) -> Result<Vec<(Vec2, f64)>> {
    let mut points = vec![from];
    points.extend(through);
    points.dedup();
    let last = points.len() - 1;
    let slope = |k: usize| {
        let (before, after) = (points[k.saturating_sub(1)], points[(k + 1).min(last)]);
        // The speed on a piece is its length over one; a shorter neighbour must not make the curve overshoot.
        let reach = |other: usize| points[k].distance(points[other]);
        let near = match k {
            0 => reach(1),
            k if k == last => reach(k - 1),
            k => reach(k - 1).min(reach(k + 1)),
        };
        let along = after - before;
        along * (near / along.norm().max(f64::MIN_POSITIVE))
    };
    let piece = |k: usize| {
        let (a, b) = (points[k], points[k + 1]);
        Segment::Cubic([a, a + slope(k) * (1.0 / 3.0), b - slope(k + 1) * (1.0 / 3.0), b])
    };
    let pieces = if last == 0 { Vec::new() } else { (0..last).map(piece).collect() };
    let Some(curve) = Curve::from_segments(pieces, false) else {
        return Err(Error::data("a spline without length").remedy("give it points other than where it starts"));
    };
    let count = chords(curve.length());
    let at = |k: usize| {
        let point = curve.at(curve.length() * k as f64 / count as f64);
        (point.position, point.tangent)
    };
    Ok((0..=count).map(at).collect())
}
