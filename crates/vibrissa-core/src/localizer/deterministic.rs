//! The deterministic estimator: rows in, a state set that shrinks, a choice at the end.

mod feeler;

use super::method::MethodOptions;
use super::sampling::{near, samples};
use super::{Estimator, STRAIGHT_ONLY};
use crate::beam::Whisker;
use crate::config::{DeterministicOptions, Setting};
use crate::flow::moment::MomentHistory;
use crate::flow::pose::{
    self, Estimate, Event, Evidence, Hypothesis, Localization, ShapeRecord, StampedPose, StepRecord, Verdict,
};
use crate::flow::preimage::Observation;
use crate::flow::sensor_log::{Channel, LogRow, SensorLog, one_owner_each};
use crate::flow::state_set::{Candidate, Pass, StateSet};
use crate::plane::Pose2;
use crate::world::{BoundarySample, Map, Robot};
use crate::{Error, Result, Stop};
use feeler::{RunRecord, WhiskerColumn};
use std::collections::VecDeque;

/// The deterministic estimator \[routray, section "Robot Localization"\]: rows in, a state set that shrinks.
///
/// What it says before the end leaves out observations that the candidates have not met yet: these are taken in over the
/// rows that follow.
pub struct DeterministicEstimator<'a> {
    map: &'a Map,
    robot: &'a Robot,
    options: DeterministicOptions,
    samples: Vec<BoundarySample>,
    feelers: Vec<WhiskerColumn>,
    states: StateSet,
    /// The robot at the first row, odometry frame: everything is told from there, so that the odometry may start
    /// thousands of kilometres from its origin without costing digits.
    start: Option<Pose2>,
    rows: Vec<(f64, Pose2)>,
    due: VecDeque<Due>,
    record: RunRecord,
    stop: Stop,
}

/// What the set still has to be told, in the order in which it happened.
enum Due {
    /// An observation of a feeler, and how far it has got.
    Meet { feeler: usize, observation: Box<Observation>, pass: Pass },
    /// The whisker of this mount was free or jumped.
    LiftOff(Pose2),
}

impl<'a> DeterministicEstimator<'a> {
    /// An estimator for logs with these channels.
    ///
    /// # Errors
    ///
    /// Options out of range, a whisker without a moment channel, or a whisker that is curved at rest.
    pub fn new(map: &'a Map, robot: &'a Robot, channels: &[Channel], options: DeterministicOptions) -> Result<Self> {
        options.check()?;
        let log = SensorLog { channels: channels.to_vec(), ..SensorLog::default() };
        one_owner_each(robot, channels)?;
        let feelers =
            robot.whiskers.iter().map(|w| WhiskerColumn::new(w, &log, &options)).collect::<Result<Vec<_>>>()?;
        Ok(Self {
            map,
            robot,
            samples: samples(map, robot, &options)?,
            options,
            feelers,
            states: StateSet::default(),
            start: None,
            rows: Vec::new(),
            due: VecDeque::new(),
            record: RunRecord::default(),
            stop: Stop::default(),
        })
    }

    /// The candidates so far, of which some may still have to meet the last observations; their odometry frame is moved to
    /// the robot's pose at the first row.
    #[must_use]
    pub fn states(&self) -> &StateSet {
        &self.states
    }

    /// Tells the set what is due, for at most so many meetings of a candidate with an observation.
    fn work(&mut self, row: &LogRow, mut meetings: usize) {
        while let Some(due) = self.due.pop_front() {
            let (feeler, observation, mut pass) = match due {
                Due::Meet { feeler, observation, pass } => (feeler, observation, pass),
                Due::LiftOff(robot_from_whisker) => {
                    self.states.lift_off(robot_from_whisker);
                    continue;
                }
            };
            let open = pass.open(self.states.candidates().len());
            if !self.states.advance(self.map, &observation, &self.options, &mut pass, meetings) {
                return self.due.push_front(Due::Meet { feeler, observation, pass });
            }
            self.record.observations.push((feeler, *observation));
            self.note(row);
            if self.record.empty_at.is_some() {
                return self.due.clear();
            }
            meetings = meetings.saturating_sub(open);
        }
    }

    /// One update: history → contact sets → alignment → preimage → intersection, the last when its turn comes.
    fn update(&mut self, feeler: usize, history: &MomentHistory, row: &LogRow) {
        let WhiskerColumn { whisker, tip, contacts, .. } = &mut self.feelers[feeler];
        if self.record.empty_at.is_some() {
            return;
        }
        if !history.smooth {
            self.due.push_back(Due::LiftOff(whisker.robot_from_whisker));
            let detail = format!(
                "{}: the readings jump by more than their declared noise; this stretch of contact is not used",
                whisker.name
            );
            return self.record.event_once(row.t, "rough", detail);
        }
        let observation = Observation::with(whisker, tip, history, &mut |moment| contacts.branches(moment));
        if self.record.first_row.is_some() {
            let pass = self.states.pass();
            return self.due.push_back(Due::Meet { feeler, observation: Box::new(observation), pass });
        }
        self.record.waiting.push((feeler, observation));
        let open = self.record.waiting.iter().map(|(_, o)| o.open_slopes()).fold(f64::INFINITY, f64::min);
        match self.record.waiting.len() {
            // Observations that cannot be aligned at all start nothing.
            waiting if waiting >= LATEST_START && open.is_infinite() => drop(self.record.waiting.remove(0)),
            waiting if waiting >= LATEST_START || (waiting >= EARLIEST_START && open <= NARROW_START) => {
                self.start_set(row);
            }
            _ => {}
        }
    }

    /// Lets candidates in.
    fn start_set(&mut self, row: &LogRow) {
        let (feelers, waiting): (Vec<usize>, Vec<Observation>) = self.record.waiting.drain(..).unzip();
        if let Some(region) = self.options.prior {
            self.samples = near(self.map, self.robot, region, &waiting, &self.options);
        }
        self.states.start(self.map, &self.samples, &waiting, &self.options);
        self.record.first_row = Some(self.rows.len() - 1);
        self.record.first_states = self.states.states(row.odom_from_robot).collect();
        feelers.into_iter().zip(waiting).for_each(|observation| self.record.observations.push(observation));
        self.note(row);
    }

    /// Writes down what the last update did.
    fn note(&mut self, row: &LogRow) {
        self.record.steps.push(self.measure(row));
        let now = self.rows.len() - 1;
        match self.states.best() {
            Some(best) => self.record.last = Some((*best, now)),
            None => self.record.emptied(row.t, now),
        }
    }

    fn measure(&self, row: &LogRow) -> StepRecord {
        let components = self.states.places(row.odom_from_robot);
        let (area_m2, volume) = self.states.size(row.odom_from_robot, self.options.boundary_spacing);
        StepRecord { t: row.t, components, area_m2, volume }
    }

    fn verdict(&self, places: &[Hypothesis]) -> Verdict {
        let emptied = self.record.empty_at.is_some();
        pose::verdict(&Evidence { touched: self.record.touched, emptied, places, ..Evidence::default() })
    }

    /// The best hypothesis along the rows, from the first estimate to the last row that any state explains.
    fn trajectory(&self) -> Vec<StampedPose> {
        let (Some(first), Some((best, last))) = (self.record.first_row, self.record.last) else { return Vec::new() };
        let end = if self.record.empty_at.is_some() { last + 1 } else { self.rows.len() };
        let stamped = |&(t, odom_from_robot): &(f64, Pose2)| StampedPose {
            t,
            map_from_robot: best.map_from_odom.compose(odom_from_robot),
        };
        self.rows[first..end].iter().map(stamped).collect()
    }

    /// The whisker's shapes as the best candidate sees them.
    fn shapes(&self, best: &Candidate) -> Vec<ShapeRecord> {
        let shape = |(feeler, observation): &(usize, Observation)| {
            let contact = best.contact(self.map, observation, &self.options)?;
            let points = observation.shape(&contact, SHAPE_POINTS)?;
            let place = |p| observation.robot_from_whisker.transform_point(p);
            let points = points.into_iter().map(place).collect();
            Some(ShapeRecord { t: observation.t, whisker: *feeler, points })
        };
        self.record.observations.iter().filter_map(shape).collect()
    }
}

/// The word for the method.
const NAME: &str = "deterministic";

impl MethodOptions for DeterministicOptions {
    fn name(&self) -> &'static str {
        NAME
    }

    fn summary(&self) -> &'static str {
        "The paper's intersection of discretised preimages"
    }

    fn settings(&mut self) -> Vec<Setting<'_>> {
        self.settings()
    }

    fn check(&self) -> Result<()> {
        self.check()
    }

    fn takes(&self, whisker: &Whisker) -> Result<()> {
        whisker.require_straight().map_err(|error| error.remedy(STRAIGHT_ONLY))
    }

    fn estimator<'a>(&self, map: &'a Map, robot: &'a Robot, channels: &[Channel]) -> Result<Box<dyn Estimator + 'a>> {
        Ok(Box::new(DeterministicEstimator::new(map, robot, channels, *self)?))
    }
}

impl Estimator for DeterministicEstimator<'_> {
    fn step(&mut self, row: &LogRow) -> Result<()> {
        if row.heading.is_some_and(f64::is_finite) {
            return Err(Error::data("the deterministic method takes no absolute headings")
                .at_line(row.line)
                .remedy("take the probabilistic or the possibilistic method, or remove the column `heading`"));
        }
        let start = *self.start.get_or_insert(row.odom_from_robot);
        let row = &LogRow { odom_from_robot: start.between(row.odom_from_robot), ..row.clone() };
        self.states.project(row.odom_from_robot, &self.robot.odometry);
        self.rows.push((row.t, row.odom_from_robot));
        let due = self.due.len();
        for index in 0..self.feelers.len() {
            let touched = self.feelers[index].in_contact;
            let history = self.feelers[index].feel(row, &mut self.record)?;
            if let Some(history) = history {
                self.update(index, &history, row);
            }
            if touched && !self.feelers[index].in_contact {
                self.due.push_back(Due::LiftOff(self.feelers[index].whisker.robot_from_whisker));
            }
        }
        // A row that makes an observation has its work.
        let share = if self.due.len() > due { 4 } else { 1 };
        let open = self.due.len() * self.states.candidates().len();
        self.work(row, MEETINGS.max(open / ROWS_BEHIND) / share);
        Ok(())
    }

    fn estimate(&self) -> Estimate {
        let Some(&(_, odom_from_robot)) = self.rows.last() else { return Estimate::default() };
        let hypotheses = pose::choose(&self.states, odom_from_robot, &self.options);
        Estimate { status: self.verdict(&hypotheses).status, hypotheses, rows: self.rows.len() }
    }

    fn states_now(&self) -> Vec<Pose2> {
        self.rows.last().map_or_else(Vec::new, |&(_, odom)| self.states.states(odom).collect())
    }

    fn heed(&mut self, stop: &Stop) {
        self.stop = stop.clone();
    }

    fn finish(mut self: Box<Self>) -> Localization {
        let (t, odom_from_robot) = self.rows.last().copied().unwrap_or((0.0, Pose2::IDENTITY));
        let last = LogRow { t, odom_from_robot, readings: Vec::new(), heading: None, line: 0 };
        for index in 0..self.feelers.len() {
            if let Some(history) = self.feelers[index].track.end() {
                self.update(index, &history, &last);
            }
        }
        if self.record.waiting.iter().any(|(_, o)| o.open_slopes().is_finite()) {
            self.start_set(&last);
        }
        while !self.due.is_empty() && !self.stop.is_asked() {
            self.work(&last, LAST_MEETINGS);
        }
        let hypotheses = pose::choose(&self.states, odom_from_robot, &self.options);
        let status = self.verdict(&hypotheses).status;
        if self.record.touched && self.record.steps.is_empty() {
            let detail = "the contact was too short or too rough to align a whisker shape with the map; \
                          keep the whisker on the wall for a longer, smoother sweep"
                .to_owned();
            self.record.events.push(Event { t, kind: "too_short", detail });
        }
        self.record.events.extend(super::unused_errors(self.robot, t));
        self.record.events.sort_by(|a, b| a.t.total_cmp(&b.t));
        let best = self.record.last.map(|(candidate, _)| candidate);
        Localization {
            nuisances: Vec::new(),
            consistency: None,
            unsure: Vec::new(),
            method: NAME,
            status,
            estimate: hypotheses.first().map(|h| h.pose),
            trajectory: self.trajectory(),
            states: self.states.states(odom_from_robot).map(crate::sets::StateBox::point).collect(),
            encloses: false,
            first_states: std::mem::take(&mut self.record.first_states),
            odometry: None,
            shapes: best.map_or_else(Vec::new, |best| self.shapes(&best)),
            steps: self.record.steps,
            events: self.record.events,
            hypotheses,
        }
    }
}

/// The state set starts from this many observations at least, as the paper's does,
const EARLIEST_START: usize = 3;
/// as soon as one leaves no more slopes of the boundary open than this (rad),
const NARROW_START: f64 = 0.8;
/// and from this many in any case.
const LATEST_START: usize = 8;
/// Meetings of a candidate with an observation in one row, some microseconds each,
const MEETINGS: usize = 150;
/// but at least this part of all that are due, so that the set does not fall further behind.
const ROWS_BEHIND: usize = 20;
/// Meetings between two looks at whether the end is asked for: some ten milliseconds.
const LAST_MEETINGS: usize = 5_000;
/// Points of a drawn whisker.
const SHAPE_POINTS: usize = 24;
