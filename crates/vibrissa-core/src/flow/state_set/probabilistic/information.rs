//! Gaussians in information form: a quadratic cost, and what can be asked of it.
//!
//! `J(x) = c - ηᵀx + xᵀΛx / 2` is the negative logarithm of a Gaussian up to a constant: `Λ` is its information matrix, `η` its
//! information vector, `Λ⁻¹η` its mean; `x` is the distance from the point of linearisation. Rows of a least-squares problem add up
//! in this form, whether they determine `x` or not. To marginalise is to take a Schur complement, to condition is to leave out rows
//! and columns (Thrun, Burgard and Fox 2005, Probabilistic Robotics, section 3.5; Dellaert and Kaess 2017, Factor Graphs for
//! Robot Perception, sections 2 and 3).

use crate::linear_algebra::{Cholesky, Square, add, congruent, dot, inverse, times};

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

/// `K` variables given `M` others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Conditional<const M: usize, const K: usize> {
    /// Their conditional mean where the others are at the point of linearisation,
    pub(super) mean: [f64; K],
    /// how much less it is for a unit of each of the others,
    pub(super) slope: [[f64; M]; K],
    /// their covariance where the others are fixed,
    pub(super) covariance: Square<K>,
    /// and by how much the cost falls when they go to their mean (nats).
    pub(super) fall: f64,
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

    /// The cost of the variables `y`, where `x = by y`.
    pub(super) fn transformed<const M: usize>(&self, by: &[[f64; M]; N]) -> Information<M> {
        let column = |j: usize| by.map(|row| row[j]);
        let columns: [[f64; N]; M] = core::array::from_fn(column);
        Information {
            matrix: congruent(&columns, &self.matrix),
            vector: times(&columns, self.vector),
            constant: self.constant,
        }
    }

    /// The same knowledge with this share of its weight, where what it costs here stays.
    pub(super) fn with_forgetting(&self, share: f64) -> Self {
        let (matrix, vector) = (self.matrix.map(|row| row.map(|v| share * v)), self.vector.map(|v| share * v));
        Self { matrix, vector, constant: self.constant }
    }

    /// The cost of some variables, conditioned on the others being at the point of linearisation.
    pub(super) fn conditioned<const M: usize>(&self, kept: [usize; M]) -> Information<M> {
        Information {
            matrix: kept.map(|i| kept.map(|j| self.matrix[i][j])),
            vector: kept.map(|i| self.vector[i]),
            constant: self.constant,
        }
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

    /// Some variables given others; those in neither list stay where they are.
    pub(super) fn conditional<const M: usize, const K: usize>(
        &self,
        of: [usize; K],
        given: [usize; M],
        prior: [Prior; K],
    ) -> Option<Conditional<M, K>> {
        let (factor, vector) = self.scaled(of, prior)?;
        let solved = |right: [f64; K]| -> [f64; K] {
            let scaled = factor.solve(&right);
            core::array::from_fn(|k| prior[k].std * scaled[k])
        };
        let slopes = given.map(|i| solved(core::array::from_fn(|k| prior[k].std * self.matrix[of[k]][i])));
        let own = factor.inverse();
        let mean = solved(vector);
        let white = factor.whitened(&vector);
        Some(Conditional {
            mean,
            slope: core::array::from_fn(|k| slopes.map(|slope| slope[k])),
            covariance: core::array::from_fn(|k| core::array::from_fn(|l| prior[k].std * own[k][l] * prior[l].std)),
            fall: 0.5 * dot(white, white),
        })
    }

    /// The same knowledge after the first `K` variables have made a random step, of which this is the covariance once the cost here is
    /// known.
    pub(super) fn predicted<const K: usize>(&self, step: &Square<K>) -> Self {
        let column = |j: usize| core::array::from_fn(|k| self.matrix[k][j]);
        let row = |i: usize| core::array::from_fn(|k| self.matrix[i][k]);
        let vector = core::array::from_fn(|k| self.vector[k]);
        let along = times(step, vector);
        let columns: [[f64; K]; N] = core::array::from_fn(|j| times(step, column(j)));
        let entry = |i: usize, j: usize| self.matrix[i][j] - dot(row(i), columns[j]);
        let mut left = Self {
            matrix: core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j))),
            vector: core::array::from_fn(|i| self.vector[i] - dot(row(i), along)),
            constant: self.constant - 0.5 * dot(vector, along),
        };
        left.mirror_last();
        left
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

impl Information<4> {
    /// The place with the gain, the last variable, marginalised; of this standard deviation before. The Schur complement of one
    /// number, in closed form: it is asked for after every few readings.
    pub(super) fn without_gain(&self, std: f64) -> Information<3> {
        let mut out = self.conditioned([0, 1, 2]);
        if std > 0.0 {
            let (own, vector) = (self.matrix[3][3], self.vector[3]);
            let per = 1.0 / (own + 1.0 / (std * std));
            out.constant += 0.5 * (1.0 + own * std * std).ln() - 0.5 * vector * vector * per;
            for i in 0..3 {
                out.vector[i] -= self.matrix[i][3] * vector * per;
                (0..3).for_each(|j| out.matrix[i][j] -= self.matrix[i][3] * self.matrix[j][3] * per);
            }
        }
        out
    }
}

impl Prior {
    /// The mean, in standard deviations.
    fn off(self) -> f64 {
        if self.std > 0.0 { self.mean / self.std } else { 0.0 }
    }
}

impl<const M: usize, const K: usize> Conditional<M, K> {
    /// The conditional mean where the others are `d` away.
    pub(super) fn given(&self, d: [f64; M]) -> [f64; K] {
        let less = times(&self.slope, d);
        core::array::from_fn(|k| self.mean[k] - less[k])
    }

    /// The covariance where the others are not fixed, but have this one.
    pub(super) fn wherever(&self, others: &Square<M>) -> Square<K> {
        let mut own = congruent(&self.slope, others);
        add(&mut own, &self.covariance);
        own
    }

    /// The covariance of the others and these together, where that of the others is this one; `L` is `M + K`.
    pub(super) fn joint<const L: usize>(&self, others: &Square<M>) -> Square<L> {
        let own = self.wherever(others);
        // Columns are these variables.
        let mixed = others.map(|row| times(&self.slope, row).map(|v| -v));
        core::array::from_fn(|i| {
            core::array::from_fn(|j| match (i.checked_sub(M), j.checked_sub(M)) {
                (None, None) => others[i][j],
                (Some(k), None) => mixed[j][k],
                (None, Some(k)) => mixed[i][k],
                (Some(k), Some(l)) => own[k][l],
            })
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    #[test]
    fn a_random_step_adds_to_the_covariance() {
        // Knowledge of x, y and heading with a shared error; by hand: covariance of the marginal plus that of the step,
        // least cost where it was.
        let mut before = Information::<4>::default();
        for (by, shared) in
            [([1e3, 2e2, 5.0], 0.3), ([0.0, 8e2, -9.0], -0.2), ([3e2, -5e2, 20.0], 0.5), ([5e2, 1e2, 1.0], 0.1)]
        {
            before.add(&[by[0], by[1], by[2], shared], 0.4 - shared, 1.0);
        }
        let q = [[4e-6, 1e-6, 0.0], [1e-6, 9e-6, 2e-5], [0.0, 2e-5, 4e-4]];
        let mut sum = inverse(&q).unwrap();
        add(&mut sum, &before.conditioned([0, 1, 2]).matrix);
        let after = before.predicted(&inverse(&sum).unwrap());
        let [before, after] =
            [before, after].map(|told| told.marginal([0, 1, 2], [3], [Prior { mean: 0.0, std: 0.5 }]).unwrap());
        let [mut wanted, found] = [before, after].map(|told| told.covariance([0.0; 3]).unwrap());
        add(&mut wanted, &q);
        (0..3).for_each(|i| {
            (0..3).for_each(|j| {
                let scale = (wanted[i][i] * wanted[j][j]).sqrt();
                assert!((found[i][j] - wanted[i][j]).abs() < 1e-6 * scale, "{found:?} {wanted:?}");
            })
        });
        let [a, b] = [before, after].map(|told| told.mean([0.0; 3]).unwrap());
        (0..3).for_each(|i| assert!((a[i] - b[i]).abs() < 1e-5 * wanted[i][i].sqrt(), "{a:?} {b:?}"));
    }

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

    #[test]
    fn a_joint_gaussian_is_its_marginal_times_its_conditional() {
        let mut told = Information::<3>::default();
        for (row, residual) in [([2.0, 1.0, -1.0], 0.3), ([0.5, -1.5, 2.0], -0.7), ([1.0, 0.2, 0.8], 0.1)] {
            told.add(&row, residual, 1.3);
        }
        let prior = [Prior { mean: 0.2, std: 0.4 }];
        let left = told.marginal([0, 1], [2], prior).unwrap();
        let last = told.conditional([2], [0, 1], prior).unwrap();
        for x in [[0.0; 3], [0.1, -0.4, 0.3], [-0.7, 0.2, 0.6]] {
            let whole = told.shifted(x).constant + 0.5 * ((x[2] - 0.2) / 0.4_f64).powi(2) + 0.4_f64.ln();
            let variance = last.covariance[0][0];
            let off = x[2] - last.given([x[0], x[1]])[0];
            let product = left.shifted([x[0], x[1]]).constant + 0.5 * off * off / variance + 0.5 * variance.ln();
            assert!((whole - product).abs() < 1e-12, "{whole} {product}");
        }
        // The closed form for one variable is the same.
        let mut four = Information::<4>::default();
        [[1.0, 0.2, -0.3, 0.4], [0.3, -0.8, 0.1, 0.9], [0.2, 0.4, 1.1, -0.5]]
            .iter()
            .for_each(|row| four.add(row, 0.6, 0.9));
        let general = four.marginal([0, 1, 2], [3], [Prior { mean: 0.0, std: 0.4 }]).unwrap();
        let closed = four.without_gain(0.4);
        assert!((general.constant - closed.constant).abs() < 1e-12);
        (0..3).for_each(|i| {
            assert!((general.vector[i] - closed.vector[i]).abs() < 1e-12);
            (0..3).for_each(|j| assert!((general.matrix[i][j] - closed.matrix[i][j]).abs() < 1e-12));
        });
        // Without any prior spread it stays where it is.
        let still = told.marginal([0, 1], [2], [Prior { mean: 0.0, std: 0.0 }]).unwrap();
        assert_eq!(still, told.conditioned([0, 1]));
    }
}
