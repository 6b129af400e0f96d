//! The map as cells and points.

use crate::grid::{Cell, OccupancyGrid};
use crate::plane::{Pose2, Vec2};
use crate::world::Map;

/// Finest cell (m),
const FINEST: f64 = 1e-3;
/// most cells along the longer side,
const MOST: f64 = 600.0;
/// and how many free cells there are around the boundaries: the outside of a map of obstacles.
const MARGIN: f64 = 4.0;
/// Places along each side of a cell that the boundary runs through: their mean is its share.
const FINE: usize = 4;
/// Most points of drawn boundaries.
const MOST_POINTS: f64 = 8e3;

/// The map painted as cells, as solid as they are.
pub(super) fn painted(map: &Map) -> OccupancyGrid {
    let bounds = map.bounds();
    let size = bounds.size();
    let resolution = (size.x.max(size.y) / MOST).max(FINEST);
    let cells = |length: f64| (length / resolution + 2.0 * MARGIN).ceil().max(1.0) as usize;
    let (width, height) = (cells(size.x), cells(size.y));
    let origin = bounds.min - Vec2::new(MARGIN, MARGIN) * resolution;
    let at = |x: f64, y: f64| origin + Vec2::new(x, y) * resolution;
    let share = |index: usize| {
        let (x, y) = ((index % width) as f64, (index / width) as f64);
        let middle = at(x + 0.5, y + 0.5);
        let Some(near) = map.nearest_within(middle, 0.75 * resolution) else {
            return f32::from(!map.is_free(middle));
        };
        if map.boundaries()[near.boundary].is_two_sided() {
            // A wall has no width; a cell that it runs through is solid.
            return if near.distance <= 0.5 * resolution { 1.0 } else { f32::from(!map.is_free(middle)) };
        }
        let fine = |k: usize| (k as f64 + 0.5) / FINE as f64;
        let solid = (0..FINE * FINE).filter(|k| !map.is_free(at(x + fine(k % FINE), y + fine(k / FINE)))).count();
        solid as f32 / (FINE * FINE) as f32
    };
    OccupancyGrid {
        width,
        height,
        resolution,
        map_from_grid: Pose2::new(origin.x, origin.y, 0.0),
        cells: (0..width * height).map(|index| Cell::Solid(share(index))).collect(),
    }
}

/// Points along the boundaries.
pub(super) fn dotted(map: &Map) -> Vec<Vec2> {
    let spacing = (map.total_length() / MOST_POINTS).max(0.2e-3);
    map.samples(spacing).iter().map(|sample| sample.position).collect()
}
