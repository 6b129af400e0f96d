//! The possibilistic estimator: rows in, a set of states that holds the true one as long as the declared bounds hold.

use super::bounded_reading::{self, LateReadings, RowReadings};
use super::drawn::{DrawnReading, DrawnReadings, ShapeDrawing};
use super::method::MethodOptions;
use super::{Estimator, searchable};
use crate::beam::Whisker;
use crate::config::limits::MOST_COVERED;
use crate::config::{PossibilisticOptions, Setting};
use crate::flow::pose::{
    self, Estimate, Event, Evidence, Hypothesis, Localization, StampedPose, Status, StepRecord, Verdict,
};
use crate::flow::sensor_log::{Channel, LogRow, SensorLog, one_owner_each};
use crate::flow::state_set::possibilistic::{EnclosedPlace, Measurement, PossibleSet};
use crate::plane::Pose2;
use crate::sets::Interval;
use crate::world::{Map, MountedWhisker, Robot};
use crate::{Error, Result, Stop, WorkBudget};

/// Sets of more cells than this are measured once in a while: when their number has changed by this share, or, up to a
/// size, after as many rows as a share of their number.
const MEASURED_AT_ONCE: usize = 24;
const MEASURED_CHANGE: f64 = 0.5;
const MEASURED_WITHIN: usize = 300;
const MEASURED_ROWS: usize = 4;
/// Places of sets of more cells than this are those of the last measurement, carried on, where they are told before the end.
const MEASURED_NOW: usize = 300;
/// Sets of more cells than this keep their volume from one measurement to the next, too.
const SUMMED: usize = 20_000;
/// So many times the work of the final refinement is proposed where it was not enough.
const MORE_WORK: usize = 5;
/// No more is proposed than may be asked for.
const MOST_WORK: usize = 1_000_000_000;
/// Largest friction coefficient: its angle is a right angle less half a degree more than the tables hold.
const LARGEST_FRICTION: f64 = 1.5;

/// At least so many contacts are kept for drawing, where there are as many: each takes a third of a millisecond at the end.
const DRAWN: usize = 48;

/// The possibilistic estimator \[routray, section "Localization: Possibilistic Method"\], sound instead of sampled.
///
/// What it says before the end holds the true state as well. It comes before the last effort, so that extents are wider than
/// in the answer; and in sets of many cells places are those of the row in which the set was last measured, carried on by
/// the odometry with its bounds.
pub struct PossibilisticEstimator<'a> {
    map: &'a Map,
    robot: &'a Robot,
    options: PossibilisticOptions,
    channels: Vec<usize>,
    set: PossibleSet,
    late: LateReadings,
    start: Option<Pose2>,
    rows: Vec<(f64, Pose2)>,
    in_contact: Vec<bool>,
    /// Contacts for drawing: not all of long logs.
    felt: DrawnReadings<DRAWN>,
    touched: bool,
    first_row: Option<usize>,
    first_states: Vec<Pose2>,
    steps: Vec<StepRecord>,
    events: Vec<Event>,
    /// The best place when it was last looked for, and the row.
    last: Option<(Pose2, usize)>,
    /// The row in which the set was last measured, and how many cells it had.
    measured: (usize, usize),
    /// The places then.
    places: Vec<EnclosedPlace>,
    empty: bool,
    phase: Phase,
    has_ended: bool,
    drawing: ShapeDrawing,
}

/// What is still to be done.
enum Phase {
    /// Nothing.
    Idle,
    /// Readings of which it is known where they were taken; at the end all others, too.
    Reading {
        had_started: bool,
        is_over: bool,
    },
    /// The set is measured after a row.
    Measuring {
        measurement: Box<Measurement>,
        is_over: bool,
    },
    /// The last effort of the set.
    Refining,
    /// The set is measured sharply.
    LastMeasuring(Box<Measurement>),
    Drawing,
}

/// Refuses a whisker that leans where its contacts are not those of a turned plane.
fn require_upright_contact(whisker: &MountedWhisker, options: &PossibilisticOptions) -> Result<()> {
    if whisker.lean.is_level() {
        return Ok(());
    }
    whisker.require_turned_plane()?;
    let fault =
        |what: &str| Error::data(format!("the whisker \"{}\" leans out of the horizontal, {what}", whisker.name));
    if whisker.friction > 0.0 {
        return Err(fault("and friction pulls it along an upright wall, out of the plane in which it bends")
            .value(whisker.friction)
            .allowed("a friction of 0")
            .remedy("mount the whisker horizontally, or take its friction into moment_relative"));
    }
    if let Some(distance) = options.two_contacts {
        return Err(fault("and two contacts at once are known of level whiskers alone")
            .value(distance)
            .remedy("leave out two_contacts"));
    }
    Ok(())
}

impl<'a> PossibilisticEstimator<'a> {
    /// An estimator for logs with these channels.
    ///
    /// # Errors
    ///
    /// Options out of range, a whisker without a moment channel, that makes no sense or has a friction coefficient above 1.5.
    pub fn new(map: &'a Map, robot: &'a Robot, channels: &[Channel], options: PossibilisticOptions) -> Result<Self> {
        options.check()?;
        bounded_reading::check(robot)?;
        robot.whiskers.iter().try_for_each(|whisker| require_upright_contact(whisker, &options))?;
        one_owner_each(robot, channels)?;
        searchable(map, options.prior, MOST_COVERED)?;
        let log = SensorLog { channels: channels.to_vec(), ..SensorLog::default() };
        for whisker in &robot.whiskers {
            MethodOptions::takes(&options, &whisker.beam)?;
            if whisker.friction > LARGEST_FRICTION {
                return Err(Error::data(format!("the friction coefficient of the whisker {}", whisker.name))
                    .value(whisker.friction)
                    .allowed(format!("0 to {LARGEST_FRICTION}")));
            }
        }
        Ok(Self {
            channels: robot.whiskers.iter().map(|w| log.moment_channel(&w.name)).collect::<Result<_>>()?,
            set: PossibleSet::new(map, robot, options),
            late: LateReadings::new(&robot.odometry),
            in_contact: vec![false; robot.whiskers.len()],
            felt: DrawnReadings::default(),
            map,
            robot,
            options,
            start: None,
            rows: Vec::new(),
            touched: false,
            first_row: None,
            first_states: Vec::new(),
            steps: Vec::new(),
            events: Vec::new(),
            last: None,
            measured: (0, 0),
            places: Vec::new(),
            empty: false,
            phase: Phase::Idle,
            has_ended: false,
            drawing: ShapeDrawing::default(),
        })
    }

    /// The set so far; its odometry starts at the first row.
    #[must_use]
    pub fn set(&self) -> &PossibleSet {
        &self.set
    }

    /// The intervals that hold the true moments.
    fn moments(&self, row: &LogRow) -> Result<Vec<Interval>> {
        let of = |(whisker, &channel): (&MountedWhisker, &usize)| {
            let z = row.readings.get(channel).copied().unwrap_or(0.0);
            if !z.is_finite() {
                let error = Error::data("a moment that is not a number").value(z).allowed("a finite number of N m");
                return Err(if row.line > 0 { error.at_line(row.line) } else { error });
            }
            let elapsed = row.t - self.rows.first().map_or(row.t, |first| first.0);
            Ok(bounded_reading::moment(whisker, z, elapsed))
        };
        self.robot.whiskers.iter().zip(&self.channels).map(of).collect()
    }

    /// Hands the set the readings of which it is known where they were taken, at the end of the log all others, too; whether it
    /// has taken them.
    fn read(&mut self, is_over: bool, budget: &mut WorkBudget) -> bool {
        loop {
            if !self.set.advance(self.map, budget) {
                return false;
            }
            if self.set.is_empty() {
                return true;
            }
            let Some(row) = self.late.pop(&self.rows, is_over) else { return true };
            let RowReadings { moments, heading } = row.readings;
            match row.late {
                Some(late) => self.set.begin_reading(&moments, heading, late),
                None => self.set.begin_reading(&[], None, (0.0, 0.0)),
            }
        }
    }

    /// Goes on with a phase; the next one, or the same and that it is time to pause.
    fn go_on(&mut self, phase: Phase, budget: &mut WorkBudget) -> (Phase, bool) {
        let (t, now) = (self.rows.last().map_or(0.0, |row| row.0), self.rows.len().saturating_sub(1));
        match phase {
            Phase::Idle => (Phase::Idle, true),
            Phase::Reading { had_started, is_over } => {
                if !self.read(is_over, budget) {
                    return (phase, true);
                }
                let is_first = self.set.has_started() && !had_started;
                let next = if self.set.has_started() && (is_first || !is_over) {
                    self.begin_note(t, had_started, is_over)
                } else {
                    self.after_row(is_over)
                };
                (next, budget.is_spent())
            }
            Phase::Measuring { mut measurement, is_over } => {
                if !measurement.advance(budget) {
                    return (Phase::Measuring { measurement, is_over }, true);
                }
                let step = self.measured(*measurement, t, now);
                self.note(t, step);
                (self.after_row(is_over), budget.is_spent())
            }
            Phase::Refining => {
                if !self.set.advance(self.map, budget) {
                    return (Phase::Refining, true);
                }
                (Phase::LastMeasuring(Box::new(self.set.measurement(true))), budget.is_spent())
            }
            Phase::LastMeasuring(mut measurement) => {
                if !measurement.advance(budget) {
                    return (Phase::LastMeasuring(measurement), true);
                }
                let step = self.measured(*measurement, t, now);
                self.note_end(t, step);
                (self.begin_drawing(), budget.is_spent())
            }
            Phase::Drawing => {
                let frame = self.map_from_odom();
                let whiskers = &self.robot.whiskers;
                let is_done = self.drawing.advance(self.map, whiskers, &|_: &DrawnReading| frame, budget);
                (if is_done { Phase::Idle } else { Phase::Drawing }, true)
            }
        }
    }

    /// What comes after a row: nothing, or the last effort.
    fn after_row(&mut self, is_over: bool) -> Phase {
        if !is_over {
            return Phase::Idle;
        }
        if self.empty || !self.set.has_started() {
            return self.begin_drawing();
        }
        self.set.begin_last_effort();
        Phase::Refining
    }

    fn begin_drawing(&mut self) -> Phase {
        if self.last.is_some() {
            self.drawing = self.felt.drawing(&self.robot.whiskers);
        }
        Phase::Drawing
    }

    /// The odometry's frame in the map, as the best place has it.
    fn map_from_odom(&self) -> Option<Pose2> {
        self.last.map(|(pose, row)| pose.compose(self.rows[row].1.inverse()))
    }

    fn note_contacts(&mut self, t: f64, moments: &[Interval]) {
        for (index, moment) in moments.iter().enumerate() {
            let touching = !moment.contains(0.0);
            if touching != self.in_contact[index] {
                let (kind, what) =
                    if touching { ("contact", "touches for certain") } else { ("lift_off", "may be free") };
                let detail = format!("{} {what}", self.robot.whiskers[index].name);
                self.events.push(Event { t, kind, detail });
            }
            self.in_contact[index] = touching;
            self.touched |= touching;
        }
    }

    /// Begins to write down what the last update did: the set is measured now and then.
    fn begin_note(&mut self, t: f64, had_started: bool, is_over: bool) -> Phase {
        let now = self.rows.len() - 1;
        if !had_started {
            self.first_row = Some(now);
            self.first_states = self.set.middles();
        }
        match self.steps.last() {
            Some(last) if !self.is_due(now) => {
                let volume = if self.set.len() > SUMMED { last.volume } else { self.set.volume() };
                let step = StepRecord { t, volume, ..*last };
                self.note(t, step);
                self.after_row(is_over)
            }
            _ => Phase::Measuring { measurement: Box::new(self.set.measurement(false)), is_over },
        }
    }

    /// Writes down what the last update did.
    fn note(&mut self, t: f64, step: StepRecord) {
        self.steps.push(step);
        if self.set.is_empty() {
            self.empty = true;
            let detail = "no state on this map explains the readings up to here within the declared bounds; \
                          is it the right map, are whisker, noise and odometry bounds those of the robot, \
                          and did the whisker touch at one place at a time, as it may not in corners?"
                .to_owned();
            self.events.push(Event { t, kind: "inconsistent", detail });
        }
    }

    /// Writes down what the last effort did.
    fn note_end(&mut self, t: f64, step: StepRecord) {
        if let Some(last) = self.steps.last_mut() {
            *last = step;
        }
        if self.set.is_empty() {
            self.empty = true;
            let detail = "all readings together rule out every state on this map".to_owned();
            self.events.push(Event { t, kind: "inconsistent", detail });
        }
    }

    /// Whether the set is to be measured anew, which costs more than a row where there are many cells.
    fn is_due(&self, now: usize) -> bool {
        let (row, cells) = self.measured;
        let count = self.set.len();
        count <= MEASURED_AT_ONCE
            || (count as f64 - cells as f64).abs() > MEASURED_CHANGE * cells as f64
            || (count <= MEASURED_WITHIN && now >= row + count / MEASURED_ROWS)
    }

    /// Takes what a measurement has told at a row.
    fn measured(&mut self, measurement: Measurement, t: f64, row: usize) -> StepRecord {
        self.measured = (row, self.set.len());
        let (places, (area_m2, volume)) = measurement.told();
        if let Some(best) = places.first() {
            self.last = Some((best.pose, row));
        }
        let components = places.len();
        self.places = places;
        StepRecord { t, components, area_m2, volume }
    }

    fn verdict(&self, places: &[Hypothesis]) -> Verdict {
        pose::verdict(&Evidence { touched: self.touched, emptied: self.empty, places, ..Evidence::default() })
    }

    /// The best place along the rows, from the first estimate to the last row that any state explains. Takes the rows.
    fn trajectory(&mut self) -> Vec<StampedPose> {
        let (Some(first), Some((_, row))) = (self.first_row, self.last) else { return Vec::new() };
        let Some(map_from_odom) = self.map_from_odom() else { return Vec::new() };
        let end = if self.empty { row + 1 } else { self.rows.len() };
        let mut rows = std::mem::take(&mut self.rows);
        rows.truncate(end);
        rows.drain(..first.min(end));
        // In the same memory.
        let stamped = |(t, odom): (f64, Pose2)| StampedPose { t, map_from_robot: map_from_odom.compose(odom) };
        rows.into_iter().map(stamped).collect()
    }
}

/// The word for the method.
const NAME: &str = "possibilistic";

impl MethodOptions for PossibilisticOptions {
    fn name(&self) -> &'static str {
        NAME
    }

    fn summary(&self) -> &'static str {
        "Guaranteed bounds on the state: what is outside is ruled out"
    }

    fn settings(&mut self) -> Vec<Setting<'_>> {
        self.settings()
    }

    fn check(&self) -> Result<()> {
        self.check()
    }

    fn takes(&self, whisker: &Whisker) -> Result<()> {
        whisker.rod().map(|_| ())
    }

    fn estimator<'a>(&self, map: &'a Map, robot: &'a Robot, channels: &[Channel]) -> Result<Box<dyn Estimator + 'a>> {
        Ok(Box::new(PossibilisticEstimator::new(map, robot, channels, *self)?))
    }
}

impl Estimator for PossibilisticEstimator<'_> {
    fn step(&mut self, row: &LogRow) -> Result<()> {
        self.begin(row)?;
        self.advance(&mut WorkBudget::unlimited());
        Ok(())
    }

    fn begin(&mut self, row: &LogRow) -> Result<()> {
        self.advance(&mut WorkBudget::unlimited());
        let start = *self.start.get_or_insert(row.odom_from_robot);
        let odom_from_robot = start.between(row.odom_from_robot);
        self.rows.push((row.t, odom_from_robot));
        let moments = self.moments(row)?;
        self.note_contacts(row.t, &moments);
        if self.empty {
            return Ok(());
        }
        let off = self.options.heading_error;
        let heading = row.heading.filter(|h| h.is_finite()).map(|h| Interval::new(h - off, h + off));
        for (whisker, moment) in moments.iter().enumerate().filter(|(_, moment)| !moment.contains(0.0)) {
            self.felt.push(DrawnReading {
                t: row.t,
                odom_from_robot,
                whisker,
                moment: 0.5 * (moment.lo() + moment.hi()),
            });
        }
        let had_started = self.set.has_started();
        self.set.foresee(odom_from_robot);
        self.late.push(RowReadings { moments, heading });
        self.phase = Phase::Reading { had_started, is_over: false };
        Ok(())
    }

    fn advance(&mut self, budget: &mut WorkBudget) -> bool {
        loop {
            let phase = std::mem::replace(&mut self.phase, Phase::Idle);
            let (next, pauses) = self.go_on(phase, budget);
            self.phase = next;
            if pauses {
                return matches!(self.phase, Phase::Idle);
            }
        }
    }

    fn end(&mut self) {
        self.advance(&mut WorkBudget::unlimited());
        let had_started = self.set.has_started();
        self.phase = if self.empty { self.begin_drawing() } else { Phase::Reading { had_started, is_over: true } };
        self.has_ended = true;
    }

    fn estimate(&self) -> Estimate {
        let told = self.set.has_started() && !self.empty;
        let places = match self.measured {
            _ if !told => Vec::new(),
            (row, _) if self.set.len() > MEASURED_NOW => self.set.carried(&self.places, row),
            _ => self.set.places(),
        };
        let hypotheses: Vec<Hypothesis> = places.iter().map(pose::enclosed).collect();
        Estimate { status: self.verdict(&hypotheses).status, hypotheses, rows: self.rows.len() }
    }

    fn states_now(&self) -> Vec<Pose2> {
        if self.set.has_started() { self.set.middles() } else { Vec::new() }
    }

    fn heed(&mut self, stop: &Stop) {
        self.set.heed(stop);
    }

    fn finish(mut self: Box<Self>) -> Localization {
        if !self.has_ended {
            self.end();
        }
        self.advance(&mut WorkBudget::unlimited());
        // The last measurement was of the cells as they are now.
        let places = if self.empty { Vec::new() } else { std::mem::take(&mut self.places) };
        let hypotheses: Vec<Hypothesis> = places.iter().map(pose::enclosed).collect();
        if self.touched && !self.set.has_started() {
            let t = self.rows.last().map_or(0.0, |r| r.0);
            let detail = "fewer contacts than the readings that may be wrong".to_owned();
            self.events.push(Event { t, kind: "too_short", detail });
        }
        let status = self.verdict(&hypotheses).status;
        if status == Status::Ambiguous && self.set.is_cut_short() {
            let t = self.rows.last().map_or(0.0, |r| r.0);
            let most = self.options.last_work;
            let detail = format!(
                "the final refinement has used up its work (last_work {most}); last_work {} may leave less, and takes in proportion longer",
                most.saturating_mul(MORE_WORK).saturating_add(self.set.cost_of_cells()).min(MOST_WORK)
            );
            self.events.push(Event { t, kind: "cut_short", detail });
        }
        Localization {
            nuisances: Vec::new(),
            consistency: None,
            unsure: Vec::new(),
            method: NAME,
            status,
            estimate: hypotheses.first().map(|h| h.pose),
            trajectory: self.trajectory(),
            states: if self.empty { Vec::new() } else { self.set.boxes() },
            encloses: true,
            first_states: std::mem::take(&mut self.first_states),
            odometry: None,
            shapes: self.drawing.shapes,
            steps: self.steps,
            events: self.events,
            hypotheses,
        }
    }
}
