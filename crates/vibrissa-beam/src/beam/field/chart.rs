//! The chart of a field: a load coordinate that is finer near rest, and how far the loads go.
use alloc::vec::Vec;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A rising analytic map of `[-from, from]` to `[-to, to]` that is six times steeper at the ends than in the middle:
/// `to w / (2 - w²)` with `w = x / from`.
///
/// As a force over its coordinate it makes cells finer near rest, as a coordinate over the tilt finer at the ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bunched {
    pub(super) from: f64,
    pub(super) to: f64,
    // Look-ups take nanoseconds, of which divisions are the most.
    per_from: f64,
    per_to: f64,
}

impl Bunched {
    pub(super) const fn new(from: f64, to: f64) -> Self {
        Self { from, to, per_from: 1.0 / from, per_to: 1.0 / to }
    }

    #[inline]
    pub(super) fn at(&self, x: f64) -> f64 {
        let w = x * self.per_from;
        self.to * w / (2.0 - w * w)
    }

    /// The derivative of [`Bunched::at`].
    #[inline]
    pub(super) fn rate(&self, x: f64) -> f64 {
        let w = x * self.per_from;
        let below = 2.0 - w * w;
        self.to * self.per_from * (2.0 + w * w) / (below * below)
    }

    /// The inverse of [`Bunched::at`].
    #[inline]
    pub(super) fn inverse(&self, y: f64) -> f64 {
        let q = y * self.per_to;
        4.0 * self.from * q / (1.0 + (1.0 + 8.0 * q * q).sqrt())
    }
}

/// The largest loads of a field, at equal steps of the other coordinate and linear between them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LoadLimits {
    start: f64,
    end: f64,
    per_step: f64,
    /// The largest positive force, and the size of the largest negative one (N).
    pub(super) forces: Vec<[f64; 2]>,
}

impl LoadLimits {
    /// Limits at equal steps from `start` to `end`; at least two.
    pub(super) fn new(start: f64, end: f64, forces: Vec<[f64; 2]>) -> Self {
        let per_step = (forces.len().max(2) - 1) as f64 / (end - start);
        Self { start, end, per_step, forces }
    }

    /// The largest load at `u` on the side of `sign`, as a size (N); 0 outside the chart.
    #[inline(always)]
    pub(super) fn at(&self, u: f64, sign: f64) -> f64 {
        if !(u >= self.start && u <= self.end) {
            return 0.0;
        }
        let cells = self.forces.len() - 1;
        let x = (u - self.start) * self.per_step;
        let i = (x as u32 as usize).min(cells - 1);
        let k = usize::from(sign < 0.0);
        let (a, b) = (self.forces[i][k], self.forces[i + 1][k]);
        a + (b - a) * (x - i as f64)
    }

    /// Loads that are within the limits all over a cell of the other coordinate, on both sides; for each cell between `knots`.
    pub(super) fn sure(&self, knots: &[f64]) -> Vec<[f64; 2]> {
        let inside = |u: f64| u.clamp(self.start, self.end);
        let least = |w: &[f64], k: usize| {
            let sign = if k == 0 { 1.0 } else { -1.0 };
            let (lo, hi) = (inside(w[0]), inside(w[1]));
            (1.0 - 1e-12) * self.corners(lo, hi, k).fold(self.at(lo, sign).min(self.at(hi, sign)), f64::min)
        };
        knots.windows(2).map(|w| [least(w, 0), least(w, 1)]).collect()
    }

    /// The limits on side `k` at the steps within `(lo, hi)`.
    fn corners(&self, lo: f64, hi: f64, k: usize) -> impl Iterator<Item = f64> + '_ {
        let step = 1.0 / self.per_step;
        let within = move |i: &usize| {
            let u = self.start + step * *i as f64;
            u > lo && u < hi
        };
        (0..self.forces.len()).filter(within).map(move |i| self.forces[i][k])
    }

    /// The largest load anywhere on either side (N).
    pub(super) fn largest(&self) -> f64 {
        self.forces.iter().flatten().fold(0.0, |a, b| a.max(*b))
    }

    /// The largest load on the side of `sign` over `[lo, hi]`.
    pub(super) fn largest_over(&self, lo: f64, hi: f64, sign: f64) -> f64 {
        self.corners(lo, hi, usize::from(sign < 0.0)).fold(self.at(lo, sign).max(self.at(hi, sign)), f64::max)
    }
}

/// The largest load up to `most` for which `ok` holds from rest on, by steps of a fifth and then by halving, to 5e-5.
pub(super) fn reach(most: f64, ok: impl Fn(f64) -> bool) -> f64 {
    let (mut good, mut bad) = (0.0, most * 0.003);
    while ok(bad) {
        if bad >= most {
            return most;
        }
        (good, bad) = (bad, (1.2 * bad).min(most));
    }
    for _ in 0..12 {
        let middle = 0.5 * (good + bad);
        if ok(middle) { good = middle } else { bad = middle }
    }
    good
}

/// How a table's coordinate follows from that of the samples: samples are spread by the smoothness of what is sampled, while a table
/// is read in the caller's own numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BendKind {
    Same,
    At(Bunched),
    Inverse(Bunched),
}

impl BendKind {
    /// The table's coordinate.
    pub(super) fn at(&self, x: f64) -> f64 {
        match self {
            Self::Same => x,
            Self::At(map) => map.at(x),
            Self::Inverse(map) => map.inverse(x),
        }
    }

    /// The samples' coordinate.
    pub(super) fn back(&self, y: f64) -> f64 {
        match self {
            Self::Same => y,
            Self::At(map) => map.inverse(y),
            Self::Inverse(map) => map.at(y),
        }
    }

    /// The derivative of [`BendKind::back`] at `y`.
    pub(super) fn back_rate(&self, y: f64) -> f64 {
        match self {
            Self::Same => 1.0,
            Self::At(map) => 1.0 / map.rate(map.inverse(y)),
            Self::Inverse(map) => map.rate(y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bunched_map_turns_back() {
        let map = Bunched::new(0.5, 3.7);
        for i in -100..=100 {
            let x = f64::from(i) / 200.0;
            assert!((map.inverse(map.at(x)) - x).abs() < 1e-14);
            let rate = (map.at(x + 1e-6) - map.at(x - 1e-6)) / 2e-6;
            assert!((rate / map.rate(x) - 1.0).abs() < 1e-8);
            for bend in [BendKind::Same, BendKind::At(map), BendKind::Inverse(map)] {
                let y = bend.at(x);
                let slope = (bend.back(y + 1e-6) - bend.back(y - 1e-6)) / 2e-6;
                assert!((bend.back(y) - x).abs() < 1e-13 && (slope / bend.back_rate(y) - 1.0).abs() < 1e-8);
            }
        }
        assert!((map.at(0.5) - 3.7).abs() < 1e-14);
        assert!((map.rate(0.5) / map.rate(0.0) - 6.0).abs() < 1e-12);
    }
}
