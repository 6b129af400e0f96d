//! Small dense least squares: Levenberg and Marquardt's method, and covariances.

use crate::{Error, Result};

/// A minimum of a sum of squares.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The parameters.
    pub parameters: Vec<f64>,
    /// The residuals there.
    pub residuals: Vec<f64>,
    /// Covariance of the parameters for residuals of unit variance.
    pub unit_covariance: Vec<Vec<f64>>,
    /// Whether the last step was small enough; otherwise this is the best point found.
    pub converged: bool,
}

/// Most steps, successful or not.
const MOST_STEPS: usize = 200;

/// A parameter's range and the size of a change that matters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Least value.
    pub lo: f64,
    /// Largest value.
    pub hi: f64,
    /// Size of a change that matters, positive.
    pub size: f64,
}

/// Minimises the sum of squared `residuals` from `start` on, each parameter within its range.
///
/// A parameter at the end of its range that would leave it is held there while the others move.
///
/// # Errors
///
/// Data: residuals that cannot be computed at the start.
pub fn minimise(residuals: impl Fn(&[f64]) -> Option<Vec<f64>>, start: &[f64], scales: &[Scale]) -> Result<Minimum> {
    let fault = || Error::data("the model cannot be computed where the fit begins");
    let finite = |parameters: &[f64]| residuals(parameters).filter(|r| r.iter().all(|v| v.is_finite()));
    let mut parameters: Vec<f64> = start.iter().zip(scales).map(|(p, s)| p.clamp(s.lo, s.hi)).collect();
    let mut here = finite(&parameters).ok_or_else(fault)?;
    let mut jacobian = differences(&finite, &parameters, scales).ok_or_else(fault)?;
    let (mut damping, mut converged) = (1e-3, false);
    for _ in 0..MOST_STEPS {
        let Some(trial) = trial(&jacobian, &here, &parameters, scales, damping) else { break };
        let small = trial.iter().zip(&parameters).zip(scales).all(|((t, p), s)| (t - p).abs() <= 1e-8 * s.size);
        let there = finite(&trial).filter(|r| square(r) <= square(&here));
        if let Some(there) = there {
            let gain = square(&here) - square(&there);
            (parameters, here) = (trial, there);
            damping = (damping * 0.2).max(1e-12);
            converged = small || gain <= 1e-14 * square(&here);
            let Some(new) = differences(&finite, &parameters, scales) else { break };
            jacobian = new;
        } else {
            converged = small;
            damping *= 10.0;
        }
        if converged || damping > 1e15 {
            break;
        }
    }
    Ok(Minimum { unit_covariance: covariance(&jacobian, 1.0), parameters, residuals: here, converged })
}

/// The parameters after a damped step; those that would leave their range from its end are held.
fn trial(
    jacobian: &[Vec<f64>],
    residuals: &[f64],
    parameters: &[f64],
    scales: &[Scale],
    damping: f64,
) -> Option<Vec<f64>> {
    let mut free: Vec<usize> = (0..parameters.len()).collect();
    loop {
        let part: Vec<Vec<f64>> = jacobian.iter().map(|row| free.iter().map(|&i| row[i]).collect()).collect();
        let step = if free.is_empty() { Vec::new() } else { damped_step(&part, residuals, damping)? };
        let leaves = |(k, &i): (usize, &usize)| {
            let Scale { lo, hi, .. } = scales[i];
            (parameters[i] <= lo && step[k] > 0.0) || (parameters[i] >= hi && step[k] < 0.0)
        };
        if let Some(held) = free.iter().enumerate().position(leaves) {
            free.remove(held);
            continue;
        }
        let mut trial = parameters.to_vec();
        for (&i, step) in free.iter().zip(&step) {
            trial[i] = (parameters[i] - step).clamp(scales[i].lo, scales[i].hi);
        }
        return Some(trial);
    }
}

/// `variance (J^T J)^-1`, by scaling first so that units do not matter; empty when the data do not fix the parameters.
#[must_use]
pub fn covariance(jacobian: &[Vec<f64>], variance: f64) -> Vec<Vec<f64>> {
    let n = jacobian.first().map_or(0, Vec::len);
    let normal = normal(jacobian, n);
    let scale: Vec<f64> = (0..n).map(|i| normal[i][i].sqrt()).collect();
    let scaled: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| normal[i][j] / (scale[i] * scale[j])).collect()).collect();
    let columns: Option<Vec<Vec<f64>>> =
        (0..n).map(|j| solve(scaled.clone(), (0..n).map(|i| if i == j { 1.0 } else { 0.0 }).collect())).collect();
    let Some(inverse) = columns else { return Vec::new() };
    (0..n).map(|i| (0..n).map(|j| variance * inverse[j][i] / (scale[i] * scale[j])).collect()).collect()
}

/// Coefficients of the least-squares combination of `columns` (each row its values) to `targets`.
#[must_use]
pub fn linear(rows: &[Vec<f64>], targets: &[f64]) -> Option<Vec<f64>> {
    let n = rows.first()?.len();
    let right = (0..n).map(|i| rows.iter().zip(targets).map(|(row, y)| row[i] * y).sum()).collect();
    solve(normal(rows, n), right)
}

fn square(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

fn normal(jacobian: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    (0..n).map(|i| (0..n).map(|j| jacobian.iter().map(|row| row[i] * row[j]).sum()).collect()).collect()
}

/// Central differences; one-sided at the end of a range.
fn differences(
    residuals: &impl Fn(&[f64]) -> Option<Vec<f64>>,
    parameters: &[f64],
    scales: &[Scale],
) -> Option<Vec<Vec<f64>>> {
    let mut columns = Vec::with_capacity(parameters.len());
    for (index, scale) in scales.iter().enumerate() {
        let moved = |by: f64| {
            let mut moved = parameters.to_vec();
            moved[index] = (moved[index] + by).clamp(scale.lo, scale.hi);
            residuals(&moved).map(|residuals| (moved[index], residuals))
        };
        let (up, down) = (moved(1e-5 * scale.size)?, moved(-1e-5 * scale.size)?);
        let width = up.0 - down.0;
        columns.push(up.1.iter().zip(&down.1).map(|(u, d)| (u - d) / width).collect::<Vec<f64>>());
    }
    let rows = columns.first().map_or(0, Vec::len);
    Some((0..rows).map(|row| columns.iter().map(|column| column[row]).collect()).collect())
}

fn damped_step(jacobian: &[Vec<f64>], residuals: &[f64], damping: f64) -> Option<Vec<f64>> {
    let n = jacobian.first()?.len();
    let mut matrix = normal(jacobian, n);
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] *= 1.0 + damping;
    }
    let gradient = (0..n).map(|i| jacobian.iter().zip(residuals).map(|(row, r)| row[i] * r).sum()).collect();
    solve(matrix, gradient)
}

/// Gaussian elimination with pivoting on a symmetrically scaled matrix; none when it is singular.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    let scale: Vec<f64> = (0..n).map(|i| a[i][i].abs().sqrt()).collect();
    if scale.iter().any(|s| s.is_nan() || *s <= 0.0) {
        return None;
    }
    for i in 0..n {
        b[i] /= scale[i];
        for j in 0..n {
            a[i][j] /= scale[i] * scale[j];
        }
    }
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        a.swap(k, pivot);
        b.swap(k, pivot);
        if a[k][k].is_nan() || a[k][k].abs() < 1e-13 {
            return None;
        }
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            let (above, below) = a.split_at_mut(i);
            below[0].iter_mut().zip(&above[k]).skip(k).for_each(|(x, y)| *x -= factor * y);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    Some(b.iter().zip(&scale).map(|(x, s)| x / s).collect())
}
