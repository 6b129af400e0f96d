//! Plans while rows come: what a running robot asks.

use super::past::{FAR, STEP, STEP_TURN, history};
use super::{Past, Plan, PlanOptions, plan, remaining};
use crate::Result;
use crate::flow::pose::Hypothesis;
use crate::flow::sensor_log::{Channel, LogRow, SensorLog};
use crate::plane::{Pose2, wrap_angle};
use crate::world::{Map, Robot};
use std::collections::VecDeque;

/// Poses nearer to each other than this share of a plan's steps are one.
const FINE: f64 = 0.1;
/// Most poses that are kept.
const MOST: usize = 1000;
/// A robot that has moved less than this (m, rad) rests.
const STILL: [f64; 2] = [2e-4, 2e-3];

/// Keeps of a robot's rows what a plan looks at, and tells when the robot rests. Its memory does not grow.
#[derive(Clone, Debug)]
pub struct Planner {
    options: PlanOptions,
    /// The channel of each whisker's moment, where all have one.
    moments: Option<Vec<usize>>,
    /// Its way, odometry frame, the oldest first.
    way: VecDeque<Pose2>,
    readings: Vec<f64>,
    /// The last row's time (s) and pose, and those of the row from which on it rests.
    last: Option<(f64, Pose2)>,
    rests: Option<(f64, Pose2)>,
}

impl Planner {
    /// Before the first row of a log with these channels.
    ///
    /// # Errors
    ///
    /// As [`PlanOptions::check`]; a robot whose whiskers lean.
    pub fn new(robot: &Robot, channels: &[Channel], options: PlanOptions) -> Result<Self> {
        options.check()?;
        robot.require_level("plan")?;
        let log = SensorLog { channels: channels.to_vec(), ..SensorLog::default() };
        let moments = robot.whiskers.iter().map(|whisker| log.moment_channel(&whisker.name).ok()).collect();
        Ok(Self { options, moments, way: VecDeque::new(), readings: Vec::new(), last: None, rests: None })
    }

    /// Takes the next row; moments are calibrated.
    pub fn row(&mut self, row: &LogRow) {
        let pose = row.odom_from_robot;
        let off = |from: Pose2, least: [f64; 2]| {
            let turn = wrap_angle(pose.theta - from.theta).abs();
            pose.position().distance(from.position()) >= least[0] || turn >= least[1]
        };
        if self.rests.is_none_or(|(_, from)| off(from, STILL)) {
            self.rests = Some((row.t, pose));
        }
        self.last = Some((row.t, pose));
        let read = |moments: &Vec<usize>| moments.iter().map(|&k| row.readings.get(k).copied()).collect();
        self.readings = self.moments.as_ref().and_then(read).unwrap_or_default();
        if self.way.back().is_none_or(|&before| off(before, [FINE * STEP, FINE * STEP_TURN])) {
            self.way.push_back(pose);
        }
        let is_far = |first: &Pose2| first.position().distance(pose.position()) > 2.0 * FAR;
        while self.way.len() > MOST || self.way.front().is_some_and(is_far) {
            self.way.pop_front();
        }
    }

    /// How long the robot has rested (s), and when it began to.
    #[must_use]
    pub fn rest(&self) -> Option<(f64, f64)> {
        self.last.zip(self.rests).map(|((now, _), (since, _))| (now - since, since))
    }

    /// How the robot came here, the oldest pose first, and the last reading of each whisker (N m), as [`Past`] takes them.
    #[must_use]
    pub fn past(&self) -> (Vec<Pose2>, &[f64]) {
        let now = self.last.map(|(_, pose)| pose).filter(|now| self.way.back() != Some(now));
        (history(self.way.iter().copied().chain(now)), &self.readings)
    }

    /// The way of the robot as far as it is kept (odometry frame), the newest pose first.
    pub fn way(&self) -> impl Iterator<Item = Pose2> + '_ {
        self.last.map(|(_, pose)| pose).into_iter().chain(self.way.iter().rev().copied())
    }

    /// The next motion that tells these places apart, as [`plan`].
    ///
    /// # Errors
    ///
    /// As [`plan`].
    pub fn plan(&self, map: &Map, robot: &Robot, places: &[Hypothesis]) -> Result<Plan> {
        let (history, readings) = self.past();
        let states = remaining(places, self.options.states);
        plan(map, robot, &states, &Past { history: &history, readings }, &self.options)
    }
}
