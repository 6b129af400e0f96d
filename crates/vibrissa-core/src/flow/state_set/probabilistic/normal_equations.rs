//! Normal equations of a Gauss-Newton step over pose and nuisance parameters: a Gaussian in information form, of any size
//! \[dellaert2017factor, ch. 2-3\].

use super::information::Information;
use super::unknowns::{POSE, Unknown};
use crate::linear_algebra::{DenseCholesky, Square};
use crate::plane::Vec2;

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
        if variance <= 0.0 {
            return;
        }
        let column: Vec<f64> = (0..self.size).map(|i| self.at(i, at)).collect();
        let (per, along) = (1.0 / (1.0 / variance + column[at]), self.vector[at]);
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
        let mut whole: Vec<f64> = (0..n * n).map(|k| self.at(k / n, k % n)).collect();
        (0..POSE).for_each(|i| whole[i * n + i] += damping[i]);
        whole
    }

    /// The step to the least cost with `damping` on the pose, and the cost that it promises.
    pub(super) fn step(&self, damping: [f64; POSE]) -> Option<(f64, Vec<f64>)> {
        let step = DenseCholesky::new(self.size, &self.mirrored(damping))?.solve(&self.vector);
        Some((self.cost_at(&step), step))
    }

    /// Laplace's approximation of minus the logarithm of the evidence, up to a constant, with `damping` on the pose: with the cost that a
    /// step promises, and with the cost at the point of linearisation.
    pub(super) fn evidence(&self, damping: [f64; POSE]) -> (f64, f64) {
        let Some(factor) = DenseCholesky::new(self.size, &self.mirrored(damping)) else {
            return (f64::INFINITY, f64::INFINITY);
        };
        let volume = 0.5 * factor.ln_determinant();
        (self.cost_at(&factor.solve(&self.vector)) + volume, self.constant + volume)
    }

    /// The cost a step away.
    pub(super) fn cost_at(&self, step: &[f64]) -> f64 {
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

    /// The same in unknowns `y` where `x = by y`, `by` with its rows one after the other.
    pub(super) fn transformed(&self, by: &[f64]) -> Self {
        let n = self.size;
        let mut out = Self::new(n);
        let mut half = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                half[i * n + j] = (0..n).map(|k| self.at(i, k) * by[k * n + j]).sum();
            }
        }
        for i in 0..n {
            out.vector[i] = (0..n).map(|k| by[k * n + i] * self.vector[k]).sum();
            for j in i..n {
                let at = out.start(i) + j - i;
                out.matrix[at] = (0..n).map(|k| by[k * n + i] * half[k * n + j]).sum();
            }
        }
        out.constant = self.constant;
        out
    }

    /// The same on a map that is turned by this angle (rad).
    pub(super) fn turned(&self, angle: f64) -> Self {
        let n = self.size;
        let Vec2 { x: cos, y: sin } = Vec2::from_angle(angle);
        let mut by: Vec<f64> = (0..n * n).map(|k| f64::from(u8::from(k / n == k % n))).collect();
        (by[0], by[1], by[n], by[n + 1]) = (cos, sin, -sin, cos);
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
