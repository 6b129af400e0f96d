//! Symmetric positive definite systems whose unknowns know only their neighbours.

/// A symmetric matrix of which only the diagonal and `width` diagonals below it are not zero, row by row.
#[derive(Clone, Debug)]
pub(super) struct Band {
    width: usize,
    rows: Vec<f64>,
}

impl Band {
    /// Zeros, for `size` unknowns.
    pub(super) fn zeros(size: usize, width: usize) -> Self {
        Self { width, rows: vec![0.0; size * (width + 1)] }
    }

    fn size(&self) -> usize {
        self.rows.len() / (self.width + 1)
    }

    fn index(&self, i: usize, j: usize) -> usize {
        i * (self.width + 1) + (j + self.width - i)
    }

    fn get(&self, i: usize, j: usize) -> f64 {
        if i > j + self.width { 0.0 } else { self.rows[self.index(i, j)] }
    }

    /// Adds the square of a row of the Jacobian: `first` is its first unknown, `row` the derivatives from there on.
    pub(super) fn add_square(&mut self, first: usize, row: &[f64]) {
        for (a, &left) in row.iter().enumerate() {
            for (b, &right) in row.iter().enumerate().take(a + 1) {
                let index = self.index(first + a, first + b);
                self.rows[index] += left * right;
            }
        }
    }

    /// The diagonal entry of an unknown.
    pub(super) fn diagonal(&mut self, i: usize) -> &mut f64 {
        let index = self.index(i, i);
        &mut self.rows[index]
    }

    /// The Cholesky factor; none when the matrix is not positive definite.
    pub(super) fn factor(mut self) -> Option<Factor> {
        for i in 0..self.size() {
            let first = i.saturating_sub(self.width);
            for j in first..=i {
                let from = first.max(j.saturating_sub(self.width));
                let sum: f64 = (from..j).map(|k| self.get(i, k) * self.get(j, k)).sum();
                let rest = self.get(i, j) - sum;
                let index = self.index(i, j);
                self.rows[index] = if i > j {
                    rest / self.get(j, j)
                } else if rest > 0.0 && rest.is_finite() {
                    rest.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(Factor { lower: self })
    }
}

/// The lower triangular factor of a [`Band`].
#[derive(Clone, Debug)]
pub(super) struct Factor {
    lower: Band,
}

impl Factor {
    /// The solution for this right side.
    pub(super) fn solve(&self, mut right: Vec<f64>) -> Vec<f64> {
        let (size, width) = (self.lower.size(), self.lower.width);
        for i in 0..size {
            let sum: f64 = (i.saturating_sub(width)..i).map(|k| self.lower.get(i, k) * right[k]).sum();
            right[i] = (right[i] - sum) / self.lower.get(i, i);
        }
        for i in (0..size).rev() {
            let last = (i + width).min(size - 1);
            let sum: f64 = (i + 1..=last).map(|k| self.lower.get(k, i) * right[k]).sum();
            right[i] = (right[i] - sum) / self.lower.get(i, i);
        }
        right
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::Band;

    #[test]
    fn solves_what_a_product_by_hand_gives() {
        // J = [[2, 1, 0], [0, 3, -1], [1, 0, 0], [0, 0, 2]] and x = (1, -2, 0.5): J^T J x by hand.
        let mut band = Band::zeros(3, 2);
        band.add_square(0, &[2.0, 1.0]);
        band.add_square(1, &[3.0, -1.0]);
        band.add_square(0, &[1.0]);
        band.add_square(2, &[2.0]);
        let x = band.factor().unwrap().solve(vec![1.0, -19.5, 8.5]);
        for (found, expected) in x.iter().zip([1.0, -2.0, 0.5]) {
            assert!((found - expected).abs() < 1e-12, "{x:?}");
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut band = Band::zeros(2, 1);
        band.add_square(0, &[1.0, 1.0]);
        assert!(band.factor().is_none());
    }
}
