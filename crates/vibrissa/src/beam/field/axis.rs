//! One coordinate of a chart, cut into cells.

extern crate alloc;
use alloc::vec::Vec;

/// Rising knots; between two of them lies a cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) knots: Vec<f64>,
    /// Cells over length where all cells are equally wide, else 0.
    per_length: f64,
}

impl Axis {
    /// Stretches between `breaks`, each cut into `cells` equal cells.
    pub(super) fn new(breaks: &[f64], cells: usize) -> Self {
        let mut knots = Vec::with_capacity((breaks.len().max(1) - 1) * cells + 1);
        for pair in breaks.windows(2) {
            let width = pair[1] - pair[0];
            knots.extend((0..cells).map(|i| pair[0] + width * (i as f64 / cells as f64)));
        }
        knots.extend(breaks.last());
        let widths = breaks.windows(2).map(|pair| pair[1] - pair[0]);
        let (lo, hi) = widths.fold((f64::INFINITY, 0.0_f64), |(lo, hi), w| (lo.min(w), hi.max(w)));
        let per_length = if hi - lo <= 1e-12 * hi { cells as f64 / lo } else { 0.0 };
        Self { knots, per_length }
    }

    /// Number of cells.
    pub(super) fn cells(&self) -> usize {
        self.knots.len() - 1
    }

    pub(super) fn width(&self, cell: usize) -> f64 {
        self.knots[cell + 1] - self.knots[cell]
    }

    /// One over the cell's width.
    #[inline]
    pub(super) fn per_width(&self, cell: usize) -> f64 {
        if self.per_length > 0.0 { self.per_length } else { 1.0 / self.width(cell) }
    }

    /// The cell that holds `x`, or the nearest one.
    #[inline]
    pub(super) fn cell(&self, x: f64) -> usize {
        let last = self.knots.len() - 2;
        if self.per_length > 0.0 {
            // The conversion saturates: what lies before the start becomes 0.
            return (((x - self.knots[0]) * self.per_length) as usize).min(last);
        }
        self.knots.partition_point(|knot| *knot <= x).saturating_sub(1).min(last)
    }
}
