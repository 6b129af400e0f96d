//! Kalman filters of the errors that readings share \[barshalom2001estimation, sec. 8.2\]: of a sensor, of the model where that sensor's
//! whisker stands, and of a stretch of wall. Each is known by its mean, the mean's derivatives by the unknowns, and its variance.

use super::correlated_noise::NoiseModel;
use super::wall_error::{WallError, WallErrors};
use crate::plane::Vec2;

/// Where the model has a whisker is off by nearly the same from reading to reading: for so long (s), but for this share of its variance.
/// Of 165 sweeps by moments that touch, in rooms drawn at random, the truth was among no place in 0 with these, in 1 with 0.1 s, and in 3
/// with independent errors (a share of 1).
const MODEL_TIME_CONSTANT: f64 = 1.0;
const MODEL_INDEPENDENT: f64 = 0.04;

/// An error that several readings have in common.
#[derive(Clone, Debug)]
pub(super) struct SharedError {
    residual: f64,
    derivatives: Vec<f64>,
    pub(super) variance: f64,
}

impl SharedError {
    /// An error of this variance of which no reading has said anything.
    fn new(size: usize, variance: f64) -> Self {
        Self { residual: 0.0, derivatives: vec![0.0; size], variance }
    }

    /// That of the stretch of wall which a reading feels (m).
    pub(super) fn of_wall(walls: &mut WallErrors, error: WallError, size: usize) -> &mut Self {
        walls.entry(error.stretch).or_insert_with(|| Self::new(size, error.std * error.std))
    }

    /// Takes what is known of it out of a residual in which it counts `by`, and out of that one's derivatives.
    pub(super) fn take_out(&self, by: f64, residual: &mut f64, derivatives: &mut [f64]) {
        *residual -= by * self.residual;
        derivatives.iter_mut().zip(&self.derivatives).for_each(|(to, f)| *to -= by * f);
    }

    pub(super) fn learn(&mut self, gain: f64, residual: f64, innovation: &[f64]) {
        self.residual += gain * residual;
        self.derivatives.iter_mut().zip(innovation).for_each(|(to, v)| *to += gain * v);
    }

    /// Goes on as a Gauss-Markov process of this variance that keeps so much of itself.
    fn decay(&mut self, kept: f64, stationary: f64) {
        self.residual *= kept;
        self.derivatives.iter_mut().for_each(|v| *v *= kept);
        self.variance = kept * kept * self.variance + (1.0 - kept * kept) * stationary;
    }

    /// The same on a map that is turned by this angle (rad).
    pub(super) fn turn(&mut self, angle: f64) {
        let Vec2 { x: cos, y: sin } = Vec2::from_angle(angle);
        let [x, y] = [self.derivatives[0], self.derivatives[1]];
        (self.derivatives[0], self.derivatives[1]) = (cos * x - sin * y, sin * x + cos * y);
    }
}

/// What a sensor's readings share: its own error, in standard deviations of the declared noise, and the model's, in standard deviations of
/// itself. Both are first-order Gauss-Markov processes.
#[derive(Clone, Debug)]
pub(super) struct SensorFilter {
    own: SharedError,
    model: SharedError,
    /// Covariance of both.
    both: f64,
    /// Variances before any reading.
    stationary: [f64; 2],
    t: f64,
}

/// What the next reading has of the errors that a sensor's readings share.
#[derive(Clone, Copy)]
pub(super) struct Expected {
    /// How much the model's error counts in it.
    by_model: f64,
    /// Covariance with both errors.
    with: [f64; 2],
    /// Variance by them, and by what of the model's error no other reading shares.
    pub(super) variance: f64,
    pub(super) independent: f64,
}

impl SensorFilter {
    pub(super) fn new(size: usize, correlated: f64) -> Self {
        Self {
            own: SharedError::new(size, correlated),
            model: SharedError::new(size, 1.0),
            both: 0.0,
            stationary: [correlated, 1.0],
            t: f64::NEG_INFINITY,
        }
    }

    /// Variance of the sensor's own error.
    pub(super) fn own_variance(&self) -> f64 {
        self.own.variance
    }

    /// Goes on to a reading in which the model's error counts `by_model`.
    pub(super) fn predict(&mut self, t: f64, noise: NoiseModel, by_model: f64) -> Expected {
        if noise.correlated > 0.0 || by_model != 0.0 {
            let past = (t - self.t).max(0.0);
            let kept = [noise.time_constant, MODEL_TIME_CONSTANT].map(|constant| (-past / constant).exp());
            self.t = t;
            self.own.decay(kept[0], self.stationary[0]);
            self.model.decay(kept[1], self.stationary[1]);
            self.both *= kept[0] * kept[1];
        }
        let independent = MODEL_INDEPENDENT * by_model * by_model;
        let by_model = by_model * (1.0 - MODEL_INDEPENDENT).sqrt();
        let with = [self.own.variance + by_model * self.both, self.both + by_model * self.model.variance];
        Expected { by_model, with, variance: with[0] + by_model * with[1], independent }
    }

    /// Takes what is known of both errors out of a residual and out of its derivatives.
    pub(super) fn take_out(&self, expected: Expected, residual: &mut f64, derivatives: &mut [f64]) {
        if self.stationary[0] > 0.0 {
            self.own.take_out(1.0, residual, derivatives);
        }
        if expected.by_model != 0.0 {
            self.model.take_out(expected.by_model, residual, derivatives);
        }
    }

    /// Takes in a reading by its innovation, as far as that is trusted, and its variance.
    pub(super) fn learn(
        &mut self,
        expected: Expected,
        (trust, variance): (f64, f64),
        residual: f64,
        innovation: &[f64],
    ) {
        let ([own, model], share) = (expected.with, trust / variance);
        let errors = [(&mut self.own, own), (&mut self.model, model)];
        for ((error, with), stationary) in errors.into_iter().zip(self.stationary).filter(|((_, with), _)| *with != 0.0)
        {
            error.learn(share * with, residual, innovation);
            error.variance -= share * with * with;
            // An error that is not followed may be the first of a jump.
            error.variance += (1.0 - trust) * (stationary - error.variance).max(0.0);
        }
        self.both -= share * own * model;
    }

    /// The same on a map that is turned by this angle (rad).
    pub(super) fn turn(&mut self, angle: f64) {
        self.own.turn(angle);
        self.model.turn(angle);
    }
}
