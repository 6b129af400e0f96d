//! Which cells of a chart may hold a value: a grid over the image, with the cells that reach into each of its boxes.
use super::image::Image;
use super::table::Table;
use alloc::vec;
use alloc::vec::Vec;

/// Boxes of the grid along each side.
const BOXES: usize = 160;

#[derive(Clone, Debug)]
pub(super) struct Index {
    lo: [f64; 2],
    hi: [f64; 2],
    /// Where the cells of each box begin in `cells`.
    starts: Vec<u32>,
    /// Positions in `held`.
    cells: Vec<u32>,
    held: Vec<Held>,
}

/// A cell of the chart and the bounds of its image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    pub(super) i: usize,
    pub(super) j: usize,
    pub(super) bounds: [f64; 4],
}

impl Held {
    /// Whether the bounds meet the box `[lo, hi]`.
    pub(super) fn meets(&self, lo: [f64; 2], hi: [f64; 2]) -> bool {
        let b = &self.bounds;
        b[0] <= hi[0] && b[2] >= lo[0] && b[1] <= hi[1] && b[3] >= lo[1]
    }
}

impl Index {
    /// The index of the cells for which `is_held(i, j)`.
    pub(super) fn new(image: Image, table: &Table, is_held: impl Fn(usize, usize) -> bool) -> Self {
        let mut held = Vec::new();
        for i in 0..table.u.cells() {
            for j in 0..table.v.cells() {
                if is_held(i, j) {
                    held.push(Held { i, j, bounds: image.bounds(table, i, j) });
                }
            }
        }
        let mut index =
            Self { lo: [f64::INFINITY; 2], hi: [f64::NEG_INFINITY; 2], starts: vec![], cells: vec![], held };
        for cell in &index.held {
            for axis in 0..2 {
                index.lo[axis] = index.lo[axis].min(cell.bounds[axis]);
                index.hi[axis] = index.hi[axis].max(cell.bounds[axis + 2]);
            }
        }
        let mut lists: Vec<Vec<u32>> = vec![vec![]; BOXES * BOXES];
        for (number, cell) in index.held.iter().enumerate() {
            let [a, b, c, d] = cell.bounds;
            let (low, high) = (index.place([a, b]), index.place([c, d]));
            for p in low[0]..=high[0] {
                for q in low[1]..=high[1] {
                    lists[p * BOXES + q].push(number as u32);
                }
            }
        }
        index.starts.push(0);
        for list in lists {
            index.cells.extend(list);
            index.starts.push(index.cells.len() as u32);
        }
        index
    }

    /// The box of the grid that holds `value`, or the nearest.
    fn place(&self, value: [f64; 2]) -> [usize; 2] {
        [0, 1].map(|axis| {
            let share = (value[axis] - self.lo[axis]) / (self.hi[axis] - self.lo[axis]);
            ((share * BOXES as f64) as usize).min(BOXES - 1)
        })
    }

    /// The cells whose image may hold `value`.
    pub(super) fn at(&self, value: [f64; 2]) -> impl Iterator<Item = &Held> {
        let inside = (0..2).all(|axis| value[axis] >= self.lo[axis] && value[axis] <= self.hi[axis]);
        let [p, q] = self.place(value);
        let (from, to) = (self.starts[p * BOXES + q] as usize, self.starts[p * BOXES + q + 1] as usize);
        let range = if inside { from..to } else { 0..0 };
        self.cells[range].iter().map(|k| &self.held[*k as usize]).filter(move |cell| cell.meets(value, value))
    }

    /// The cells whose image may meet the box `[lo, hi]`, in the order of the chart.
    pub(super) fn meeting(&self, lo: [f64; 2], hi: [f64; 2]) -> Vec<&Held> {
        self.held.iter().filter(|cell| cell.meets(lo, hi)).collect()
    }

    /// The range of the first of the two quantities.
    pub(super) fn first_range(&self) -> (f64, f64) {
        (self.lo[0], self.hi[0])
    }
}
