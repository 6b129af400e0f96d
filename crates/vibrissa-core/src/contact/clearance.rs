//! How far places are from all boundaries at least, on a grid: most of a whisker is nowhere near any.

use crate::plane::{Bounds, Vec2};
use crate::world::Map;

/// Width of a cell (m), and the most cells along a side of the map.
const CELL: f64 = 2e-3;
const MOST: f64 = 512.0;
/// Distances between the middles of cells are too long by no more than this (cells): half a diagonal at either end, and
/// how far boundaries are sampled apart.
const SLACK: f64 = 1.7;
/// Samples of a boundary for each cell.
const SAMPLES: f64 = 4.0;

/// A grid of distances to the boundaries; without cells, nothing is known of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Clearance {
    origin: Vec2,
    cell: f64,
    columns: usize,
    rows: usize,
    /// At least so far from every boundary (m).
    distances: Vec<f64>,
}

impl Clearance {
    pub(super) fn new(map: &Map) -> Self {
        let bounds = map.bounds();
        let size = bounds.size();
        let cell = CELL.max(size.x.max(size.y) / MOST);
        let count = |length: f64| (length / cell).max(0.0).ceil() as usize + 1;
        let (columns, rows) = (count(size.x), count(size.y));
        let origin = bounds.min;
        let mut grid = Self { origin, cell, columns, rows, distances: vec![f64::INFINITY; columns * rows] };
        map.for_each_edge_in(everywhere(bounds), |[a, b]| {
            let steps = (a.distance(b) / cell * SAMPLES).ceil().max(1.0);
            for step in 0..=steps as usize {
                if let Some(index) = grid.index(a + (b - a) * (step as f64 / steps)) {
                    grid.distances[index] = 0.0;
                }
            }
            false
        });
        grid.spread();
        grid.distances.iter_mut().for_each(|square| *square = cell * (square.sqrt() - SLACK).max(0.0));
        grid
    }

    /// A place of the map is at least this far from every boundary (m); 0 where that is not known.
    pub(super) fn at(&self, place: Vec2) -> f64 {
        self.index(place).map_or(0.0, |index| self.distances[index])
    }

    fn index(&self, place: Vec2) -> Option<usize> {
        let (x, y) = ((place.x - self.origin.x) / self.cell, (place.y - self.origin.y) / self.cell);
        (x >= 0.0 && y >= 0.0 && (x as usize) < self.columns && (y as usize) < self.rows)
            .then(|| y as usize * self.columns + x as usize)
    }

    /// Squared distances (cells) from those that are nothing, along the rows and then along the columns.
    fn spread(&mut self) {
        let mut hull = Vec::new();
        let mut line = vec![0.0; self.columns.max(self.rows)];
        for row in 0..self.rows {
            let at = row * self.columns;
            line[..self.columns].copy_from_slice(&self.distances[at..at + self.columns]);
            lowest(&line[..self.columns], &mut hull, |i, square| self.distances[at + i] = square);
        }
        for column in 0..self.columns {
            for (row, height) in line[..self.rows].iter_mut().enumerate() {
                *height = self.distances[row * self.columns + column];
            }
            lowest(&line[..self.rows], &mut hull, |i, square| self.distances[i * self.columns + column] = square);
        }
    }
}

/// The least of the parabolas `heights[k] + (i - k)²` at each `i`, from the lower envelope of all of them.
fn lowest(heights: &[f64], hull: &mut Vec<(usize, f64)>, mut tell: impl FnMut(usize, f64)) {
    hull.clear();
    for (k, &height) in heights.iter().enumerate().filter(|(_, height)| height.is_finite()) {
        let mut from = f64::NEG_INFINITY;
        while let Some(&(j, begins)) = hull.last() {
            let (a, b) = (j as f64, k as f64);
            from = ((height + b * b) - (heights[j] + a * a)) / (2.0 * (b - a));
            if from > begins {
                break;
            }
            hull.pop();
            from = f64::NEG_INFINITY;
        }
        hull.push((k, from));
    }
    let mut part = 0;
    for i in 0..heights.len() {
        while hull.get(part + 1).is_some_and(|&(_, from)| from <= i as f64) {
            part += 1;
        }
        let square = hull.get(part).map_or(f64::INFINITY, |&(k, _)| heights[k] + (i as f64 - k as f64).powi(2));
        tell(i, square);
    }
}

/// A little more than these bounds.
fn everywhere(bounds: Bounds) -> Bounds {
    let margin = Vec2::new(1.0, 1.0);
    Bounds::of(&[bounds.min - margin, bounds.max + margin])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;
    use crate::plane::Curve;
    use crate::world::{Boundary, Role};

    #[test]
    fn no_boundary_is_nearer_than_told() {
        let corner = |x: f64, y: f64| Vec2::new(x, y).rotated(0.4);
        let outline = [corner(0.0, 0.0), corner(0.3, 0.0), corner(0.32, 0.21), corner(0.1, 0.15), corner(0.0, 0.2)];
        let map = Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&outline, true).unwrap(), None).unwrap()])
            .unwrap();
        let grid = Clearance::new(&map);
        let bounds = map.bounds();
        let mut far = 0;
        for i in 0..97 {
            for j in 0..89 {
                let share = Vec2::new(f64::from(i) / 96.0, f64::from(j) / 88.0);
                let size = bounds.size();
                let place = bounds.min + Vec2::new(share.x * size.x, share.y * size.y);
                let (told, exact) = (grid.at(place), map.nearest(place).unwrap().distance);
                assert!(told <= exact && told >= exact - 2.0 * SLACK * CELL, "{place:?}: {told} {exact}");
                far += u32::from(told > 6e-3);
            }
        }
        assert!(far > 1000, "{far}");
        assert!(grid.at(Vec2::new(50.0, 0.0)) <= 0.0);
    }
}
