//! Joint Kalman filter of the errors that readings share \[barshalom2001estimation, sec. 8.2\]: of each sensor, of the model where that
//! sensor's whisker stands, of each stretch of wall that is known within a band, and of the pose by errors of the odometry's increments. Each is known by its mean, the mean's derivatives by
//! the unknowns, and its covariance with the others.

use super::correlated_noise::NoiseModel;
use super::measurement::Row;
use super::odometry_drift::{OnWalk, Transition, product, transposed};
use super::unknowns::POSE;
use super::wall_error::WallError;
use crate::linear_algebra::Square;
use crate::plane::{Pose2, Vec2};
use std::collections::BTreeMap;

/// Where the model has a whisker is off by nearly the same from reading to reading while the whisker moves so far (m), but for this share
/// of its variance. Of 540 sweeps by moments in rooms drawn at random one was told wrong or without its truth with 0.1, 0.2 and 1 m, two with
/// 0.03, 0.3 and 3 m: no difference beyond two standard errors. With independent errors (a share of 1) three of 165 were.
const MODEL_CORRELATION_LENGTH: f64 = 0.2;
const MODEL_INDEPENDENT: f64 = 0.04;
/// A turn counts as much as a way of the same angle on an arm of this length (m), that of a usual whisker. Not looked at alone.
const LEVER: f64 = 0.1;
/// A reading has something of this many: its sensor's error, the wall's, the model's, and the pose's three.
const PARTS: usize = 6;

/// A sensor's error is in standard deviations of the declared noise, the model's in standard deviations of itself; both are first-order
/// Gauss-Markov processes. A wall's (m) stays.
#[derive(Clone, Debug)]
struct ErrorState {
    mean: f64,
    /// Variance before any reading, where the error changes.
    stationary: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
struct SensorStates {
    own: usize,
    model: usize,
    /// When the last reading was taken (s), and where.
    t: f64,
    odom_from_whisker: Pose2,
}

/// What is known of all errors that readings share.
#[derive(Clone, Debug, Default)]
pub(super) struct ErrorFilter {
    /// How many unknowns there are.
    size: usize,
    states: Vec<ErrorState>,
    derivatives: Vec<f64>,
    /// The lower triangle, row by row.
    covariance: Vec<f64>,
    sensors: Vec<SensorStates>,
    stretches: BTreeMap<(u32, u32), usize>,
    /// The first of the three of the pose, and where on the odometry's walk they are.
    drift: Option<(usize, OnWalk)>,
    /// Covariance of each error with what the next reading has of all.
    with: Vec<f64>,
}

/// What the next reading has of the errors that readings share.
#[derive(Clone, Copy)]
pub(super) struct Expected {
    /// States, and how much each counts.
    parts: [(usize, f64); PARTS],
    /// Variance by all, and by all but the model's.
    pub(super) variance: f64,
    pub(super) without_model: f64,
    /// Variance by what of the model's error no other reading shares.
    pub(super) independent: f64,
}

fn at(i: usize, j: usize) -> usize {
    let (low, high) = (i.min(j), i.max(j));
    high * (high + 1) / 2 + low
}

impl ErrorFilter {
    /// Has the errors of so many sensors from now on, and goes on with what it knows of those that it had.
    pub(super) fn begin(&mut self, size: usize, sensors: usize, correlated: f64) {
        self.size = size;
        for _ in self.sensors.len()..sensors {
            let [own, model] = [correlated, 1.0].map(|variance| self.push(variance, Some(variance)));
            self.sensors.push(SensorStates { own, model, t: f64::NEG_INFINITY, odom_from_whisker: Pose2::default() });
        }
    }

    /// Forgets all readings.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Adds an error that no other one has to do with.
    fn push(&mut self, variance: f64, stationary: Option<f64>) -> usize {
        let state = self.states.len();
        self.states.push(ErrorState { mean: 0.0, stationary });
        self.derivatives.resize((state + 1) * self.size, 0.0);
        self.covariance.resize(at(state, state), 0.0);
        self.covariance.push(variance);
        state
    }

    /// Goes on as a Gauss-Markov process that keeps so much of itself.
    fn decay(&mut self, state: usize, kept: f64) {
        let ErrorState { mean, stationary: Some(stationary) } = &mut self.states[state] else { return };
        *mean *= kept;
        let fresh = (1.0 - kept * kept) * *stationary;
        self.derivatives[state * self.size..][..self.size].iter_mut().for_each(|v| *v *= kept);
        for other in 0..self.states.len() {
            self.covariance[at(state, other)] *= kept;
        }
        let own = &mut self.covariance[at(state, state)];
        *own = kept * *own + fresh;
    }

    /// Goes on to a reading: a sensor's error changes with time, the model's while the whisker moves.
    pub(super) fn predict(&mut self, row: &Row, noise: NoiseModel) -> Expected {
        let SensorStates { own, model, t, odom_from_whisker } = self.sensors[row.sensor];
        let has_own = noise.correlated > 0.0;
        if has_own || row.model_error != 0.0 {
            if has_own {
                self.decay(own, (-(row.t - t).max(0.0) / noise.time_constant).exp());
            }
            let step = odom_from_whisker.between(row.odom_from_whisker);
            let way = step.position().norm() + LEVER * step.theta.abs();
            self.decay(model, (-way / MODEL_CORRELATION_LENGTH).exp());
            self.sensors[row.sensor] = SensorStates { own, model, t: row.t, odom_from_whisker: row.odom_from_whisker };
        }
        let shared = row.model_error * (1.0 - MODEL_INDEPENDENT).sqrt();
        let wall = row.wall.map_or((own, 0.0), |error| (self.of_wall(error), error.by_displacement));
        let (drift, by) = row.drift.map_or((own, [0.0; POSE]), |drift| (self.walk_to(drift.on_walk), drift.by));
        let [x, y, turn] = core::array::from_fn(|k| (drift + if row.drift.is_some() { k } else { 0 }, by[k]));
        let parts = [(own, f64::from(u8::from(has_own))), wall, (model, shared), x, y, turn];
        self.with.clear();
        self.with.resize(self.states.len(), 0.0);
        self.count(&parts[..2]);
        let without_model = self.variance(&parts[..2]);
        self.count(&parts[2..]);
        let independent = MODEL_INDEPENDENT * row.model_error.powi(2);
        Expected { parts, variance: self.variance(&parts), without_model, independent }
    }

    /// The error of the stretch of wall that a reading feels (m).
    fn of_wall(&mut self, error: WallError) -> usize {
        if let Some(&state) = self.stretches.get(&error.stretch) {
            return state;
        }
        let state = self.push(error.std * error.std, None);
        self.stretches.insert(error.stretch, state);
        state
    }

    /// Goes on along the odometry's walk; gives the first of the pose's errors.
    fn walk_to(&mut self, to: OnWalk) -> usize {
        let Some((first, from)) = self.drift else {
            let covariance = to.covariance();
            let first = self.push(covariance[0][0], None);
            (1..POSE).for_each(|k| {
                self.push(covariance[k][k], None);
            });
            (0..POSE).for_each(|i| (0..i).for_each(|j| self.covariance[at(first + i, first + j)] = covariance[i][j]));
            self.drift = Some((first, to));
            return first;
        };
        if from != to {
            let Transition { keeps, fresh } = from.transition(&to);
            self.transform(first, &keeps);
            (0..POSE).for_each(|i| (0..=i).for_each(|j| self.covariance[at(first + i, first + j)] += fresh[i][j]));
            self.drift = Some((first, to));
        }
        first
    }

    /// Takes these three errors for linear combinations of them.
    fn transform(&mut self, first: usize, by: &Square<POSE>) {
        let mixed =
            |v: [f64; POSE]| -> [f64; POSE] { core::array::from_fn(|i| (0..POSE).map(|k| by[i][k] * v[k]).sum()) };
        let means = mixed(core::array::from_fn(|k| self.states[first + k].mean));
        (0..POSE).for_each(|k| self.states[first + k].mean = means[k]);
        for unknown in 0..self.size {
            let place = |k: usize| (first + k) * self.size + unknown;
            let all = mixed(core::array::from_fn(|k| self.derivatives[place(k)]));
            (0..POSE).for_each(|k| self.derivatives[place(k)] = all[k]);
        }
        let own: Square<POSE> =
            core::array::from_fn(|i| core::array::from_fn(|j| self.covariance[at(first + i, first + j)]));
        for other in (0..self.states.len()).filter(|other| !(first..first + POSE).contains(other)) {
            let with = mixed(core::array::from_fn(|k| self.covariance[at(first + k, other)]));
            (0..POSE).for_each(|k| self.covariance[at(first + k, other)] = with[k]);
        }
        let moved = product(&product(by, &own), &transposed(by));
        (0..POSE).for_each(|i| (0..=i).for_each(|j| self.covariance[at(first + i, first + j)] = moved[i][j]));
    }

    /// Adds to each error's covariance with the next reading what that one has of these.
    fn count(&mut self, parts: &[(usize, f64)]) {
        for &(state, by) in parts.iter().filter(|(_, by)| *by != 0.0) {
            for (other, with) in self.with.iter_mut().enumerate() {
                *with += by * self.covariance[at(state, other)];
            }
        }
    }

    /// Variance of what a reading has of these, where it has nothing else.
    fn variance(&self, parts: &[(usize, f64)]) -> f64 {
        parts.iter().map(|&(state, by)| by * self.with[state]).sum()
    }

    /// Variance of a sensor's own error.
    pub(super) fn own_variance(&self, sensor: usize) -> f64 {
        let own = self.sensors[sensor].own;
        self.covariance[at(own, own)]
    }

    /// Takes what is known of the errors out of a residual and out of its derivatives.
    pub(super) fn take_out(&self, expected: &Expected, residual: &mut f64, derivatives: &mut [f64]) {
        for &(state, by) in expected.parts.iter().filter(|(_, by)| *by != 0.0) {
            *residual -= by * self.states[state].mean;
            let known = &self.derivatives[state * self.size..][..self.size];
            derivatives.iter_mut().zip(known).for_each(|(to, v)| *to -= by * v);
        }
    }

    /// Takes in the reading that [`Self::predict`] went on to, by its innovation, as far as that is trusted, and its variance.
    pub(super) fn learn(&mut self, (trust, variance): (f64, f64), residual: f64, innovation: &[f64]) {
        let share = trust / variance;
        for (state, &with) in self.with.iter().enumerate().filter(|(_, with)| **with != 0.0) {
            let gain = share * with;
            self.states[state].mean += gain * residual;
            let known = &mut self.derivatives[state * self.size..][..self.size];
            known.iter_mut().zip(innovation).for_each(|(to, v)| *to += gain * v);
            for (other, &with_other) in self.with[..=state].iter().enumerate() {
                self.covariance[at(state, other)] -= gain * with_other;
            }
            // An error that is not followed may be the first of a jump.
            if let Some(stationary) = self.states[state].stationary {
                let own = &mut self.covariance[at(state, state)];
                *own += (1.0 - trust) * (stationary - *own).max(0.0);
            }
        }
    }

    /// The same on a map that is turned by this angle (rad).
    pub(super) fn turn(&mut self, angle: f64) {
        let Vec2 { x: cos, y: sin } = Vec2::from_angle(angle);
        for state in 0..self.states.len() {
            let place = &mut self.derivatives[state * self.size..][..2];
            let [x, y] = [place[0], place[1]];
            (place[0], place[1]) = (cos * x - sin * y, sin * x + cos * y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::odometry_drift::{Drift, DriftSums};
    use super::*;
    use crate::linear_algebra::{Cholesky, dot};

    const COUNT: usize = 14;

    /// Signed numbers between -1 and 1.
    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Readings of two sensors in turn, some of them free, on two stretches of wall that both feel.
    fn rows(seed: &mut u64) -> Vec<Row> {
        let (mut t, mut x) = (0.0, 0.0);
        let row = |k: usize| {
            (t, x) = (t + 0.1 * random(seed).abs(), x + 0.2 * random(seed).abs());
            let stretch = (0, u32::from(random(seed) > 0.0));
            let wall = WallError { stretch, by_displacement: 3e3 * random(seed), std: 1e-3 };
            Row {
                sensor: k % 2,
                row: k,
                t,
                odom_from_whisker: Pose2::new(x, 0.0, 0.3),
                residual: 3.0 * random(seed),
                plain: 0.0,
                model_variance: 0.0,
                model_error: if k % 5 == 4 { 0.0 } else { 4.0 * random(seed) },
                held: Some(true),
                wander: 0.0,
                drift: None,
                wall: (k % 3 != 2).then_some(wall),
                unmapped: false,
            }
        };
        (0..COUNT).map(row).collect()
    }

    /// The same with poses on a walk of which the middle is held.
    fn with_drift(mut rows: Vec<Row>, seed: &mut u64) -> Vec<Row> {
        let (mut pose, mut sums) = (Pose2::default(), vec![DriftSums::default()]);
        let mut places = vec![pose.position()];
        for _ in 1..COUNT {
            let step = Pose2::new(0.1 * random(seed), 0.1 * random(seed), random(seed));
            pose = pose.compose(step);
            sums.push(sums[sums.len() - 1].with(step, pose, [0.1, 0.05]));
            places.push(pose.position());
        }
        let held = COUNT / 2;
        for (k, row) in rows.iter_mut().enumerate() {
            let by = [300.0 * random(seed), 300.0 * random(seed), 30.0 * random(seed)];
            let on_walk = OnWalk::new(places[k], sums[k], sums[held], k >= held);
            row.drift = Some(Drift { by, on_walk });
        }
        rows
    }

    /// Covariance of two readings by the walk: that of the nearer one to the held row, carried on.
    fn by_drift(a: &Row, b: &Row) -> f64 {
        let (Some(first), Some(then)) = (a.drift, b.drift) else { return 0.0 };
        let (first, then) = if a.row <= b.row { (first, then) } else { (then, first) };
        let own = first.on_walk.covariance();
        let with = product(&first.on_walk.transition(&then.on_walk).keeps, &own);
        (0..POSE).map(|i| (0..POSE).map(|j| then.by[i] * with[i][j] * first.by[j]).sum::<f64>()).sum()
    }

    /// Covariance of two readings by all that they share, written down at once.
    fn covariance(a: &Row, b: &Row, noise: NoiseModel) -> f64 {
        let mut all = if a.row == b.row { noise.white + MODEL_INDEPENDENT * a.model_error.powi(2) } else { 0.0 };
        if a.sensor == b.sensor {
            all += noise.correlated * (-(a.t - b.t).abs() / noise.time_constant).exp();
            let way = a.odom_from_whisker.position().distance(b.odom_from_whisker.position());
            let alike = (1.0 - MODEL_INDEPENDENT) * (-way / MODEL_CORRELATION_LENGTH).exp();
            all += a.model_error * b.model_error * alike;
        }
        if let (Some(one), Some(other)) = (a.wall, b.wall)
            && one.stretch == other.stretch
        {
            all += one.by_displacement * other.by_displacement * one.std * one.std;
        }
        all + by_drift(a, b)
    }

    #[test]
    fn innovations_have_the_likelihood_of_the_joint_gaussian() {
        let noise = NoiseModel { white: 0.3, correlated: 2.0, time_constant: 0.2, bounded: false };
        for mut seed in 1..40 {
            let mut rows = rows(&mut seed);
            if seed % 2 == 0 {
                rows = with_drift(rows, &mut seed);
            }
            let mut filter = ErrorFilter::default();
            filter.begin(1, 2, noise.correlated);
            let mut told = 0.0;
            for row in &rows {
                let shared = filter.predict(row, noise);
                let (mut residual, mut derivative) = (row.residual, [1.0]);
                filter.take_out(&shared, &mut residual, &mut derivative);
                let variance = shared.variance + shared.independent + noise.white;
                told += 0.5 * (variance.ln() + residual * residual / variance);
                filter.learn((1.0, variance), residual, &derivative);
            }
            let all: [[f64; COUNT]; COUNT] =
                core::array::from_fn(|i| core::array::from_fn(|j| covariance(&rows[i], &rows[j], noise)));
            let factor = Cholesky::new(&all).unwrap();
            let off = factor.whitened(&core::array::from_fn(|i| rows[i].residual));
            let joint = factor.root_determinant().ln() + 0.5 * dot(off, off);
            assert!((told - joint).abs() < 1e-9 * joint.abs().max(1.0), "{told} {joint}");
        }
    }
}
