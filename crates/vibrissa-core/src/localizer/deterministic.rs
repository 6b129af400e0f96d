//! The deterministic estimator: rows in, a state set that shrinks, a choice at the end.

mod agenda;
mod feeler;

use super::method::MethodOptions;
use super::sampling::{near, samples};
use super::{Estimator, STRAIGHT_ONLY};
use crate::beam::Whisker;
use crate::config::{DeterministicOptions, Setting};
use crate::flow::pose::{self, Estimate, Event, Evidence, Hypothesis, Localization, ShapeRecord, StampedPose, Verdict};
use crate::flow::preimage::Observation;
use crate::flow::sensor_log::{Channel, LogRow, SensorLog, one_owner_each};
use crate::flow::state_set::{Candidate, StateSet};
use crate::plane::Pose2;
use crate::world::{BoundarySample, Map, Robot};
use crate::{Error, Result, Stop, WorkBudget};
use agenda::{Due, Task};
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
    agenda: Vec<Task>,
    has_ended: bool,
    record: RunRecord,
    stop: Stop,
}

impl<'a> DeterministicEstimator<'a> {
    /// An estimator for logs with these channels.
    ///
    /// # Errors
    ///
    /// Options out of range, a whisker without a moment channel, a whisker that is curved at rest, or a map with unknown stretches.
    pub fn new(map: &'a Map, robot: &'a Robot, channels: &[Channel], options: DeterministicOptions) -> Result<Self> {
        options.check()?;
        let options = widened(map, options)?;
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
            agenda: Vec::new(),
            has_ended: false,
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

/// The tolerances with what the map's bands leave open; an unknown stretch has no preimage.
fn widened(map: &Map, options: DeterministicOptions) -> Result<DeterministicOptions> {
    if !map.unknown().is_empty() {
        return Err(Error::data("the deterministic method needs a map without unknown stretches")
            .remedy("use --method probabilistic or possibilistic, for which they rule nothing out"));
    }
    Ok(DeterministicOptions {
        position_floor: options.position_floor + map.widest_bound(),
        heading_floor: options.heading_floor + map.widest_slope(),
        ..options
    })
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
        let begun = self.begin(row);
        self.go_on(&mut WorkBudget::unlimited());
        begun
    }

    fn begin(&mut self, row: &LogRow) -> Result<()> {
        self.go_on(&mut WorkBudget::unlimited());
        if row.heading.is_some_and(f64::is_finite) {
            return Err(Error::data("the deterministic method takes no absolute headings")
                .at_line(row.line)
                .remedy("take the probabilistic or the possibilistic method, or remove the column `heading`"));
        }
        let start = *self.start.get_or_insert(row.odom_from_robot);
        let row = LogRow { odom_from_robot: start.between(row.odom_from_robot), ..row.clone() };
        self.states.project(row.odom_from_robot, &self.robot.odometry);
        self.rows.push((row.t, row.odom_from_robot));
        // Whiskers before one that cannot have caused its reading feel the row.
        let refused =
            self.feelers.iter().map(|feeler| feeler.check(&row)).enumerate().find(|(_, checked)| checked.is_err());
        let (end, checked) = refused.unwrap_or((self.feelers.len(), Ok(())));
        self.agenda.push(Task::Feel { row, next: 0, end, due: self.due.len() });
        checked
    }

    fn advance(&mut self, budget: &mut WorkBudget) -> bool {
        self.go_on(budget)
    }

    fn end(&mut self) {
        self.go_on(&mut WorkBudget::unlimited());
        if !self.has_ended {
            self.has_ended = true;
            let (t, odom_from_robot) = self.rows.last().copied().unwrap_or((0.0, Pose2::IDENTITY));
            let row = LogRow { t, odom_from_robot, readings: Vec::new(), heading: None, line: 0 };
            self.agenda.push(Task::LetGo { row, next: 0 });
        }
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
        if !self.has_ended {
            self.end();
        }
        // Meetings alone refine the answer.
        let may_end = |agenda: &[Task]| agenda.iter().all(|task| matches!(task, Task::Work { .. }));
        loop {
            let is_due = self.stop.is_asked() && may_end(&self.agenda);
            if is_due || self.go_on(&mut WorkBudget::new(LAST_UNITS)) {
                break;
            }
        }
        let (t, odom_from_robot) = self.rows.last().copied().unwrap_or((0.0, Pose2::IDENTITY));
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

/// Meetings of a candidate with an observation in one row, some microseconds each,
const MEETINGS: usize = 150;
/// but at least this part of all that are due, so that the set does not fall further behind.
const ROWS_BEHIND: usize = 20;
/// Work between two looks at whether the end is asked for: some ten milliseconds.
const LAST_UNITS: usize = 50_000;
/// Points of a drawn whisker.
const SHAPE_POINTS: usize = 24;
