//! Symmetric positive definite systems whose unknowns know only their neighbours.

/// Share of a diagonal entry below which what elimination leaves of it is rounding.
const SINGULAR: f64 = 1e-13;

/// A symmetric matrix of which only the diagonal and `width` diagonals below it are not zero, row by row.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    width: usize,
    rows: Vec<f64>,
}

impl Band {
    /// Zeros, for `size` unknowns.
    pub(crate) fn zeros(size: usize, width: usize) -> Self {
        Self { width, rows: vec![0.0; size * (width + 1)] }
    }

    /// Number of unknowns.
    pub(crate) fn size(&self) -> usize {
        self.rows.len() / (self.width + 1)
    }

    fn index(&self, i: usize, j: usize) -> usize {
        i * (self.width + 1) + (j + self.width - i)
    }

    /// An entry, of which the first unknown is no earlier.
    pub(super) fn get(&self, i: usize, j: usize) -> f64 {
        if i > j + self.width { 0.0 } else { self.rows[self.index(i, j)] }
    }

    /// Adds the square of a row of the Jacobian: `first` is its first unknown, `row` the derivatives from there on.
    pub(crate) fn add_square(&mut self, first: usize, row: &[f64]) {
        for (a, &left) in row.iter().enumerate() {
            for (b, &right) in row.iter().enumerate().take(a + 1) {
                let index = self.index(first + a, first + b);
                self.rows[index] += left * right;
            }
        }
    }

    /// Adds to an entry, of which the first unknown is the later.
    pub(crate) fn add(&mut self, i: usize, j: usize, value: f64) {
        let index = self.index(i, j);
        self.rows[index] += value;
    }

    /// The diagonal entry of an unknown.
    pub(crate) fn diagonal(&mut self, i: usize) -> &mut f64 {
        let index = self.index(i, i);
        &mut self.rows[index]
    }

    /// The normal matrix of a dense Jacobian, row by row: all unknowns are neighbours.
    pub(crate) fn of_rows<'a>(size: usize, rows: impl Iterator<Item = &'a [f64]>) -> Self {
        let mut band = Self::zeros(size, size.saturating_sub(1));
        rows.for_each(|row| band.add_square(0, row));
        band
    }

    /// The matrix of some of the unknowns alone.
    pub(crate) fn part(&self, unknowns: &[usize]) -> Self {
        let mut part = Self::zeros(unknowns.len(), unknowns.len().saturating_sub(1));
        for (a, &i) in unknowns.iter().enumerate() {
            for (b, &j) in unknowns.iter().enumerate().take(a + 1) {
                let index = part.index(a, b);
                part.rows[index] = self.get(i.max(j), i.min(j));
            }
        }
        part
    }

    /// The same system with the diagonal raised by the share `damping`; unknowns on which nothing depends stay where they are.
    pub(crate) fn damped(mut self, damping: f64) -> Self {
        for i in 0..self.size() {
            let entry = self.diagonal(i);
            *entry = if *entry > 0.0 { *entry * (1.0 + damping) } else { 1.0 };
        }
        self
    }

    /// The Cholesky factor; none when the matrix is not positive definite in double precision.
    ///
    /// A pivot is compared with its own diagonal entry, so that the unknowns' units do not matter.
    pub(crate) fn factor(mut self) -> Option<Factor> {
        for i in 0..self.size() {
            let first = i.saturating_sub(self.width);
            for j in first..=i {
                let from = first.max(j.saturating_sub(self.width));
                let sum: f64 = (from..j).map(|k| self.get(i, k) * self.get(j, k)).sum();
                let rest = self.get(i, j) - sum;
                let index = self.index(i, j);
                self.rows[index] = if i > j {
                    rest / self.get(j, j)
                } else if rest.is_finite() && rest > SINGULAR * self.get(i, i) {
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
pub(crate) struct Factor {
    lower: Band,
}

impl Factor {
    /// The solution for this right side.
    pub(crate) fn solve(&self, mut right: Vec<f64>) -> Vec<f64> {
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

impl Factor {
    /// The entries of the inverse within the band, by Takahashi's equations \[takahashi1973formation\]: with the work of a few factors, not of a
    /// solution for each unknown.
    pub(crate) fn inverse_within_band(&self) -> Band {
        let (size, width) = (self.lower.size(), self.lower.width);
        let mut inverse = Band::zeros(size, width);
        for i in (0..size).rev() {
            let own = self.lower.get(i, i);
            let below: Vec<f64> = (i + 1..=(i + width).min(size - 1)).map(|k| self.lower.get(k, i) / own).collect();
            let count = below.len();
            let mut sums = vec![0.0; count];
            for a in 0..count {
                // Row by row, each entry for both of its places.
                let row = inverse.index(i + 1 + a, i + 1);
                let entries = &inverse.rows[row..=row + a];
                let (before, diagonal) = entries.split_at(a);
                let along: f64 = before.iter().zip(&below).map(|(z, l)| z * l).sum();
                sums[a] += along + diagonal[0] * below[a];
                sums[..a].iter_mut().zip(before).for_each(|(sum, z)| *sum += z * below[a]);
            }
            let with_itself: f64 = sums.iter().zip(&below).map(|(sum, l)| sum * l).sum();
            for (a, sum) in sums.into_iter().enumerate() {
                inverse.add(i + 1 + a, i, -sum);
            }
            *inverse.diagonal(i) = (own * own).recip() + with_itself;
        }
        inverse
    }

    /// The inverse of the matrix.
    pub(crate) fn inverse(&self) -> Vec<Vec<f64>> {
        let size = self.lower.size();
        (0..size).map(|i| self.solve((0..size).map(|j| if i == j { 1.0 } else { 0.0 }).collect())).collect()
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
    fn the_inverse_within_the_band_is_that_of_all_solutions() {
        let value = |k: usize| ((k * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
        for (size, width) in [(1, 0), (7, 0), (12, 1), (12, 4), (9, 8)] {
            let mut band = Band::zeros(size, width);
            for k in 0..size - width {
                band.add_square(k, &(0..=width).map(|j| value(11 * k + j)).collect::<Vec<f64>>());
            }
            (0..size).for_each(|k| *band.diagonal(k) += 0.3);
            let factor = band.factor().unwrap();
            let (within, whole) = (factor.inverse_within_band(), factor.inverse());
            for (i, row) in whole.iter().enumerate() {
                for (j, &expected) in row.iter().enumerate().take(i + 1).skip(i.saturating_sub(width)) {
                    let found = within.get(i, j);
                    assert!((found - expected).abs() < 1e-12, "{size} {width}: {i} {j}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        let mut band = Band::zeros(2, 1);
        band.add_square(0, &[1.0, 1.0]);
        assert!(band.factor().is_none());
    }
}
