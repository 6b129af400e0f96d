//! Few unknowns: residuals as a function, derivatives by differences.

use super::band::Band;
use super::descent::{Normal, Rules, descend};
use crate::{Error, Result};

/// A minimum of a sum of squares.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Minimum {
    /// The parameters.
    pub(crate) parameters: Vec<f64>,
    /// The residuals there.
    pub(crate) residuals: Vec<f64>,
    /// Covariance of the parameters for residuals of unit variance; empty when the residuals do not fix them.
    pub(crate) unit_covariance: Vec<Vec<f64>>,
}

/// A parameter's range and the size of a change that matters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// Least value.
    pub(crate) lo: f64,
    /// Largest value.
    pub(crate) hi: f64,
    /// Size of a change that matters, positive.
    pub(crate) size: f64,
}

impl Scale {
    /// Without a range.
    pub(crate) fn free(size: f64) -> Self {
        Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY, size }
    }
}

/// Most steps, and a gain that is rounding.
const RULES: Rules = Rules { rounds: 100, gain: 1e-13, damping: 1e-3 };
/// Step of the differences, in sizes.
const DIFFERENCE: f64 = 1e-5;

/// Minimises the sum of squared `residuals` from `start` on, each parameter within its range.
///
/// A parameter at the end of its range that would leave it is held there while the others move; one that no residual
/// depends on stays where it is.
///
/// # Errors
///
/// Data: residuals that cannot be computed at the start or next to it.
pub(crate) fn minimise(
    residuals: impl Fn(&[f64]) -> Option<Vec<f64>>,
    start: &[f64],
    scales: &[Scale],
) -> Result<Minimum> {
    let fault = || Error::data("the model cannot be computed where the fit begins");
    let finite = |parameters: &[f64]| residuals(parameters).filter(|r| r.iter().all(|v| v.is_finite()));
    let start: Vec<f64> = start.iter().zip(scales).map(|(p, s)| p.clamp(s.lo, s.hi)).collect();
    let evaluate = |parameters: &[f64]| finite(parameters).map(|r| (square(&r), r)).map(|(cost, r)| (r, cost));
    let normal = |parameters: &[f64], residuals: &Vec<f64>| {
        let jacobian = differences(&finite, parameters, scales)?;
        Some(Normal::of_rows(parameters.len(), &jacobian, residuals))
    };
    let bounded = |linear: &Normal, damping: f64, parameters: &[f64]| within(linear, damping, parameters, scales);
    let end = descend(start.clone(), RULES, evaluate, normal, bounded).ok_or_else(fault)?;
    if !end.converged && end.unknowns == start {
        return Err(fault());
    }
    let jacobian = differences(&finite, &end.unknowns, scales).unwrap_or_default();
    Ok(Minimum { unit_covariance: covariance(&jacobian, 1.0), parameters: end.unknowns, residuals: end.state })
}

/// The parameters after a damped step; those that would leave their range from its end are held.
fn within(linear: &Normal, damping: f64, parameters: &[f64], scales: &[Scale]) -> Option<Vec<f64>> {
    let mut free: Vec<usize> = (0..parameters.len()).collect();
    loop {
        let mut trial = parameters.to_vec();
        if free.is_empty() {
            return Some(trial);
        }
        let matrix = linear.matrix.part(&free).damped(damping);
        let step = matrix.factor()?.solve(free.iter().map(|&i| linear.gradient[i]).collect());
        let leaves = |(k, &i): (usize, &usize)| {
            let Scale { lo, hi, .. } = scales[i];
            (parameters[i] <= lo && step[k] > 0.0) || (parameters[i] >= hi && step[k] < 0.0)
        };
        if let Some(held) = free.iter().enumerate().position(leaves) {
            free.remove(held);
            continue;
        }
        for (&i, step) in free.iter().zip(&step) {
            trial[i] = (parameters[i] - step).clamp(scales[i].lo, scales[i].hi);
        }
        return Some(trial);
    }
}

/// `variance (J^T J)^-1`; empty when the rows of `jacobian` do not fix the parameters.
pub(crate) fn covariance(jacobian: &[Vec<f64>], variance: f64) -> Vec<Vec<f64>> {
    let size = jacobian.first().map_or(0, Vec::len);
    let Some(factor) = Band::of_rows(size, jacobian.iter().map(Vec::as_slice)).factor() else { return Vec::new() };
    let mut inverse = factor.inverse();
    inverse.iter_mut().flatten().for_each(|value| *value *= variance);
    inverse
}

/// Coefficients of the least-squares combination of columns to `targets`, given row by row; none when the rows do not fix
/// them.
pub(crate) fn linear(rows: &[Vec<f64>], targets: &[f64]) -> Option<Vec<f64>> {
    let normal = Normal::of_rows(rows.first()?.len(), rows, targets);
    Some(normal.matrix.factor()?.solve(normal.gradient))
}

fn square(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

/// Central differences, row by row; one-sided at the end of a range.
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
        let (up, down) = (moved(DIFFERENCE * scale.size)?, moved(-DIFFERENCE * scale.size)?);
        let width = up.0 - down.0;
        columns.push(up.1.iter().zip(&down.1).map(|(u, d)| (u - d) / width).collect::<Vec<f64>>());
    }
    let rows = columns.first().map_or(0, Vec::len);
    Some((0..rows).map(|row| columns.iter().map(|column| column[row]).collect()).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::{Scale, covariance, linear, minimise};

    /// Rosenbrock's valley: its minimum is (1, 1), far along a bent floor.
    #[test]
    fn the_end_of_a_bent_valley_is_found() {
        let residuals = |x: &[f64]| Some(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
        let found = minimise(residuals, &[-1.2, 1.0], &[Scale::free(1.0); 2]).unwrap();
        assert!(found.parameters.iter().all(|p| (p - 1.0).abs() < 1e-7), "{found:?}");
    }

    /// At the end of its range a parameter is held, and the other is best for it: y = 2 x with x <= 1.
    #[test]
    fn a_parameter_at_the_end_of_its_range_is_held() {
        let residuals = |x: &[f64]| Some(vec![x[0] - 3.0, x[1] - 2.0 * x[0]]);
        let scales = [Scale { lo: -1.0, hi: 1.0, size: 1.0 }, Scale::free(1.0)];
        let found = minimise(residuals, &[0.0, 0.0], &scales).unwrap();
        assert!((found.parameters[0] - 1.0).abs() < 1e-12 && (found.parameters[1] - 2.0).abs() < 1e-7, "{found:?}");
    }

    /// The turn of a circle changes nothing: it stays, and no covariance is told.
    #[test]
    fn what_nothing_depends_on_stays_and_is_not_told() {
        let residuals = |x: &[f64]| Some(vec![x[0] - 3.0, 2.0 * x[0] - 6.0]);
        let found = minimise(residuals, &[0.0, 0.7], &[Scale::free(1.0); 2]).unwrap();
        assert!((found.parameters[0] - 3.0).abs() < 1e-8, "{found:?}");
        assert!((found.parameters[1] - 0.7).abs() < 1e-15 && found.unit_covariance.is_empty());
    }

    /// A straight line through three points by hand: y = 1/6 + 3/2 x; (J^T J)^-1 = [[5/6, -1/2], [-1/2, 1/2]].
    #[test]
    fn a_line_by_hand_whatever_the_units() {
        for unit in [1.0, 1e-7, 1e9] {
            let rows: Vec<Vec<f64>> = (0..3).map(|i| vec![1.0, unit * f64::from(i)]).collect();
            let line = linear(&rows, &[0.0, 2.0, 3.0]).unwrap();
            assert!((line[0] - 1.0 / 6.0).abs() < 1e-12 && (unit * line[1] - 1.5).abs() < 1e-12, "{line:?}");
            let c = covariance(&rows, 2.0);
            assert!((c[0][0] - 5.0 / 3.0).abs() < 1e-12 && (unit * c[0][1] + 1.0).abs() < 1e-12, "{c:?}");
        }
        let twins: Vec<Vec<f64>> = (0..3).map(|i| vec![f64::from(i), 1e6 * f64::from(i)]).collect();
        assert!(linear(&twins, &[0.0, 1.0, 2.0]).is_none() && covariance(&twins, 1.0).is_empty());
    }

    #[test]
    fn a_start_without_a_model_is_refused() {
        let error = minimise(|_| None, &[0.0], &[Scale::free(1.0)]).unwrap_err();
        assert!(error.is_data());
    }
}
