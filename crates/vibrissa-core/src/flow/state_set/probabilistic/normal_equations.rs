//! Normal equations of a Gauss-Newton step over pose and nuisance parameters: a Gaussian in information form, of any size
//! \[dellaert2017factor, ch. 2-3\].

use super::information::Information;
use super::unknowns::{POSE, Unknown};
use crate::linear_algebra::{DenseCholesky, Square};
use crate::plane::Vec2;

/// What is left of a variance when all else is known is none below this share of it.
const TINY: f64 = 1e-12;

/// `J(x) = c - ηᵀx + xᵀΛx / 2` around the point of linearisation; the first three unknowns are the pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct NormalEquations {
    size: usize,
    /// The upper triangle, its rows one after the other.
    matrix: Vec<f64>,
    vector: Vec<f64>,
    pub(super) constant: f64,
}

/// The nuisance parameters given the pose.
#[derive(Clone, Debug)]
pub(super) struct Response {
    /// Their means where the pose is that of the linearisation, as steps from there.
    pub(super) mean: Vec<f64>,
    /// By how much each mean changes with a unit of each coordinate of the pose.
    pub(super) slope: Vec<[f64; POSE]>,
    /// Their covariance where the pose is given, rows one after the other.
    pub(super) covariance: Vec<f64>,
}

impl NormalEquations {
    pub(super) fn new(size: usize) -> Self {
        Self { size, matrix: vec![0.0; size * (size + 1) / 2], vector: vec![0.0; size], constant: 0.0 }
    }

    /// Adds a row `weight (residual + row x)² / 2`, without what it costs at the point of linearisation.
    pub(super) fn add(&mut self, row: &[f64], residual: f64, weight: f64) {
        for (i, &value) in row.iter().enumerate() {
            if value == 0.0 {
                continue;
            }
            let scaled = weight * value;
            self.vector[i] -= scaled * residual;
            let start = self.start(i);
            self.matrix[start..start + self.size - i].iter_mut().zip(&row[i..]).for_each(|(to, &v)| *to += scaled * v);
        }
    }

    /// Adds what is known of the nuisance parameters before any reading, at these values.
    pub(super) fn add_priors(&mut self, unknowns: &[Unknown], values: &[f64]) {
        for (k, (unknown, &value)) in unknowns.iter().zip(values).enumerate() {
            let (at, weight) = (POSE + k, unknown.std.powi(-2));
            let start = self.start(at);
            self.matrix[start] += weight;
            self.vector[at] -= weight * value;
            self.constant += 0.5 * weight * value * value;
        }
    }

    /// Takes away what [`NormalEquations::add_priors`] has added.
    pub(super) fn remove_priors(&mut self, unknowns: &[Unknown], values: &[f64]) {
        for (k, (unknown, &value)) in unknowns.iter().zip(values).enumerate() {
            let (at, weight) = (POSE + k, unknown.std.powi(-2));
            let start = self.start(at);
            self.matrix[start] -= weight;
            self.vector[at] += weight * value;
            self.constant -= 0.5 * weight * value * value;
        }
    }

    /// Adds an independent error of this variance to one unknown.
    pub(super) fn loosen(&mut self, at: usize, variance: f64) {
        if variance > 0.0 {
            self.loosen_along(&[(at, variance.sqrt())]);
        }
    }

    /// Adds an independent error of the pose with this covariance (x, y, heading), in a frame that is turned by this angle (rad).
    pub(super) fn loosen_pose(&mut self, covariance: &Square<POSE>, angle: f64) {
        let variances: [f64; POSE] = core::array::from_fn(|i| covariance[i][i]);
        if variances.iter().all(|v| *v <= 0.0) {
            return;
        }
        // Directions in which the error is wide, one after the other (Cholesky), what is exact left out.
        let mut left = *covariance;
        for k in [2, 0, 1] {
            if left[k][k] <= TINY * variances[k] {
                continue;
            }
            let root = left[k][k].sqrt();
            let column: [f64; POSE] = core::array::from_fn(|i| left[i][k] / root);
            (0..POSE).for_each(|i| (0..POSE).for_each(|j| left[i][j] -= column[i] * column[j]));
            let place = Vec2::new(column[0], column[1]).rotated(angle);
            self.loosen_along(&[(0, place.x), (1, place.y), (2, column[2])]);
        }
    }

    /// Adds an independent error along a direction, of these components, of the variance one.
    fn loosen_along(&mut self, direction: &[(usize, f64)]) {
        let column: Vec<f64> =
            (0..self.size).map(|i| direction.iter().map(|&(k, v)| v * self.at(i, k)).sum()).collect();
        let along: f64 = direction.iter().map(|&(k, v)| v * self.vector[k]).sum();
        let per = 1.0 / (1.0 + direction.iter().map(|&(k, v)| v * column[k]).sum::<f64>());
        for i in 0..self.size {
            let (start, by) = (self.start(i), per * column[i]);
            self.vector[i] -= by * along;
            self.matrix[start..].iter_mut().zip(&column[i..]).for_each(|(to, v)| *to -= by * v);
        }
        self.constant -= 0.5 * per * along * along;
    }

    /// Adds other equations around the same point.
    pub(super) fn add_all(&mut self, other: &Self) {
        self.matrix.iter_mut().zip(&other.matrix).for_each(|(to, v)| *to += v);
        self.vector.iter_mut().zip(&other.vector).for_each(|(to, v)| *to += v);
        self.constant += other.constant;
    }

    /// Where the row of a diagonal element begins.
    fn start(&self, i: usize) -> usize {
        i * (2 * self.size + 1 - i) / 2
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.matrix[self.start(i.min(j)) + i.abs_diff(j)]
    }

    /// The whole matrix with `damping` on the diagonal of the pose.
    fn mirrored(&self, damping: [f64; POSE]) -> Vec<f64> {
        let n = self.size;
        let mut whole = vec![0.0; n * n];
        let mut rest = self.matrix.as_slice();
        for i in 0..n {
            let (row, below) = rest.split_at(n - i);
            rest = below;
            whole[i * n + i..(i + 1) * n].copy_from_slice(row);
            row.iter().enumerate().skip(1).for_each(|(k, &value)| whole[(i + k) * n + i] = value);
        }
        (0..POSE).for_each(|i| whole[i * n + i] += damping[i]);
        whole
    }

    /// The cost at the solution of the damped equations: `(Λ + D) x = η` leaves of the quadratic form `-(ηᵀx + xᵀDx) / 2`.
    fn cost_at_solution(&self, solution: &[f64], damping: [f64; POSE]) -> f64 {
        let along: f64 = self.vector.iter().zip(solution).map(|(v, x)| v * x).sum();
        let damped: f64 = damping.iter().zip(solution).map(|(d, x)| d * x * x).sum();
        self.constant - 0.5 * (along + damped)
    }

    /// The step to the least cost with `damping` on the pose, and the cost that it promises.
    pub(super) fn step(&self, damping: [f64; POSE]) -> Option<(f64, Vec<f64>)> {
        let step = DenseCholesky::new(self.size, &self.mirrored(damping))?.solve(&self.vector);
        Some((self.cost_at_solution(&step, damping), step))
    }

    /// Laplace's approximation of minus the logarithm of the evidence, up to a constant, with `damping` on the pose: with the cost that a
    /// step promises, and with the cost at the point of linearisation.
    pub(super) fn evidence(&self, damping: [f64; POSE]) -> (f64, f64) {
        let Some(factor) = DenseCholesky::new(self.size, &self.mirrored(damping)) else {
            return (f64::INFINITY, f64::INFINITY);
        };
        let volume = 0.5 * factor.ln_determinant();
        let step = factor.solve(&self.vector);
        (self.cost_at_solution(&step, damping) + volume, self.constant + volume)
    }

    /// The cost a step away.
    fn cost_at(&self, step: &[f64]) -> f64 {
        let mut cost = self.constant;
        for (i, &d) in step.iter().enumerate() {
            let along: f64 = (0..self.size).map(|j| self.at(i, j) * step[j]).sum();
            cost += d * (0.5 * along - self.vector[i]);
        }
        cost
    }

    /// The same around a point that is `step` away.
    pub(super) fn shifted(&self, step: &[f64]) -> Self {
        let mut there = self.clone();
        for i in 0..self.size {
            there.vector[i] -= (0..self.size).map(|j| self.at(i, j) * step[j]).sum::<f64>();
        }
        there.constant = self.cost_at(step);
        there
    }

    /// The same in unknowns `y` where `x = (I + E) y`, and `E` has rows of the pose alone, `by`, one after the other.
    pub(super) fn transformed(&self, by: &[Vec<f64>; POSE]) -> Self {
        let n = self.size;
        // (I + E)ᵀ Λ (I + E) = Λ + G + Gᵀ + Eᵀ Λ E, with G = Λ E.
        let mut product = vec![0.0; n * n];
        for (i, row) in product.chunks_exact_mut(n).enumerate() {
            for (k, by) in by.iter().enumerate() {
                let scale = self.at(i, k);
                row.iter_mut().zip(by).for_each(|(to, e)| *to += scale * e);
            }
        }
        let mut out = self.clone();
        for i in 0..n {
            let from = out.start(i);
            for j in i..n {
                let both: f64 = (0..POSE).map(|k| by[k][i] * product[k * n + j]).sum();
                out.matrix[from + j - i] += product[i * n + j] + product[j * n + i] + both;
            }
            out.vector[i] += (0..POSE).map(|k| by[k][i] * self.vector[k]).sum::<f64>();
        }
        out
    }

    /// The same on a map that is turned by this angle (rad).
    pub(super) fn turned(&self, angle: f64) -> Self {
        let n = self.size;
        let Vec2 { x: cos, y: sin } = Vec2::from_angle(angle);
        let mut by: [Vec<f64>; POSE] = core::array::from_fn(|_| vec![0.0; n]);
        (by[0][0], by[0][1], by[1][0], by[1][1]) = (cos - 1.0, sin, -sin, cos - 1.0);
        self.transformed(&by)
    }

    /// The same knowledge with this share of its weight.
    pub(super) fn with_forgetting(&self, share: f64) -> Self {
        let scaled = |values: &[f64]| values.iter().map(|v| share * v).collect();
        Self { matrix: scaled(&self.matrix), vector: scaled(&self.vector), ..*self }
    }

    fn nuisances(&self) -> Option<DenseCholesky> {
        let (n, k) = (self.size, self.size - POSE);
        let own: Vec<f64> = (0..k * k).map(|at| self.at(POSE + at / k, POSE + at % k)).collect();
        DenseCholesky::new(n - POSE, &own)
    }

    /// The pose with the nuisance parameters marginalised, of which `unknowns` say what was known before.
    pub(super) fn marginal(&self, unknowns: &[Unknown]) -> Information<POSE> {
        let mut left = Information {
            matrix: core::array::from_fn(|i| core::array::from_fn(|j| self.at(i, j))),
            vector: core::array::from_fn(|i| self.vector[i]),
            constant: self.constant,
        };
        let Some(factor) = self.nuisances().filter(|_| self.size > POSE) else { return left };
        let column = |i: usize| -> Vec<f64> { (POSE..self.size).map(|j| self.at(i, j)).collect() };
        let columns: [Vec<f64>; POSE] = core::array::from_fn(column);
        let solved = columns.each_ref().map(|c| factor.solve(c));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (i, solved) in solved.iter().enumerate() {
            left.vector[i] -= dot(solved, &self.vector[POSE..]);
            (0..POSE).for_each(|j| left.matrix[i][j] -= dot(solved, &columns[j]));
        }
        // As symmetric as it is.
        (0..POSE).for_each(|i| (0..i).for_each(|j| left.matrix[i][j] = left.matrix[j][i]));
        left.constant -= 0.5 * dot(&factor.solve(&self.vector[POSE..]), &self.vector[POSE..]);
        // What the nuisance parameters' volume has shrunk to.
        left.constant += 0.5 * factor.ln_determinant() + unknowns.iter().map(|u| u.std.ln()).sum::<f64>();
        left
    }

    /// The nuisance parameters given the pose.
    pub(super) fn response(&self) -> Option<Response> {
        let factor = self.nuisances().filter(|_| self.size > POSE)?;
        let columns: [Vec<f64>; POSE] =
            core::array::from_fn(|i| factor.solve(&(POSE..self.size).map(|j| self.at(i, j)).collect::<Vec<_>>()));
        let slope = (0..self.size - POSE).map(|k| columns.each_ref().map(|c| -c[k])).collect();
        Some(Response { mean: factor.solve(&self.vector[POSE..]), slope, covariance: factor.inverse() })
    }

    /// The same of the nuisance parameters where the pose is given.
    pub(super) fn nuisances_half_ln_determinant(&self) -> f64 {
        self.nuisances().map_or(0.0, |factor| 0.5 * factor.ln_determinant())
    }

    /// Half the logarithm of the determinant, with `damping` on the pose; infinite where it is singular.
    pub(super) fn half_ln_determinant(&self, damping: [f64; POSE]) -> f64 {
        DenseCholesky::new(self.size, &self.mirrored(damping)).map_or(f64::INFINITY, |f| 0.5 * f.ln_determinant())
    }
}

impl Response {
    /// The steps of the nuisance parameters for a step of the pose.
    pub(super) fn given(&self, d: [f64; POSE]) -> Vec<f64> {
        let with = |(mean, slope): (&f64, &[f64; POSE])| mean + slope[0] * d[0] + slope[1] * d[1] + slope[2] * d[2];
        self.mean.iter().zip(&self.slope).map(with).collect()
    }

    /// The standard deviation of the `k`-th where the pose has this covariance.
    pub(super) fn std(&self, k: usize, pose: &Square<POSE>) -> f64 {
        let s = self.slope[k];
        let by_pose: f64 = (0..POSE).map(|i| (0..POSE).map(|j| s[i] * pose[i][j] * s[j]).sum::<f64>()).sum();
        (self.covariance[k * self.mean.len() + k] + by_pose).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    const SIZE: usize = 6;

    /// Numbers between -1 and 1 that repeat nothing.
    fn number(k: usize) -> f64 {
        (1.7 * k as f64 + 0.3 * (k * k) as f64).sin()
    }

    fn equations() -> NormalEquations {
        let mut told = NormalEquations::new(SIZE);
        told.constant = 3.0;
        for k in 0..20 {
            let row: Vec<f64> = (0..SIZE).map(|i| number(SIZE * k + i)).collect();
            told.add(&row, number(500 + k), 1.0 + 0.1 * k as f64);
        }
        told
    }

    #[test]
    fn the_promised_cost_is_that_of_the_step() {
        let (told, damping) = (equations(), [0.7, 2.0, 0.3]);
        let (promised, step) = told.step(damping).unwrap();
        assert!((promised - told.cost_at(&step)).abs() < 1e-12, "{promised} {}", told.cost_at(&step));
        // No other step costs less with the damping's own cost.
        let damped = |x: &[f64]| told.cost_at(x) + 0.5 * damping.iter().zip(x).map(|(d, x)| d * x * x).sum::<f64>();
        for k in 0..SIZE {
            let other: Vec<f64> =
                step.iter().enumerate().map(|(i, x)| x + 1e-3 * f64::from(u8::from(i == k))).collect();
            assert!(damped(&other) > damped(&step));
        }
        let (evidence, here) = told.evidence(damping);
        assert!((here - evidence - (told.constant - promised)).abs() < 1e-12);
        assert!((here - told.constant - told.half_ln_determinant(damping)).abs() < 1e-12);
    }

    #[test]
    fn other_unknowns_cost_the_same() {
        let told = equations();
        let by: [Vec<f64>; POSE] =
            core::array::from_fn(|k| (0..SIZE).map(|i| 0.8 * number(900 + SIZE * k + i)).collect());
        let there = told.transformed(&by);
        for k in 0..5 {
            let y: Vec<f64> = (0..SIZE).map(|i| number(2000 + SIZE * k + i)).collect();
            let mut x = y.clone();
            (0..POSE).for_each(|i| x[i] += by[i].iter().zip(&y).map(|(e, y)| e * y).sum::<f64>());
            assert!((there.cost_at(&y) - told.cost_at(&x)).abs() < 1e-10, "{} {}", there.cost_at(&y), told.cost_at(&x));
        }
    }

    #[test]
    fn an_error_of_the_pose_adds_its_covariance() {
        let inverse = |told: &NormalEquations| DenseCholesky::new(SIZE, &told.mirrored([0.0; POSE])).unwrap().inverse();
        let root = |i: usize, j: usize| number(7 * i + 3 * j + 40);
        let full = core::array::from_fn(|i| core::array::from_fn(|j| (0..3).map(|k| root(i, k) * root(j, k)).sum()));
        // An error of the heading alone, and of the place alone.
        let heading = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.3]];
        let place = [[0.2, 0.1, 0.0], [0.1, 0.4, 0.0], [0.0, 0.0, 0.0]];
        for (covariance, angle) in [(full, 0.0), (full, 2.1), (heading, 1.0), (place, -0.7)] {
            let (told, mut loose) = (equations(), equations());
            loose.loosen_pose(&covariance, angle);
            let (before, after) = (inverse(&told), inverse(&loose));
            let (sin, cos) = f64::sin_cos(angle);
            let turn = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
            let turned = |i: usize, j: usize| -> f64 {
                (0..3).map(|k| (0..3).map(|l| turn[i][k] * covariance[k][l] * turn[j][l]).sum::<f64>()).sum()
            };
            for i in 0..SIZE {
                for j in 0..SIZE {
                    let more = if i < POSE && j < POSE { turned(i, j) } else { 0.0 };
                    let off = after[i * SIZE + j] - before[i * SIZE + j] - more;
                    assert!(off.abs() < 1e-9, "{i} {j}: {off}");
                }
            }
            // The mean stays.
            let (_, a) = told.step([0.0; POSE]).unwrap();
            let (_, b) = loose.step([0.0; POSE]).unwrap();
            a.iter().zip(&b).for_each(|(a, b)| assert!((a - b).abs() < 1e-9, "{a} {b}"));
        }
    }
}
