//! Places that were passed, as cells of a grid in the frame of a key pose: an occupancy bitmap in tiles \[elfes1989occupancy\]. A robot that comes
//! by again takes no more memory.

use crate::plane::Vec2;
use std::collections::BTreeMap;

/// Cells along a side of a tile.
const SIDE: i32 = 64;
/// The cells' side, as a share of that of the cells into which they are filled: each of those has the middle of one in it, however it is turned.
const FINER: f64 = 0.5;

/// Cells that were passed.
#[derive(Clone, Debug, Default)]
pub(super) struct PassedCells {
    tiles: BTreeMap<(i32, i32), Box<[u64; SIDE as usize]>>,
}

impl PassedCells {
    /// Takes a place (m); what it is kept for has cells of this side (m).
    pub(super) fn insert(&mut self, place: Vec2, cell: f64) {
        // Beyond all integers is a place that no grid reaches.
        let [x, y] = [place.x, place.y].map(|v| (v / (FINER * cell)).floor() as i32);
        let tile = (x.div_euclid(SIDE), y.div_euclid(SIDE));
        let row =
            &mut self.tiles.entry(tile).or_insert_with(|| Box::new([0; SIDE as usize]))[y.rem_euclid(SIDE) as usize];
        *row |= 1 << x.rem_euclid(SIDE);
    }

    /// The middles of the cells (m).
    pub(super) fn middles(&self, cell: f64) -> impl Iterator<Item = Vec2> {
        let side = FINER * cell;
        self.tiles.iter().flat_map(move |((i, j), rows)| {
            let (left, low) = (f64::from(*i) * f64::from(SIDE), f64::from(*j) * f64::from(SIDE));
            rows.iter().zip(0..).flat_map(move |(row, y)| {
                let set = (0..SIDE).filter(move |x| row >> x & 1 == 1);
                set.map(move |x| Vec2::new(left + f64::from(x) + 0.5, low + f64::from(y) + 0.5) * side)
            })
        })
    }

    /// How far from the middle of its cell a place may be (m).
    pub(super) fn off(cell: f64) -> f64 {
        core::f64::consts::FRAC_1_SQRT_2 * FINER * cell
    }

    /// How many cells there are.
    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.tiles.values().flat_map(|rows| rows.iter()).map(|row| row.count_ones() as usize).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_place_is_kept_once_and_no_farther_off_than_told() {
        const GOLDEN: f64 = 2.399_963_229_728_653;
        let (mut cells, cell) = (PassedCells::default(), 1e-3);
        let place = |k: u32| Vec2::from_angle(f64::from(k) * GOLDEN) * (2e-4 * f64::from(k).sqrt());
        let places: Vec<Vec2> = (0..60_000).map(place).collect();
        places.iter().for_each(|place| cells.insert(*place, cell));
        let count = cells.count();
        places.iter().for_each(|place| cells.insert(*place, cell));
        let middles: Vec<Vec2> = cells.middles(cell).collect();
        assert_eq!((middles.len(), cells.count()), (count, count));
        let off = PassedCells::off(cell) + 1e-12;
        let near = |place: &Vec2| middles.iter().any(|middle| middle.distance(*place) <= off);
        assert!(places.iter().step_by(997).all(near));
        // A disc of 49 mm has so many cells of half a millimetre.
        assert!((29_500..31_500).contains(&count), "{count}");
        // Whatever a larger cell's turn, one of these middles is in it.
        for turn in [0.0, 0.3, 0.785] {
            let mut is_in = vec![false; 60 * 60];
            for middle in cells.middles(cell) {
                let p = middle.rotated(turn) * (1.0 / cell) + Vec2::new(30.0, 30.0);
                if (0.0..60.0).contains(&p.x) && (0.0..60.0).contains(&p.y) {
                    is_in[p.y as usize * 60 + p.x as usize] = true;
                }
            }
            assert!(is_in.iter().all(|&is_in| is_in), "{turn}");
        }
    }
}
