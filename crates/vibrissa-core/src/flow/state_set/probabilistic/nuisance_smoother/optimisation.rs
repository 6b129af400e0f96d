//! Levenberg and Marquardt's method over a window of readings \[nocedal2006numerical, sec. 10.3\]: one mode of the posterior.

use super::super::information::Information;
use super::correlated_noise::{Filter, NoiseModel, add_readings};
use super::measurement::{Linearisation, MeasurementModel, Start, State, difference};
use super::normal_equations::{NormalEquations, Response};
use super::unknowns::POSE;
use crate::plane::Pose2;

/// Inverse variances that keep a step finite where the readings leave a direction open (5 mm, 5°).
pub(super) const DAMPING: [f64; POSE] = [4e4, 4e4, 131.0];
/// Longest step of one linearisation (m, rad).
const LONGEST: [f64; 2] = [3e-3, 0.06];
/// Parts of a step that are tried.
const FRACTIONS: [f64; 2] = [1.0, 0.3];
/// A step that promises less than this (nats) is not taken.
const SETTLED: f64 = 2e-2;

/// A place that may be the true one, with the normal equations around it.
#[derive(Clone, Debug)]
pub(super) struct Mode {
    pub(super) state: State,
    pub(super) start: Start,
    pub(super) equations: NormalEquations,
    /// Whether it has come to its least cost over the rows that it has seen.
    pub(super) is_settled: bool,
    /// How its whiskers stand at the last of them, and what the errors of its readings are.
    pub(super) end: Option<Box<Start>>,
    pub(super) filters: Vec<Filter>,
}

impl Mode {
    pub(super) fn new(frame: Pose2, start: Start, model: &MeasurementModel<'_>) -> Self {
        let values = vec![0.0; model.unknowns.all().len()];
        Self {
            state: State { frame, values },
            start,
            equations: NormalEquations::default(),
            is_settled: false,
            end: None,
            filters: Vec::new(),
        }
    }

    /// The cost where it stands, with the nuisance parameters marginalised.
    pub(super) fn cost(&self, model: &MeasurementModel<'_>) -> f64 {
        self.marginal(model).constant
    }

    /// The pose with the nuisance parameters marginalised.
    pub(super) fn marginal(&self, model: &MeasurementModel<'_>) -> Information<POSE> {
        self.equations.marginal(model.unknowns.all())
    }

    /// The nuisance parameters given the pose.
    pub(super) fn response(&self) -> Option<Response> {
        self.equations.response()
    }

    /// Linearises it where it stands.
    pub(super) fn relinearise(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        noise: NoiseModel,
        scratch: &mut Linearisation,
    ) {
        self.end = Some(Box::new(model.run(&self.state, &self.start, rows, scratch)));
        self.equations = model.known(&self.state, &self.start);
        self.filters.clear();
        add_readings(scratch, noise, &mut self.filters, &mut self.equations);
    }

    /// Takes in rows that follow those that it has been linearised by.
    pub(super) fn carry_on(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        noise: NoiseModel,
        scratch: &mut Linearisation,
    ) {
        let Some(end) = &self.end else { return };
        self.end = Some(Box::new(model.run(&self.state, end, rows, scratch)));
        add_readings(scratch, noise, &mut self.filters, &mut self.equations);
    }

    /// The same at another state.
    pub(super) fn at(
        &self,
        state: State,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        noise: NoiseModel,
        scratch: &mut Linearisation,
    ) -> Self {
        let mut there = Self { state, is_settled: false, end: None, ..self.clone() };
        there.relinearise(model, rows, noise, scratch);
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

    /// Goes to where the cost is least, in so many steps at most; it must be linearised by these rows and this noise.
    pub(super) fn descend(
        &mut self,
        model: &MeasurementModel<'_>,
        rows: &[usize],
        noise: NoiseModel,
        steps: usize,
        scratch: &mut Linearisation,
    ) {
        for _ in 0..steps {
            let Some((promised, step)) = self.equations.step(DAMPING) else { return };
            if self.equations.constant - promised < SETTLED {
                self.is_settled = true;
                return;
            }
            let long = step[0].hypot(step[1]) / LONGEST[0];
            let share = long.max(step[2].abs() / LONGEST[1]).max(1.0).recip();
            let mut taken = false;
            for fraction in FRACTIONS {
                let part: Vec<f64> = step.iter().map(|d| d * share * fraction).collect();
                let next = self.at(self.state.stepped(model.pivot(), &part), model, rows, noise, scratch);
                if next.equations.constant < self.equations.constant {
                    (*self, taken) = (next, true);
                    break;
                }
            }
            if !taken {
                self.is_settled = true;
                return;
            }
        }
    }
}

/// What it takes to fit a mode elsewhere to the same readings.
pub(super) struct Rerun<'a> {
    pub(super) model: &'a MeasurementModel<'a>,
    pub(super) rows: &'a [usize],
    pub(super) noise: NoiseModel,
}

impl Rerun<'_> {
    /// The mode with its pose at this frame, and the nuisance parameters as the readings would have them there.
    pub(super) fn at(&self, mode: &Mode, frame: Pose2) -> Mode {
        let state = mode.state_at(self.model, frame);
        mode.at(state, self.model, self.rows, self.noise, &mut Linearisation::default())
    }
}
