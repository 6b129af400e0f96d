//! The robot on its way: rows, what is known at each, and the next motion.

use super::enclosure::{Opinion, SAME_PLACE, opinion};
use super::pilot::{Chooser, way_back};
use super::{Ended, Exploration, ExploreOptions, Made, Onlooker, Order, Pilot, Strategy, Underway};
use crate::Result;
use crate::control::{FollowState, WallFollower};
use crate::flow::pose::{Event, Hypothesis, Localization, StampedPose, Status};
use crate::flow::sensor_log::SensorLog;
use crate::localizer::{Localizer, Method};
use crate::plane::{Pose2, Twist2, Vec2, wrap_angle};
use crate::sim::recorder::TrueErrors;
use crate::sim::{Drive, Stage, SweepNoise, path_through};
use crate::tasks::localize;
use crate::tasks::plan::{Motion, Past, Plan, history};
use crate::world::MountedWhisker;
use core::ops::ControlFlow;

/// How often on the way (m, rad) the robot asks whether it knows where it is.
const ASK: f64 = 0.01;
const ASK_TURN: f64 = 0.2;
/// What is ahead of the robot (rad to either side).
const AHEAD: f64 = 0.5;
/// Turn after which a way along the wall ends in any case (rad).
const MOST_TURN: f64 = 7.0;
/// Way (m) that tells where the robot goes.
const TELLING: f64 = 0.02;
/// How far (m) the robot goes on before it asks again where the whole answer was less sure than the estimator.
const UNSURE: f64 = 0.03;

/// The name of the motion by which a log is begun anew, how often that is done, and how hard the robot presses then, over what ends other motions.
const ANEW: &str = "back, to begin anew";
const MOST_ANEW: usize = 2;
const GENTLER: f64 = 0.5;
/// How often it goes back the way it came until its whiskers are free.
const MOST_BACK_TO_BE_FREE: usize = 3;
/// The name of the motion that tests a place.
const TEST: &str = "a test of the place";

/// A robot on its way.
pub(super) struct Under<'a> {
    stage: &'a Stage,
    options: &'a ExploreOptions,
    method: &'a Method,
    drive: Drive<'a>,
    localizer: Localizer<'a>,
    log: SensorLog,
    truth: Vec<StampedPose>,
    motions: Vec<Made>,
    events: Vec<Event>,
    way: f64,
    turn: f64,
    asked: [f64; 2],
    /// Motions made when the whole answer was asked for.
    answered: usize,
    collided: bool,
    hardest: f64,
    pilot: Pilot,
    /// The odometry's pose and the place, while that is tested.
    tested: Option<(Pose2, Pose2)>,
    /// Whether the robot asks on its way whether it knows where it is.
    asks: bool,
    /// Whether the set of all states that are left is at the place that is told; the answer where only the set knows one; and whether it leaves others.
    is_proved: bool,
    enclosed: Option<Localization>,
    is_disputed: bool,
    /// The row with which the log begins that counts, and how often it was begun anew.
    since: usize,
    begun_anew: usize,
    /// Whether the onlooker asked for the end.
    broken: bool,
}

impl<'a> Under<'a> {
    pub(super) fn new(
        stage: &'a Stage,
        first: StampedPose,
        method: &'a Method,
        noise: &SweepNoise,
        options: &'a ExploreOptions,
    ) -> Result<Self> {
        let mut under = Self {
            stage,
            options,
            method,
            drive: Drive::start(stage, first, noise)?,
            localizer: Localizer::new(stage.map(), stage.robot(), &stage.channels(), method)?,
            log: SensorLog::default(),
            truth: Vec::new(),
            motions: Vec::new(),
            events: Vec::new(),
            way: 0.0,
            turn: 0.0,
            asked: [0.0; 2],
            answered: 0,
            collided: false,
            hardest: 0.0,
            pilot: Pilot::new(options.plan)?,
            tested: None,
            asks: true,
            is_proved: false,
            enclosed: None,
            is_disputed: false,
            since: 0,
            begun_anew: 0,
            broken: false,
        };
        under.advance(first, &mut |_| ControlFlow::Continue(()))?;
        Ok(under)
    }

    pub(super) fn motions(&self) -> &[Made] {
        &self.motions
    }

    pub(super) fn way(&self) -> f64 {
        self.way
    }

    /// What is left if it ends now.
    pub(super) fn so_far(&self) -> Exploration {
        let estimate = self.localizer.estimate();
        let answer = Localization {
            method: self.method.name(),
            status: estimate.status,
            estimate: estimate.pose(),
            states: estimate.hypotheses.iter().map(|place| place.extent).collect(),
            hypotheses: estimate.hypotheses,
            ..Localization::default()
        };
        Exploration {
            ended: Ended::Interrupted,
            answer,
            way: self.way,
            turn: self.turn,
            motions: self.motions.clone(),
            log: self.log.clone(),
            truth: self.truth.clone(),
            collided: self.collided,
            hardest: self.hardest,
            since: self.since,
            events: self.events.clone(),
        }
    }

    /// Lets the onlooker see what is there; whether the exploration is to end.
    fn show(&mut self, is_long: bool, onlooker: &mut Onlooker<'_>) -> bool {
        self.broken |= onlooker(&Underway { under: self, is_long }).is_break();
        self.broken
    }

    /// One row on; the sizes of the readings.
    fn advance(&mut self, to: StampedPose, onlooker: &mut Onlooker<'_>) -> Result<Vec<f64>> {
        let from = self.drive.pose().map_from_robot;
        let row = self.drive.advance(to, &TrueErrors::default(), 0.0)?;
        let pose = to.map_from_robot;
        self.way += pose.position().distance(from.position());
        self.turn += wrap_angle(pose.theta - from.theta).abs();
        let map = self.stage.map();
        let footprint = self.options.plan.footprint;
        let hits = |a: Vec2, b: Vec2| !map.is_free(b) || (a.distance(b) > 0.0 && map.crosses(a, b));
        self.collided |= hits(from.position(), pose.position())
            || map.nearest_within(pose.position(), footprint).is_some()
            || self.stage.robot().whiskers.iter().any(|w| {
                let base = |p: Pose2| p.compose(w.robot_from_whisker).position();
                hits(base(from), base(pose))
            });
        for (moment, whisker) in self.drive.moments().iter().zip(&self.stage.robot().whiskers) {
            self.hardest = self.hardest.max(moment.abs() / self.options.plan.most(whisker));
        }
        self.events.extend(self.drive.events());
        self.localizer.step(&row)?;
        let sizes = row.readings.iter().map(|z| z.abs()).collect();
        self.log.rows.push(row);
        self.truth.push(to);
        self.show(false, onlooker);
        Ok(sizes)
    }

    fn answer(&self) -> Result<Localization> {
        localize(&self.log_that_counts(), self.stage.map(), self.stage.robot(), self.method, &mut |_| {})
    }

    fn log_that_counts(&self) -> SensorLog {
        let SensorLog { channels, rows, .. } = &self.log;
        SensorLog { channels: channels.clone(), rows: rows[self.since..].to_vec(), ..SensorLog::default() }
    }

    /// What is known now: the estimator's word on the way, or the whole answer where that says more.
    fn known(&mut self) -> Result<(Status, Vec<Hypothesis>)> {
        (self.is_proved, self.is_disputed, self.enclosed) = (false, false, None);
        let now = self.localizer.estimate();
        let due = self.motions.is_empty() || self.motions.len() >= self.answered + self.options.answer_each;
        if now.status == Status::Ambiguous && !now.hypotheses.is_empty() && !due {
            return Ok((now.status, now.hypotheses));
        }
        self.answered = self.motions.len();
        let answer = self.answer()?;
        let Method::Probabilistic(options) = self.method else { return Ok((answer.status, answer.hypotheses)) };
        if !self.options.is_tested || !matches!(answer.status, Status::Localized | Status::Inconsistent) {
            return Ok((answer.status, answer.hypotheses));
        }
        let (map, robot) = (self.stage.map(), self.stage.robot());
        Ok(match opinion(&self.log_that_counts(), map, robot, options, answer.estimate) {
            Opinion::None => (answer.status, answer.hypotheses),
            Opinion::Proved => {
                self.is_proved = true;
                (Status::Localized, answer.hypotheses)
            }
            // By one method alone, which the other contradicts: it is tested by a motion.
            Opinion::Elsewhere(set) => {
                let places = set.hypotheses.clone();
                self.enclosed = Some(*set);
                (Status::Localized, places)
            }
            Opinion::Open(places) => {
                self.is_disputed = true;
                (Status::Ambiguous, places)
            }
        })
    }

    /// The first motion, which nobody chooses.
    pub(super) fn begin(&mut self, path: &[StampedPose], onlooker: &mut Onlooker<'_>) -> Result<()> {
        let stop_at = self.options.plan.stop_at(self.stage.robot());
        for pose in path {
            let sizes = self.advance(*pose, onlooker)?;
            if self.broken || sizes.iter().zip(&stop_at).any(|(size, most)| size >= most) {
                break;
            }
        }
        self.log.channels = self.stage.channels();
        (self.way, self.turn, self.hardest) = (0.0, 0.0, 0.0);
        Ok(())
    }

    pub(super) fn run(mut self, mut strategy: Strategy<'_>, onlooker: &mut Onlooker<'_>) -> Result<Exploration> {
        let mut follower = match &strategy {
            Strategy::Following(options) => Some(WallFollower::new(self.stage.robot(), options)?),
            _ => None,
        };
        loop {
            if self.show(true, onlooker) {
                return Ok(self.so_far());
            }
            let (status, places) = self.known()?;
            if self.show(true, onlooker) {
                return Ok(self.so_far());
            }
            let before = self.tested.take();
            let ended = match status {
                Status::Localized if self.is_proved => Some(Ended::Localized),
                Status::Localized => self.tested_by_motion(before, &places, onlooker)?.then_some(Ended::Localized),
                Status::Inconsistent => (!self.begin_anew(onlooker)?).then_some(Ended::Inconsistent),
                _ if places.is_empty() => Some(Ended::NoPlace),
                _ if self.way > self.options.most_way || self.motions.len() >= self.options.most_motions => {
                    Some(Ended::GaveUp)
                }
                _ => match &mut follower {
                    Some(follower) => self.follow(follower, &places, onlooker)?,
                    None => self.motion(&places, &mut strategy, onlooker)?,
                },
            };
            if let Some(ended) = ended {
                if self.show(true, onlooker) {
                    return Ok(self.so_far());
                }
                let answer = match self.enclosed.take() {
                    Some(set) => set,
                    None => self.answer()?,
                };
                return Ok(self.end(ended, answer));
            }
        }
    }

    fn end(self, ended: Ended, answer: Localization) -> Exploration {
        Exploration {
            ended,
            answer,
            way: self.way,
            turn: self.turn,
            motions: self.motions,
            log: self.log,
            truth: self.truth,
            collided: self.collided,
            hardest: self.hardest,
            since: self.since,
            events: self.events,
        }
    }

    /// Whether a place has stood a test since it was told first, needs none, or cannot be tested; else the motion that tests it is made.
    fn tested_by_motion(
        &mut self,
        before: Option<(Pose2, Pose2)>,
        places: &[Hypothesis],
        onlooker: &mut Onlooker<'_>,
    ) -> Result<bool> {
        let Some(row) = self.log.rows.last().filter(|_| self.options.is_tested) else { return Ok(true) };
        let (odom, place) = (row.odom_from_robot, places[0].pose);
        if let Some((odom_before, place_before)) = before {
            let expected = place_before.compose(odom_before.between(odom));
            if expected.position().distance(place.position()) <= SAME_PLACE {
                return Ok(true);
            }
        }
        let history = history(self.log.rows.iter().map(|row| row.odom_from_robot));
        let past = Past { history: &history, readings: &row.readings };
        let order = self.pilot.test(self.stage.map(), self.stage.robot(), places, &past)?;
        self.tested = matches!(order, Order::Go { .. }).then_some((odom, place));
        self.asks = false;
        let ended = self.obey(order, None, TEST, places, onlooker)?;
        self.asks = true;
        Ok(ended.is_some())
    }

    /// Forgets a log that no place explains: the robot goes back the way it came until its whiskers are free, and goes on the same way to touch anew,
    /// more gently. Whether it could.
    fn begin_anew(&mut self, onlooker: &mut Onlooker<'_>) -> Result<bool> {
        if self.begun_anew >= MOST_ANEW {
            return Ok(false);
        }
        self.begun_anew += 1;
        self.note(None, ANEW, &[]);
        self.asks = false;
        let from = self.truth.len() - 1;
        let mut backs = 0;
        while !self.is_free() && backs < MOST_BACK_TO_BE_FREE {
            let waypoints = way_back(self.truth.iter().rev().map(|pose| pose.map_from_robot));
            self.go(&waypoints, &[], onlooker)?;
            backs += 1;
        }
        let is_free = self.is_free();
        if let Some(row) = self.log.rows.last().filter(|_| is_free) {
            self.since = self.log.rows.len() - 1;
            let stage = self.stage;
            self.localizer = Localizer::new(stage.map(), stage.robot(), &stage.channels(), self.method)?;
            self.localizer.step(row)?;
            self.pilot = Pilot::new(self.options.plan)?;
            let there: Vec<Pose2> = self.truth[from..].iter().rev().map(|pose| pose.map_from_robot).collect();
            let stop_at: Vec<f64> =
                self.options.plan.stop_at(stage.robot()).iter().map(|most| GENTLER * most).collect();
            let stopped = self.go(&there, &stop_at, onlooker)?;
            self.motions.last_mut().into_iter().for_each(|made| made.stopped = stopped);
        }
        self.asks = true;
        Ok(is_free)
    }

    /// Whether no whisker reads more than its noise.
    fn is_free(&self) -> bool {
        let reads_nothing = |(z, whisker): (&f64, &MountedWhisker)| {
            let [low, high] = whisker.noise.readings(0.0);
            (low..=high).contains(z)
        };
        self.readings().iter().zip(&self.stage.robot().whiskers).all(reads_nothing)
    }

    /// One motion, or why there is none.
    fn motion(
        &mut self,
        known: &[Hypothesis],
        strategy: &mut Strategy<'_>,
        onlooker: &mut Onlooker<'_>,
    ) -> Result<Option<Ended>> {
        let (history, begin) = (history(self.log.rows.iter().map(|row| row.odom_from_robot)), self.drive.pose());
        let past = Past { history: &history, readings: self.log.rows.last().map_or(&[], |row| &row.readings) };
        let (map, robot) = (self.stage.map(), self.stage.robot());
        let (order, plan) = match strategy {
            Strategy::Chosen(choose) => {
                let ahead = self.ahead();
                let mut choose = |all: &[Motion]| choose(all, ahead);
                self.pilot.next_by(map, robot, known, &past, Chooser::Other(&mut choose))?
            }
            Strategy::Hindsight => {
                self.pilot.next_by(map, robot, known, &past, Chooser::Hindsight(begin.map_from_robot))?
            }
            Strategy::Planned | Strategy::Following(_) => self.pilot.next(map, robot, known, &past)?,
        };
        if self.show(false, onlooker) {
            return Ok(None);
        }
        let name = if let Order::Go { motion, .. } = &order { motion.name() } else { "" };
        self.obey(order, plan, name, known, onlooker)
    }

    /// Does what is ordered, a motion under this name; or why it ends.
    fn obey(
        &mut self,
        order: Order,
        plan: Option<Plan>,
        name: &'static str,
        known: &[Hypothesis],
        onlooker: &mut Onlooker<'_>,
    ) -> Result<Option<Ended>> {
        let (motion, stop_at) = match order {
            Order::End(ended) => return Ok(Some(ended)),
            Order::Back => {
                self.note(None, "back the way it came", known);
                let waypoints = way_back(self.truth.iter().rev().map(|pose| pose.map_from_robot));
                self.go(&waypoints, &[], onlooker)?;
                return Ok(None);
            }
            Order::Go { motion, stop_at } => (motion, stop_at),
        };
        let begin = self.drive.pose().map_from_robot;
        self.note(plan, name, known);
        let follower = WallFollower::new(self.stage.robot(), &self.options.follow()).ok();
        if let Some(mut follower) = follower.filter(|_| self.options.by_touch && goes_along(&motion)) {
            let blocked = self.go_along(&mut follower, motion.way(), onlooker)?;
            self.motions.last_mut().into_iter().for_each(|made| made.stopped = blocked);
            return Ok(None);
        }
        let waypoints: Vec<Pose2> = motion.waypoints().iter().map(|pose| begin.compose(*pose)).collect();
        let stopped = self.go(&waypoints, &stop_at, onlooker)?;
        self.motions.last_mut().into_iter().for_each(|made| made.stopped = stopped);
        Ok(None)
    }

    fn note(&mut self, plan: Option<Plan>, name: &'static str, known: &[Hypothesis]) {
        let places = known.iter().map(|h| (h.pose, h.weight)).collect();
        self.motions.push(Made { plan, name, places, row: self.log.rows.len(), stopped: false });
    }

    /// Goes through waypoints until a whisker feels too much or the robot knows where it is; whether a whisker ended it.
    fn go(&mut self, waypoints: &[Pose2], stop_at: &[f64], onlooker: &mut Onlooker<'_>) -> Result<bool> {
        let Ok(path) = path_through(waypoints, &self.options.pace) else { return Ok(false) };
        let begin = self.drive.pose().t;
        for pose in &path[1..] {
            let sizes = self.advance(StampedPose { t: begin + pose.t, ..*pose }, onlooker)?;
            if sizes.iter().zip(stop_at).any(|(size, most)| size >= most) {
                return Ok(true);
            }
            if self.broken || self.is_localized(onlooker)? {
                return Ok(false);
            }
        }
        Ok(false)
    }

    /// Whether the robot knows where it is, if it is time to ask.
    fn is_localized(&mut self, onlooker: &mut Onlooker<'_>) -> Result<bool> {
        if !self.asks || self.is_disputed || self.way - self.asked[0] <= ASK && self.turn - self.asked[1] <= ASK_TURN {
            return Ok(false);
        }
        self.asked = [self.way, self.turn];
        if self.localizer.estimate().status != Status::Localized {
            return Ok(false);
        }
        if self.show(true, onlooker) || self.answer()?.status == Status::Localized {
            return Ok(true);
        }
        self.asked[0] += UNSURE;
        Ok(false)
    }

    /// Follows the wall as far as the longest motion, or until the robot knows where it is.
    fn follow(
        &mut self,
        follower: &mut WallFollower,
        known: &[Hypothesis],
        onlooker: &mut Onlooker<'_>,
    ) -> Result<Option<Ended>> {
        self.note(None, "along the wall, by touch", known);
        let blocked = self.go_along(follower, self.options.plan.longest, onlooker)?;
        Ok(blocked.then_some(Ended::Confined))
    }

    /// Along the wall by touch, so far (m) or until the robot knows where it is; whether it is blocked.
    fn go_along(&mut self, follower: &mut WallFollower, most: f64, onlooker: &mut Onlooker<'_>) -> Result<bool> {
        let (way, turn, step) = (self.way, self.turn, 1.0 / self.options.pace.rate);
        while self.way - way < most && self.turn - turn < MOST_TURN {
            let now = self.drive.pose();
            let command = follower.step(now.t, self.readings());
            if command.state == FollowState::Blocked {
                return Ok(true);
            }
            let Twist2 { x, y, theta } = command.twist;
            let moved = Pose2::exp(Twist2 { x: step * x, y: step * y, theta: step * theta });
            let to = StampedPose { t: now.t + step, map_from_robot: now.map_from_robot.compose(moved) };
            self.advance(to, onlooker)?;
            if self.broken || self.is_localized(onlooker)? {
                break;
            }
        }
        Ok(false)
    }

    fn readings(&self) -> &[f64] {
        self.log.rows.last().map_or(&[], |row| &row.readings)
    }

    /// Where the robot went last (rad, robot frame).
    fn ahead(&self) -> f64 {
        let now = self.drive.pose().map_from_robot;
        let far = |pose: &&StampedPose| pose.map_from_robot.position().distance(now.position()) > TELLING;
        let last = self.truth.iter().rev().find(far);
        last.map_or(0.0, |last| (-now.inverse_transform_point(last.map_from_robot.position())).angle())
    }
}

/// Whether a motion goes along the wall, straight ahead of the robot.
fn goes_along(motion: &Motion) -> bool {
    let end = motion.end();
    motion.name() == "along the wall" && end.position().norm() > TELLING && end.position().angle().abs() < AHEAD
}
