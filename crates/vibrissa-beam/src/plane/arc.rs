//! Circular and elliptical arcs as cubic Béziers.

use super::{Segment, Vec2};
use crate::math;
use alloc::vec::Vec;
use core::f64::consts::TAU;
use kurbo::{Arc, PathEl, Point};

/// The cubics that follow an elliptical arc within `tolerance` (m), in the direction of travel.
///
/// The ellipse has the given `center` (m) and `radii` (m), its first axis turned by `rotation` (rad,
/// counter-clockwise). The arc starts at the parameter `start` (rad) and goes through `sweep` (rad, positive
/// counter-clockwise), at most once round. Tolerances below 1e-12 of the larger radius are raised to that: f64 holds no more.
/// Empty when a value is not finite.
#[must_use]
pub fn arc_to_cubics(center: Vec2, radii: Vec2, rotation: f64, start: f64, sweep: f64, tolerance: f64) -> Vec<Segment> {
    let size = radii.x.abs().max(radii.y.abs());
    if !(center.is_finite() && radii.is_finite() && (rotation + start + sweep).is_finite()) {
        return Vec::new();
    }
    let tolerance = tolerance.max(1e-12 * size).max(f64::MIN_POSITIVE);
    let sweep = sweep.clamp(-TAU, TAU);
    let arc = Arc::new((center.x, center.y), (radii.x, radii.y), start, sweep, rotation);
    let place = |p: Point| Vec2::new(p.x, p.y);
    let mut from = {
        let (sin, cos) = math::sin_cos(start);
        center + Vec2::new(radii.x * cos, radii.y * sin).rotated(rotation)
    };
    let mut cubics = Vec::new();
    for element in arc.append_iter(tolerance) {
        if let PathEl::CurveTo(p1, p2, p3) = element {
            cubics.push(Segment::Cubic([from, place(p1), place(p2), place(p3)]));
            from = place(p3);
        }
    }
    cubics
}
