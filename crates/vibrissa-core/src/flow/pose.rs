//! The last door: the only place that chooses, and it says how wide the choice was.

use super::state_set::probabilistic::corrected;
use super::state_set::{Candidate, StateSet, components};
use crate::config::DeterministicOptions;
use crate::plane::{Pose2, Vec2};
use crate::sets::StateBox;

/// The verdict on a whole log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// One place explains the log.
    Localized,
    /// Several separate places explain the log, or the contact was too short to tell any place.
    Ambiguous,
    /// No state explains this log on this map.
    Inconsistent,
    /// The whisker never touched anything.
    NoContact,
}

/// Which estimator made the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The paper's intersection of discretised preimages.
    Deterministic,
    /// Guaranteed bounds on the state: what is outside is ruled out.
    Possibilistic,
    /// Least squares over all readings at every place that explains them, with calibrated weights.
    Probabilistic,
}

/// One place that explains the log, kept apart from every other.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// The chosen state at the last row, map frame.
    pub pose: Pose2,
    /// Its share among all hypotheses; the shares sum to 1.
    pub weight: f64,
    /// The extent of the component that it stands for.
    pub extent: StateBox,
    /// Covariance of (x, y, heading) in the map frame (m², m rad, rad²), where the method gives one: what the declared
    /// noise and odometry bounds leave open at this place.
    pub covariance: Option<[[f64; 3]; 3]>,
    /// The curve along which the readings leave the place open, where the method gives one and the place is longer than 4 mm:
    /// states at the last row (map frame), in order from one end of what the readings allow to the other, each a fit of its
    /// own; else empty. Between neighbours states lie on a straight line, their headings on the shorter way.
    pub ridge: Vec<Pose2>,
}

impl Hypothesis {
    /// The error to be expected: root mean square of the position (m) and of the heading (rad), where the method gives a
    /// covariance.
    #[must_use]
    pub fn bound(&self) -> Option<(f64, f64)> {
        self.covariance.map(|c| ((c[0][0] + c[1][1]).max(0.0).sqrt(), c[2][2].max(0.0).sqrt()))
    }

    /// How far the robot's positions go along the ridge (m), where there is one.
    #[must_use]
    pub fn ridge_length(&self) -> Option<f64> {
        let length = self.ridge.windows(2).map(|w| w[0].position().distance(w[1].position())).sum();
        (self.ridge.len() > 1).then_some(length)
    }
}

/// Something that happened at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When (s).
    pub t: f64,
    /// A short fixed word: `contact`, `lift_off`, `inconsistent`, …
    pub kind: &'static str,
    /// What happened, for people.
    pub detail: String,
}

/// The state set after one update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepRecord {
    /// When (s).
    pub t: f64,
    /// How many separate components the set has.
    pub components: usize,
    /// Area of the set's projection onto the plane (m²).
    pub area_m2: f64,
    /// Volume of the set (m² rad).
    pub volume: f64,
}

/// The robot at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StampedPose {
    /// When (s).
    pub t: f64,
    /// The robot in the map frame.
    pub map_from_robot: Pose2,
}

/// One reconstructed whisker shape.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeRecord {
    /// When (s).
    pub t: f64,
    /// Points along the whisker from base to tip, robot frame (m).
    pub points: Vec<Vec2>,
}

/// What the readings say about the odometry: each of its increments has to be stretched, turned aside and turned further alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryEstimate {
    /// The true length of an increment over the one that odometry gives; 1 where it is right.
    pub translation_scale: f64,
    /// Its standard deviation.
    pub translation_scale_std: f64,
    /// How far increments go to the left of where odometry says (rad).
    pub aside: f64,
    /// Its standard deviation (rad).
    pub aside_std: f64,
    /// The true turn of an increment over the one that odometry gives; 1 where it is right.
    pub rotation_scale: f64,
    /// Its standard deviation.
    pub rotation_scale_std: f64,
}

impl OdometryEstimate {
    /// An increment of the odometry (robot frame), corrected.
    #[must_use]
    pub fn corrected(&self, increment: Pose2) -> Pose2 {
        corrected(increment, [self.translation_scale - 1.0, self.aside, self.rotation_scale - 1.0])
    }
}

/// What a log and a map say about the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Localization {
    /// The estimator that made this answer.
    pub method: Method,
    /// The verdict.
    pub status: Status,
    /// The best hypothesis at the last row, map frame.
    pub estimate: Option<Pose2>,
    /// Every surviving place, heaviest first, never averaged over separate places.
    pub hypotheses: Vec<Hypothesis>,
    /// The best hypothesis over time, one entry for each log row from the first estimate on.
    pub trajectory: Vec<StampedPose>,
    /// What is said about the odometry, by the probabilistic method where the robot declares that it may be wrong.
    pub odometry: Option<OdometryEstimate>,
    /// The final state set; for the deterministic method its surviving points.
    pub states: Vec<StateBox>,
    /// The candidates after the first observation, at that time: the first row of the trajectory.
    pub first_states: Vec<Pose2>,
    /// The set's size after each update.
    pub steps: Vec<StepRecord>,
    /// What happened along the way.
    pub events: Vec<Event>,
    /// Whisker shapes along the sweep, for drawing.
    pub shapes: Vec<ShapeRecord>,
}

/// A single place larger than this (m, rad) is not called localized: its candidates do not agree on where it is.
const LARGEST_PLACE: f64 = 0.02;
const LARGEST_TURN: f64 = 0.35;
/// Candidates less likely than the best by this factor stay in the state set, but nobody would bet on them.
const LEAST_LIKELIHOOD: f64 = 1e-2;

/// One hypothesis for each separate place that is worth a bet, at the odometry's `odom_from_robot`, the heaviest first.
///
/// A candidate's likelihood is that of its misfit, if the tolerance is as many standard deviations as it says and a
/// missed observation was missed by a whole tolerance. Candidates within a factor of 100 of the best are grouped into
/// separate places; each place stands for its best candidate, and is as wide as its group with the `tolerance` standard
/// deviations of each.
#[must_use]
pub fn choose(states: &StateSet, odom_from_robot: Pose2, options: &DeterministicOptions) -> Vec<Hypothesis> {
    let Some(best) = states.best() else { return Vec::new() };
    let independent = (options.update_travel / options.history_travel).min(1.0);
    let half_chi = 0.5 * options.tolerance * options.tolerance * independent;
    let likelihood = |c: &Candidate| (-half_chi * (c.rank() - best.rank())).exp();
    let likely: Vec<Candidate> =
        states.candidates().iter().filter(|c| likelihood(c) >= LEAST_LIKELIHOOD).copied().collect();
    let mut hypotheses: Vec<Hypothesis> = components(&likely, odom_from_robot)
        .iter()
        .map(|place| {
            let chosen = &likely[place.members[0]];
            let pose = chosen.map_from_odom.compose(odom_from_robot);
            let own = |&i: &usize| likely[i].extent(odom_from_robot, options.tolerance);
            let extent = place.members.iter().map(own).fold(StateBox::EMPTY, |all, one| all.hull(&one));
            Hypothesis { pose, weight: likelihood(chosen), extent, covariance: None, ridge: Vec::new() }
        })
        .collect();
    let total: f64 = hypotheses.iter().map(|h| h.weight).sum();
    hypotheses.iter_mut().for_each(|h| h.weight /= total);
    hypotheses.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    hypotheses
}

/// The verdict on a log.
#[must_use]
pub fn verdict(touched: bool, became_empty: bool, hypotheses: &[Hypothesis]) -> Status {
    let small = |e: &StateBox| e.x.width().hypot(e.y.width()) <= LARGEST_PLACE && e.theta.width() <= LARGEST_TURN;
    match hypotheses {
        _ if !touched => Status::NoContact,
        [] if became_empty => Status::Inconsistent,
        [only] if small(&only.extent) => Status::Localized,
        _ => Status::Ambiguous,
    }
}
