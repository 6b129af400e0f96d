//! Bordered band systems (arrowheads): unknowns that know only their neighbours, and a few that know all \[golub2013matrix, sec. 4.3\].

use super::band::{Band, Factor};
use crate::linear_algebra::DenseCholesky;

/// A symmetric system `[[A, E], [Eᵀ, C]]` with a band `A` and a dense border.
#[derive(Clone, Debug)]
pub(crate) struct Bordered {
    band: Band,
    /// One column for each unknown of the border, over the unknowns of the band.
    columns: Vec<Vec<f64>>,
    /// The border's own block, rows one after the other.
    corner: Vec<f64>,
}

/// Its factor: the band's, and the one of the Schur complement.
pub(crate) struct BorderedFactor {
    band: Factor,
    columns: Vec<Vec<f64>>,
    /// `A⁻¹ E`, column by column.
    solved: Vec<Vec<f64>>,
    schur: DenseCholesky,
}

impl Bordered {
    /// Zeros for `size` unknowns that know no neighbour farther than `width`, and `border` that know all.
    pub(crate) fn zeros(size: usize, width: usize, border: usize) -> Self {
        Self {
            band: Band::zeros(size, width),
            columns: vec![vec![0.0; size]; border],
            corner: vec![0.0; border * border],
        }
    }

    /// Number of unknowns of the band.
    pub(crate) fn size(&self) -> usize {
        self.band.size()
    }

    /// Adds the square of a row of the Jacobian: unknowns with their derivatives, those of the border counted after the band's.
    pub(crate) fn add_square(&mut self, row: &[(usize, f64)]) {
        let (size, border) = (self.size(), self.columns.len());
        for &(i, a) in row {
            for &(j, b) in row.iter().filter(|(j, _)| *j <= i) {
                match (i.checked_sub(size), j.checked_sub(size)) {
                    (None, None) => self.band.add(i, j, a * b),
                    (Some(column), None) => self.columns[column][j] += a * b,
                    (Some(column), Some(other)) => {
                        self.corner[column * border + other] += a * b;
                        if column != other {
                            self.corner[other * border + column] += a * b;
                        }
                    }
                    // Of two unknowns the one of the border is the later.
                    (None, Some(_)) => {}
                }
            }
        }
    }

    /// The same with the diagonal raised by the share `damping`.
    pub(crate) fn damped(mut self, damping: f64) -> Self {
        let border = self.columns.len();
        self.band = self.band.damped(damping);
        for k in 0..border {
            let entry = &mut self.corner[k * border + k];
            *entry = if *entry > 0.0 { *entry * (1.0 + damping) } else { 1.0 };
        }
        self
    }

    /// Its factor; none where it is not positive definite.
    pub(crate) fn factor(self) -> Option<BorderedFactor> {
        let border = self.columns.len();
        let band = self.band.factor()?;
        let solved: Vec<Vec<f64>> = self.columns.iter().map(|column| band.solve(column.clone())).collect();
        let mut schur = self.corner;
        for i in 0..border {
            for j in 0..border {
                schur[i * border + j] -= dot(&self.columns[i], &solved[j]);
            }
        }
        Some(BorderedFactor { band, columns: self.columns, solved, schur: DenseCholesky::new(border, &schur)? })
    }
}

impl BorderedFactor {
    /// The blocks of the inverse of so many unknowns of the band from each of these on; they lie within the band.
    pub(crate) fn inverse_blocks<const N: usize>(&self, from: &[usize]) -> Vec<[[f64; N]; N]> {
        let within = self.band.inverse_within_band();
        let border = self.columns.len();
        let schur = self.schur.inverse();
        // A⁻¹ + A⁻¹ E S⁻¹ Eᵀ A⁻¹, with the complement S.
        let by_border = |i: usize, j: usize| -> f64 {
            let pairs = (0..border).flat_map(|a| (0..border).map(move |b| (a, b)));
            pairs.map(|(a, b)| self.solved[a][i] * schur[a * border + b] * self.solved[b][j]).sum()
        };
        let entry = |i: usize, j: usize| within.get(i.max(j), i.min(j)) + by_border(i, j);
        let block = |&first: &usize| core::array::from_fn(|i| core::array::from_fn(|j| entry(first + i, first + j)));
        from.iter().map(block).collect()
    }

    /// The solution for a right side: the band's unknowns, then the border's.
    pub(crate) fn solve(&self, right: &[f64]) -> Vec<f64> {
        let size = right.len() - self.columns.len();
        let mut own = self.band.solve(right[..size].to_vec());
        let rest: Vec<f64> =
            self.solved.iter().zip(&right[size..]).map(|(column, b)| b - dot(column, &right[..size])).collect();
        let border = self.schur.solve(&rest);
        for (column, value) in self.solved.iter().zip(&border) {
            own.iter_mut().zip(column).for_each(|(x, c)| *x -= c * value);
        }
        own.extend(border);
        own
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    #[test]
    fn solves_as_the_dense_system_does() {
        let (size, border) = (9, 3);
        let whole = size + border;
        let value = |k: usize| ((k * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
        let (mut bordered, mut dense) = (Bordered::zeros(size, 2, border), vec![0.0; whole * whole]);
        let mut add = |row: &[(usize, f64)]| {
            bordered.add_square(row);
            row.iter().for_each(|&(i, a)| row.iter().for_each(|&(j, b)| dense[i * whole + j] += a * b));
        };
        for k in 0..size - 2 {
            let entry = |j: usize| (k + j, value(5 * k + j));
            add(&[entry(0), entry(1), entry(2), (size + k % 3, value(k + 40)), (size + (k + 1) % 3, value(k + 60))]);
        }
        (0..whole).for_each(|k| add(&[(k, 0.7)]));
        let right: Vec<f64> = (0..whole).map(|k| value(k + 200)).collect();
        let factor = bordered.factor().unwrap();
        let found = factor.solve(&right);
        for i in 0..whole {
            let product: f64 = (0..whole).map(|j| dense[i * whole + j] * found[j]).sum();
            assert!((product - right[i]).abs() < 1e-10, "{i}: {product} {}", right[i]);
        }
        let starts: Vec<usize> = (0..size - 2).collect();
        for (first, block) in factor.inverse_blocks::<3>(&starts).into_iter().enumerate() {
            for (i, row) in block.iter().enumerate() {
                let mut unit = vec![0.0; whole];
                unit[first + i] = 1.0;
                let column = factor.solve(&unit);
                (0..3).for_each(|j| assert!((row[j] - column[first + j]).abs() < 1e-10, "{first} {i} {j}"));
            }
        }
    }
}
