//! Levenberg and Marquardt's method over a window of readings \[nocedal2006numerical, sec. 10.3\]: one mode of the posterior.

use super::correlated_noise::{NoiseModel, add_readings, estimated};
use super::error_filter::ErrorFilter;
use super::information::{Information, by_cost};
use super::map_symmetry::MapSymmetry;
use super::measurement::{Linearisation, MeasurementModel, Row};
use super::normal_equations::{NormalEquations, Response};
use super::state::{Start, State, difference, moved};
use super::unknowns::POSE;
use crate::config::NoiseAssumption;
use crate::plane::Pose2;

/// Inverse variances that keep a step finite where the readings leave a direction open (5 mm, 5°).
pub(super) const DAMPING: [f64; POSE] = [4e4, 4e4, 131.0];
/// Longest step of one linearisation (m, rad).
const LONGEST: [f64; 2] = [3e-3, 0.06];
/// A direction that the readings leave open by more than this (standard deviation, m) is searched at these distances to either side (m),
/// where that promises so much (nats): a corner at a wall's end tells a tenth of a millimetre, by rows that fit or are far off.
const OPEN: f64 = 2e-3;
pub(super) const LINE: [f64; 4] = [0.4e-3, 0.8e-3, 1.5e-3, 2.5e-3];
const WORTH_LINE: f64 = 1.0;
/// Which of the two directions of a line is tried first: that towards a direction with this slope, to which hardly a wall is at right angles, so that
/// rounding does not choose.
const SIGN_BY: f64 = 0.2718;
/// Parts of a step that are tried.
const FRACTIONS: [f64; 2] = [1.0, 0.3];
/// Residuals further off than this (standard deviations of an even law) are unexplained: two and a half times their bound, as what is
/// estimated along may have taken in an error of once the bound.
pub(super) const UNEXPLAINED: f64 = 4.3;
/// With so many of them in what has just come a mode is fitted by a graduated cost: variances larger by these factors, one after the other.
const MOST_UNEXPLAINED: usize = 3;
const GRADUATED: [f64; 2] = [900.0, 30.0];
/// Steps by each of these costs, and readings that this takes, about, per row.
const GRADUATED_STEPS: usize = 5;
pub(super) const GRADUATED_RUNS: usize = 20;
/// So many readings are added to the equations in the time in which one is run.
pub(super) const READINGS_ADDED: usize = 16;
/// A step that promises less than this (nats) is not taken.
const SETTLED: f64 = 2e-2;

/// A place that may be the true one, with the normal equations around it by each noise model that may be right: a multiple-model estimator
/// \[barshalom2001estimation, sec. 11.6.2\].
#[derive(Clone, Debug)]
pub(super) struct Mode {
    pub(super) state: State,
    pub(super) start: Start,
    pub(super) fits: Vec<NoiseFit>,
    /// The one of the largest evidence, and minus the logarithm of that, as its linearisation promises it and where it stands.
    likeliest: usize,
    promise: f64,
    here: f64,
    /// Whether the rows that came last are further off than noise, which a robust cost takes for false.
    pub(super) is_off: bool,
    /// How its whiskers stand at the last of them.
    pub(super) end: Option<Box<Start>>,
}

/// The readings by one noise model.
#[derive(Clone, Debug)]
pub(super) struct NoiseFit {
    pub(super) noise: NoiseModel,
    pub(super) equations: NormalEquations,
    /// What the errors of the readings are at the last row.
    filter: ErrorFilter,
    /// How much likelier the readings are than this model says (nats), where it stands for others.
    pub(super) credit: f64,
    /// By how much a step promises to lower the cost (nats).
    gain: f64,
}

impl NoiseFit {
    pub(super) fn new(noise: NoiseModel) -> Self {
        Self { noise, equations: NormalEquations::default(), filter: ErrorFilter::default(), credit: 0.0, gain: 0.0 }
    }
}

impl Mode {
    /// A mode that is not linearised yet, by these noise models.
    pub(super) fn new(state: State, start: Start, noise: &[NoiseModel]) -> Self {
        Self {
            state,
            start,
            fits: noise.iter().copied().map(NoiseFit::new).collect(),
            likeliest: 0,
            promise: f64::INFINITY,
            here: f64::INFINITY,
            is_off: false,
            end: None,
        }
    }

    /// The same, not linearised, by another noise model alone.
    pub(super) fn by(&self, noise: NoiseModel) -> Self {
        Self {
            state: self.state.clone(),
            start: self.start.clone(),
            fits: vec![NoiseFit::new(noise)],
            likeliest: 0,
            promise: f64::INFINITY,
            here: f64::INFINITY,
            is_off: false,
            end: None,
        }
    }

    /// The same at another state and by its likeliest noise model alone, with these equations there.
    pub(super) fn told_by(&self, state: State, equations: NormalEquations) -> Self {
        let NoiseFit { noise, credit, .. } = *self.fit();
        let fit = NoiseFit { equations, credit, ..NoiseFit::new(noise) };
        Self { state, fits: vec![fit], ..self.by(noise) }
    }

    /// Lets it cost so much (nats) more, wherever it goes.
    pub(super) fn discount(&mut self, by: f64) {
        self.fits.iter_mut().for_each(|fit| fit.credit -= by);
        (self.promise, self.here) = (self.promise + by, self.here + by);
    }

    /// The same at an image of its place on a symmetric map.
    pub(super) fn turned(&self, turn: &MapSymmetry) -> Self {
        let mut there = self.clone();
        there.fits.iter_mut().for_each(|fit| fit.equations = fit.equations.turned(turn.motion.theta));
        there.state.frame = turn.motion.compose(self.state.frame);
        there.start = self.start.turned(turn);
        there.fits.iter_mut().for_each(|fit| fit.filter.turn(turn.motion.theta));
        there.end = self.end.as_ref().map(|end| Box::new(end.turned(turn)));
        there
    }

    /// What the likeliest noise model says.
    pub(super) fn fit(&self) -> &NoiseFit {
        &self.fits[self.likeliest]
    }

    pub(super) fn equations(&self) -> &NormalEquations {
        &self.fit().equations
    }

    /// The cost where it stands, with the nuisance parameters marginalised.
    pub(super) fn cost(&self, model: &MeasurementModel<'_>) -> f64 {
        self.marginal(model).constant
    }

    /// The pose with the nuisance parameters marginalised.
    pub(super) fn marginal(&self, model: &MeasurementModel<'_>) -> Information<POSE> {
        let mut told = self.equations().marginal(model.unknowns.all());
        told.constant -= self.fit().credit;
        told
    }

    /// The nuisance parameters given the pose.
    pub(super) fn response(&self) -> Option<Response> {
        self.equations().response()
    }

    /// Linearises it where it stands.
    pub(super) async fn relinearise(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        scratch: &mut Linearisation,
    ) {
        self.end = Some(Box::new(model.run(&self.state, &self.start, rows, scratch).await));
        let known = model.known(&self.state, &self.start);
        for fit in &mut self.fits {
            fit.equations.clone_from(&known);
            fit.filter.clear();
            add_readings(scratch, fit.noise, &mut fit.filter, &mut fit.equations);
            model.works(rows.len() / READINGS_ADDED).await;
        }
        self.choose_noise();
    }

    /// Takes in rows that follow those that it has been linearised by.
    pub(super) async fn carry_on(&mut self, model: &MeasurementModel<'_>, rows: &[usize], scratch: &mut Linearisation) {
        let Some(end) = &self.end else { return };
        self.end = Some(Box::new(model.run(&self.state, end, rows, scratch).await));
        self.is_off |= is_off(&scratch.rows);
        for fit in &mut self.fits {
            add_readings(scratch, fit.noise, &mut fit.filter, &mut fit.equations);
            model.works(rows.len() / READINGS_ADDED).await;
        }
        self.choose_noise();
    }

    /// The noise model that its residuals tell, and how much likelier the likeliest one makes the readings (nats).
    pub(super) async fn estimated_noise(
        &self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        scratch: &mut Linearisation,
    ) -> (NoiseModel, f64) {
        match model.noise_model {
            NoiseAssumption::Independent => (NoiseModel::DECLARED, 0.0),
            NoiseAssumption::Correlated => {
                model.run(&self.state, &self.start, rows, scratch).await;
                estimated(model, scratch, &model.known(&self.state, &self.start), DAMPING).await
            }
        }
    }

    /// Takes the noise model of the largest evidence.
    fn choose_noise(&mut self) {
        (self.likeliest, self.promise, self.here) = (0, f64::INFINITY, f64::INFINITY);
        for (index, fit) in self.fits.iter_mut().enumerate() {
            let (promise, here) = fit.equations.evidence(DAMPING);
            fit.gain = if promise.is_finite() { here - promise } else { 0.0 };
            if index == 0 || (promise - fit.credit).total_cmp(&self.promise).is_lt() {
                (self.likeliest, self.promise, self.here) = (index, promise - fit.credit, here - fit.credit);
            }
        }
    }

    /// Minus the logarithm of the evidence that its linearisation promises.
    pub(super) fn evidence(&self) -> f64 {
        self.promise
    }

    /// By how much a step promises to lower its cost (nats).
    pub(super) fn gain(&self) -> f64 {
        self.fit().gain
    }

    /// The same with the cost where it stands: a step from afar may promise what it does not keep.
    pub(super) fn evidence_here(&self) -> f64 {
        self.here
    }

    /// Whether independent errors would take it elsewhere, while others explain where it is.
    pub(super) fn might_move(&self, gain: f64) -> bool {
        self.likeliest != 0 && self.fits[0].gain > gain
    }

    /// Goes on as if errors were independent, and stays there if all is likelier there by any noise model: errors that stay alike explain
    /// a mode that has not come to its place yet.
    pub(super) async fn descend_independently(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        steps: usize,
        scratch: &mut Linearisation,
    ) {
        let mut there = self.by(NoiseModel::DECLARED);
        there.relinearise(model, rows, scratch).await;
        there.descend(model, rows, steps, scratch).await;
        there.fits.clone_from(&self.fits);
        there.relinearise(model, rows, scratch).await;
        if by_cost(there.evidence(), self.evidence()).is_lt() {
            *self = there;
        }
    }

    /// Whether so many of the last readings are off.
    pub(super) async fn is_off_at(
        &self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        last: usize,
        scratch: &mut Linearisation,
    ) -> bool {
        model.run(&self.state, &self.start, rows, scratch).await;
        is_off(&scratch.rows[scratch.rows.len().saturating_sub(last)..])
    }

    /// Goes on by graduated non-convexity \[yang2020graduated\], and stays there if all is likelier there: readings that are
    /// far off all at once have no weight with a robust cost, although one small motion may explain them.
    pub(super) async fn descend_graduated(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        scratch: &mut Linearisation,
    ) {
        let mut there = self.clone();
        for factor in GRADUATED {
            there = there.by(NoiseModel { white: factor, ..NoiseModel::DECLARED });
            there.relinearise(model, rows, scratch).await;
            there.descend(model, rows, GRADUATED_STEPS, scratch).await;
        }
        there.fits.clone_from(&self.fits);
        there.relinearise(model, rows, scratch).await;
        there.descend(model, rows, GRADUATED_STEPS, scratch).await;
        if by_cost(there.evidence_here(), self.evidence_here()).is_lt() {
            *self = there;
        }
    }

    /// The same at another state.
    pub(super) async fn at(
        &self,
        state: State,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        scratch: &mut Linearisation,
    ) -> Self {
        let mut there = Self {
            state,
            start: self.start.clone(),
            fits: self.fits.iter().map(|fit| NoiseFit { credit: fit.credit, ..NoiseFit::new(fit.noise) }).collect(),
            likeliest: self.likeliest,
            promise: f64::INFINITY,
            here: f64::INFINITY,
            is_off: false,
            end: None,
        };
        there.relinearise(model, rows, scratch).await;
        there
    }

    /// Where it stands with the pose at this frame, and the nuisance parameters as the readings would have them there.
    pub(super) fn state_at(&self, model: &MeasurementModel<'_>, frame: Pose2) -> State {
        let d = difference(self.state.frame, frame, model.pivot());
        let mut values = self.state.values.clone();
        if let Some(response) = self.response() {
            values.iter_mut().zip(response.given(d)).for_each(|(value, step)| *value += step);
        }
        State { frame, values }
    }

    /// Moves to the likeliest of some places along the direction that the readings leave open \[nocedal2006numerical, sec. 9.3\], if there
    /// is one, and tells whether: where a cost has steps its derivatives lead nowhere.
    pub(super) async fn search_line(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        steps: &[f64],
        scratch: &mut Linearisation,
    ) -> bool {
        let Some(c) = self.marginal(model).covariance(DAMPING) else { return false };
        let (sin, cos) = (0.5 * (2.0 * c[0][1]).atan2(c[0][0] - c[1][1])).sin_cos();
        let sign = 1.0_f64.copysign(cos + SIGN_BY * sin);
        let (sin, cos) = (sign * sin, sign * cos);
        let variance = cos * cos * c[0][0] + 2.0 * sin * cos * c[0][1] + sin * sin * c[1][1];
        if variance < OPEN * OPEN {
            return false;
        }
        let turn = (cos * c[0][2] + sin * c[1][2]) / variance;
        let mut best: Option<Self> = None;
        for by in steps.iter().flat_map(|&by| [by, -by]) {
            let frame = moved(self.state.frame, model.pivot(), [cos * by, sin * by, turn * by]);
            let there = self.at(self.state_at(model, frame), model, rows, scratch).await;
            if by_cost(there.evidence(), best.as_ref().unwrap_or(self).evidence()).is_lt() {
                best = Some(there);
            }
        }
        let Some(mut best) = best.filter(|best| best.evidence() < self.evidence() - WORTH_LINE) else { return false };
        best.descend(model, rows, 1, scratch).await;
        let is_better = by_cost(best.evidence_here(), self.evidence_here()).is_lt();
        if is_better {
            *self = best;
        }
        is_better
    }

    /// Goes to where the cost is least, in so many steps at most; it must be linearised by these rows.
    pub(super) async fn descend(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        steps: usize,
        scratch: &mut Linearisation,
    ) {
        for _ in 0..steps {
            let fit = self.fit();
            let Some((promised, step)) = fit.equations.step(DAMPING) else { return };
            if fit.equations.constant - promised < SETTLED {
                return;
            }
            let long = step[0].hypot(step[1]) / LONGEST[0];
            let share = long.max(step[2].abs() / LONGEST[1]).max(1.0).recip();
            let mut taken = false;
            for fraction in FRACTIONS {
                let part: Vec<f64> = step.iter().map(|d| d * share * fraction).collect();
                let next = self.at(self.state.stepped(model.pivot(), &part), model, rows, scratch).await;
                if next.fits[self.likeliest].equations.constant < self.equations().constant {
                    (*self, taken) = (next, true);
                    break;
                }
            }
            if !taken {
                return;
            }
        }
    }
}

/// Whether too many of these readings are unexplained for false ones.
fn is_off(rows: &[Row]) -> bool {
    rows.iter().filter(|row| row.plain.abs() > UNEXPLAINED).count() >= MOST_UNEXPLAINED
}

/// What it takes to fit a mode elsewhere to the same readings.
pub(super) struct Rerun<'a> {
    pub(super) model: &'a MeasurementModel<'a>,
    pub(super) rows: &'a [usize],
}

impl Rerun<'_> {
    /// The mode with its pose at this frame, and the nuisance parameters as the readings would have them there.
    pub(super) async fn at(&self, mode: &Mode, frame: Pose2) -> Mode {
        let state = mode.state_at(self.model, frame);
        mode.at(state, self.model, self.rows, &mut Linearisation::default()).await
    }
}
