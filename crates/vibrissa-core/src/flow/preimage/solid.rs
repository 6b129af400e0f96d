//! Which places lie deep in something solid, by look-up.

use super::state_grid::Raster;
use crate::plane::Vec2;
use crate::world::{Map, Role};

/// Columns whose distances are told together.
const COLUMNS: usize = 16;
/// Largest distance between a boundary and the chain that stands for it here (m).
const CHAIN_TOLERANCE: f64 = 1e-5;

/// A raster of the places that are deeper in something solid than a given depth: no free whisker has a point there.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    raster: Raster,
    /// How far a point of each cell can move and stay what it is, deep or not (m); negative for deep cells.
    room: Vec<f32>,
    /// Whether all beyond the raster is solid.
    beyond: bool,
}

/// The squared distance, in cells, that stands for no marked cell at all.
const FAR: f32 = 1e6;
/// What stands for no room, so that deep and not deep have different signs.
const LEAST_ROOM: f32 = 1e-9;

impl Solid {
    /// The places of `map` that are further than `depth` (m) from everything free, for certain.
    pub(super) fn new(map: &Map, raster: Raster, depth: f64) -> Self {
        let beyond = map.boundaries().iter().any(|b| b.role() == Role::Arena);
        Self { room: room(&deep_cells(map, &raster, depth), &raster), raster, beyond }
    }

    /// How far a point at `point` (m) can move without a change of whether it is deep in something solid; negative where it is.
    #[inline]
    pub(super) fn room(&self, point: Vec2) -> f32 {
        match self.raster.index(point) {
            Some(index) => self.room[index],
            None if self.beyond => -LEAST_ROOM,
            None => LEAST_ROOM,
        }
    }
}

/// Which cells of a raster are further than `depth` (m) from everything free on `map`, for certain and as a whole.
pub(super) fn deep_cells(map: &Map, raster: &Raster, depth: f64) -> Vec<bool> {
    let distance = squared_distance(&free_cells(map, raster), raster.columns, raster.rows);
    // From anywhere in a cell to its middle, and the same at the free end.
    let limit = depth / raster.cell + core::f64::consts::SQRT_2;
    distance.iter().map(|&d| f64::from(d) > limit * limit).collect()
}

/// The room of each cell: to the nearest cell of the other kind, less what two points can be off their cells' middles.
fn room(deep: &[bool], raster: &Raster) -> Vec<f32> {
    let free: Vec<bool> = deep.iter().map(|d| !d).collect();
    let to = |marked: &[bool]| squared_distance(marked, raster.columns, raster.rows);
    let least = |square: f32| (((square.sqrt() - 1.42) * raster.cell as f32) * 0.999).max(LEAST_ROOM);
    let pairs = to(deep).into_iter().zip(to(&free)).zip(deep);
    pairs.map(|((to_deep, to_free), &deep)| if deep { -least(to_free) } else { least(to_deep) }).collect()
}

/// The cells whose middle is free, and those that a boundary passes through.
fn free_cells(map: &Map, raster: &Raster) -> Vec<bool> {
    let mut free = vec![false; raster.columns * raster.rows];
    let has_arena = map.boundaries().iter().any(|b| b.role() == Role::Arena);
    let mut crossings: Vec<Vec<(f64, i32, bool)>> = vec![Vec::new(); raster.rows];
    for boundary in map.boundaries() {
        let chain = boundary.curve().flatten(CHAIN_TOLERANCE);
        for link in chain.windows(2) {
            mark(raster, link[0], link[1], &mut free);
            if boundary.role() != Role::Wall {
                cross(raster, link[0], link[1], boundary.role() == Role::Arena, &mut crossings);
            }
        }
    }
    for (row, list) in crossings.iter_mut().enumerate() {
        list.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let (mut arenas, mut obstacles, mut next) = (0, 0, 0);
        for column in 0..raster.columns {
            let x = raster.origin.x + (column as f64 + 0.5) * raster.cell;
            while let Some(&(at, turn, arena)) = list.get(next).filter(|c| c.0 <= x) {
                debug_assert!(at.is_finite());
                // Outlines have free space on their left: what goes down opens an arena to its right.
                if arena {
                    arenas -= turn
                } else {
                    obstacles -= turn
                }
                next += 1;
            }
            if (arenas > 0 || !has_arena) && obstacles >= 0 {
                free[row * raster.columns + column] = true;
            }
        }
    }
    free
}

/// Marks the cells that a link passes through.
fn mark(raster: &Raster, a: Vec2, b: Vec2, free: &mut [bool]) {
    let steps = (a.distance(b) / (0.5 * raster.cell)).ceil().max(1.0) as usize;
    for k in 0..=steps {
        if let Some(index) = raster.index(a + (b - a) * (k as f64 / steps as f64)) {
            free[index] = true;
        }
    }
}

/// Notes where a link crosses the middles of rows: place and +1 for going up.
fn cross(raster: &Raster, a: Vec2, b: Vec2, arena: bool, crossings: &mut [Vec<(f64, i32, bool)>]) {
    let row_of = |y: f64| (y - raster.origin.y) / raster.cell - 0.5;
    let (lo, hi, turn) = if a.y < b.y { (a, b, 1) } else { (b, a, -1) };
    let first = row_of(lo.y).ceil().max(0.0);
    let last = row_of(hi.y).min(raster.rows as f64 - 1.0);
    let mut row = first;
    // A row through the upper end belongs to the next link.
    while row <= last && row < row_of(hi.y) {
        let y = raster.origin.y + (row + 0.5) * raster.cell;
        let x = lo.x + (hi.x - lo.x) * ((y - lo.y) / (hi.y - lo.y));
        crossings[row as usize].push((x, turn, arena));
        row += 1.0;
    }
}

/// The squared distance from each cell to the nearest marked one, in cells, by lower envelopes of parabolas
/// \[felzenszwalb2012\]; at most a thousand cells' squared.
fn squared_distance(marked: &[bool], columns: usize, rows: usize) -> Vec<f32> {
    let mut distance = vec![FAR; marked.len()];
    for row in 0..rows {
        let line = &mut distance[row * columns..(row + 1) * columns];
        let here = &marked[row * columns..(row + 1) * columns];
        let mut last = 1e3f32;
        for (d, &m) in line.iter_mut().zip(here) {
            last = if m { 0.0 } else { (last + 1.0).min(1e3) };
            *d = last;
        }
        last = 1e3;
        for (d, &m) in line.iter_mut().zip(here).rev() {
            last = if m { 0.0 } else { (last + 1.0).min(1e3) };
            *d = d.min(last) * d.min(last);
        }
    }
    let mut envelope = Envelope::new(rows);
    // Some columns at once, as a row holds them side by side in memory.
    let mut lines = vec![vec![0.0; rows]; COLUMNS];
    for first in (0..columns).step_by(COLUMNS) {
        let count = COLUMNS.min(columns - first);
        for (row, line) in distance.chunks_exact(columns).enumerate() {
            lines.iter_mut().zip(&line[first..first + count]).for_each(|(column, d)| column[row] = *d);
        }
        for column in &mut lines[..count] {
            if column.iter().any(|&d| d > 0.0) {
                envelope.of(column);
            }
        }
        for (row, line) in distance.chunks_exact_mut(columns).enumerate() {
            lines.iter().zip(&mut line[first..first + count]).for_each(|(column, d)| *d = column[row]);
        }
    }
    distance
}

/// The lower envelope of the parabolas over one column.
struct Envelope {
    /// One over twice a number: divisions take the most.
    per_double: Vec<f64>,
    /// Where each parabola of the envelope stands, its height, and from where on it is the lowest.
    peaks: Vec<(usize, f32, f64)>,
}

impl Envelope {
    /// For columns of so many cells.
    fn new(rows: usize) -> Self {
        Self { per_double: (0..rows).map(|n| 0.5 / n as f64).collect(), peaks: Vec::with_capacity(rows) }
    }

    /// Lowers heights to the envelope of the parabolas over them.
    fn of(&mut self, heights: &mut [f32]) {
        self.peaks.clear();
        // What is far is so by itself, whatever the envelope says.
        for (q, &height) in heights.iter().enumerate().filter(|(_, height)| **height < FAR) {
            let lift = |q: usize, height: f32| f64::from(height) + (q * q) as f64;
            let mut start = f64::NEG_INFINITY;
            while let Some(&(p, lower, from)) = self.peaks.last() {
                start = (lift(q, height) - lift(p, lower)) * self.per_double[q - p];
                if start > from {
                    break;
                }
                self.peaks.pop();
                start = f64::NEG_INFINITY;
            }
            self.peaks.push((q, height, start));
        }
        if self.peaks.is_empty() {
            return;
        }
        let mut at = 0;
        for (place, height) in heights.iter_mut().enumerate() {
            while self.peaks.get(at + 1).is_some_and(|next| next.2 < place as f64) {
                at += 1;
            }
            let (peak, lower, _) = self.peaks[at];
            let away = place.abs_diff(peak) as f32;
            *height = (away * away + lower).min(FAR);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]
mod tests {
    use super::*;
    use crate::plane::{Bounds, Curve};
    use crate::world::Boundary;
    use core::f64::consts::TAU;

    fn triangle(role: Role) -> Map {
        let corners = [(0.0, 0.0), (0.09, 0.02), (0.03, 0.08)].map(|(x, y)| Vec2::new(x, y));
        Map::new(vec![Boundary::new(role, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
    }

    #[test]
    fn points_stay_what_they_are_within_their_room() {
        for (role, beyond) in [(Role::Arena, true), (Role::Obstacle, false)] {
            let bounds = Bounds { min: Vec2::new(-0.05, -0.05), max: Vec2::new(0.15, 0.15) };
            let solid = Solid::new(&triangle(role), Raster::over(bounds, 1e-3), 2e-3);
            assert_eq!(solid.room(Vec2::new(5.0, 5.0)) < 0.0, beyond);
            let (mut deep, mut far) = (0, 0);
            for i in 0..40 * 40 {
                let from = Vec2::new(0.0051 * f64::from(i % 40) - 0.05, 0.0049 * f64::from(i / 40) - 0.05);
                let room = solid.room(from);
                deep += u32::from(room < 0.0);
                far += u32::from(room.abs() > 5e-3);
                for k in (0..24).filter(|_| room.abs() > LEAST_ROOM) {
                    let to = from + Vec2::from_angle(TAU * f64::from(k) / 24.0) * (0.999 * f64::from(room.abs()));
                    assert_eq!(solid.room(to) < 0.0, room < 0.0, "{role:?}: from {from:?} to {to:?}, room {room}");
                }
            }
            assert!(deep > 30 && far > 100, "{role:?}: {deep} deep, {far} with room");
        }
    }
}
