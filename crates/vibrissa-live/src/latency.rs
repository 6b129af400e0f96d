//! How long things take, in buckets that grow by an eighth of an octave: 9 % wide.

/// Buckets an octave.
const FINENESS: f64 = 8.0;
/// The least that is told apart (s).
const LEAST: f64 = 1e-6;
/// Buckets: from a microsecond to an hour.
const BUCKETS: usize = 256;

/// Counts of durations.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    counts: Vec<u64>,
    count: u64,
    largest: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: vec![0; BUCKETS], count: 0, largest: 0.0 }
    }
}

impl Histogram {
    /// Adds a duration (s).
    pub fn push(&mut self, seconds: f64) {
        let bucket = (FINENESS * (seconds / LEAST).max(1.0).log2()) as usize;
        self.counts[bucket.min(BUCKETS - 1)] += 1;
        self.count += 1;
        self.largest = self.largest.max(seconds);
    }

    /// How many were added.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The longest (s).
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// The duration (s) that this share of them does not exceed, to 9 %; 0 where there is none.
    #[must_use]
    pub fn quantile(&self, share: f64) -> f64 {
        let wanted = (share * self.count as f64).ceil() as u64;
        let mut seen = 0;
        for (bucket, count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= wanted.max(1) {
                return bucket_end(bucket).min(self.largest);
            }
        }
        0.0
    }

    /// What was added since an earlier copy of this; the longest is that of all.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        let counts: Vec<u64> =
            self.counts.iter().zip(&earlier.counts).map(|(now, then)| now.saturating_sub(*then)).collect();
        Self { count: counts.iter().sum(), counts, largest: self.largest }
    }

    /// Every bucket that holds something: its end (s), its count.
    pub fn buckets(&self) -> impl Iterator<Item = (f64, u64)> {
        let told = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        told.map(|(bucket, count)| (bucket_end(bucket), *count))
    }
}

fn bucket_end(bucket: usize) -> f64 {
    LEAST * ((bucket + 1) as f64 / FINENESS).exp2()
}

#[cfg(test)]
mod tests {
    use super::Histogram;

    #[test]
    fn quantiles_are_those_of_the_sorted_durations() {
        let mut histogram = Histogram::default();
        let mut all: Vec<f64> = (0..5000).map(|i| 1e-5 * 1.001_f64.powi(i * 7919 % 5000)).collect();
        all.iter().for_each(|&seconds| histogram.push(seconds));
        all.sort_by(f64::total_cmp);
        for share in [0.01, 0.5, 0.9, 0.99, 1.0] {
            let exact = all[((share * 5000.0) as usize).clamp(1, 5000) - 1];
            let found = histogram.quantile(share);
            assert!(found >= exact * 0.999 && found <= exact * 1.1, "{share}: {found} for {exact}");
        }
        let earlier = histogram.clone();
        (0..10).for_each(|_| histogram.push(3.0));
        let since = histogram.since(&earlier);
        assert!(since.count() == 10 && since.quantile(0.01) > 2.7, "{since:?}");
        histogram = earlier;
        assert_eq!((histogram.count(), Histogram::default().quantile(0.5)), (5000, 0.0));
    }
}
