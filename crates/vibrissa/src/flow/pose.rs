//! The last door: the only place that chooses, and it says how wide the choice was.

use crate::plane::{Pose2, Vec2};
use crate::sets::StateBox;

/// The verdict on a whole log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// One place explains the log.
    Localized,
    /// Several separate places explain the log.
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
}

/// One place that explains the log, kept apart from every other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// The chosen state at the last row, map frame.
    pub pose: Pose2,
    /// Its share among all hypotheses; the shares sum to 1.
    pub weight: f64,
    /// The extent of the component that it stands for.
    pub extent: StateBox,
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
    /// The final state set; for the deterministic method its surviving points.
    pub states: Vec<StateBox>,
    /// The candidates after the first observation, moved to the last row by the known motion.
    pub first_states: Vec<Pose2>,
    /// The set's size after each update.
    pub steps: Vec<StepRecord>,
    /// What happened along the way.
    pub events: Vec<Event>,
    /// Whisker shapes along the sweep, for drawing.
    pub shapes: Vec<ShapeRecord>,
}
