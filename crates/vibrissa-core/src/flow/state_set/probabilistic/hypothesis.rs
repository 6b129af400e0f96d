//! One hypothesis: a place with the normal equations of a Gauss-Newton step over all readings \[dellaert2017factor, ch. 2\].
//! It is relinearised only when its estimate has moved, as in \[kaess2012isam2\].
//!
//! With the odometry given, the unknown is the pose of the odometry frame in the map, three numbers. Each reading adds
//! one line to the normal equations of a Gauss-Newton step around the point where the hypothesis was last linearised;
//! linearising again runs the whole history through the forward model, so that the estimate is that of a batch, not of
//! a filter that cannot take back its first steps.

use super::calibrated_path::{CalibrationPrior, OdometryCalibration};
use super::information::Information;
use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetry;
use super::odometry_calibration::{Belief, Matrix};
use super::odometry_path::OdometryPath;
use super::relinearisation::Relinearisation;
use super::sensor::{LikelihoodOptions, Sensor};
use crate::contact::Boundaries;
use crate::contact::follow::{ForwardModel, Mechanics, WhiskerState};
use crate::plane::{Pose2, Vec2};
use crate::world::Map;

/// What all hypotheses share.
pub(super) struct MeasurementModel<'a> {
    pub(super) map: &'a Map,
    pub(super) ground: &'a Boundaries,
    pub(super) sensors: &'a [Sensor],
    pub(super) history: &'a LogWindow,
    /// The place that turns leave where it is, odometry frame (m).
    pub(super) pivot: Vec2,
    pub(super) likelihood: LikelihoodOptions,
    pub(super) shared: CalibrationPrior,
    /// Whether steep readings are trusted less, for covariances that hold over more than a facet of the map.
    pub(super) model_error: bool,
    /// Standard deviation of the absolute headings' one error (rad).
    pub(super) heading_std: f64,
    /// How exactly the forward model is solved.
    pub(super) solver: Mechanics<'a>,
    /// Whether it looks at the whole whisker, not only at its contact.
    pub(super) whole: bool,
}

impl<'a> MeasurementModel<'a> {
    /// The forward model of a sense.
    pub(super) fn forward(&self, sensor: &'a Sensor) -> ForwardModel<'a> {
        let (length, mechanics, quantity) = (sensor.length, sensor.solver(self.solver), sensor.quantity);
        let base = None;
        ForwardModel { map: self.map, boundaries: self.ground, length, mechanics, whole: self.whole, quantity, base }
    }
}

/// So many rows are run before it is asked whether to go on.
pub(super) const CHECK_EVERY: usize = 3;
/// How exactly the model is believed to know where the whisker stands (m, rad).
const MODEL_STD: [f64; 2] = [5e-5, 5e-4];

/// Weight of what is marginalised, each time that rows are added to it.
const FORGETTING: f64 = 0.8;

/// What rows usually cost: the best one's cost after each of them; and how much more is too much.
#[derive(Clone, Copy)]
pub(super) struct CostLimits<'a> {
    pub(super) reference_costs: &'a [f64],
    pub(super) more: f64,
}

/// One place that may be the true one.
#[derive(Clone, Debug)]
pub(super) struct GaussianHypothesis {
    /// Where it is linearised: the odometry frame in the map frame.
    pub(super) map_from_odom: Pose2,
    /// What the readings up to `row` say.
    pub(super) belief: Belief,
    /// Sine and cosine of its heading.
    turned: (f64, f64),
    /// What [`GaussianHypothesis::damped_step`] said when it was last asked by [`GaussianHypothesis::update_prediction`].
    pub(super) predicted: (f64, [f64; 3]),
    /// How many rows it has taken since it was linearised.
    pub(super) age: usize,
    /// Whether it is to be relinearised before it is dropped; until then it takes no rows.
    pub(super) is_pending: bool,
    /// How often that has been done in turn, when it was about to be dropped again.
    pub(super) retries: u32,
    /// Rows for which it is not refitted with tempering to readings that seem false, since it has just been.
    pub(super) cooldown: usize,
    /// The last row used.
    pub(super) row: usize,
    /// How each whisker stands to the map there.
    pub(super) states: Vec<WhiskerState>,
    /// The residual of each whisker's last reading, in standard deviations.
    pub(super) normalised_residual: Vec<f64>,
    /// The moment that each is predicted to feel there.
    pub(super) predictions: Vec<f64>,
    /// How each stood at the row from which on this is judged, when the odometry frame was at `start_at`.
    start: Vec<WhiskerState>,
    start_row: usize,
    start_at: Pose2,
    /// The odometry at that row then, where that may change.
    start_odom: Option<Pose2>,
    /// What readings before that row said, around `start_at`.
    prior: Belief,
    /// The heading of the cell that it comes from, if it has come to the same as all of that heading on straight walls.
    pub(super) heading_class: Option<u32>,
    /// Its run through the history from elsewhere, as long as that is under way.
    pub(super) relinearisation: Option<Box<Relinearisation>>,
}

/// The frame moved by `d`: shifted by (x, y) and turned about the pivot.
pub(super) fn moved(map_from_odom: Pose2, pivot: Vec2, d: [f64; 3]) -> Pose2 {
    let center = map_from_odom.transform_point(pivot);
    let place = center + (map_from_odom.position() - center).rotated(d[2]) + Vec2::new(d[0], d[1]);
    Pose2::new(place.x, place.y, map_from_odom.theta + d[2])
}

/// From the pivot to the robot (m, map frame) with the odometry at `odom_from_robot`.
pub(super) fn arm(map_from_odom: Pose2, pivot: Vec2, odom_from_robot: Pose2) -> Vec2 {
    map_from_odom.transform_point(odom_from_robot.position()) - map_from_odom.transform_point(pivot)
}

/// The move that takes one frame to another.
pub(super) fn difference(from: Pose2, to: Pose2, pivot: Vec2) -> [f64; 3] {
    let shift = to.transform_point(pivot) - from.transform_point(pivot);
    [shift.x, shift.y, crate::plane::wrap_angle(to.theta - from.theta)]
}

impl GaussianHypothesis {
    /// A hypothesis whose whiskers stand so at `row`, from which on it is judged.
    pub(super) fn new(map_from_odom: Pose2, states: Vec<WhiskerState>, row: usize) -> Self {
        Self {
            map_from_odom,
            turned: map_from_odom.theta.sin_cos(),
            predicted: (0.0, [0.0; 3]),
            belief: Belief::default(),
            age: 0,
            is_pending: false,
            retries: 0,
            cooldown: 0,
            heading_class: None,
            row,
            start: states.clone(),
            start_row: row,
            start_at: map_from_odom,
            start_odom: None,
            prior: Belief::default(),
            relinearisation: None,
            normalised_residual: vec![0.0; states.len()],
            predictions: vec![0.0; states.len()],
            states,
        }
    }

    /// The same on a map that is symmetric.
    pub(super) fn turned(&self, turn: &MapSymmetry) -> Self {
        self.transformed(turn.motion, &|state| state.turned(turn.motion, &|piece| turn.piece(piece)))
    }

    /// The same elsewhere, where the piece that its tip is on goes to another.
    pub(super) fn slid(&self, motion: Pose2, to: &dyn Fn((u32, f64)) -> (u32, f64)) -> Self {
        self.transformed(motion, &|state| state.slid(motion, to))
    }

    /// The same where the odometry frame is at `frame` and its whiskers begin to be judged in these states; what earlier
    /// readings said goes with it.
    pub(super) fn transformed_to(&self, frame: Pose2, start: Vec<WhiskerState>, pivot: Vec2) -> Self {
        let motion = frame.compose(self.map_from_odom.inverse());
        let there = self.transformed(motion, &|state| *state);
        let d = difference(there.start_at, frame, pivot);
        let prior = there.prior.moved(d);
        Self { states: start.clone(), start, start_at: frame, start_odom: None, prior, ..there }
    }

    /// How each whisker stands to the map where it begins to be judged.
    pub(super) fn start(&self) -> &[WhiskerState] {
        &self.start
    }

    /// The piece on which its first whisker is held where it begins to be judged.
    pub(super) fn start_piece(&self) -> Option<(u32, f64)> {
        self.start.first().and_then(WhiskerState::on_piece)
    }

    /// The same in a map that is moved.
    fn transformed(&self, motion: Pose2, state: &dyn Fn(&WhiskerState) -> WhiskerState) -> Self {
        let angle = motion.theta;
        let map_from_odom = motion.compose(self.map_from_odom);
        let (cost, d) = self.predicted;
        let shift = Vec2::new(d[0], d[1]).rotated(angle);
        let all = |states: &[WhiskerState]| states.iter().map(state).collect();
        Self {
            map_from_odom,
            turned: map_from_odom.theta.sin_cos(),
            predicted: (cost, [shift.x, shift.y, d[2]]),
            belief: self.belief.turned(angle),
            prior: self.prior.turned(angle),
            states: all(&self.states),
            start: all(&self.start),
            start_at: motion.compose(self.start_at),
            relinearisation: None,
            normalised_residual: self.normalised_residual.clone(),
            predictions: self.predictions.clone(),
            ..*self
        }
    }

    /// One at this place, to be judged from the history's first row on, where all whiskers were free.
    pub(super) fn free_at(&self, map_from_odom: Pose2) -> Self {
        Self::new(map_from_odom, vec![WhiskerState::Free; self.states.len()], 0)
    }

    /// Whether it is judged from the first row on, where all whiskers were free.
    pub(super) fn starts_free(&self) -> bool {
        self.start_row == 0 && self.start.iter().all(|state| *state == WhiskerState::Free)
    }

    /// Takes in the row `row`, which must not be before the last one.
    pub(super) fn add_row(&mut self, model: &MeasurementModel<'_>, row: usize) {
        let (sin, cos) = self.turned;
        let at = |p: Vec2| self.map_from_odom.position() + Vec2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y);
        let pivot = at(model.pivot);
        let follows = model.shared.has_odometry();
        if follows {
            self.belief.way.travel(model.history.pose(self.row), model.history.pose(row));
        }
        for (index, sensor) in model.sensors.iter().enumerate() {
            let z = model.history.readings(row)[index];
            let place = |odom: Pose2| {
                let (x, y) = (cos * odom.x - sin * odom.y, sin * odom.x + cos * odom.y);
                Pose2 {
                    x: self.map_from_odom.x + x,
                    y: self.map_from_odom.y + y,
                    theta: self.map_from_odom.theta + odom.theta,
                }
            };
            let there = place(model.history.base(row, index));
            let forward = model.forward(sensor);
            let felt = forward.advance(
                &mut self.states[index],
                place(model.history.base(self.row, index)),
                there,
                sensor.is_contact(z),
            );
            let misfit = match self.states[index] {
                WhiskerState::Unknown => Sensor::uncovered(),
                WhiskerState::Free => sensor.weighted_residual(0.0, z, false, false, model.likelihood),
                WhiskerState::Touching(touch) => {
                    sensor.weighted_residual(felt.value, z, touch.q > 0.0, true, model.likelihood)
                }
            };
            self.belief.information.constant += misfit.cost;
            self.normalised_residual[index] = misfit.normalised_residual;
            self.predictions[index] = felt.value;
            if misfit.weight > 0.0 {
                let arm = (there.position() - pivot).perp();
                let [gx, gy, turn] = felt.gradient;
                // Where the moment is steep, near a snap or in a slight corner, it is so over a tiny range only.
                let steep = MODEL_STD[0].powi(2) * (gx * gx + gy * gy) + MODEL_STD[1].powi(2) * turn * turn;
                let weight =
                    if model.model_error { misfit.weight / (1.0 + misfit.weight * steep) } else { misfit.weight };
                let by = [gx, gy, turn + gx * arm.x + gy * arm.y];
                let by_calibration = if follows {
                    let robot = at(model.history.pose(row).position());
                    self.belief.way.slopes(self.map_from_odom.theta, there.position() - robot, felt.gradient)
                } else {
                    [0.0; 3]
                };
                self.belief.add(by, by_calibration, felt.value, (misfit.residual, weight));
            }
        }
        self.row = row;
        self.age += 1;
    }

    /// Runs the history anew with the odometry frame at `map_from_odom`, row by row as listed.
    pub(super) fn relinearise(
        &mut self,
        model: &MeasurementModel<'_>,
        map_from_odom: Pose2,
        rows: impl Iterator<Item = usize>,
    ) {
        self.restart(model, map_from_odom);
        if let Some(heading) = model.history.heading() {
            let off = crate::plane::wrap_angle(map_from_odom.theta - heading);
            let weight = model.heading_std.powi(-2);
            self.belief.add([0.0, 0.0, 1.0], [0.0; 3], 0.0, (off, weight));
            self.belief.information.constant += 0.5 * weight * off * off;
        }
        rows.for_each(|row| {
            self.add_row(model, row);
        });
        self.age = 0;
    }

    /// The same moved by `d` at the row that it has come to, with its whiskers taken along.
    pub(super) fn shifted(&self, model: &MeasurementModel<'_>, d: [f64; 3]) -> Self {
        let mut there = self.clone();
        let frame = moved(self.map_from_odom, model.pivot, d);
        for (index, (state, sensor)) in there.states.iter_mut().zip(model.sensors).enumerate() {
            let base = model.history.base(self.row, index);
            model.forward(sensor).advance(state, self.map_from_odom.compose(base), frame.compose(base), false);
        }
        (there.map_from_odom, there.turned) = (frame, frame.theta.sin_cos());
        there.belief = self.belief.moved(d);
        there
    }

    /// Puts the odometry frame to `map_from_odom` and goes back to the first row, before any reading.
    fn restart(&mut self, model: &MeasurementModel<'_>, map_from_odom: Pose2) {
        let first = model.history.pose(self.start_row);
        // Where the frame would be if it had stayed where it was at that row, while the odometry was corrected.
        let began = self.start_odom.map_or(self.start_at, |odom| self.start_at.compose(odom).compose(first.inverse()));
        for (state, sensor) in self.start.iter_mut().zip(model.sensors) {
            let place = |frame: Pose2| frame.compose(first).compose(sensor.robot_from_whisker);
            model.forward(sensor).advance(state, place(began), place(map_from_odom), false);
        }
        let from = if self.prior.is_from_last() { self.start_at } else { began };
        let d = difference(from, map_from_odom, model.pivot);
        let mut prior = self.prior.moved(d);
        if let Some(way) = model.history.whole().filter(|_| !prior.is_from_last()) {
            let last = model.history.pose(model.history.len() - 1);
            prior = prior.told_from_last(way, map_from_odom.theta, arm(map_from_odom, model.pivot, last));
        }
        self.start_odom = model.shared.has_odometry().then_some(first);
        self.prior = prior.shifted([0.0; 3], model.history.calibration());
        self.start_at = map_from_odom;
        self.map_from_odom = map_from_odom;
        self.turned = map_from_odom.theta.sin_cos();
        self.belief = self.prior;
        self.is_pending = false;
        self.relinearisation = None;
        self.states.clone_from(&self.start);
        self.row = self.start_row;
        if model.shared.has_odometry() {
            self.belief.way.travel(model.history.pose(0), first);
        }
    }

    /// Goes over to a path corrected by other calibration parameters; at the last row the robot is at `last` as before, at the first it was at `first`
    /// (odometry frame), and `way` is what lay between. What the readings say is reported around the new path, to first order.
    pub(super) fn correct(
        &mut self,
        way: &OdometryPath,
        [first, last]: [Pose2; 2],
        pivot: Vec2,
        to: OdometryCalibration,
    ) {
        let at = self.belief.at();
        let mut d = [0.0; 3];
        if !self.belief.is_from_last() {
            let back = way.holding(self.map_from_odom.theta, arm(self.map_from_odom, pivot, last));
            (0..3).for_each(|i| d[i] = (0..3).map(|k| back[k][i] * (to[k] - at[k])).sum());
        }
        self.belief = self.belief.shifted(d, to);
        self.start_odom.get_or_insert(first);
        self.relinearisation = None;
    }

    /// Marginalises what these rows say, the last of which is to become the first that is kept; `process_noise` is what odometry may
    /// have added since then, as a covariance.
    pub(super) fn marginalise(&mut self, model: &MeasurementModel<'_>, rows: &[usize], process_noise: &Matrix) {
        let Some(&last) = rows.last() else { return };
        let mut early = self.clone();
        early.restart(model, self.map_from_odom);
        rows.iter().for_each(|&row| early.add_row(model, row));
        let theta = self.map_from_odom.theta;
        let arm = arm(self.map_from_odom, model.pivot, model.history.pose(last));
        self.start_odom = model.shared.has_odometry().then_some(model.history.pose(last));
        let told = early.belief.carried_on(&early.belief.way, theta, arm);
        self.prior = told.with_process_noise(process_noise, model.shared.odometry).with_forgetting(FORGETTING);
        self.belief = self.belief.carried_on(&early.belief.way, theta, arm);
        (self.start, self.start_row, self.start_at) = (early.states, 0, self.map_from_odom);
        self.row = self.row.saturating_sub(last);
        self.relinearisation = None;
    }

    /// Runs the history anew as [`GaussianHypothesis::relinearise`] does, until it has cost more than these limits; whether it has not.
    pub(super) fn relinearise_below(
        &mut self,
        model: &MeasurementModel<'_>,
        map_from_odom: Pose2,
        rows: &[usize],
        most: CostLimits<'_>,
    ) -> bool {
        self.relinearise(model, map_from_odom, core::iter::empty());
        for (some, reference_costs) in rows.chunks(CHECK_EVERY).zip(most.reference_costs.chunks(CHECK_EVERY)) {
            some.iter().for_each(|&row| self.add_row(model, row));
            if self.cost(model.shared) > reference_costs[reference_costs.len() - 1] + most.more {
                return false;
            }
        }
        self.age = 0;
        true
    }

    /// What it costs after each of these rows.
    pub(super) fn costs(&self, model: &MeasurementModel<'_>, rows: &[usize]) -> Vec<f64> {
        let mut again = self.clone();
        again.relinearise(model, self.map_from_odom, core::iter::empty());
        let mut after = |&row: &usize| {
            again.add_row(model, row);
            again.cost(model.shared)
        };
        rows.iter().map(&mut after).collect()
    }

    /// Keeps what the readings promise now; one that waits has not taken all of them, and costs what it is taken to.
    pub(super) fn update_prediction(&mut self, damping: [f64; 3], shared: CalibrationPrior) {
        let (cost, d) = self.damped_step(damping, shared);
        self.predicted = (if self.is_pending { self.predicted.0 } else { cost }, d);
    }

    /// What it will cost once it is moved to its best place, as far as is known.
    pub(super) fn predicted_cost(&self, damping: [f64; 3], shared: CalibrationPrior) -> f64 {
        if self.is_pending { self.predicted.0 } else { self.damped_step(damping, shared).0 }
    }

    /// The cost where it is linearised.
    pub(super) fn cost(&self, shared: CalibrationPrior) -> f64 {
        self.marginal(shared).constant
    }

    /// The cost where it is linearised with the odometry as it has been corrected, whatever other calibration parameters would promise.
    pub(super) fn cost_on_path(&self, shared: CalibrationPrior) -> f64 {
        self.cost(shared) + self.belief.calibration(shared).map_or(0.0, |response| response.fall)
    }

    /// What the readings say about moves, whatever errors they share.
    pub(super) fn marginal(&self, shared: CalibrationPrior) -> Information<3> {
        self.belief.place(shared)
    }

    /// The relative error that all readings share, as they estimate it.
    pub(super) fn gain(&self, shared: CalibrationPrior) -> f64 {
        self.belief.gain(shared)
    }

    /// The least cost that the linearisation predicts, whatever the errors that all readings share, of these standard deviations; and
    /// the step to where it is least as long as the odometry is not corrected any further.
    pub(super) fn damped_step(&self, damping: [f64; 3], shared: CalibrationPrior) -> (f64, [f64; 3]) {
        let (cost, d) = self.calibrated_step(damping, shared);
        if self.keeps_path(shared) {
            (cost, self.belief.place_on_path(shared.gain).least(damping).1)
        } else {
            (cost, d)
        }
    }

    /// Whether it is moved along the path as it has been corrected; at the end it goes where the last row is best, whatever the path.
    fn keeps_path(&self, shared: CalibrationPrior) -> bool {
        shared.has_odometry() && !self.belief.is_from_last()
    }

    /// The same with the step for the odometry corrected as this hypothesis would have it.
    pub(super) fn calibrated_step(&self, damping: [f64; 3], shared: CalibrationPrior) -> (f64, [f64; 3]) {
        self.marginal(shared).least(damping)
    }

    /// The step of [`GaussianHypothesis::damped_step`], and what it will cost there as far as is known.
    pub(super) fn damped_step_cost(&self, damping: [f64; 3], shared: CalibrationPrior) -> (f64, [f64; 3]) {
        let (cost, d) = self.damped_step(damping, shared);
        if self.keeps_path(shared) { (self.marginal(shared).shifted(d).constant, d) } else { (cost, d) }
    }
}
