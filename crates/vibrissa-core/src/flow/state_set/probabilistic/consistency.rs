//! Consistency of the best hypothesis: normalised innovations squared over all rows, single and in blocks
//! \[barshalom2001estimation, sec. 5.4\].

use super::bank::{BankContext, HypothesisBank};
use super::hypothesis::{GaussianHypothesis, MeasurementModel};
use super::log_window::LogWindow;
use super::sensor::LikelihoodOptions;
use crate::contact::follow::{Mechanics, WhiskerState};

/// Fewest blocks that speak about drift, and the mean square of their means (1 for independent errors) that chance explains, in
/// standard deviations of that mean.
const FEWEST_BLOCKS: usize = 6;
const MOST_DRIFT: f64 = 4.0;
/// Rows whose mean residual is looked at together, and where single residuals are cut (standard deviations).
const BLOCK: usize = 8;
const OUTLIER_SIGMAS: f64 = 2.5;
/// What a residual counts for at most (standard deviations), and stretches of which the worst is told.
pub(super) const MOST_SIGMAS: f64 = 6.0;
pub(crate) const STRETCHES: usize = 10;
/// The declared bound of a reading, with a hair for the model (standard deviations of an even law).
const BOUND: f64 = 1.76;

/// How well the best hypothesis explains the readings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Consistency {
    /// Rows with a whisker held by a boundary.
    pub touching: usize,
    /// Share of all rows whose reading lies beyond 2.5 standard deviations or is not explained.
    pub beyond: f64,
    /// Share of all rows whose reading breaks its declared bound.
    pub broken: f64,
    /// Mean square of the residuals within 2.5 standard deviations of rows with a whisker held by a boundary, and what the
    /// declared odometry errors may have added to it.
    pub square: f64,
    /// See `square`.
    pub odometry: f64,
    /// Mean square of the residuals' block means, in units of what independent errors give.
    pub drift: f64,
    /// The same without the tolerated share of the worst blocks.
    pub tolerant_drift: f64,
    /// How many blocks that is of.
    pub blocks: usize,
    /// Mean normalised residual squared where a boundary holds the whisker or the contact is not explained; far ones count as six standard
    /// deviations.
    pub statistic: f64,
    /// The tenth of the rows with the largest one: from and to so many rows before the last, and the statistic there.
    pub worst: Option<(usize, usize, f64)>,
}

impl Consistency {
    /// Whether the residuals stray on the same side for longer than independent errors do.
    pub(super) fn is_biased(&self) -> bool {
        self.blocks >= FEWEST_BLOCKS && self.drift > 1.0 + MOST_DRIFT * (2.0 / self.blocks as f64).sqrt()
    }
}

/// By the solver that leaves fewer readings unexplained: where the two disagree the whisker is about to snap, and one of them has it on
/// another branch for a while.
pub(super) fn fit(
    h: &GaussianHypothesis,
    bank: &HypothesisBank,
    context: &BankContext<'_>,
    history: &LogWindow,
) -> Consistency {
    let [exact, quick] = [Mechanics::ClosedForm, Mechanics::Table(context.table)]
        .map(|solver| fit_by(solver, h, bank, context, history));
    if quick.beyond < exact.beyond { quick } else { exact }
}

/// Runs the history once more and looks at the residuals.
pub(super) fn fit_by(
    solver: Mechanics<'_>,
    h: &GaussianHypothesis,
    bank: &HypothesisBank,
    context: &BankContext<'_>,
    history: &LogWindow,
) -> Consistency {
    let model =
        MeasurementModel { solver, ..context.model(history, bank.pivot, LikelihoodOptions::DECLARED, bank.shared) };
    let mut again = h.clone();
    let mut fit = Consistency::default();
    let gain = h.gain(bank.shared);
    let (mut squares, mut within) = (0.0, 0);
    let (mut sum, mut count, mut beyond, mut broken, mut rows) = (0.0, 0, 0, 0, 0);
    let mut blocks = Vec::new();
    let mut felt: Vec<(usize, f64)> = Vec::new();
    again.relinearise(&model, h.map_from_odom, core::iter::empty());
    for &row in &bank.used {
        again.add_row(&model, row);
        for (index, state) in again.states.iter().enumerate() {
            let held = matches!(state, WhiskerState::Touching(touch) if touch.q > 0.0);
            let z = history.readings(row)[index];
            let normalised_residual = if held {
                context.sensors[index].normalised_without_gain(again.predictions[index], gain, z)
            } else {
                again.normalised_residual[index]
            };
            rows += 1;
            if held || normalised_residual.abs() > OUTLIER_SIGMAS {
                felt.push((history.len() - 1 - row, normalised_residual.abs().min(MOST_SIGMAS).powi(2)));
            }
            beyond += usize::from(normalised_residual.abs() > OUTLIER_SIGMAS);
            broken += usize::from(again.normalised_residual[index].abs() > BOUND);
            if held {
                fit.touching += 1;
                sum += normalised_residual.clamp(-OUTLIER_SIGMAS, OUTLIER_SIGMAS);
                if normalised_residual.abs() <= OUTLIER_SIGMAS {
                    squares += normalised_residual * normalised_residual;
                    within += 1;
                }
                count += 1;
            }
            if count == BLOCK {
                blocks.push(sum * sum / BLOCK as f64);
                (sum, count) = (0.0, 0);
            }
        }
    }
    let share = |count: u32| f64::from(count) / f64::from(rows.max(1) as u32);
    (fit.beyond, fit.broken) = (share(beyond as u32), share(broken as u32));
    fit.square = squares / f64::from(within.max(1));
    fit.blocks = blocks.len();
    (fit.statistic, fit.worst) = mean_and_worst(&felt);
    fit.drift = blocks.iter().sum::<f64>() / blocks.len().max(1) as f64;
    fit.tolerant_drift = drift(blocks, context.options.tolerated_share);
    fit
}

/// The mean of squares, each with what it is at, and the tenth of them in which that is largest: from, to, and the mean there.
pub(super) fn mean_and_worst<T: Copy>(squares: &[(T, f64)]) -> (f64, Option<(T, T, f64)>) {
    let mean = |part: &[(T, f64)]| part.iter().map(|one| one.1).sum::<f64>() / part.len().max(1) as f64;
    let length = squares.len().div_ceil(STRETCHES).max(1);
    let stretches = squares.chunks(length).map(|part| (part[0].0, part[part.len() - 1].0, mean(part)));
    (mean(squares), stretches.max_by(|a, b| a.2.total_cmp(&b.2)))
}

/// The mean of squares without a share of the largest, in units of what squares of a Gaussian give.
fn drift(mut squares: Vec<f64>, left_out: f64) -> f64 {
    squares.sort_by(f64::total_cmp);
    let kept = ((1.0 - left_out) * squares.len() as f64).ceil() as usize;
    squares.truncate(kept);
    // Without its largest share f the mean of chi² for one degree of freedom is 1, 0.62, 0.44, 0.26 and 0.14 for f = 0, 0.1,
    // 0.2, 0.35 and 0.5; this is never less than that by much, and more where it is not near.
    let fair = (1.0 - left_out).powi(3);
    squares.iter().sum::<f64>() / (fair * kept.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_without_the_largest_are_measured_by_what_a_gaussian_leaves() {
        // Normal numbers on a grid of Box and Muller's map.
        let grid = |i: u32| (f64::from(i) + 0.5) / 300.0;
        let normal = |i: u32, j: u32| (-2.0 * grid(i).ln()).sqrt() * (core::f64::consts::TAU * grid(j)).cos();
        let squares: Vec<f64> = (0..300).flat_map(|i| (0..300).map(move |j| normal(i, j).powi(2))).collect();
        assert!((drift(squares.clone(), 0.0) - 1.0).abs() < 0.01);
        for share in [0.1, 0.15, 0.2, 0.35] {
            let mean = drift(squares.clone(), share);
            assert!((0.8..1.03).contains(&mean), "{share}: {mean}");
        }
        // A tenth of wild ones does not count, a fifth does.
        let wild =
            |every: usize| squares.iter().enumerate().map(|(i, &s)| if i % every == 0 { 50.0 } else { s }).collect();
        assert!(drift(wild(10), 0.15) < 1.35 && drift(wild(5), 0.15) > 3.0);
    }
}
