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

/// Minimises the sum of squared `residuals` from `start` on; `steps` are the scales of the parameters for differences.
///
/// # Errors
///
/// Data: residuals that cannot be computed at the start.
pub fn minimise(residuals: impl Fn(&[f64]) -> Option<Vec<f64>>, start: &[f64], steps: &[f64]) -> Result<Minimum> {
    let fault = || Error::data("the model cannot be computed where the fit begins");
    let mut parameters = start.to_vec();
    let mut here = residuals(&parameters).filter(|r| r.iter().all(|v| v.is_finite())).ok_or_else(fault)?;
    let mut cost = square(&here);
    let (mut damping, mut converged) = (1e-3, false);
    let mut jacobian = differences(&residuals, &parameters, steps).ok_or_else(fault)?;
    for _ in 0..MOST_STEPS {
        let Some(step) = damped_step(&jacobian, &here, damping) else { break };
        let trial: Vec<f64> = parameters.iter().zip(&step).map(|(p, s)| p - s).collect();
        let there = residuals(&trial).filter(|r| r.iter().all(|v| v.is_finite()));
        let small = step.iter().zip(steps).all(|(s, scale)| s.abs() <= 1e-8 * scale.abs());
        match there.filter(|r| square(r) <= cost) {
            Some(there) => {
                let gain = cost - square(&there);
                (parameters, here) = (trial, there);
                cost = square(&here);
                damping = (damping * 0.2).max(1e-12);
                if small || gain <= 1e-14 * cost {
                    converged = true;
                    break;
                }
                match differences(&residuals, &parameters, steps) {
                    Some(new) => jacobian = new,
                    None => break,
                }
            }
            None if small || damping > 1e12 => {
                converged = small;
                break;
            }
            None => damping *= 10.0,
        }
    }
    let jacobian = differences(&residuals, &parameters, steps).unwrap_or(jacobian);
    Ok(Minimum { unit_covariance: covariance(&jacobian, 1.0), parameters, residuals: here, converged })
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

/// Central differences; one-sided where the model ends.
fn differences(
    residuals: &impl Fn(&[f64]) -> Option<Vec<f64>>,
    parameters: &[f64],
    steps: &[f64],
) -> Option<Vec<Vec<f64>>> {
    let here = residuals(parameters)?;
    let mut columns = Vec::with_capacity(parameters.len());
    for (index, scale) in steps.iter().enumerate() {
        let step = 1e-5 * scale;
        let moved = |by: f64| {
            let mut moved = parameters.to_vec();
            moved[index] += by;
            residuals(&moved).filter(|r| r.iter().all(|v| v.is_finite()))
        };
        let (up, down) = (moved(step), moved(-step));
        let width = step * f64::from(u8::from(up.is_some()) + u8::from(down.is_some()));
        let (up, down) = (up.unwrap_or_else(|| here.clone()), down.unwrap_or_else(|| here.clone()));
        columns.push(up.iter().zip(&down).map(|(u, d)| (u - d) / width).collect::<Vec<f64>>());
    }
    Some((0..here.len()).map(|row| columns.iter().map(|column| column[row]).collect()).collect())
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
