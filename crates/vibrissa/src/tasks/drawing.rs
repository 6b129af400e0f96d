//! Maps as lines to draw.

use crate::figure::{Outline, OutlineRole};
use crate::plane::Vec2;
use crate::world::{Boundary, Map, PieceCourse, Role};

/// A map's boundaries as polylines (m, map frame) no farther than `tolerance` (m) from its curves, for figures, with the bands in
/// which they lie and their unknown stretches.
#[must_use]
pub fn outlines(map: &Map, tolerance: f64) -> Vec<Outline> {
    map.boundaries().iter().map(|boundary| outline(boundary, tolerance)).collect()
}

fn outline(boundary: &Boundary, tolerance: f64) -> Outline {
    let closed = boundary.curve().is_closed();
    let mut points = boundary.curve().flatten(tolerance);
    if closed {
        points.pop();
    }
    let role = match boundary.role() {
        Role::Arena => OutlineRole::Arena,
        Role::Obstacle => OutlineRole::Obstacle,
        Role::Wall => OutlineRole::Wall,
    };
    let mut outline = Outline::exact(points, role, closed);
    if boundary.course().is_some() {
        add_course(boundary, tolerance, &mut outline);
    }
    outline
}

/// Adds the bands, as quadrilaterals, and the unknown stretches.
fn add_course(boundary: &Boundary, tolerance: f64, outline: &mut Outline) {
    for (index, segment) in boundary.curve().segments().iter().enumerate() {
        let parts = segment.flat_parts(tolerance);
        let place = |k: usize| segment.point(k as f64 / parts as f64);
        match boundary.piece_course(index) {
            Some(PieceCourse::Unknown(_)) => outline.unknown.push((0..=parts).map(place).collect()),
            Some(PieceCourse::Band([from, to])) => {
                let across = |k: usize| {
                    let share = k as f64 / parts as f64;
                    Vec2::from_angle(segment.tangent(share)).perp() * (from.bound + (to.bound - from.bound) * share)
                };
                outline.band.extend((0..parts).map(|k| {
                    let (a, b) = (place(k), place(k + 1));
                    [a + across(k), b + across(k + 1), b - across(k + 1), a - across(k)]
                }));
            }
            None => {}
        }
    }
    outline.band.retain(|[a, b, c, d]| a.distance(*d).max(b.distance(*c)) > 0.0);
}
