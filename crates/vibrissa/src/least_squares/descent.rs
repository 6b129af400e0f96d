//! Levenberg and Marquardt's method.

use super::band::Band;

/// The linear problem at one place: the normal matrix, and the gradient of half the sum of squares.
pub(crate) struct Normal {
    pub(crate) matrix: Band,
    pub(crate) gradient: Vec<f64>,
}

impl Normal {
    /// Of a dense Jacobian, row by row, and its residuals.
    pub(crate) fn of_rows(size: usize, rows: &[Vec<f64>], residuals: &[f64]) -> Self {
        let mut gradient = vec![0.0; size];
        for (row, residual) in rows.iter().zip(residuals) {
            row.iter().zip(&mut gradient).for_each(|(d, sum)| *sum += d * residual);
        }
        Self { matrix: Band::of_rows(size, rows.iter().map(Vec::as_slice)), gradient }
    }

    /// By how much a step lowers the cost as far as the gradient tells.
    fn promise(&self, from: &[f64], to: &[f64]) -> f64 {
        0.5 * self.gradient.iter().zip(from.iter().zip(to)).map(|(g, (from, to))| g * (from - to)).sum::<f64>()
    }
}

/// When a descent ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    /// Most successful steps.
    pub(crate) rounds: usize,
    /// Gain of a step, as a share of the cost, that is no gain.
    pub(crate) gain: f64,
    /// The damping of the first step.
    pub(crate) damping: f64,
}

/// Damping is raised by `RAISE` after a failure, and lowered by `LOWER` after a success, within `LEAST` and `MOST`.
const RAISE: f64 = 4.0;
const LOWER: f64 = 8.0;
const LEAST: f64 = 1e-12;
const MOST: f64 = 1e12;

/// Where a descent ended.
pub(crate) struct Descent<S> {
    pub(crate) unknowns: Vec<f64>,
    /// What `evaluate` made of the unknowns.
    pub(crate) state: S,
    pub(crate) cost: f64,
    /// Whether there was no more to gain; otherwise this is the best place found.
    pub(crate) converged: bool,
}

/// Goes down from `start`; none when the start cannot be evaluated.
///
/// `evaluate` gives a state and its cost, or none where there is none; `normal` the linear problem there. `bounded` has the
/// last word on a step: it is given the unknowns and the damped step's way to the next ones (to be subtracted).
pub(crate) fn descend<S>(
    start: Vec<f64>,
    rules: Rules,
    evaluate: impl Fn(&[f64]) -> Option<(S, f64)>,
    normal: impl Fn(&[f64], &S) -> Option<Normal>,
    bounded: impl Fn(&Normal, f64, &[f64]) -> Option<Vec<f64>>,
) -> Option<Descent<S>> {
    let (state, cost) = evaluate(&start).filter(|(_, cost)| cost.is_finite())?;
    let mut best = Descent { unknowns: start, state, cost, converged: false };
    let mut damping = rules.damping;
    for _ in 0..rules.rounds {
        let Some(linear) = normal(&best.unknowns, &best.state) else { break };
        let mut better = None;
        while damping < MOST {
            let next = bounded(&linear, damping, &best.unknowns);
            if next.as_ref().is_some_and(|next| linear.promise(&best.unknowns, next) <= rules.gain * best.cost) {
                break;
            }
            let tried = next.and_then(|next| evaluate(&next).map(|(state, cost)| (next, state, cost)));
            better = tried.filter(|(.., cost)| *cost <= best.cost);
            if better.is_some() {
                break;
            }
            damping *= RAISE;
        }
        let Some((unknowns, state, cost)) = better else {
            // No step promises more, or not even the shortest leads down.
            best.converged = true;
            break;
        };
        let gain = best.cost - cost;
        best = Descent { unknowns, state, cost, converged: gain <= rules.gain * cost };
        damping = (damping / LOWER).max(LEAST);
        if best.converged {
            break;
        }
    }
    Some(best)
}

/// The next unknowns after a damped step without bounds.
pub(crate) fn unbounded(linear: &Normal, damping: f64, unknowns: &[f64]) -> Option<Vec<f64>> {
    let step = linear.matrix.clone().damped(damping).factor()?.solve(linear.gradient.clone());
    Some(unknowns.iter().zip(&step).map(|(u, s)| u - s).collect())
}
