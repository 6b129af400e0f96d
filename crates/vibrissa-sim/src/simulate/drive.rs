//! A robot that is steered while it is simulated: [`simulate`](super::simulate) pose by pose, for paths that nobody knows beforehand.

use super::follow::{Follower, Scene};
use super::noise::{Dice, SweepNoise};
use super::recorder::TrueErrors;
use super::{SimulateOptions, Touch, channels};
use crate::config::limits::LONGEST_DRIVE_STEP;
use crate::contact::Boundaries;
use crate::contact::quasi_static::LoadedWhisker;
use crate::flow::pose::{Event, StampedPose};
use crate::flow::sensor_log::{Channel, LogRow};
use crate::plane::{Pose2, Vec2};
use crate::world::{Map, Robot};
use crate::{Error, Result, Stop};
use core::f64::consts::TAU;

/// What a robot is steered on: its map, its whiskers, and what is computed of them once.
#[derive(Debug)]
pub struct Stage {
    map: Map,
    robot: Robot,
    boundaries: Boundaries,
    loaded: Vec<LoadedWhisker>,
    options: SimulateOptions,
    stop: Stop,
}

impl Stage {
    /// The stage of a map and a robot.
    ///
    /// # Errors
    ///
    /// Whiskers that make no sense; the message says which value.
    pub fn new(map: Map, robot: Robot, options: SimulateOptions) -> Result<Self> {
        let boundaries = Boundaries::new(&map);
        let loaded = robot.whiskers.iter().map(|whisker| LoadedWhisker::new(&whisker.beam)).collect::<Result<_>>()?;
        Ok(Self { map, robot, boundaries, loaded, options, stop: Stop::default() })
    }

    /// The map.
    #[must_use]
    pub fn map(&self) -> &Map {
        &self.map
    }

    /// The robot.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The columns of the rows that a [`Drive`] gives.
    #[must_use]
    pub fn channels(&self) -> Vec<Channel> {
        channels(&self.robot)
    }
}

/// A robot that is steered over a [`Stage`].
///
/// Every whisker is in equilibrium at every pose, as in [`simulate`](super::simulate): the same poses give the same moments.
pub struct Drive<'a> {
    stage: &'a Stage,
    whiskers: Vec<Follower<'a>>,
    dice: Dice,
    start: f64,
    at: StampedPose,
    odom_from_robot: Pose2,
    events: Vec<Event>,
}

impl<'a> Drive<'a> {
    /// A robot at its first pose (map frame), where its whiskers must be free.
    ///
    /// # Errors
    ///
    /// Usage: a whisker that touches or is inside something solid, noise out of range; the message says where.
    pub fn start(stage: &'a Stage, at: StampedPose, noise: &SweepNoise) -> Result<Self> {
        noise.check()?;
        let Stage { map, robot, boundaries, loaded, options, stop } = stage;
        let follower =
            |(whisker, loaded)| Follower::start(Scene { map, boundaries, whisker, loaded, options, stop }, at);
        let whiskers = robot.whiskers.iter().zip(loaded).map(follower).collect::<Result<_>>()?;
        Ok(Self {
            stage,
            whiskers,
            dice: noise.dice(),
            start: at.t,
            at,
            odom_from_robot: Pose2::IDENTITY,
            events: Vec::new(),
        })
    }

    /// Moves the robot on to a pose (map frame) and tells what it records there.
    ///
    /// Of `errors` gain, zero and drift befall the readings, and the scales the odometry; the rest is for whole sweeps. Wheels
    /// that slip turn further than the robot goes by the share `slip`: 0 for none, 1 counts the way twice.
    ///
    /// # Errors
    ///
    /// Usage: a pose that is not finite, or further than 10 m or more than a turn from the last one. A discrete rod that cannot be built, or
    /// that does not come to rest as [`simulate`](super::simulate) tells.
    pub fn advance(&mut self, to: StampedPose, errors: &TrueErrors, slip: f64) -> Result<LogRow> {
        self.check_step(to.map_from_robot)?;
        for whisker in &mut self.whiskers {
            whisker.advance(to, &mut self.events)?;
        }
        let step = errors.counted(self.at.map_from_robot.between(to.map_from_robot));
        let felt = Pose2 { x: (1.0 + slip) * step.x, y: (1.0 + slip) * step.y, ..step };
        self.odom_from_robot = self.odom_from_robot.compose(self.dice.increment(felt));
        self.at = to;
        let since = to.t - self.start;
        let read = |(follower, whisker): (&Follower<'_>, &crate::world::MountedWhisker)| {
            self.dice.reading(errors.read(since, follower.moment()), &whisker.noise)
        };
        let readings = self.whiskers.iter().zip(&self.stage.robot.whiskers).map(read).collect();
        Ok(LogRow { t: to.t, odom_from_robot: self.odom_from_robot, readings, heading: None, line: 0 })
    }

    fn check_step(&self, to: Pose2) -> Result<()> {
        let from = self.at.map_from_robot;
        let (way, turn) = (from.position().distance(to.position()), (to.theta - from.theta).abs());
        // No number is within bounds, either.
        let is_within = |value: f64, most: f64| value <= most;
        if !is_within(way, LONGEST_DRIVE_STEP) {
            let error = Error::usage("way of the robot to its next pose").value(format!("{way:?} m"));
            return Err(error.allowed(format!("up to {LONGEST_DRIVE_STEP} m")).remedy("give poses between the two"));
        }
        if !is_within(turn, TAU) {
            let error = Error::usage("turn of the robot to its next pose").value(format!("{turn:?} rad"));
            return Err(error
                .allowed("up to one turn, 2 pi")
                .remedy("give headings in rad, and poses between the two"));
        }
        Ok(())
    }

    /// Where the robot is.
    #[must_use]
    pub fn pose(&self) -> StampedPose {
        self.at
    }

    /// The moments at the whiskers' bases without noise (N m).
    #[must_use]
    pub fn moments(&self) -> Vec<f64> {
        self.whiskers.iter().map(Follower::moment).collect()
    }

    /// The contacts now, in order of whiskers and from base to tip.
    #[must_use]
    pub fn touches(&self) -> Vec<Touch> {
        self.whiskers.iter().enumerate().flat_map(|(index, whisker)| whisker.touches(0, index)).collect()
    }

    /// Points of each whisker from base to tip, map frame (m): at least two, about `n` of a bent one.
    #[must_use]
    pub fn shapes(&self, n: usize) -> Vec<Vec<Vec2>> {
        self.whiskers.iter().map(|whisker| whisker.shape(n.max(2))).collect()
    }

    /// What happened to the whiskers since this was last asked, as [`simulate`](super::simulate) tells it.
    #[must_use]
    pub fn events(&mut self) -> Vec<Event> {
        core::mem::take(&mut self.events)
    }
}
