//! Goodness of fit: how well the modes explain the readings, by normalised residuals \[barshalom2001estimation, sec. 5.4\].

use super::bank::Bank;
use super::correlated_noise::NoiseModel;
use super::measurement::{Linearisation, MeasurementModel, Row};
use super::optimisation::Mode;
use crate::config::NoiseAssumption;
use crate::contact::follow::Mechanics;
use crate::flow::pose::Stretch;

/// Where single residuals count as beyond their noise, and the declared bound with a hair for the model (standard deviations of an even
/// law).
const OUTLIER_SIGMAS: f64 = 2.5;
const BOUND: f64 = 1.76;
/// Readings whose mean residual is looked at together, and the mean of chi² for one degree of freedom without its largest tenth.
const BLOCK: usize = 8;
const TRIMMED_MEAN: f64 = 0.62;
/// What a residual counts for at most (standard deviations), and stretches of which the worst is told.
const MOST_SIGMAS: f64 = 6.0;
pub(crate) const STRETCHES: usize = 10;
/// The largest share of readings beyond their noise, and the largest mean square of the others, of a mode that may be right.
const AGREES: [f64; 2] = [0.1, 3.3];

/// How well the modes explain the readings \[barshalom2001estimation, sec. 5.4\]: the best one that may be right.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fit {
    /// Whether a likelier mode leaves too much unexplained to be right, so that neither can be believed alone.
    pub is_disputed: bool,
    /// Readings with a whisker held by a boundary.
    pub touching: usize,
    /// Share of all readings that lie beyond 2.5 standard deviations or are not explained.
    pub beyond: f64,
    /// Share of all readings that break their declared bound.
    pub broken: f64,
    /// Mean square of the residuals within 2.5 standard deviations where a boundary holds the whisker.
    pub square: f64,
    /// Mean normalised residual squared where a boundary holds the whisker or the contact is not explained; far ones count as six standard
    /// deviations.
    pub statistic: f64,
    /// How long errors stay alike (s), 0 where they are independent.
    pub correlation_time: f64,
    /// The tenth of these readings with the largest one, and the statistic there.
    pub worst: Option<(Stretch, f64)>,
    /// Whether errors are taken for independent.
    pub independent: bool,
    /// Mean square of the residuals' means over eight readings of a contact, in units of what independent errors give, without the largest
    /// tenth; and of how many such means.
    pub drift: f64,
    /// See `drift`.
    pub blocks: usize,
    /// By which factor the nuisance parameter that is furthest beyond its declared bound exceeds it; below 1 where none does.
    pub of_bound: f64,
}

impl Fit {
    /// Whether a mode may be right; otherwise modes are searched from another contact.
    pub(crate) fn agrees(&self) -> bool {
        self.beyond <= AGREES[0] && self.square <= AGREES[1]
    }
}

/// How well the best mode fits that may be right, or the best one if none may.
pub(super) async fn of_bank(bank: &Bank, model: &MeasurementModel<'_>) -> Fit {
    let mut best = BestFit::default();
    for mode in &bank.modes {
        if best.take(of_mode(mode, bank, model).await) {
            break;
        }
    }
    best.told()
}

/// The fits of modes, the likeliest first, as far as they are looked at.
#[derive(Debug, Default)]
struct BestFit {
    likeliest: Option<Fit>,
    agreeing: Option<Fit>,
}

impl BestFit {
    /// Takes the next one; whether it may be right, so that no other is needed.
    fn take(&mut self, fit: Fit) -> bool {
        let agrees = fit.agrees();
        if agrees {
            self.agreeing = Some(Fit { is_disputed: self.likeliest.is_some(), ..fit });
        } else if self.likeliest.is_none() {
            self.likeliest = Some(fit);
        }
        agrees
    }

    fn told(self) -> Fit {
        self.agreeing.or(self.likeliest).unwrap_or_default()
    }
}

/// By the solver that leaves fewer readings unexplained, since where the two disagree the whisker is about to snap.
async fn of_mode(mode: &Mode, bank: &Bank, model: &MeasurementModel<'_>) -> Fit {
    let exact = MeasurementModel { solver: Mechanics::ClosedForm, ..*model };
    let mut fits = [Fit::default(), Fit::default()];
    for (fit, model) in fits.iter_mut().zip([model, &exact]) {
        let mut told = Linearisation::default();
        model.run(&mode.state, &mode.start, &bank.rows, &mut told).await;
        *fit = of_run(&told, mode.fit().noise, model.noise_model);
    }
    let [quick, exact] = fits;
    let fit = if quick.beyond < exact.beyond { quick } else { exact };
    Fit { of_bound: model.unknowns.most_of_bound(&mode.state.values), ..fit }
}

/// Of one run of the forward model, whose errors have this noise model.
pub(super) fn of_run(told: &Linearisation, noise: NoiseModel, assumption: NoiseAssumption) -> Fit {
    // What is felt where the map knows nothing says nothing of the fit.
    let mapped = || told.rows.iter().filter(|row| !row.unmapped);
    let all = mapped().count().max(1) as f64;
    let size = |row: &Row| row.held.map_or(f64::INFINITY, |_| row.plain.abs() / (1.0 + row.model_variance).sqrt());
    let share = |most: f64| mapped().filter(|row| size(row) > most).count() as f64 / all;
    let held: Vec<&Row> = mapped().filter(|row| row.held == Some(true)).collect();
    let square = |rows: &[&Row]| {
        let within: Vec<f64> = rows.iter().map(|row| size(row)).filter(|&s| s <= OUTLIER_SIGMAS).collect();
        within.iter().map(|s| s * s).sum::<f64>() / within.len().max(1) as f64
    };
    let felt: Vec<(f64, f64)> = mapped()
        .filter(|row| row.held != Some(false) || size(row) > OUTLIER_SIGMAS)
        .map(|row| (row.t, size(row).min(MOST_SIGMAS).powi(2)))
        .collect();
    let (statistic, worst) = mean_and_worst(&felt);
    let (drift, blocks) = drift(&held);
    Fit {
        is_disputed: false,
        touching: held.len(),
        beyond: share(OUTLIER_SIGMAS),
        broken: share(BOUND),
        square: square(&held),
        correlation_time: if noise.correlated > 0.0 { noise.time_constant } else { 0.0 },
        statistic,
        worst: worst.map(|(from, to, there)| (Stretch { from, to }, there)),
        independent: assumption == NoiseAssumption::Independent,
        of_bound: 0.0,
        drift,
        blocks,
    }
}

/// The mean square of block means, see [`Fit::drift`]: a test for whiteness \[barshalom2001estimation, sec. 5.4\].
fn drift(held: &[&Row]) -> (f64, usize) {
    let sensors = held.iter().map(|row| row.sensor + 1).max().unwrap_or(0);
    let mut squares = Vec::new();
    for sensor in 0..sensors {
        let own: Vec<&Row> = held.iter().filter(|row| row.sensor == sensor).copied().collect();
        squares.extend(own.chunks_exact(BLOCK).map(|block| {
            let sum: f64 = block.iter().map(|row| row.residual.clamp(-OUTLIER_SIGMAS, OUTLIER_SIGMAS)).sum();
            // A wall that is known within a band is off alike along a block.
            let of_wall: f64 = block.iter().filter_map(|row| row.wall).map(|wall| wall.variance().sqrt()).sum();
            sum * sum / (BLOCK as f64 + of_wall * of_wall)
        }));
    }
    squares.sort_by(f64::total_cmp);
    let kept = squares.len() - squares.len() / 10;
    (squares[..kept].iter().sum::<f64>() / (TRIMMED_MEAN * kept.max(1) as f64), squares.len())
}

/// The mean of squares, each with what it is at, and the tenth of them in which that is largest: from, to, and the mean there.
fn mean_and_worst<T: Copy>(squares: &[(T, f64)]) -> (f64, Option<(T, T, f64)>) {
    let mean = |part: &[(T, f64)]| part.iter().map(|one| one.1).sum::<f64>() / part.len().max(1) as f64;
    let length = squares.len().div_ceil(STRETCHES).max(1);
    let stretches = squares.chunks(length).map(|part| (part[0].0, part[part.len() - 1].0, mean(part)));
    (mean(squares), stretches.max_by(|a, b| a.2.total_cmp(&b.2)))
}

#[cfg(test)]
mod tests {
    use super::{BestFit, Fit};

    fn told(shares_beyond: &[f64]) -> Fit {
        let mut best = BestFit::default();
        for &beyond in shares_beyond {
            best.take(Fit { beyond, ..Fit::default() });
        }
        best.told()
    }

    #[test]
    fn the_likeliest_mode_is_told_alone_where_it_explains_the_readings() {
        let fit = told(&[0.02]);
        assert_eq!((fit.beyond, fit.is_disputed), (0.02, false));
    }

    #[test]
    fn where_the_likeliest_mode_leaves_readings_unexplained_the_next_one_is_disputed() {
        let fit = told(&[0.4, 0.3, 0.02]);
        assert_eq!((fit.beyond, fit.is_disputed), (0.02, true));
    }

    #[test]
    fn where_no_mode_explains_the_readings_nothing_disputes_the_likeliest() {
        let fit = told(&[0.4, 0.3]);
        assert_eq!((fit.beyond, fit.is_disputed), (0.4, false));
    }
}
