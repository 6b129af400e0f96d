//! Maps as lines to draw.

use crate::figure::{Outline, OutlineRole};
use crate::world::{Boundary, Map, Role};

/// A map's boundaries as polylines (m, map frame) no farther than `tolerance` (m) from its curves, for figures.
#[must_use]
pub fn outlines(map: &Map, tolerance: f64) -> Vec<Outline> {
    let one = |boundary: &Boundary| {
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
        Outline { points, role, closed }
    };
    map.boundaries().iter().map(one).collect()
}
