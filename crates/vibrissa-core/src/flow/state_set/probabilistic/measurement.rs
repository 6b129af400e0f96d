//! Measurement model of a log: what every reading of a window is predicted to be by a hypothesis, with derivatives by pose and
//! nuisance parameters \[dellaert2017factor, ch. 2\].

use super::corrected_path::{OdometryCalibration, PathPoint, corrected_path};
use super::log_window::LogWindow;
use super::normal_equations::NormalEquations;
use super::odometry_drift::Drift;
use super::optimisation::UNEXPLAINED;
use super::sensor::Sensor;
use super::state::{Prior, Start, State, difference};
use super::unknowns::{POSE, Unknowns, value};
use super::wall_error::WallError;
use crate::config::NoiseAssumption;
use crate::contact::follow::{Contact, ForwardModel, Mechanics, Prediction, WhiskerState};
use crate::contact::{Boundaries, Hold, SensedQuantity, Support, WallKnowledge};
use crate::coroutine::{Pace, Pause};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::Map;

/// How exactly the model is believed to know where the whisker stands (m, rad): near a snap or in a slight corner the moment is steep
/// over a tiny range only.
const MODEL_STD: [f64; 2] = [5e-5, 5e-4];
/// Units of work of a reading that is run through the forward model.
const READING: usize = 10;

/// What all hypotheses share.
#[derive(Clone, Copy)]
pub(super) struct MeasurementModel<'a> {
    pub(super) map: &'a Map,
    pub(super) ground: &'a Boundaries,
    pub(super) sensors: &'a [Sensor],
    /// The whisker of each sensor.
    pub(super) whiskers: &'a [usize],
    pub(super) unknowns: &'a Unknowns,
    pub(super) window: &'a LogWindow,
    /// The row at which the corrected path is where the odometry says.
    pub(super) anchor: usize,
    /// Standard deviation of the absolute headings' one error (rad).
    pub(super) heading_std: f64,
    /// How exactly the forward model is solved, and whether it looks at the whole whisker.
    pub(super) solver: Mechanics<'a>,
    pub(super) whole: bool,
    /// How the readings' errors hang together.
    pub(super) noise_model: NoiseAssumption,
    /// When work pauses.
    pub(super) pace: &'a Pace,
}

/// A linearised reading: residual and derivatives in standard deviations of the declared noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) sensor: usize,
    pub(super) row: usize,
    pub(super) t: f64,
    /// The whisker by the odometry.
    pub(super) odom_from_whisker: Pose2,
    pub(super) residual: f64,
    /// The plain residual, not stabilised.
    pub(super) plain: f64,
    /// Variance that the model adds.
    pub(super) model_variance: f64,
    /// What one standard deviation of the model's error makes of it: a whisker that bends to the other side reads the opposite of it.
    pub(super) model_error: f64,
    /// What errors of the odometry's increments make of it: of the place (1/m, odometry frame) and of the heading (1/rad) there.
    pub(super) drift: Option<Drift>,
    /// Whether a boundary holds the whisker; none where the contact is not known.
    pub(super) held: Option<bool>,
    /// By how much a contact that is not known may have changed since the reading before (standard deviations of the declared noise).
    pub(super) wander: f64,
    /// What the wall's error makes of it, where the wall is known within a band.
    pub(super) wall: Option<WallError>,
    /// Whether the whisker is where the map knows nothing, and feels what the map does not explain.
    pub(super) unmapped: bool,
}

/// The readings of a run and their derivatives.
#[derive(Clone, Debug, Default)]
pub(super) struct Linearisation {
    pub(super) size: usize,
    pub(super) rows: Vec<Row>,
    derivatives: Vec<f64>,
    path: Vec<PathPoint>,
}

impl Linearisation {
    /// The derivatives of the `k`-th reading.
    pub(super) fn derivatives(&self, k: usize) -> &[f64] {
        &self.derivatives[k * self.size..(k + 1) * self.size]
    }

    /// The rows with readings that are further off than noise.
    pub(super) fn unexplained(&self) -> Vec<usize> {
        self.rows.iter().filter(|row| row.plain.abs() > UNEXPLAINED).map(|row| row.row).collect()
    }

    /// The same with those of contacts that are not known.
    pub(super) fn unexplained_or_unknown(&self) -> Vec<usize> {
        let is_open = |row: &&Row| row.plain.abs() > UNEXPLAINED || (row.held.is_none() && !row.unmapped);
        self.rows.iter().filter(is_open).map(|row| row.row).collect()
    }
}

/// A whisker as the nuisance parameters make it, in the metres of the map as it is drawn.
struct Adjusted {
    mount: Pose2,
    length: f64,
    stretch: f64,
    gain: f64,
    zero: f64,
    drift: f64,
}

impl<'a> MeasurementModel<'a> {
    /// The place that turns of a frame leave where it is, odometry frame (m).
    pub(super) fn pivot(&self) -> Vec2 {
        self.window.pose(self.anchor).position()
    }

    /// The robot at these rows, in order, by the odometry as the nuisance parameters calibrate it, in the metres of the map as it is drawn: at
    /// the anchor it stays where the odometry says.
    fn path(&self, values: &[f64], rows: &[usize], out: &mut Vec<PathPoint>) {
        match self.unknowns.odometry {
            Some(at) => {
                let calibration: OdometryCalibration = [0, 1, 2].map(|k| values[at - POSE + k]);
                corrected_path(self.window, rows, self.anchor, calibration, out);
            }
            None => {
                let exact = |&row: &usize| PathPoint { pose: self.window.pose(row), ..PathPoint::default() };
                out.clear();
                out.extend(rows.iter().map(exact));
            }
        }
        if self.unknowns.map_scale.is_some() {
            let per = 1.0 / self.map_scale(values);
            out.iter_mut().for_each(|point| *point = point.drawn(per, self.pivot()));
        }
    }

    /// The robot's velocity at a row, its own frame (m/s by the map as it is drawn, rad/s).
    fn velocity(&self, row: usize, values: &[f64]) -> Pose2 {
        let (v, per) = (self.window.velocity(row), 1.0 / self.map_scale(values));
        Pose2 { x: v.x * per, y: v.y * per, theta: v.theta }
    }

    /// How many metres of the world a metre of the map stands for.
    fn map_scale(&self, values: &[f64]) -> f64 {
        1.0 + value(values, self.unknowns.map_scale).max(-0.5)
    }

    fn adjusted(&self, index: usize, values: &[f64]) -> Adjusted {
        let (sensor, whisker, u) = (&self.sensors[index], self.whiskers[index], self.unknowns);
        let Pose2 { mut x, mut y, mut theta } = sensor.robot_from_whisker;
        if let Some(at) = u.mount[whisker].map(|at| at - POSE) {
            (x, y, theta) = (x + values[at], y + values[at + 1], theta + values[at + 2]);
        }
        let stretch = 1.0 + value(values, u.length[whisker]).max(-0.5);
        let per = 1.0 / self.map_scale(values);
        Adjusted {
            mount: Pose2 { x: x * per, y: y * per, theta },
            length: sensor.length * stretch * per,
            stretch,
            gain: 1.0 + value(values, u.gain[index]),
            zero: value(values, u.zero[index]),
            drift: value(values, u.drift[index]),
        }
    }

    fn forward(&self, sensor: &'a Sensor, length: f64) -> ForwardModel<'a> {
        let (mechanics, quantity) = (sensor.solver(self.solver), sensor.quantity);
        ForwardModel {
            map: self.map,
            boundaries: self.ground,
            length,
            mechanics,
            whole: self.whole,
            quantity,
            base: sensor.base,
        }
    }

    /// Lets zeros wander by the declared noise: an error that stays alike, within its bound, for as long as rows are kept is another one
    /// afterwards. A step of a random walk in information form \[barshalom2001estimation, sec. 7.2\].
    pub(super) fn loosen(&self, equations: &mut NormalEquations) {
        if self.noise_model == NoiseAssumption::Independent {
            return;
        }
        for (sensor, zero) in self.sensors.iter().zip(&self.unknowns.zero) {
            zero.iter().for_each(|&at| equations.loosen(at, sensor.absolute_bound().powi(2)));
        }
    }

    /// Runs the forward model over these rows, in order; gives how the whiskers stand at the last one and where they are.
    pub(super) async fn run(&self, state: &State, start: &Start, rows: &[usize], out: &mut Linearisation) -> Start {
        let values = &state.values;
        out.size = self.unknowns.size();
        out.rows.clear();
        out.derivatives.clear();
        let mut path = core::mem::take(&mut out.path);
        self.path(values, rows, &mut path);
        let adjusted: Vec<Adjusted> = (0..self.sensors.len()).map(|index| self.adjusted(index, values)).collect();
        let mut end = start.clone();
        let began = |k: usize| -> Option<Pose2> { start.bases.get(k).copied() };
        let mut bases: Vec<Option<Pose2>> = (0..self.sensors.len()).map(began).collect();
        for (&row, point) in rows.iter().zip(&path) {
            let mut robot = state.frame.compose(point.pose);
            if let Some(at) = self.unknowns.delay {
                let (v, late) = (self.velocity(row, values), values[at - POSE]);
                robot = robot.compose(Pose2 { x: v.x * late, y: v.y * late, theta: v.theta * late });
            }
            for (index, own) in adjusted.iter().enumerate() {
                let sensor = &self.sensors[index];
                let base = robot.compose(own.mount);
                if self.window.is_aside(row, index) {
                    // When it is free again it is met anew.
                    (end.states[index], bases[index]) = (WhiskerState::Free, None);
                    continue;
                }
                let z = self.window.readings(row)[index];
                let offset = own.zero + own.drift * self.window.since_start(row);
                let felt = self.forward(sensor, own.length).advance(
                    &mut end.states[index],
                    bases[index].unwrap_or(base),
                    base,
                    sensor.is_contact(z - offset),
                );
                let wander = sensor.wander(bases[index].replace(base).unwrap_or(base), base, z - offset);
                let seen = Seen { row, index, robot, base, wander, felt, offset, z };
                self.linearise(&seen, own, &end.states[index], (state, point), out);
                self.works(1).await;
            }
        }
        out.path = path;
        end.bases = bases.into_iter().map(Option::unwrap_or_default).collect();
        end
    }

    /// Says that work as of so many readings is done, after which there may be a pause.
    pub(super) fn works(&self, readings: usize) -> Pause<'a> {
        self.pace.spend(READING * readings)
    }

    /// Adds one reading to the linearisation.
    fn linearise(
        &self,
        seen: &Seen,
        own: &Adjusted,
        whisker: &WhiskerState,
        (state, point): (&State, &PathPoint),
        out: &mut Linearisation,
    ) {
        let (sensor, u) = (&self.sensors[seen.index], self.unknowns);
        let power = match sensor.quantity {
            SensedQuantity::Moment => 1,
            SensedQuantity::Force => 2,
            SensedQuantity::Slope => 0,
        };
        let per = own.gain / own.stretch.powi(power);
        let first = out.derivatives.len();
        out.derivatives.resize(first + out.size, 0.0);
        let j = &mut out.derivatives[first..];
        let mut row = Row {
            sensor: seen.index,
            row: seen.row,
            t: self.window.time(seen.row),
            odom_from_whisker: self.window.pose(seen.row).compose(sensor.robot_from_whisker),
            residual: 0.0,
            plain: 0.0,
            model_variance: 0.0,
            model_error: 0.0,
            drift: None,
            held: None,
            wander: 0.0,
            wall: None,
            unmapped: false,
        };
        let z = seen.z - seen.offset;
        let (touch, residual) = match whisker {
            WhiskerState::Unknown => {
                row.wander = seen.wander;
                out.rows.push(row);
                return;
            }
            WhiskerState::Free => (None, sensor.residual(0.0, z, false, false)),
            WhiskerState::Touching(touch) => {
                (Some(touch), sensor.residual(per * seen.felt.value, z, touch.q > 0.0, true))
            }
        };
        if let Some(touch) = touch {
            match self.ground.knowledge(support(touch)) {
                WallKnowledge::Band { std, stretch } if residual.informs => {
                    row.wall = Some(WallError::new(
                        seen.felt.gradient,
                        per / residual.std,
                        (std, stretch),
                        seen.felt.value > 0.0,
                    ));
                }
                WallKnowledge::Unknown => {
                    row.unmapped = true;
                    out.rows.push(row);
                    return;
                }
                WallKnowledge::Exact | WallKnowledge::Band { .. } => {}
            }
        }
        let widened = row.wall.map_or(1.0, |wall| 1.0 + wall.variance()).sqrt();
        (row.residual, row.plain) = (residual.value, residual.plain / widened);
        if row.plain.abs() > UNEXPLAINED && self.is_unmapped(seen, own, touch) {
            row.unmapped = true;
            out.rows.push(row);
            return;
        }
        row.held = Some(touch.is_some_and(|touch| touch.q > 0.0));
        let scale = 1.0 / residual.std;
        if let Some(touch) = touch.filter(|_| residual.informs) {
            let steep = self.by_contact(seen, own, touch, (state, point), per * scale, j);
            row.model_variance = steep;
            row.model_error = steep.sqrt().copysign(seen.felt.value);
            if self.window.drifts() {
                let force = Vec2::new(j[0], j[1]);
                let arm = seen.robot.position() - state.frame.transform_point(self.pivot());
                let by = force.rotated(-state.frame.theta);
                let on_walk = self.window.on_walk(seen.row, self.anchor);
                let drift = Drift { by: [by.x, by.y, j[2] - force.dot(arm.perp())], on_walk };
                row.plain /= (1.0 + drift.variance()).sqrt();
                row.drift = Some(drift);
            }
            if let Some(at) = u.gain[seen.index] {
                j[at] = scale * seen.felt.value / own.stretch.powi(power);
            }
            if let Some(at) = u.length[self.whiskers[seen.index]] {
                j[at] -= scale * f64::from(power) * per * seen.felt.value / own.stretch;
            }
        }
        if residual.informs || touch.is_some() {
            if let Some(at) = u.zero[seen.index] {
                j[at] = scale;
            }
            if let Some(at) = u.drift[seen.index] {
                j[at] = scale * self.window.since_start(seen.row);
            }
        }
        out.rows.push(row);
    }

    /// Whether the whisker, from its base to its contact or at rest, goes through a place of which the map knows nothing.
    fn is_unmapped(&self, seen: &Seen, own: &Adjusted, touch: Option<&Contact>) -> bool {
        let rest = || seen.base.transform_point(Vec2::new(own.length, 0.0));
        let end = touch.map_or_else(rest, |touch| touch.place);
        self.map.unknown().may_meet([seen.base.position(), end], 0.0)
    }

    /// Derivatives by pose and by all that moves the whisker; gives the variance that a slightly wrong pose makes.
    fn by_contact(
        &self,
        seen: &Seen,
        own: &Adjusted,
        touch: &Contact,
        (state, point): (&State, &PathPoint),
        scale: f64,
        j: &mut [f64],
    ) -> f64 {
        let (u, Prediction { gradient, .. }) = (self.unknowns, seen.felt);
        let map_scale = self.map_scale(&state.values);
        let whisker = self.whiskers[seen.index];
        let force = Vec2::new(gradient[0], gradient[1]) * scale;
        let turning = gradient[2] * scale;
        let base = seen.base.position();
        let moves = |place: Vec2, turn: f64, arm: Vec2| force.dot(place + arm.perp() * turn) + turning * turn;
        let center = state.frame.transform_point(self.pivot());
        (j[0], j[1], j[2]) = (force.x, force.y, moves(Vec2::ZERO, 1.0, base - center));
        let arm = base - seen.robot.position();
        if let Some(at) = u.odometry {
            for (k, sway) in point.by_calibration.iter().enumerate() {
                j[at + k] = moves(sway.place.rotated(state.frame.theta), sway.turn, arm);
            }
        }
        if let Some(at) = u.delay {
            let v = self.velocity(seen.row, &state.values);
            j[at] = moves(v.position().rotated(seen.robot.theta), v.theta, arm);
        }
        let contact = touch.place;
        if let Some(at) = u.map_scale {
            // All that is not of the map shrinks about the anchor, and around its contact a boundary looks the same from near and from far.
            j[at] = force.dot(center - contact) / map_scale;
        }
        if let Some(at) = u.mount[whisker] {
            let forward = Vec2::from_angle(seen.robot.theta);
            let [x, y] = [forward, forward.perp()].map(|axis| force.dot(axis) / map_scale);
            (j[at], j[at + 1], j[at + 2]) = (x, y, turning);
        }
        if let Some(at) = u.length[whisker] {
            j[at] = -force.dot(base - contact) / own.stretch;
        }
        MODEL_STD[0].powi(2) * force.norm_squared() + (MODEL_STD[1] * turning).powi(2)
    }

    /// What is known beside the readings at a state: absolute headings, nuisance parameters, marginalised rows.
    pub(super) fn known(&self, state: &State, start: &Start) -> NormalEquations {
        let mut equations = NormalEquations::new(self.unknowns.size());
        equations.add_priors(self.unknowns.all(), &state.values);
        self.add_heading(state, &mut equations, 1.0);
        if let Some(prior) = &start.prior {
            equations.add_all(&self.marginalised(state, prior));
        }
        equations
    }

    /// Takes away what is known of all rows at once, headings and nuisance parameters, which is added again with rows that follow.
    pub(super) fn remove_shared(&self, state: &State, equations: &mut NormalEquations) {
        equations.remove_priors(self.unknowns.all(), &state.values);
        self.add_heading(state, equations, -1.0);
    }

    /// Adds the one error of the absolute headings, so many times.
    fn add_heading(&self, state: &State, equations: &mut NormalEquations, times: f64) {
        if let Some(heading) = self.window.heading() {
            let off = wrap_angle(state.frame.theta - heading);
            let weight = times * self.heading_std.powi(-2);
            equations.add(&[0.0, 0.0, 1.0], off, weight);
            equations.constant += 0.5 * weight * off * off;
        }
    }

    /// What marginalised rows say around a state: they know the pose at the window's first row.
    pub(super) fn marginalised(&self, state: &State, prior: &Prior) -> NormalEquations {
        let n = self.unknowns.size();
        let mut path = Vec::new();
        self.path(&state.values, &[0], &mut path);
        let Some(first) = path.first() else { return NormalEquations::new(n) };
        let raw = self.window.pose(0);
        let frame = state.frame.compose(first.pose).compose(raw.inverse());
        let mut step = difference(prior.at.frame, frame, raw.position()).to_vec();
        step.extend(state.values.iter().zip(&prior.at.values).map(|(now, then)| now - then));
        let mut equations = prior.equations.shifted(&step);
        if self.window.drifts() && self.anchor > 0 {
            equations.loosen_pose(&self.window.on_walk(0, self.anchor).covariance(), state.frame.theta);
        }
        equations.transformed(&self.derivatives_by_anchor(state, first))
    }

    /// Equations around a state with the pose at another row in the place of that at the anchor.
    pub(super) fn equations_at(&self, equations: &NormalEquations, state: &State, row: usize) -> NormalEquations {
        let mut path = Vec::new();
        let there = MeasurementModel { anchor: row, ..*self };
        there.path(&state.values, &[self.anchor], &mut path);
        let moved = self.anchored(state, row);
        path.first().map_or_else(
            || equations.clone(),
            |point| equations.transformed(&there.derivatives_by_anchor(&moved, point)),
        )
    }

    /// The derivatives of the pose at a row by (pose at the anchor, nuisance parameters), without those by itself.
    fn derivatives_by_anchor(&self, state: &State, first: &PathPoint) -> [Vec<f64>; POSE] {
        let mut by: [Vec<f64>; POSE] = core::array::from_fn(|_| vec![0.0; self.unknowns.size()]);
        let arm =
            (state.frame.transform_point(first.pose.position()) - state.frame.transform_point(self.pivot())).perp();
        (by[0][2], by[1][2]) = (arm.x, arm.y);
        if let Some(at) = self.unknowns.odometry {
            for (k, sway) in first.by_calibration.iter().enumerate() {
                let place = sway.place.rotated(state.frame.theta);
                (by[0][at + k], by[1][at + k], by[2][at + k]) = (place.x, place.y, sway.turn);
            }
        }
        if let Some(at) = self.unknowns.map_scale {
            let scale = self.map_scale(&state.values);
            // The arm is the way there turned by a right angle.
            (by[0][at], by[1][at]) = (-arm.y / scale, arm.x / scale);
        }
        by
    }

    /// The robot in the map at a row.
    pub(super) fn robot_at(&self, state: &State, row: usize) -> Pose2 {
        let mut path = Vec::new();
        self.path(&state.values, &[row], &mut path);
        state.frame.compose(path.first().map_or(self.window.pose(row), |point| point.pose))
    }

    /// The same state where the path is held at another row.
    pub(super) fn anchored(&self, state: &State, row: usize) -> State {
        let frame = self.robot_at(state, row).compose(self.window.pose(row).inverse());
        State { frame, values: state.values.clone() }
    }
}

/// What a contact rests on; of two at once, the tip's.
fn support(touch: &Contact) -> Support {
    match touch.hold {
        Hold::Tip(on) | Hold::Side(on, _) => on,
        Hold::Both(both) => both.outer,
    }
}

/// One reading of a run.
struct Seen {
    row: usize,
    index: usize,
    robot: Pose2,
    /// In the map as it is drawn.
    base: Pose2,
    /// See [`Row`].
    wander: f64,
    felt: Prediction,
    /// What the sensor reads while its whisker is free.
    offset: f64,
    z: f64,
}
