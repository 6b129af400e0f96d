//! The closed loop: a simulated robot that localizes itself by its own motion, and stops when it knows where it is.

mod enclosure;
mod pilot;
mod run;

#[cfg(doc)]
use super::plan::plan;
use super::plan::{Motion, Plan, PlanOptions};
use crate::control::FollowOptions;
#[cfg(doc)]
use crate::control::WallFollower;
use crate::flow::pose::{Event, Localization, StampedPose};
use crate::flow::sensor_log::SensorLog;
use crate::localizer::Method;
use crate::plane::Pose2;
use crate::sim::{Pace, Stage, SweepNoise, path_through};
use crate::{Error, Result};
use core::ops::ControlFlow;
pub use pilot::{Order, Pilot, way_back};
use run::Under;

/// How the next motion is chosen.
pub enum Strategy<'a> {
    /// By [`plan`].
    Planned,
    /// By somebody else, among the admissible ones.
    Chosen(&'a mut Choose<'a>),
    /// As planned by one who knows the true state: what could be gained at best.
    Hindsight,
    /// None is: the robot follows the wall by touch.
    Following(FollowOptions),
}

/// Chooses a motion of one's own, of those that are admissible; `ahead` is where the robot went last (rad, robot frame).
pub type Choose<'a> = dyn FnMut(&[Motion], f64) -> Option<Motion> + 'a;

/// How a robot explores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExploreOptions {
    /// What it can do.
    pub plan: PlanOptions,
    /// Speed, turning rate and rows a second.
    pub pace: Pace,
    /// The way (m) after which it gives up.
    pub most_way: f64,
    /// The motions after which it gives up.
    pub most_motions: usize,
    /// The whole answer, with ridges, is asked for after so many motions; in between what the estimator tells has to do, which
    /// is quicker, but collisions are then ruled out less surely.
    pub answer_each: usize,
    /// Whether motions along the wall that go ahead are made by [`WallFollower`] instead of straight. It sees to bumps and corners, but not to what
    /// stands on the side of the robot where no whisker is.
    pub by_touch: bool,
    /// Whether a place is tested before the robot stops: by the set of all states that the declared bounds leave open, and where that says nothing by one
    /// more motion, along which the robot would feel something else if it were elsewhere.
    pub is_tested: bool,
}

impl Default for ExploreOptions {
    fn default() -> Self {
        Self {
            plan: PlanOptions::default(),
            pace: Pace { speed: 0.1, turn_rate: 1.0, rate: 50.0 },
            most_way: 2.0,
            most_motions: 40,
            answer_each: 1,
            by_touch: false,
            is_tested: true,
        }
    }
}

impl ExploreOptions {
    /// The limits for a robot that follows walls.
    #[must_use]
    pub fn follow(&self) -> FollowOptions {
        FollowOptions {
            speed: self.pace.speed,
            turn_rate: self.pace.turn_rate,
            sideways: self.plan.sideways,
            footprint: self.plan.footprint,
            largest_moment: self.plan.largest_moment,
            ..FollowOptions::default()
        }
    }
}

/// Why an exploration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The robot knows where it is.
    Localized,
    /// No motion tells the places apart: the map is symmetric.
    Symmetric,
    /// Nothing on this map explains what was felt.
    Inconsistent,
    /// Way or motions are used up.
    GaveUp,
    /// Nothing is free of collision and gentle at all places that are left.
    Confined,
    /// The first motion did not tell any place.
    NoPlace,
    /// Who watched it asked for its end.
    Interrupted,
}

impl Ended {
    /// The word for it: `localized`, `symmetric`, `inconsistent`, `gave_up`, `confined`, `no_place` or
    /// `interrupted`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Localized => "localized",
            Self::Symmetric => "symmetric",
            Self::Inconsistent => "inconsistent",
            Self::GaveUp => "gave_up",
            Self::Confined => "confined",
            Self::NoPlace => "no_place",
            Self::Interrupted => "interrupted",
        }
    }
}

/// The first poses of a path, as far as so much way (m): what an exploration may begin with.
#[must_use]
pub fn beginning(path: &[StampedPose], most: f64) -> Vec<Pose2> {
    let mut gone = 0.0;
    let mut poses: Vec<Pose2> = Vec::new();
    for pose in path.iter().map(|pose| pose.map_from_robot) {
        gone += poses.last().map_or(0.0, |last| last.position().distance(pose.position()));
        poses.push(pose);
        if gone >= most {
            break;
        }
    }
    poses
}

/// A motion that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Made {
    /// Its plan, where it was planned.
    pub plan: Option<Plan>,
    /// What kind of motion.
    pub name: &'static str,
    /// The places before it, map frame, and their weights.
    pub places: Vec<(Pose2, f64)>,
    /// The row with which it began.
    pub row: usize,
    /// Whether a whisker ended it.
    pub stopped: bool,
}

/// What became of a robot.
#[derive(Clone, Debug)]
pub struct Exploration {
    /// Why it ended.
    pub ended: Ended,
    /// What it knows at the end.
    pub answer: Localization,
    /// Way (m) and turn (rad) after the first motion.
    pub way: f64,
    /// As above.
    pub turn: f64,
    /// The motions after the first.
    pub motions: Vec<Made>,
    /// What it recorded.
    pub log: SensorLog,
    /// Where it was, row by row.
    pub truth: Vec<StampedPose>,
    /// Whether footprint or a whisker's base came to a boundary.
    pub collided: bool,
    /// The largest moment at a whisker's base after the first motion, over what is gentle.
    pub hardest: f64,
    /// The row of the log from which on the answer is of: no place explained what came before, and the robot began anew.
    pub since: usize,
    /// What happened to the whiskers.
    pub events: Vec<Event>,
}

/// Lets a robot go along `begin` (map frame), at least two waypoints, and then on by its own motions until it knows where it is.
///
/// Whiskers must be free at the first waypoint; the motion ends where one feels as much as other motions end at. The same arguments give the same answer.
///
/// # Errors
///
/// Options out of range, a start that touches, and robots that [`plan`] or the method do not take.
pub fn explore(
    stage: &Stage,
    begin: &[Pose2],
    method: &Method,
    noise: &SweepNoise,
    options: &ExploreOptions,
) -> Result<Exploration> {
    explore_by(stage, begin, method, noise, options, Strategy::Planned)
}

/// As [`explore`], by another strategy, to compare with.
///
/// # Errors
///
/// As [`explore`]; a robot that [`WallFollower`] does not take.
pub fn explore_by(
    stage: &Stage,
    begin: &[Pose2],
    method: &Method,
    noise: &SweepNoise,
    options: &ExploreOptions,
    strategy: Strategy<'_>,
) -> Result<Exploration> {
    explore_watched(stage, begin, method, noise, options, strategy, &mut |_| ControlFlow::Continue(()))
}

/// An exploration under way.
pub struct Underway<'a> {
    under: &'a Under<'a>,
    is_long: bool,
}

impl Underway<'_> {
    /// Whether what comes next may take long: the choice of a motion, or the search for the whole answer.
    #[must_use]
    pub fn is_long(&self) -> bool {
        self.is_long
    }

    /// How many motions were begun after the first.
    #[must_use]
    pub fn motions(&self) -> usize {
        self.under.motions().len()
    }

    /// The way (m) after the first motion.
    #[must_use]
    pub fn way(&self) -> f64 {
        self.under.way()
    }

    /// What would be left if it ended now: [`Ended::Interrupted`], with what the estimator tells row by row as the answer.
    #[must_use]
    pub fn so_far(&self) -> Exploration {
        self.under.so_far()
    }
}

/// Looks on after each row, and before work that may take long; `Break` ends the exploration.
pub type Onlooker<'a> = dyn FnMut(&Underway<'_>) -> ControlFlow<()> + 'a;

/// As [`explore_by`], with somebody who looks on and may end it: what is known by then is returned, as [`Underway::so_far`] tells it.
///
/// # Errors
///
/// As [`explore_by`].
pub fn explore_watched(
    stage: &Stage,
    begin: &[Pose2],
    method: &Method,
    noise: &SweepNoise,
    options: &ExploreOptions,
    strategy: Strategy<'_>,
    onlooker: &mut Onlooker<'_>,
) -> Result<Exploration> {
    options.plan.check()?;
    let path = path_through(begin, &options.pace)?;
    let Some(&first) = path.first() else { return Err(Error::usage("the first motion holds no pose")) };
    let mut under = Under::new(stage, first, method, noise, options)?;
    under.begin(&path[1..], onlooker)?;
    under.run(strategy, onlooker)
}
