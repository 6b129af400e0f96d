//! Dense matrices: of a small, fixed size, factors, inverses, determinants; of any size, the factor of a symmetric one.
//!
//! Plain arrays, rows first, so that the library underneath stays out of all signatures. Only kernels whose order of summation does not depend on the processor are used.

use alloc::vec::Vec;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;
use numeris::dynmatrix::DynCholesky;
use numeris::linalg::CholeskyDecomposition;
use numeris::{DynMatrix, DynVector, Matrix, Vector};

/// A square matrix, rows first.
pub type Square<const N: usize> = [[f64; N]; N];

/// Correlation matrices with a smaller determinant count as singular.
const SINGULAR: f64 = 1e-15;

/// The lower triangular factor `L` of a symmetric positive definite matrix `L Lᵀ`.
#[derive(Debug)]
pub struct Cholesky<const N: usize>(CholeskyDecomposition<f64, N>);

impl<const N: usize> Cholesky<N> {
    /// None for a matrix that is not positive definite or not finite.
    #[must_use]
    pub fn new(matrix: &Square<N>) -> Option<Self> {
        let factor = Matrix::new(*matrix).cholesky().ok()?;
        // The library takes what is no number for positive.
        (0..N).all(|i| factor.l()[(i, i)].is_finite()).then_some(Self(factor))
    }

    /// The same, and none for a matrix that is singular to working precision, whatever the units of its rows.
    #[must_use]
    pub fn regular(matrix: &Square<N>) -> Option<Self> {
        let factor = Self::new(matrix)?;
        let share = |i: usize| factor.diagonal(i) * factor.diagonal(i) / matrix[i][i];
        ((0..N).map(share).product::<f64>() > SINGULAR).then_some(factor)
    }

    fn diagonal(&self, i: usize) -> f64 {
        self.0.l()[(i, i)]
    }

    /// The factor `L`.
    #[must_use]
    pub fn lower(&self) -> Square<N> {
        core::array::from_fn(|i| core::array::from_fn(|j| if j <= i { self.0.l()[(i, j)] } else { 0.0 }))
    }

    /// The determinant of `L`: the root of that of the matrix.
    #[must_use]
    pub fn root_determinant(&self) -> f64 {
        (0..N).map(|i| self.diagonal(i)).product()
    }

    /// `L⁻¹ right`: of unit covariance where `right` has the matrix for its covariance. The library has no half of a solution.
    #[must_use]
    pub fn whitened(&self, right: &[f64; N]) -> [f64; N] {
        let mut out = *right;
        for i in 0..N {
            (0..i).for_each(|j| out[i] -= self.0.l()[(i, j)] * out[j]);
            out[i] /= self.diagonal(i);
        }
        out
    }

    /// The solution `x` of `L Lᵀ x = right`.
    #[must_use]
    pub fn solve(&self, right: &[f64; N]) -> [f64; N] {
        let solution = self.0.solve(&Vector::from_array(*right));
        core::array::from_fn(|i| solution[i])
    }

    /// The inverse of the matrix, as symmetric as it is.
    #[must_use]
    pub fn inverse(&self) -> Square<N> {
        let unit = |i: usize| core::array::from_fn(|j| f64::from(u8::from(i == j)));
        let columns: Square<N> = core::array::from_fn(|i| self.solve(&unit(i)));
        core::array::from_fn(|i| core::array::from_fn(|j| columns[i.max(j)][i.min(j)]))
    }
}

/// The lower triangular factor of a symmetric positive definite matrix of any size.
#[derive(Debug)]
pub struct DenseCholesky(DynCholesky<f64>);

impl DenseCholesky {
    /// Of a matrix of `size` rows one after the other; none where it is not positive definite or not finite.
    #[must_use]
    pub fn new(size: usize, matrix: &[f64]) -> Option<Self> {
        let factor = DynCholesky::new(&DynMatrix::from_slice(size, size, matrix)).ok()?;
        // The library takes what is no number for positive.
        (0..size).all(|i| factor.l()[(i, i)].is_finite()).then_some(Self(factor))
    }

    /// The solution `x` of `L Lᵀ x = right`.
    #[must_use]
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        self.0.solve(&DynVector::from_slice(right)).as_slice().to_vec()
    }

    /// The product `L x`: of independent standard normal numbers it makes some with the factored covariance.
    #[must_use]
    pub fn lower_times(&self, x: &[f64]) -> Vec<f64> {
        let l = self.0.l();
        (0..x.len()).map(|i| (0..=i).map(|j| l[(i, j)] * x[j]).sum()).collect()
    }

    /// The inverse, its rows one after the other.
    #[must_use]
    pub fn inverse(&self) -> Vec<f64> {
        let inverse = self.0.inverse();
        let size = inverse.nrows();
        (0..size * size).map(|k| inverse[(k / size, k % size)]).collect()
    }

    /// The logarithm of the matrix' determinant.
    #[must_use]
    pub fn ln_determinant(&self) -> f64 {
        self.0.ln_det()
    }
}

/// The inverse of a symmetric matrix; none where it is not positive definite, or singular to working precision.
///
/// By cofactors of the correlation matrix, not by the library, whose closed form takes small numbers for a singular matrix: along a
/// straight wall places cost the same to the last bit, so that this order of operations decides which of them is told as the best.
#[must_use]
pub fn inverse(matrix: &Square<3>) -> Option<Square<3>> {
    let scale = [0, 1, 2].map(|i: usize| matrix[i][i].sqrt().recip());
    scale.iter().all(|s| s.is_finite() && *s > 0.0).then_some(())?;
    let n: Square<3> = core::array::from_fn(|i| core::array::from_fn(|j| matrix[i][j] * (scale[i] * scale[j])));
    let det = determinant(&n);
    (det > SINGULAR).then_some(())?;
    let cofactor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        n[a][c] * n[b][d] - n[a][d] * n[b][c]
    };
    Some(core::array::from_fn(|i| core::array::from_fn(|j| cofactor(j, i) / det * scale[i] * scale[j])))
}

/// The solution of `matrix x = right` by elimination with pivots; none for a matrix that is singular to working precision.
#[must_use]
pub fn solve<const N: usize>(matrix: &Square<N>, right: &[f64; N]) -> Option<[f64; N]> {
    // The library's measure of a pivot is absolute.
    let largest = matrix.iter().flatten().fold(0.0, |most: f64, v| most.max(v.abs()));
    let scaled = Matrix::new(matrix.map(|row| row.map(|v| v / largest)));
    let solution = scaled.lu().ok()?.solve(&Vector::from_array(right.map(|v| v / largest)));
    let solution = core::array::from_fn(|i| solution[i]);
    solution.iter().all(|v| v.is_finite()).then_some(solution)
}

/// The determinant, by the closed form where the matrix is no larger than 4 by 4.
#[must_use]
pub fn determinant<const N: usize>(matrix: &Square<N>) -> f64 {
    Matrix::new(*matrix).det()
}

/// The scalar product.
#[must_use]
pub fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    (1..N).fold(a[0] * b[0], |sum, i| sum + a[i] * b[i])
}

/// A matrix times a vector.
#[must_use]
pub fn times<const M: usize, const N: usize>(matrix: &[[f64; N]; M], v: [f64; N]) -> [f64; M] {
    matrix.map(|row| dot(row, v))
}

/// `t covariance tᵀ`: the covariance of `t v` where `v` has this one.
#[must_use]
pub fn congruent<const M: usize, const N: usize>(t: &[[f64; N]; M], covariance: &Square<N>) -> Square<M> {
    let rows = t.map(|row| times(covariance, row));
    t.map(|left| rows.map(|right| dot(left, right)))
}

/// Adds a matrix to another.
pub fn add<const N: usize>(to: &mut Square<N>, more: &Square<N>) {
    to.iter_mut().flatten().zip(more.iter().flatten()).for_each(|(to, more)| *to += more);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    const M: Square<4> = [[4.0, 1.0, -0.5, 0.3], [1.0, 2.0, 0.3, 0.0], [-0.5, 0.3, 1.0, -0.2], [0.3, 0.0, -0.2, 0.7]];

    fn product(a: &Square<4>, b: &Square<4>) -> Square<4> {
        core::array::from_fn(|i| core::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
    }

    fn near(a: &Square<4>, b: &Square<4>) -> bool {
        a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    const UNIT: Square<4> = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

    #[test]
    fn a_root_times_itself_is_the_matrix() {
        let factor = Cholesky::new(&M).unwrap();
        let l = factor.lower();
        let transposed = core::array::from_fn(|i| core::array::from_fn(|j| l[j][i]));
        assert!(near(&product(&l, &transposed), &M));
        assert!((0..4).all(|i| (i + 1..4).all(|j| l[i][j] == 0.0)));
        assert!(near(&product(&factor.inverse(), &M), &UNIT));
        assert!((factor.root_determinant().powi(2) / determinant(&M) - 1.0).abs() < 1e-12);
        assert!(Cholesky::new(&[[1.0, 2.0], [2.0, 1.0]]).is_none());
        assert!(Cholesky::new(&[[f64::NAN, 0.0], [0.0, 1.0]]).is_none());
        assert!(Cholesky::new(&[[1.0, f64::NAN], [f64::NAN, 1.0]]).is_none());
    }

    #[test]
    fn units_make_no_matrix_singular() {
        // Micrometres and radians: by far more than the precision apart, but uncorrelated to a half.
        let units = [1e-9, 1e3, 1.0, 1e-5];
        let scaled: Square<4> = core::array::from_fn(|i| core::array::from_fn(|j| units[i] * units[j] * M[i][j]));
        let found = Cholesky::regular(&scaled).unwrap().inverse();
        let back = core::array::from_fn(|i| core::array::from_fn(|j| found[i][j] * units[i] * units[j]));
        assert!(near(&product(&back, &M), &UNIT));
        assert!(Cholesky::regular(&[[1.0, 1.0], [1.0, 1.0]]).is_none());
        assert!(Cholesky::regular(&[[1e-20, 1e-20], [1e-20, 1.0]]).is_some());
        // The closed form and the factor are the same.
        let three: Square<3> = core::array::from_fn(|i| core::array::from_fn(|j| scaled[i][j]));
        let (closed, found) = (inverse(&three).unwrap(), Cholesky::regular(&three).unwrap().inverse());
        (0..3).for_each(|i| {
            (0..3).for_each(|j| assert!((closed[i][j] - found[i][j]).abs() * units[i] * units[j] < 1e-12));
        });
        assert!(inverse(&[[1.0; 3]; 3]).is_none() && inverse(&[[f64::NAN; 3]; 3]).is_none());
    }

    #[test]
    fn elimination_solves_what_a_product_gives() {
        // A zero on the diagonal asks for a pivot; small numbers are no sign of a singular matrix.
        let m = [[0.0, 2.0, 1.0], [1.0, -1.0, 0.5], [3.0, 0.2, 0.0]];
        let x = [0.3, -1.2, 2.0];
        for scale in [1.0, 1e-30, 1e20] {
            let m = m.map(|row| row.map(|v| scale * v));
            let found = solve(&m, &times(&m, x)).unwrap();
            assert!(found.iter().zip(x).all(|(found, x)| (found - x).abs() < 1e-14), "{found:?}");
        }
        assert!(solve(&[[1.0, 2.0], [2.0, 4.0]], &[1.0, 1.0]).is_none());
        assert!(solve(&[[0.0; 2]; 2], &[1.0, 1.0]).is_none());
    }
}
