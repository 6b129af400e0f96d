//! One door for every estimator: rows in, what can be said now at any row, an answer at the end.
//!
//! [`Localizer`] is for robots that are running; `vibrissa::localize` is the same in one call for whole logs.
//! What differs between methods stands in one file each behind [`Estimator`].

mod bounded_reading;
mod deterministic;
mod drawn;
mod limit_check;
mod method;
mod possibilistic;
mod probabilistic;
mod sampling;

pub use deterministic::DeterministicEstimator;
pub use method::Method;
pub use possibilistic::PossibilisticEstimator;
pub use probabilistic::ProbabilisticEstimator;

use crate::config::limits::COARSEST_SPACING;
use crate::flow::pose::{Estimate, Event, Localization};
use crate::flow::sensor_log::{Channel, LogRow};
use crate::plane::Pose2;
use crate::world::{Map, Robot};
use crate::{Error, Result, Stop, WorkBudget};
use limit_check::LimitCheck;

/// What every method of localization is: it takes rows, says at any row what is known, and answers at the end.
pub trait Estimator: Send {
    /// Takes in one row.
    ///
    /// # Errors
    ///
    /// A reading that the whisker cannot cause; the message names the line.
    fn step(&mut self, row: &LogRow) -> Result<()>;

    /// As [`Estimator::step`], but what takes long is left to [`Estimator::advance`], for callers that must be able to answer within
    /// milliseconds. What an earlier row has left is done first. A method that cannot pause does all of it here.
    ///
    /// # Errors
    ///
    /// As [`Estimator::step`].
    fn begin(&mut self, row: &LogRow) -> Result<()> {
        self.step(row)
    }

    /// Goes on with the work that is left until the budget is spent; whether none is left. Where it pauses changes no answer.
    ///
    /// In between, [`Estimator::estimate`] may be asked: it then knows the newest row in part.
    fn advance(&mut self, budget: &mut WorkBudget) -> bool {
        let _ = budget;
        true
    }

    /// Says that no more rows come: the work of the end is begun, and left to [`Estimator::advance`]. [`Estimator::finish`] does what
    /// is left then. A method that cannot pause leaves all of it to that.
    fn end(&mut self) {}

    /// What can be said at the last row: verdict, places and extents. It changes nothing: the answer at the end is the same,
    /// however often this is asked.
    ///
    /// It takes a tenth of a millisecond in the median, some milliseconds while there are thousands of candidates, for which
    /// it is less exact than [`Estimator::finish`]; each estimator says in what.
    fn estimate(&self) -> Estimate;

    /// The states at the last row that explain the rows so far (map frame): candidates, middles of cells, or best fits, as
    /// the method has them. Empty before the first contact has told.
    fn states_now(&self) -> Vec<Pose2>;

    /// Takes a request to end early: once it is asked for, what refines the answer ends within milliseconds, and the answer is as right, but
    /// less sharp. An estimator that does not look at it ends in its own time.
    fn heed(&mut self, stop: &Stop) {
        let _ = stop;
    }

    /// Ends the log and chooses.
    fn finish(self: Box<Self>) -> Localization;
}

/// A robot that is being localized, row by row, by any method.
pub struct Localizer<'a> {
    estimator: Box<dyn Estimator + 'a>,
    has_ended: bool,
}

impl<'a> Localizer<'a> {
    /// A localizer by a method, for logs with these channels.
    ///
    /// # Errors
    ///
    /// Options out of range, a whisker without a channel, or a robot or a map that the method does not cover.
    pub fn new(map: &'a Map, robot: &'a Robot, channels: &[Channel], method: &Method) -> Result<Self> {
        Ok(Self { estimator: method.estimator(map, robot, channels)?, has_ended: false })
    }

    /// A localizer by an estimator of one's own.
    #[must_use]
    pub fn by(estimator: impl Estimator + 'a) -> Self {
        Self { estimator: Box::new(estimator), has_ended: false }
    }

    /// Takes in one row.
    ///
    /// # Errors
    ///
    /// As [`Estimator::step`], a time or a pose that is no number, or a row after the end.
    pub fn step(&mut self, row: &LogRow) -> Result<()> {
        self.check(row)?;
        self.estimator.step(row)
    }

    /// Takes in one row and leaves what takes long to [`Localizer::advance`], see [`Estimator::begin`].
    ///
    /// # Errors
    ///
    /// As [`Localizer::step`].
    pub fn begin(&mut self, row: &LogRow) -> Result<()> {
        self.check(row)?;
        self.estimator.begin(row)
    }

    /// Goes on with the work that is left until the budget is spent; whether none is left.
    ///
    /// ```
    /// use vibrissa_core::flow::sensor_log::{Channel, LogRow, Quantity};
    /// use vibrissa_core::plane::{Curve, Pose2, Vec2};
    /// use vibrissa_core::world::{Boundary, Map, Robot, Role};
    /// use vibrissa_core::WorkBudget;
    /// use vibrissa_core::localizer::{Localizer, Method};
    ///
    /// let corners = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.3), (0.0, 0.3)].map(|(x, y)| Vec2::new(x, y));
    /// let map = Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None)?])?;
    /// let (robot, channels) = (Robot::default(), [Channel { whisker: String::new(), quantity: Quantity::Moment }]);
    /// let method = Method::named("possibilistic")?;
    /// let mut localizer = Localizer::new(&map, &robot, &channels, &method)?;
    /// for k in 0..20 {
    ///     let odom_from_robot = Pose2::new(1e-3 * f64::from(k), 0.0, 0.0);
    ///     localizer.begin(&LogRow { t: f64::from(k), odom_from_robot, readings: vec![2e-3], heading: None, line: 0 })?;
    ///     // Answer others, look at the clock, or stop here.
    ///     while !localizer.advance(&mut WorkBudget::new(1000)) {}
    /// }
    /// localizer.end();
    /// while !localizer.advance(&mut WorkBudget::new(1000)) {}
    /// assert!(!localizer.finish().hypotheses.is_empty());
    /// # Ok::<(), vibrissa_core::Error>(())
    /// ```
    pub fn advance(&mut self, budget: &mut WorkBudget) -> bool {
        self.estimator.advance(budget)
    }

    /// Says that no more rows come and leaves the work of the end to [`Localizer::advance`], see [`Estimator::end`].
    pub fn end(&mut self) {
        if !self.has_ended {
            self.has_ended = true;
            self.estimator.end();
        }
    }

    /// Refuses what no estimator has to take. Readings are checked where they are used.
    fn check(&self, row: &LogRow) -> Result<()> {
        if !self.has_ended {
            return row.check([]);
        }
        Err(Error::usage("a row after the end of the log").value(row.t).remedy("begin anew with another Localizer"))
    }

    /// What can be said at the last row, see [`Estimator::estimate`].
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        self.estimator.estimate()
    }

    /// The states at the last row that explain the rows so far, map frame.
    #[must_use]
    pub fn states_now(&self) -> Vec<Pose2> {
        self.estimator.states_now()
    }

    /// Takes a request to end early, see [`Estimator::heed`].
    pub fn heed(&mut self, stop: &Stop) {
        self.estimator.heed(stop);
    }

    /// Ends the log and chooses.
    #[must_use]
    pub fn finish(self) -> Localization {
        self.estimator.finish()
    }
}

/// What a method that takes declared errors for none says about them.
fn unused_errors(robot: &Robot, t: f64) -> Option<Event> {
    let keys = robot.declared_errors();
    (!keys.is_empty()).then(|| Event {
        t,
        kind: "unused",
        detail: format!(
            "this method takes {} of the robot file for 0, so that places may be told too sharply; --method probabilistic \
             estimates them",
            keys.join(", ")
        ),
    })
}

/// What to do with a whisker that is curved at rest.
const STRAIGHT_ONLY: &str =
    "this method takes whiskers that are straight at rest; `localize --method possibilistic` takes this one, too";
/// What to do where a search of the whole map would take too long: the option, and how the ROS 2 node takes it.
const FIRST_POSE: &str =
    "say where the robot is at the first row (option --within; of the ROS 2 node, the topic initialpose)";
/// At least this many observations are kept for drawing, where there are as many.
const SHAPES: usize = 512;

/// Refuses a map with more boundary than a search without a region goes through in a time that anybody waits.
fn searchable(map: &Map, prior: Option<[[f64; 2]; 3]>, most: f64) -> Result<()> {
    let (walked, _) = map.walk_in(map.bounds(), COARSEST_SPACING);
    if prior.is_some() || walked <= most {
        return Ok(());
    }
    Err(Error::data("the map has too much boundary to search all of it for the robot")
        .value(format!("{walked:.1} m"))
        .allowed(format!("up to {most} m, or a region for the first pose"))
        .remedy(format!("{FIRST_POSE}, or use the part of the map that it can be in")))
}
