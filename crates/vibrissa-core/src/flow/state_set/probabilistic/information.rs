//! Gaussians in information form: a quadratic cost, and what can be asked of it.
//!
//! `J(x) = c - ηᵀx + xᵀΛx / 2` is the negative logarithm of a Gaussian up to a constant: `Λ` is its information matrix, `η` its
//! information vector, `Λ⁻¹η` its mean; `x` is the distance from the point of linearisation. Rows of a least-squares problem add up
//! in this form, whether they determine `x` or not. To marginalise is to take a Schur complement, to condition is to leave out rows
//! and columns (Thrun, Burgard and Fox 2005, Probabilistic Robotics, section 3.5; Dellaert and Kaess 2017, Factor Graphs for
//! Robot Perception, sections 2 and 3).

use crate::linear_algebra::{Cholesky, Square, dot, inverse, times};
use core::cmp::Ordering;

/// Costs that differ by less than about this (nats) are equal: all places along a straight wall explain a contact alike, and which of them stays
/// is not to be a matter of rounding, which differs between processors.
const SAME_COST: f64 = 1e-6;

/// The order of two costs; those that are equal but for rounding stay in the order in which they are.
pub(super) fn by_cost(a: f64, b: f64) -> Ordering {
    let rounded = |cost: f64| (cost / SAME_COST).round();
    rounded(a).total_cmp(&rounded(b))
}

/// A quadratic cost around the point of linearisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Information<const N: usize> {
    /// The information matrix `Λ`.
    pub(super) matrix: Square<N>,
    /// The information vector `η`: the cost's gradient with its sign changed.
    pub(super) vector: [f64; N],
    /// The cost `c` where it is linearised (nats).
    pub(super) constant: f64,
}

/// What is known of a variable before: its mean, as a distance from the point of linearisation, and its standard deviation; one
/// of no standard deviation stays at the point of linearisation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    pub(super) mean: f64,
    pub(super) std: f64,
}

impl<const N: usize> Default for Information<N> {
    fn default() -> Self {
        Self { matrix: [[0.0; N]; N], vector: [0.0; N], constant: 0.0 }
    }
}

impl<const N: usize> Information<N> {
    /// Adds a row `weight (residual + row x)² / 2`, without what it costs where it is linearised.
    pub(super) fn add(&mut self, row: &[f64; N], residual: f64, weight: f64) {
        for i in (0..N).filter(|&i| row[i] != 0.0) {
            let scaled = weight * row[i];
            self.vector[i] -= scaled * residual;
            (0..N).for_each(|j| self.matrix[i][j] += scaled * row[j]);
        }
        self.mirror_last();
    }

    /// Makes the last row that of the last column, so that both are the same sums to the last bit.
    fn mirror_last(&mut self) {
        (1..N).for_each(|i| self.matrix[N - 1][i - 1] = self.matrix[i - 1][N - 1]);
    }

    /// The same cost around the point `d` away.
    pub(super) fn shifted(&self, d: [f64; N]) -> Self {
        let along = times(&self.matrix, d);
        let constant = self.constant - dot(self.vector, d) + 0.5 * dot(along, d);
        Self { vector: core::array::from_fn(|i| self.vector[i] - along[i]), constant, ..*self }
    }

    /// The cost of some variables with others marginalised, of which this was known before; those in neither list stay where they
    /// are. None where a number is not finite.
    pub(super) fn marginal<const M: usize, const K: usize>(
        &self,
        kept: [usize; M],
        out: [usize; K],
        prior: [Prior; K],
    ) -> Option<Information<M>> {
        let (factor, vector) = self.scaled(out, prior)?;
        let coupling = |i: usize| core::array::from_fn(|k| prior[k].std * self.matrix[out[k]][i]);
        let mut left = self.complement(kept, &factor, coupling, &vector);
        left.constant += factor.root_determinant().ln() + 0.5 * prior.iter().map(|p| p.off().powi(2)).sum::<f64>();
        Some(left)
    }

    /// The information matrix with `damping` added to its diagonal.
    pub(super) fn damped(&self, damping: [f64; N]) -> Square<N> {
        let mut matrix = self.matrix;
        (0..N).for_each(|i| matrix[i][i] += damping[i]);
        matrix
    }

    /// The information of some variables with what was known before, these measured in standard deviations of it: the factor of the
    /// matrix, and the vector.
    fn scaled<const K: usize>(&self, of: [usize; K], prior: [Prior; K]) -> Option<(Cholesky<K>, [f64; K])> {
        let unit = |k: usize, l: usize| f64::from(u8::from(k == l));
        let own = |k: usize, l: usize| unit(k, l) + prior[k].std * prior[l].std * self.matrix[of[k]][of[l]];
        let factor = Cholesky::new(&core::array::from_fn(|k| core::array::from_fn(|l| own(k, l))))?;
        Some((factor, core::array::from_fn(|k| prior[k].std * self.vector[of[k]] + prior[k].off())))
    }

    /// The cost of `kept` at its least over further variables: the Schur complement of their matrix, by its factor, with their
    /// `coupling` with each of the variables here, and their part of the vector.
    fn complement<const M: usize, const K: usize>(
        &self,
        kept: [usize; M],
        factor: &Cholesky<K>,
        coupling: impl Fn(usize) -> [f64; K],
        vector: &[f64; K],
    ) -> Information<M> {
        let white = factor.whitened(vector);
        let rows = kept.map(|i| factor.whitened(&coupling(i)));
        let entry = |i: usize, j: usize| self.matrix[kept[i]][kept[j]] - dot(rows[i], rows[j]);
        Information {
            matrix: core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))),
            vector: core::array::from_fn(|i| self.vector[kept[i]] - dot(rows[i], white)),
            constant: self.constant - 0.5 * dot(white, white),
        }
    }
}

impl Information<3> {
    /// The mean when `damping` is added to the diagonal; none where the matrix is not positive definite.
    pub(super) fn mean(&self, damping: [f64; 3]) -> Option<[f64; 3]> {
        Some(times(&self.covariance(damping)?, self.vector))
    }

    /// The cost at that mean, and the way there; here, where there is none.
    pub(super) fn least(&self, damping: [f64; 3]) -> (f64, [f64; 3]) {
        self.mean(damping).map_or((self.constant, [0.0; 3]), |d| (self.shifted(d).constant, d))
    }

    /// The covariance when `damping` is added to the diagonal; none where the matrix is not positive definite.
    pub(super) fn covariance(&self, damping: [f64; 3]) -> Option<Square<3>> {
        inverse(&self.damped(damping))
    }
}

impl Prior {
    /// The mean, in standard deviations.
    fn off(self) -> f64 {
        if self.std > 0.0 { self.mean / self.std } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    #[test]
    fn the_mean_is_where_the_cost_is_least() {
        let mut told = Information::default();
        // Three planes meet at (1e-3, -2e-3, 0.5) by hand.
        let at = [1e-3, -2e-3, 0.5];
        for by in [[1e3, 0.0, 2.0], [0.0, 2e3, -1.0], [5e2, 5e2, 1.0]] {
            told.add(&by, -dot(by, at), 1.0);
            told.constant += 0.5 * dot(by, at).powi(2);
        }
        let mean = told.mean([0.0; 3]).unwrap();
        (0..3).for_each(|i| assert!((mean[i] - at[i]).abs() < 1e-12, "{mean:?}"));
        assert!(told.shifted(at).constant.abs() < 1e-12);
        assert!(Information::<3>::default().mean([0.0; 3]).is_none());
    }
}
