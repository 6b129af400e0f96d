//! The loops between solid and free cells. Lengths are in cells, from the grid's first corner.

use crate::plane::Vec2;

/// The share of each cell that is solid, and that of everything around the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) shares: &'a [f32],
    pub(super) outside: f32,
}

/// What a loop goes around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LoopKind {
    /// Free space in the midst of all that is solid.
    Room,
    /// Something solid.
    Island,
    /// Free space inside an island.
    Hole,
}

/// Where a loop crosses from a free cell to a solid one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// The middle of the side between the two cells.
    pub(super) side: Vec2,
    /// The crossing by the cells' shares.
    pub(super) fine: Vec2,
    /// Whether one of the cells is neither all solid nor all free.
    pub(super) is_grey: bool,
    /// Whether the boundary runs across the row of cells rather than along it, so that the row tells its place.
    pub(super) is_across: bool,
}

/// One closed loop, travelled with free cells on the left.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Loop {
    pub(super) kind: LoopKind,
    pub(super) crossings: Vec<Crossing>,
    /// The corners of the cells' sides.
    pub(super) corners: Vec<Vec2>,
}

/// A corner of cells, or a step between two.
type Place = (isize, isize);

/// The four directions, counter-clockwise from +x.
const STEPS: [Place; 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
/// The cell to the left of a step in each direction, from the corner where it starts.
const LEFT: [Place; 4] = [(0, 0), (-1, 0), (-1, -1), (0, -1)];
/// The cell to its right.
const RIGHT: [Place; 4] = [(0, -1), (0, 0), (-1, 0), (-1, -1)];
/// How far a corner moves into its cell where two solid cells touch by a corner, so that no loop touches itself (cells).
const APART: f64 = 0.1;
/// How many cells on either side tell where a boundary lies: one that runs at 45° crosses three.
const DEPTH: usize = 3;
/// What counts as all free, and from the other end as all solid.
const SATURATED: f32 = 0.02;

impl Field<'_> {
    fn share(&self, (x, y): Place) -> f32 {
        let inside = x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height;
        if inside { self.shares[y as usize * self.width + x as usize] } else { self.outside }
    }

    fn is_solid(&self, cell: Place) -> bool {
        self.share(cell) >= 0.5
    }

    /// Whether a step from a corner has a free cell on its left and a solid one on its right.
    fn borders(&self, corner: Place, direction: usize) -> bool {
        !self.is_solid(add(corner, LEFT[direction])) && self.is_solid(add(corner, RIGHT[direction]))
    }

    /// Whether each cell is solid and joined to the solid outside, sides and corners alike.
    fn outer(&self) -> Vec<bool> {
        let mut outer = vec![false; self.shares.len()];
        if self.outside < 0.5 {
            return outer;
        }
        let mut open: Vec<Place> = Vec::new();
        let (width, height) = (self.width as isize, self.height as isize);
        let rim = (0..width).flat_map(|x| [(x, 0), (x, height - 1)]);
        let rim = rim.chain((0..height).flat_map(|y| [(0, y), (width - 1, y)]));
        let mut reach = |cell: Place, open: &mut Vec<Place>| {
            let inside = cell.0 >= 0 && cell.1 >= 0 && cell.0 < width && cell.1 < height;
            if inside && self.is_solid(cell) {
                let seen = &mut outer[(cell.1 * width + cell.0) as usize];
                if !core::mem::replace(seen, true) {
                    open.push(cell);
                }
            }
        };
        rim.for_each(|cell| reach(cell, &mut open));
        while let Some((x, y)) = open.pop() {
            for dx in -1..=1 {
                (-1..=1).for_each(|dy| reach((x + dx, y + dy), &mut open));
            }
        }
        outer
    }

    /// The crossing of a step.
    fn crossing(&self, corner: Place, direction: usize) -> Crossing {
        let (free, solid) = (add(corner, LEFT[direction]), add(corner, RIGHT[direction]));
        let inwards = (solid.0 - free.0, solid.1 - free.1);
        let (along, normal) = (place(STEPS[direction]), place(inwards));
        let side = place(corner) + along * 0.5;
        let (f0, g0) = (self.share(free), self.share(solid));
        // How the share grows towards the solid cell, and along the side.
        let ahead = |cell: Place| self.share(add(cell, STEPS[direction]));
        let behind = |cell: Place| self.share(add(cell, STEPS[(direction + 2) % 4]));
        let across = (ahead(solid) - ahead(free)) + 2.0 * (g0 - f0) + (behind(solid) - behind(free));
        let sideways = (ahead(solid) - behind(solid)) + (ahead(free) - behind(free));
        Crossing {
            side,
            fine: side + normal * self.offset(free, solid, inwards),
            is_grey: f0 > SATURATED || g0 < 1.0 - SATURATED,
            is_across: across.abs() >= sideways.abs(),
        }
    }

    /// How far the boundary lies beyond the side between a free and a solid cell (cells, towards the solid one).
    ///
    /// The solid parts of a row of cells, from all free to all solid, add up to the length of its solid end. Where a row
    /// does not go all the way, the place is where the share passes one half between the two cells' middles.
    fn offset(&self, free: Place, solid: Place, inwards: Place) -> f64 {
        let outwards = (-inwards.0, -inwards.1);
        let (mut lowest, mut filled, mut cell) = (self.share(free), 0.0, free);
        let mut sum = f64::from(lowest);
        for _ in 1..DEPTH {
            cell = add(cell, outwards);
            let next = self.share(cell);
            if next >= lowest {
                break;
            }
            sum += f64::from(next);
            lowest = next;
        }
        let (mut highest, mut cell) = (self.share(solid), solid);
        filled += 1.0 - f64::from(highest);
        for _ in 1..DEPTH {
            cell = add(cell, inwards);
            let next = self.share(cell);
            if next <= highest {
                break;
            }
            filled += 1.0 - f64::from(next);
            highest = next;
        }
        if lowest <= SATURATED && highest >= 1.0 - SATURATED {
            return (filled - sum).clamp(-1.0, 1.0);
        }
        let (f0, g0) = (f64::from(self.share(free)), f64::from(self.share(solid)));
        (0.5 - f0) / (g0 - f0) - 0.5
    }
}

fn add(a: Place, b: Place) -> Place {
    (a.0 + b.0, a.1 + b.1)
}

fn place((x, y): Place) -> Vec2 {
    Vec2::new(x as f64, y as f64)
}

/// Every loop of the field; none when they have more than `most` crossings together.
pub(super) fn loops(field: &Field, most: usize) -> Option<Vec<Loop>> {
    let outer = field.outer();
    let (width, height) = (field.width as isize, field.height as isize);
    // Steps along +x, of which every loop has one.
    let mut walked = vec![false; field.width * (field.height + 1)];
    let (mut loops, mut total) = (Vec::new(), 0);
    for y in 0..=height {
        for x in 0..width {
            if walked[(y * width + x) as usize] || !field.borders((x, y), 0) {
                continue;
            }
            let one = follow(field, (x, y), &mut walked, &outer);
            total += one.crossings.len();
            if total > most {
                return None;
            }
            loops.push(one);
        }
    }
    Some(loops)
}

/// Follows one loop from a step along +x.
fn follow(field: &Field, start: Place, walked: &mut [bool], outer: &[bool]) -> Loop {
    let (width, mut corner, mut direction) = (field.width as isize, start, 0);
    let (mut crossings, mut corners, mut area) = (Vec::new(), Vec::new(), 0);
    loop {
        if direction == 0 {
            walked[(corner.1 * width + corner.0) as usize] = true;
            area -= corner.1;
        } else if direction == 2 {
            area += corner.1;
        }
        crossings.push(field.crossing(corner, direction));
        corner = add(corner, STEPS[direction]);
        // Left first: free cells that touch by a corner are apart, solid ones hang together.
        let turns = [(direction + 1) % 4, direction, (direction + 3) % 4];
        let next = turns.into_iter().find(|&turn| field.borders(corner, turn)).unwrap_or(direction);
        if next != direction {
            let touches = next == turns[0] && field.borders(corner, turns[2]);
            let (into, here) = (LEFT[direction], place(corner));
            // The cell on the left of the step lies behind the corner that it led to.
            let middle = place(add(add(corner, into), STEPS[(direction + 2) % 4])) + Vec2::new(0.5, 0.5);
            corners.push(if touches { here + (middle - here) * (2.0 * APART) } else { here });
        }
        direction = next;
        if corner == start && direction == 0 {
            break;
        }
    }
    let solid = add(start, RIGHT[0]);
    let is_outer = solid.1 < 0 || outer[(solid.1 * width + solid.0) as usize];
    let kind = match (area > 0, is_outer) {
        (false, _) => LoopKind::Island,
        (true, true) => LoopKind::Room,
        (true, false) => LoopKind::Hole,
    };
    Loop { kind, crossings, corners }
}

#[cfg(test)]
mod tests {
    use super::{Field, Loop, LoopKind, loops};

    fn traced(rows: &[&str], outside: f32) -> Vec<Loop> {
        let digit = |c: char| c.to_digit(10).map_or(1.0, |d| d as f32 / 10.0);
        let shares: Vec<f32> = rows.iter().rev().flat_map(|row| row.chars().map(digit)).collect();
        let field = Field { width: rows[0].len(), height: rows.len(), shares: &shares, outside };
        loops(&field, 1000).unwrap()
    }

    fn kinds(rows: &[&str], outside: f32) -> Vec<LoopKind> {
        traced(rows, outside).iter().map(|one| one.kind).collect()
    }

    #[test]
    fn rooms_islands_and_holes_are_told_apart() {
        use LoopKind::{Hole, Island, Room};
        let nested = ["0000000", "0#####0", "0#000#0", "0#0#0#0", "0#000#0", "0#####0", "0000000"];
        // In order of their lowest side with the free cell above it.
        assert_eq!(kinds(&nested, 1.0), [Room, Hole, Island, Island]);
        assert_eq!(kinds(&nested, 0.0), [Hole, Island, Island]);
        assert_eq!(kinds(&["###", "#0#", "###"], 1.0), [Room]);
        assert_eq!(kinds(&["###", "###"], 1.0), []);
        assert_eq!(kinds(&["00", "00"], 0.0), []);
    }

    #[test]
    fn solid_cells_that_touch_by_a_corner_hang_together() {
        let traced = traced(&["#0", "0#"], 0.0);
        assert_eq!((traced.len(), traced[0].crossings.len()), (1, 8));
        let mut corners = traced[0].corners.clone();
        corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        assert!(corners.windows(2).all(|w| w[0] != w[1]), "{corners:?}");
    }

    #[test]
    fn the_shares_of_a_row_add_up_to_the_boundarys_place() {
        // A vertical wall's edge at x = 2.7, then at 2.2: the third cell is solid to 0.3 and 0.8.
        for (row, edge) in [("003###", 2.7), ("008###", 2.2), ("00####", 2.0), ("0016##", 3.3)] {
            let one = traced(&[row, row, row], 0.0).remove(0);
            let left: Vec<_> =
                one.crossings.iter().filter(|c| c.fine.x < 4.0 && (c.fine.y - 1.5).abs() < 1e-9).collect();
            assert!(left.len() == 1 && (left[0].fine.x - edge).abs() < 1e-6, "{row}: {left:?}");
        }
    }
}
