//! One coordinate of a table, cut into cells.
use alloc::vec::Vec;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Most bins over the axis: cells a thousandth as wide as the mean need no more.
const MOST_BINS: usize = 1 << 17;

/// Rising knots; between two of them lies a cell. A grid of equal bins, none wider than the narrowest cell, tells the cell of a place
/// without a search.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) knots: Vec<f64>,
    spans: Vec<AxisSpan>,
    first: f64,
    /// Half a bin beyond the first knot.
    half: f64,
    per_bin: f64,
    bins: Vec<Bin>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Bin {
    /// The cell of the bin's start.
    cell: u32,
    /// Where that cell ends.
    end: f64,
}

/// A number this large has no fractions: what is added to it is rounded, and stands in its last bits.
const WHOLE: f64 = (1u64 << 52) as f64;

#[derive(Clone, Copy, Debug, PartialEq)]
struct AxisSpan {
    start: f64,
    width: f64,
    per_width: f64,
}

/// A place on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisPlace {
    pub(super) cell: usize,
    /// The way through the cell, 0 at its start and 1 at its end.
    pub(super) share: f64,
    /// The same as a distance.
    pub(super) along: f64,
    pub(super) width: f64,
}

impl Axis {
    /// The axis with these knots, which rise; at least two.
    pub(super) fn new(knots: Vec<f64>) -> Self {
        let spans: Vec<AxisSpan> = knots
            .windows(2)
            .map(|w| AxisSpan { start: w[0], width: w[1] - w[0], per_width: 1.0 / (w[1] - w[0]) })
            .collect();
        let narrowest = spans.iter().fold(f64::INFINITY, |least, span| least.min(span.width));
        let length = spans.iter().fold(0.0, |sum, span| sum + span.width);
        let count = ((length / narrowest).ceil() as usize).clamp(1, MOST_BINS);
        let per_bin = count as f64 / length;
        let start = |bin: usize| knots[0] + bin as f64 / per_bin;
        let cell = |x: f64| knots.partition_point(|knot| *knot <= x).saturating_sub(1).min(spans.len().max(1) - 1);
        let end = |cell: usize| if cell + 1 < spans.len() { knots[cell + 1] } else { f64::NAN };
        let mut bins: Vec<Bin> =
            (0..count).map(|bin| cell(start(bin))).map(|cell| Bin { cell: cell as u32, end: end(cell) }).collect();
        // What lies beyond the last bin belongs to the last cell, which no place is beyond, not even an infinite one.
        bins.push(Bin { cell: spans.len() as u32 - 1, end: f64::NAN });
        Self { first: knots[0], half: knots[0] + 0.5 / per_bin, knots, spans, per_bin, bins }
    }

    /// Number of cells.
    #[inline(always)]
    pub(super) fn cells(&self) -> usize {
        self.knots.len() - 1
    }

    #[inline]
    pub(super) fn width(&self, cell: usize) -> f64 {
        self.spans[cell].width
    }

    /// What lies at a share of a cell.
    #[inline]
    pub(super) fn at(&self, cell: usize, share: f64) -> f64 {
        let span = &self.spans[cell];
        span.start + share * span.width
    }

    /// The cell that holds `x`, or the nearest one.
    #[inline]
    pub(super) fn cell(&self, x: f64) -> usize {
        // The conversion saturates: what lies before the start becomes 0. To 32 bits it takes a third of the instructions.
        let bin = ((x - self.first) * self.per_bin) as u32 as usize;
        let Some(Bin { cell, end }) = self.bins.get(bin) else { return self.spans.len() - 1 };
        // A bin holds one knot at most.
        *cell as usize + usize::from(x >= *end)
    }

    /// The place of `x` in the cell that holds it, or in the nearest one.
    #[inline]
    pub(super) fn place(&self, x: f64) -> AxisPlace {
        self.place_in(self.cell(x), x)
    }

    /// The cell that holds `x`, or the nearest one, and the distance from its start; within rounding of a knot the cell may be the
    /// one on its other side. Look-ups wait for this: a sum is rounded in half the time that a conversion to a whole number takes.
    #[inline(always)]
    pub(super) fn along(&self, x: f64) -> (usize, f64) {
        let bins = (x - self.half) * self.per_bin;
        let whole = WHOLE + if bins > 0.0 { bins } else { 0.0 };
        let bin = usize::try_from(whole.to_bits().wrapping_sub(WHOLE.to_bits())).unwrap_or(usize::MAX);
        let cell = match self.bins.get(bin) {
            Some(Bin { cell, end }) => *cell as usize + usize::from(x >= *end),
            None => self.knots.len().saturating_sub(2),
        };
        (cell, x - self.knots.get(cell).copied().unwrap_or(x))
    }

    /// The place of `x` as seen from a cell.
    #[inline]
    pub(super) fn place_in(&self, cell: usize, x: f64) -> AxisPlace {
        let AxisSpan { start, width, per_width } = self.spans[cell];
        let along = x - start;
        AxisPlace { cell, share: along * per_width, along, width }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bin_knows_its_cell() {
        let uneven = [-1.0, -0.9, -0.85, 0.0, 0.011, 0.5, 3.0];
        let even: Vec<f64> = (0..=96).map(|i| f64::from(i) / 96.0 * 0.7).collect();
        for knots in [uneven.to_vec(), even, alloc::vec![2.0, 5.0]] {
            let axis = Axis::new(knots.clone());
            let last = knots.len() - 2;
            let inside = (0..=4000).map(|i| knots[0] + (knots[last + 1] - knots[0]) * f64::from(i) / 4000.0);
            for x in inside.chain([-1e9, 1e9, f64::NEG_INFINITY, f64::INFINITY]).chain(knots.clone()) {
                let want = knots.iter().rposition(|knot| *knot <= x).unwrap_or(0).min(last);
                assert_eq!(axis.cell(x), want, "{x} {knots:?}");
                let place = axis.place(x);
                let (cell, along) = axis.along(x);
                assert!(
                    cell == want || !x.is_finite() || (x - knots[want]).min(knots[want + 1] - x).abs() < 1e-14,
                    "{x}"
                );
                assert!(!x.is_finite() || along + knots[cell] - x == 0.0);
                assert!(
                    !x.is_finite() || (knots[want] + place.share * place.width - x).abs() <= 1e-12 * (1.0 + x.abs())
                );
            }
            assert_eq!(axis.cell(f64::NAN), 0);
        }
    }
}
