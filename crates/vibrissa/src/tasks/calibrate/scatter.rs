//! What the fits of moments share: how readings scatter, weights, rows that are left out together, hysteresis.

use crate::least_squares::linear;

/// How readings scatter about the curve: the variance at a moment `m` is `floor + share * m²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scatter {
    floor: f64,
    share: f64,
}

/// Rounds of the fit of the scatter.
const ROUNDS: usize = 20;
/// The least floor, as a share of the variance at the largest moment: no contact outweighs another by more than its root.
const LEAST_FLOOR: f64 = 1e-4;

impl Scatter {
    /// The same everywhere.
    pub(super) const EVEN: Self = Self { floor: 1.0, share: 0.0 };

    /// What explains the squares of the residuals best, each weighed by its own variance.
    pub(super) fn of(moments: &[f64], residuals: &[f64]) -> Self {
        let largest = moments.iter().fold(0.0, |most: f64, m| most.max(m * m));
        let mean = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len().max(1) as f64;
        if !(mean > 0.0 && largest > 0.0) {
            return Self::EVEN;
        }
        let mut scatter = Self { floor: mean, share: 0.0 };
        for _ in 0..ROUNDS {
            let row = |m: f64| vec![1.0 / scatter.variance(m), m * m / scatter.variance(m)];
            let rows: Vec<Vec<f64>> = moments.iter().map(|m| row(*m)).collect();
            let targets: Vec<f64> = moments.iter().zip(residuals).map(|(m, r)| r * r / scatter.variance(*m)).collect();
            let Some(fitted) = linear(&rows, &targets) else { break };
            let (floor, share) = (fitted[0], fitted[1].max(0.0));
            scatter = Self { floor: floor.max(LEAST_FLOOR * (share * largest).max(mean)), share };
        }
        scatter
    }

    pub(super) fn variance(&self, moment: f64) -> f64 {
        self.floor + self.share * moment * moment
    }

    pub(super) fn std(&self, moment: f64) -> f64 {
        self.variance(moment).sqrt()
    }
}

/// Whether squared errors are no larger than others of the same rows by more than one standard error of the difference.
pub(super) fn is_as_good(own: &[f64], best: &[f64]) -> bool {
    let n = own.len().max(1) as f64;
    let mean = own.iter().zip(best).map(|(a, b)| a - b).sum::<f64>() / n;
    let spread = own.iter().zip(best).map(|(a, b)| (a - b - mean).powi(2)).sum::<f64>() / n;
    mean <= (spread / n).sqrt()
}

/// Rows in one block that is left out together: neighbours in time share their errors.
const BLOCK: usize = 8;
/// How many parts the blocks are dealt into.
const FOLDS: usize = 10;

/// The rows of each part, and all others.
pub(super) fn parts(rows: usize) -> impl Iterator<Item = (Vec<usize>, Vec<usize>)> {
    let fold = |row: usize| row / BLOCK % FOLDS;
    (0..FOLDS).map(move |part| (0..rows).partition(|&row| fold(row) == part))
}

/// The combination of the terms of readings that is nearest to targets, each row with its weight.
///
/// The readings have errors and the labels all but none: plain least squares of moments by readings would make every
/// moment too small. The terms of the readings are therefore first replaced by what those of the labels tell of them (instrumental
/// variables).
pub(super) fn by_labels(
    labels: &[Vec<f64>],
    readings: &[Vec<f64>],
    targets: &[f64],
    weights: &[f64],
) -> Option<Vec<f64>> {
    let weighed = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
        rows.iter().zip(weights).map(|(row, w)| row.iter().map(|v| v * w).collect()).collect()
    };
    let weighed_labels = weighed(labels);
    let told = |k: usize| {
        let column: Vec<f64> = readings.iter().zip(weights).map(|(row, w)| row[k] * w).collect();
        linear(&weighed_labels, &column)
    };
    let terms = readings.first()?.len();
    let told: Vec<Vec<f64>> = (0..terms).map(told).collect::<Option<_>>()?;
    let rows: Vec<Vec<f64>> = labels.iter().map(|label| told.iter().map(|by| dot(by, label)).collect()).collect();
    let targets: Vec<f64> = targets.iter().zip(weights).map(|(target, w)| target * w).collect();
    linear(&weighed(&rows), &targets)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Widest gap between the mean residuals of rising and of falling load, over eighths of the range.
pub(super) fn hysteresis(moments: &[f64], residuals: &[f64]) -> f64 {
    const BINS: usize = 8;
    const FEWEST: usize = 4;
    let most = moments.iter().map(|m| m.abs()).fold(0.0, f64::max);
    let mut sums = [[(0.0, 0usize); 2]; BINS];
    let mut rising = None;
    for row in 1..moments.len() {
        let (before, now) = (moments[row - 1].abs(), moments[row].abs());
        if (now - before).abs() > 1e-6 * most {
            rising = Some(now > before);
        }
        if let Some(rising) = rising {
            let bin = ((now / most * BINS as f64) as usize).min(BINS - 1);
            let cell = &mut sums[bin][usize::from(rising)];
            *cell = (cell.0 + residuals[row] * moments[row].signum(), cell.1 + 1);
        }
    }
    let gap = |[down, up]: &[(f64, usize); 2]| match (down.1.min(up.1) >= FEWEST, down, up) {
        (true, down, up) => (down.0 / down.1 as f64 - up.0 / up.1 as f64).abs(),
        _ => 0.0,
    };
    sums.iter().map(gap).fold(0.0, f64::max)
}

pub(super) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
