//! What the readings say of a place, of the odometry's calibration and of the readings' gain.
//!
//! Each increment of the odometry may be off by a share of itself. What does not average out is one share for all: the path stretched,
//! sheared aside or turned too far. These three are unknowns beside the place, and so is a relative error that all readings share:
//! seven, in one information matrix. Before any reading calibration and gain have the standard deviations of the declared bounds.

use super::calibrated_path::{CALIBRATION_SIZE, CalibrationPrior, OdometryCalibration, prior_stds};
use super::information::{Conditional, Information, Prior};
use super::odometry_path::OdometryPath;
use crate::linear_algebra::{Cholesky, Square, add, inverse, times};
use crate::plane::Vec2;
use crate::world::Odometry;

/// A symmetric matrix over (x, y, theta).
pub(super) type Matrix = Square<3>;

/// The unknowns: the move of the odometry frame (x, y, heading), the odometry's calibration, the gain.
const PLACE: [usize; 3] = [0, 1, 2];
const CALIBRATION: [usize; CALIBRATION_SIZE] = [3, 4, 5];
const GAIN: usize = 6;
const ALL: usize = 7;

/// How far the calibration may wander each time that rows are marginalised (of its standard deviations).
const CALIBRATION_WANDER: f64 = 0.2;
/// Variances of a frame that does not move at all (m², rad²).
const STILL: [f64; 3] = [1e-14, 1e-14, 1e-12];

/// What the readings so far say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Belief {
    /// The information around the place, the calibration and the gain where it is linearised.
    pub(super) information: Information<ALL>,
    pub(super) way: OdometryPath,
    /// The calibration that the path has been corrected by.
    at: OdometryCalibration,
    /// Whether the calibration leaves the robot where it is at the last row, not at the first.
    from_last: bool,
}

/// The calibration given the place.
pub(super) type Response = Conditional<3, CALIBRATION_SIZE>;

impl Belief {
    /// One that is reported with its place alone, as a search finds it.
    pub(super) fn of_place(information: &Information<4>) -> Self {
        let unit = |i: usize| core::array::from_fn(|j| f64::from(u8::from(i == j)));
        let rows = [unit(0), unit(1), unit(2), unit(GAIN)];
        Self { information: information.transformed(&rows), ..Self::default() }
    }

    /// Place and gain, as long as the calibration stays what it is.
    pub(super) fn place_and_gain(&self) -> Information<4> {
        self.information.conditioned([0, 1, 2, GAIN])
    }

    /// The calibration that the path has been corrected by.
    pub(super) fn at(&self) -> OdometryCalibration {
        self.at
    }

    /// Whether the calibration leaves the robot where it is at the last row, not at the first.
    pub(super) fn is_from_last(&self) -> bool {
        self.from_last
    }

    /// Adds a reading: its residual (standard deviations, with its weight), and its derivatives by a move, by the calibration and by
    /// the gain.
    pub(super) fn add(
        &mut self,
        by: [f64; 3],
        by_calibration: [f64; CALIBRATION_SIZE],
        by_gain: f64,
        residual: (f64, f64),
    ) {
        let ([x, y, turn], [long, aside, turned]) = (by, by_calibration);
        self.information.add(&[x, y, turn, long, aside, turned, by_gain], residual.0, residual.1);
    }

    /// The same around a place that has been moved by `d`.
    pub(super) fn moved(&self, d: [f64; 3]) -> Self {
        self.shifted(d, self.at)
    }

    /// The same around a place that has been moved by `d` and another calibration.
    pub(super) fn shifted(&self, d: [f64; 3], to: OdometryCalibration) -> Self {
        let by = [0, 1, 2].map(|way| to[way] - self.at[way]);
        let information = self.information.shifted([d[0], d[1], d[2], by[0], by[1], by[2], 0.0]);
        Self { information, at: to, ..*self }
    }

    /// The same in a map that is turned by this angle.
    pub(super) fn turned(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let mut back = unit();
        (back[0][0], back[0][1], back[1][0], back[1][1]) = (cos, sin, -sin, cos);
        Self { information: self.information.transformed(&back), ..*self }
    }

    /// The same with the robot's place at a later row in the place of that at the first: `reached` is the path until there, and
    /// `arm` goes from the pivot to the robot there, in a frame turned by `theta`.
    pub(super) fn carried_on(&self, reached: &OdometryPath, theta: f64, arm: Vec2) -> Self {
        // What was a move is the move there less what the calibration does until then.
        let by = reached.holding(theta, arm);
        let mut from = unit();
        (0..3).for_each(|i| (0..CALIBRATION_SIZE).for_each(|way| from[i][CALIBRATION[way]] = by[way][i]));
        Self { information: self.information.transformed(&from), way: self.way.after(reached), ..*self }
    }

    /// The same with the robot's place at the last row in the place of that at the first, before any row has been taken; `way` is
    /// the whole path.
    pub(super) fn told_from_last(&self, way: &OdometryPath, theta: f64, arm: Vec2) -> Self {
        Self { from_last: true, ..self.carried_on(way, theta, arm) }
    }

    /// What the readings say with this share of its weight.
    pub(super) fn with_forgetting(&self, share: f64) -> Self {
        Self { information: self.information.with_forgetting(share), ..*self }
    }

    /// The same after the robot has made a random move of this covariance, and the calibration has wandered on a little.
    pub(super) fn with_process_noise(&self, covariance: &Matrix, stds: OdometryCalibration) -> Self {
        let mut own = *covariance;
        (0..3).for_each(|i| own[i][i] += STILL[i]);
        let Some(mut precision) = inverse(&own) else { return *self };
        let told = &self.information;
        add(&mut precision, &told.conditioned(PLACE).matrix);
        let information = if stds.iter().any(|&std| std <= 0.0) {
            inverse(&precision).map(|step| told.predicted(&step))
        } else {
            let mut both = told.conditioned([0, 1, 2, 3, 4, 5]).matrix;
            (0..3).for_each(|i| both[i][..3].copy_from_slice(&precision[i]));
            CALIBRATION.into_iter().zip(stds).for_each(|(i, std)| both[i][i] += (CALIBRATION_WANDER * std).powi(-2));
            Cholesky::regular(&both).map(|factor| told.predicted(&factor.inverse()))
        };
        Self { information: information.unwrap_or(*told), ..*self }
    }

    /// The place with calibration and gain marginalised: as if what they do to the readings were a correlated part of the noise.
    pub(super) fn place(&self, shared: CalibrationPrior) -> Information<3> {
        if !shared.has_odometry() {
            return self.place_on_path(shared.gain);
        }
        let [long, aside, turned] = self.priors(shared);
        let priors = [long, aside, turned, Prior { mean: 0.0, std: shared.gain }];
        let told = self.information.marginal(PLACE, [3, 4, 5, GAIN], priors);
        told.unwrap_or_else(|| self.place_on_path(shared.gain))
    }

    /// The place on the path as it has been corrected, with the gain marginalised, of this standard deviation.
    pub(super) fn place_on_path(&self, gain: f64) -> Information<3> {
        self.place_and_gain().without_gain(gain)
    }

    /// The gain that the readings estimate.
    pub(super) fn gain(&self, shared: CalibrationPrior) -> f64 {
        let left = self.information.marginal([GAIN], CALIBRATION, self.priors(shared));
        let left = left.unwrap_or_else(|| self.information.conditioned([GAIN]));
        if shared.gain > 0.0 { left.vector[0] / (left.matrix[0][0] + shared.gain.powi(-2)) } else { 0.0 }
    }

    /// The calibration given the place, as a distance from that which the path has been corrected by; none where it is not looked for.
    pub(super) fn calibration(&self, shared: CalibrationPrior) -> Option<Response> {
        shared.odometry.iter().all(|&std| std > 0.0).then_some(())?;
        self.without_gain(shared)?.conditional(CALIBRATION, PLACE, self.priors(shared))
    }

    /// The calibration that the odometry needs, each number with its standard deviation, where the place has this covariance.
    pub(super) fn calibrated(&self, given: &Response, place: &Matrix) -> [[f64; 2]; CALIBRATION_SIZE] {
        let covariance = given.wherever(place);
        [0, 1, 2].map(|way| [self.at[way] + given.mean[way], covariance[way][way].max(0.0).sqrt()])
    }

    /// The sum of squares, in standard deviations of the readings' noise, that the declared bounds may add to the residuals.
    pub(super) fn squares(&self, bounds: &Odometry) -> f64 {
        let std = prior_stds(bounds);
        (0..CALIBRATION_SIZE)
            .map(|way| std[way] * std[way] * self.information.matrix[CALIBRATION[way]][CALIBRATION[way]])
            .sum()
    }

    /// What the declared bounds add to the covariance of the robot's pose at the last row; `arm` goes from the pivot to the robot,
    /// map frame.
    pub(super) fn covariance(
        &self,
        shared: CalibrationPrior,
        open: [f64; 3],
        theta: f64,
        arm: Vec2,
        bounds: &Odometry,
    ) -> Matrix {
        let told = self.without_gain(shared).unwrap_or_else(|| self.information.conditioned([0, 1, 2, 3, 4, 5]));
        let place = told.conditioned(PLACE).covariance(open).unwrap_or_default();
        let (turned, std) = (arm.perp(), prior_stds(bounds));
        let mut out = [[0.0; 3]; 3];
        for (way, error) in self.way.errors(theta).into_iter().enumerate() {
            let d = times(&place, PLACE.map(|i| told.matrix[i][CALIBRATION[way]])).map(|v| -v);
            let off = [error[0] + d[0] + d[2] * turned.x, error[1] + d[1] + d[2] * turned.y, error[2] + d[2]];
            let variance = std[way] * std[way];
            (0..3).for_each(|i| (0..3).for_each(|j| out[i][j] += variance * off[i] * off[j]));
        }
        out
    }

    /// What is known of the calibration before any reading.
    fn priors(&self, shared: CalibrationPrior) -> [Prior; CALIBRATION_SIZE] {
        [0, 1, 2].map(|way| Prior { mean: -self.at[way], std: shared.odometry[way] })
    }

    /// Place and calibration with the gain marginalised.
    fn without_gain(&self, shared: CalibrationPrior) -> Option<Information<6>> {
        self.information.marginal([0, 1, 2, 3, 4, 5], [GAIN], [Prior { mean: 0.0, std: shared.gain }])
    }
}

fn unit() -> Square<ALL> {
    core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))))
}

#[cfg(test)]
mod tests;
