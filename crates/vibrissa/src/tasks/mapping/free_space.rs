//! The space that whiskers and robot passed, as a grid of how deep in it a place lies \[elfes1989occupancy; borgefors1986distance\].

use crate::plane::{Bounds, Vec2};

/// Steps of the chamfer distance transform, straight and diagonal (cells), and the share of the Euclidean distance that it tells at
/// least: it is too long by no more than a twelfth.
const STRAIGHT: f64 = 1.0;
const DIAGONAL: f64 = core::f64::consts::SQRT_2;
const AT_LEAST: f64 = 0.92;
/// Most cells of a grid.
const MOST: usize = 4_000_000;

/// How deep in passed space places lie at least; 0 outside.
pub(super) struct FreeSpace {
    origin: Vec2,
    cell: f64,
    columns: usize,
    rows: usize,
    depths: Vec<f64>,
    /// How far any place around may be off, by bins of [`BIN`] cells a side (m).
    offs: Vec<f64>,
}

/// Passed space in pieces, each of which was passed in one go.
pub(super) struct PassedSpace(pub(super) Vec<FreeSpace>);

impl PassedSpace {
    /// As [`FreeSpace::depth`], in the piece in which it is deepest; at most 0 outside of all.
    pub(super) fn depth(&self, place: Vec2) -> f64 {
        self.0.iter().map(|piece| piece.depth(place)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Cells along a side of a bin.
const BIN: usize = 16;

impl FreeSpace {
    /// Around places that were passed, and around the middles of a disc of this radius that was passed (m), each with how far it may be
    /// off (m), in cells of this side (m).
    pub(super) fn new(places: &[(Vec2, f64)], (middles, radius): (&[(Vec2, f64)], f64), cell: f64) -> Self {
        let of_discs = middles.iter().fold(Bounds::EMPTY, |all, (p, _)| all.including(*p)).inflated(radius);
        let bounds = places.iter().fold(of_discs, |all, (p, _)| all.including(*p));
        let (depths, offs) = (Vec::new(), Vec::new());
        let mut grid = Self { origin: Vec2::ZERO, cell, columns: 0, rows: 0, depths, offs };
        if bounds.is_empty() || !bounds.size().is_finite() {
            return grid;
        }
        let margin = Vec2::new(2.0, 2.0) * cell;
        let size = bounds.size() + margin * 2.0;
        (grid.columns, grid.rows) = ((size.x / cell) as usize + 1, (size.y / cell) as usize + 1);
        if grid.columns.saturating_mul(grid.rows) > MOST {
            (grid.columns, grid.rows) = (0, 0);
            return grid;
        }
        grid.origin = bounds.min - margin;
        grid.depths = vec![0.0; grid.columns * grid.rows];
        grid.offs = vec![0.0; grid.bins().0 * grid.bins().1];
        for (place, off) in places {
            if let Some(index) = grid.index(*place) {
                grid.depths[index] = f64::INFINITY;
                grid.note(index, *off);
            }
        }
        middles.iter().filter(|_| radius > 0.0).for_each(|(middle, off)| grid.fill(*middle, radius, *off));
        grid.spread();
        grid.widen();
        grid
    }

    /// Notes a disc.
    fn fill(&mut self, middle: Vec2, radius: f64, off: f64) {
        // Closer than cells, so that none is left out.
        let steps = (2.0 * radius / (0.7 * self.cell)).ceil().max(1.0) as usize;
        let at = |k: usize| radius * (2.0 * k as f64 / steps as f64 - 1.0);
        for (i, j) in (0..=steps).flat_map(|i| (0..=steps).map(move |j| (i, j))) {
            let from = Vec2::new(at(i), at(j));
            if let Some(index) = self.index(middle + from).filter(|_| from.norm_squared() <= radius * radius) {
                self.depths[index] = f64::INFINITY;
                self.note(index, off);
            }
        }
    }

    /// Bins along both sides.
    fn bins(&self) -> (usize, usize) {
        (self.columns.div_ceil(BIN), self.rows.div_ceil(BIN))
    }

    /// A place of this cell may be off by so much.
    fn note(&mut self, index: usize, off: f64) {
        let bin = index / self.columns / BIN * self.bins().0 + index % self.columns / BIN;
        self.offs[bin] = self.offs[bin].max(off);
    }

    /// A depth depends on all places that are as near as it is deep: bins take the largest of theirs.
    fn widen(&mut self) {
        let deepest = self.depths.iter().copied().fold(0.0, f64::max);
        let reach = (deepest / BIN as f64).ceil() as usize + 1;
        let (across, up) = self.bins();
        for (count, length, step) in [(up, across, 1), (across, up, across)] {
            for line in 0..count {
                let first = if step == 1 { line * across } else { line };
                let own: Vec<f64> = (0..length).map(|k| self.offs[first + k * step]).collect();
                for k in 0..length {
                    let near = &own[k.saturating_sub(reach)..(k + reach + 1).min(length)];
                    self.offs[first + k * step] = near.iter().copied().fold(0.0, f64::max);
                }
            }
        }
    }

    fn index(&self, place: Vec2) -> Option<usize> {
        let (x, y) = ((place.x - self.origin.x) / self.cell, (place.y - self.origin.y) / self.cell);
        (x >= 0.0 && y >= 0.0 && (x as usize) < self.columns && (y as usize) < self.rows)
            .then(|| y as usize * self.columns + x as usize)
    }

    /// Distances from the cells that were not passed, forth and back over the grid.
    fn spread(&mut self) {
        let (columns, rows) = (self.columns as isize, self.rows as isize);
        let mut relax = |x: isize, y: isize, before: [(isize, isize, f64); 4]| {
            let at = (y * columns + x) as usize;
            for (dx, dy, step) in before {
                let (i, j) = (x + dx, y + dy);
                let beyond = i < 0 || j < 0 || i >= columns || j >= rows;
                let there = if beyond { 0.0 } else { self.depths[(j * columns + i) as usize] };
                self.depths[at] = self.depths[at].min(there + step);
            }
        };
        let forth = [(-1, 0, STRAIGHT), (-1, -1, DIAGONAL), (0, -1, STRAIGHT), (1, -1, DIAGONAL)];
        let back = forth.map(|(dx, dy, step)| (-dx, -dy, step));
        (0..rows).for_each(|y| (0..columns).for_each(|x| relax(x, y, forth)));
        (0..rows).rev().for_each(|y| (0..columns).rev().for_each(|x| relax(x, y, back)));
    }

    /// Every place within this distance (m) of a place was passed, wherever within its bounds all that was passed is.
    pub(super) fn depth(&self, place: Vec2) -> f64 {
        self.index(place).map_or(0.0, |index| {
            let bin = index / self.columns / BIN * self.bins().0 + index % self.columns / BIN;
            // Places lie up to half a diagonal from the middles between which distances are told, and a cell counts as passed by any
            // place in it.
            self.cell * (AT_LEAST * self.depths[index] - 2.0 * DIAGONAL).max(0.0) - self.offs[bin]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_is_told_to_be_deeper_than_it_is() {
        let passed = |p: Vec2| p.norm() < 0.05 && (p - Vec2::new(0.02, 0.01)).norm() > 0.01;
        let places: Vec<(Vec2, f64)> = (-120..=120)
            .flat_map(|i| (-120..=120).map(move |j| Vec2::new(f64::from(i), f64::from(j)) * 5e-4))
            .filter(|p| passed(*p))
            .map(|p| (p, 1e-3))
            .collect();
        let space = FreeSpace::new(&places, (&[], 0.0), 2e-3);
        let mut deepest = 0.0_f64;
        for k in 0..4000 {
            let place = Vec2::from_angle(f64::from(k) * 2.399) * (1e-3 * f64::from(k).sqrt());
            let exact = (0.05 - place.norm()).min((place - Vec2::new(0.02, 0.01)).norm() - 0.01).max(0.0);
            let told = space.depth(place);
            assert!(told <= (exact - 1e-3).max(0.0), "{place:?}: {told} {exact}");
            deepest = deepest.max(told);
        }
        assert!(deepest > 8e-3, "{deepest}");
        // A disc is as deep as it is wide, but for what cells cost and what it may be off.
        let disc = FreeSpace::new(&[], (&[(Vec2::new(0.1, 0.0), 1e-3)], 0.03), 1e-3);
        assert!((0.02..0.029).contains(&disc.depth(Vec2::new(0.1, 0.0))) && disc.depth(Vec2::new(0.135, 0.0)) <= 0.0);
        assert!(FreeSpace::new(&[], (&[], 0.0), 2e-3).depth(Vec2::ZERO) <= 0.0);
    }
}
