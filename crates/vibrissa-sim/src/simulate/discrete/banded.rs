//! Symmetric banded matrices and their solution.

/// Entries on each side of the diagonal: a node is tied to its two neighbours on either side.
const BAND: usize = 5;

/// A symmetric matrix, its lower triangle by rows: `rows[i][j]` is the entry `(i, i - BAND + j)`.
#[derive(Clone, Debug)]
pub(super) struct Banded {
    rows: Vec<[f64; BAND + 1]>,
}

impl Banded {
    pub(super) fn zero(size: usize) -> Self {
        Self { rows: vec![[0.0; BAND + 1]; size] }
    }

    pub(super) fn clear(&mut self) {
        self.rows.fill([0.0; BAND + 1]);
    }

    /// Adds to the entry `(i, j)`, `i >= j`; entries outside the band do not exist.
    #[inline]
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        self.rows[i][BAND + j - i] += value;
    }

    /// The largest entry of the diagonal.
    pub(super) fn scale(&self) -> f64 {
        self.rows.iter().map(|row| row[BAND].abs()).fold(0.0, f64::max)
    }

    /// Solves `(A + shift) x = b` in place by Cholesky's method into `factor`; false when that is not positive definite.
    pub(super) fn solve(&self, shift: f64, factor: &mut Self, b: &mut [f64]) -> bool {
        let n = self.rows.len();
        factor.rows.clone_from(&self.rows);
        for i in 0..n {
            let first = i.saturating_sub(BAND);
            for j in first..=i {
                let mut sum = factor.rows[i][BAND + j - i] + if i == j { shift } else { 0.0 };
                for k in first.max(j.saturating_sub(BAND))..j {
                    sum -= factor.rows[i][BAND + k - i] * factor.rows[j][BAND + k - j];
                }
                if i == j {
                    if sum.is_nan() || sum <= 0.0 {
                        return false;
                    }
                    factor.rows[i][BAND] = sum.sqrt();
                } else {
                    factor.rows[i][BAND + j - i] = sum / factor.rows[j][BAND];
                }
            }
        }
        for i in 0..n {
            for k in i.saturating_sub(BAND)..i {
                b[i] -= factor.rows[i][BAND + k - i] * b[k];
            }
            b[i] /= factor.rows[i][BAND];
        }
        for i in (0..n).rev() {
            b[i] /= factor.rows[i][BAND];
            for k in i.saturating_sub(BAND)..i {
                b[k] -= factor.rows[i][BAND + k - i] * b[i];
            }
        }
        true
    }
}
