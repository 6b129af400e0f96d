//! What the estimator still has to do, so that it can pause in between: a stack of tasks, the one that comes next on top.
//!
//! Each task does what comes next in the order of a row that is done in one piece, so that pauses change no answer.

use super::{DeterministicEstimator, MEETINGS, ROWS_BEHIND};
use crate::WorkBudget;
use crate::flow::moment::MomentHistory;
use crate::flow::pose::StepRecord;
use crate::flow::preimage::{Observation, observed_moments};
use crate::flow::sensor_log::LogRow;
use crate::flow::state_set::{Pass, Progress, Start};
use crate::plane::Pose2;

/// The state set starts from this many observations at least, as the paper's does,
const EARLIEST_START: usize = 3;
/// as soon as one leaves no more slopes of the boundary open than this (rad),
const NARROW_START: f64 = 0.8;
/// and from this many in any case.
const LATEST_START: usize = 8;
/// What it costs to feel a reading, to trace a contact set, to make an observation of a history, and to measure so many candidates.
const FEEL_COST: usize = 5;
const TRACE_COST: usize = 500;
const OBSERVATION_COST: usize = 500;
const MEASURED_FOR_ONE: usize = 5;

/// A piece of work that can pause.
pub(super) enum Task {
    /// The whiskers feel a row, from this one on to that one; the row then has its work, unless one of them refuses it.
    Feel { row: LogRow, next: usize, end: usize, due: usize },
    /// No readings come any more: what the whiskers from this one on have felt becomes observations.
    LetGo { row: LogRow, next: usize },
    /// A history of a whisker becomes an observation, once the contact sets of these moments are traced; a whisker of this mount is free
    /// then.
    Observe { row: LogRow, feeler: usize, history: Box<MomentHistory>, moments: Vec<f64>, let_go: Option<Pose2> },
    /// Candidates are let in.
    Start { row: LogRow, start: Box<Start>, feelers: Vec<usize>, waiting: Vec<Observation> },
    /// The set is told what is due, for at most so many meetings of a candidate with an observation.
    Work { row: LogRow, meetings: usize },
    /// What the last update did is written down; how many places there are by now.
    Note { row: LogRow, places: Option<usize> },
}

/// What the set still has to be told, in the order in which it happened.
pub(super) enum Due {
    /// An observation of a feeler, and how far it has got.
    Meet { feeler: usize, observation: Box<Observation>, pass: Pass },
    /// The whisker of this mount was free or jumped.
    LiftOff(Pose2),
}

impl DeterministicEstimator<'_> {
    /// Goes on with what was begun, as far as the budget goes; whether all of it is done.
    pub(super) fn go_on(&mut self, budget: &mut WorkBudget) -> bool {
        while let Some(mut task) = self.agenda.pop() {
            // What a task asks for first comes on top of it.
            let at = self.agenda.len();
            let is_done = match &mut task {
                Task::Feel { row, next, end, due } => self.feel_next(row, next, *end, *due, budget),
                Task::LetGo { row, next } => self.let_go_next(row, next),
                Task::Observe { row, feeler, history, moments, let_go } => {
                    let is_done = self.trace_next(*feeler, moments, budget);
                    if is_done {
                        self.update(*feeler, history, row, budget);
                        self.due.extend(let_go.map(Due::LiftOff));
                    }
                    is_done
                }
                Task::Start { row, start, feelers, waiting } => {
                    let set = &mut self.states;
                    let is_done = start.advance(set, self.map, &self.samples, waiting, &self.options, budget);
                    if is_done {
                        self.started(row, feelers, waiting);
                    }
                    is_done
                }
                Task::Work { row, meetings } => self.work(row, meetings, budget),
                Task::Note { row, places } => self.note(row, places, budget),
            };
            if !is_done {
                self.agenda.insert(at, task);
            }
            if budget.is_spent() {
                return self.agenda.is_empty();
            }
        }
        true
    }

    /// The next whisker feels the row.
    fn feel_next(&mut self, row: &LogRow, next: &mut usize, end: usize, due: usize, budget: &mut WorkBudget) -> bool {
        budget.spend(FEEL_COST);
        let index = *next;
        if index < end {
            *next += 1;
            let feeler = &mut self.feelers[index];
            let touched = feeler.in_contact;
            let history = feeler.feel(row, &mut self.record);
            let let_go = (touched && !feeler.in_contact).then_some(feeler.whisker.robot_from_whisker);
            self.observe(index, history, row, let_go);
            return false;
        }
        if end == self.feelers.len() {
            // A row that makes an observation has its work.
            let share = if self.due.len() > due { 4 } else { 1 };
            let open = self.due.len() * self.states.candidates().len();
            let meetings = MEETINGS.max(open / ROWS_BEHIND) / share;
            self.agenda.push(Task::Work { row: row.clone(), meetings });
        }
        true
    }

    /// What the next whisker has felt last becomes an observation; after all of them the set meets all that is due.
    fn let_go_next(&mut self, row: &LogRow, next: &mut usize) -> bool {
        if let Some(feeler) = self.feelers.get_mut(*next) {
            let history = feeler.track.end();
            let index = *next;
            *next += 1;
            self.observe(index, history, row, None);
            return false;
        }
        self.agenda.push(Task::Work { row: row.clone(), meetings: usize::MAX });
        if self.record.waiting.iter().any(|(_, o)| o.open_slopes().is_finite()) {
            self.begin_start(row);
        }
        true
    }

    /// Begins to make an observation of a history, where there is one.
    fn observe(&mut self, feeler: usize, history: Option<MomentHistory>, row: &LogRow, let_go: Option<Pose2>) {
        let Some(history) = history else {
            return self.due.extend(let_go.map(Due::LiftOff));
        };
        let is_used = history.smooth && self.record.empty_at.is_none();
        let moments = if is_used { observed_moments(&history) } else { Vec::new() };
        let history = Box::new(history);
        self.agenda.push(Task::Observe { row: row.clone(), feeler, history, moments, let_go });
    }

    /// Traces the contact sets of moments until the budget is spent; whether all are.
    fn trace_next(&mut self, feeler: usize, moments: &mut Vec<f64>, budget: &mut WorkBudget) -> bool {
        while let Some(moment) = moments.pop() {
            budget.spend(TRACE_COST * self.feelers[feeler].contacts.prepare(moment));
            if budget.is_spent() {
                return moments.is_empty();
            }
        }
        true
    }

    /// One update: history → contact sets → alignment → preimage → intersection, the last when its turn comes.
    fn update(&mut self, feeler: usize, history: &MomentHistory, row: &LogRow, budget: &mut WorkBudget) {
        if self.record.empty_at.is_some() {
            return;
        }
        let column = &mut self.feelers[feeler];
        let whisker = &column.whisker;
        if !history.smooth {
            self.due.push_back(Due::LiftOff(whisker.robot_from_whisker));
            let detail = format!(
                "{}: the readings jump by more than their declared noise; this stretch of contact is not used",
                whisker.name
            );
            return self.record.event_once(row.t, "rough", detail);
        }
        let contacts = &mut column.contacts;
        let observation = Observation::with(whisker, &column.tip, history, &mut |moment| contacts.branches(moment));
        budget.spend(OBSERVATION_COST);
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
                self.begin_start(row);
            }
            _ => {}
        }
    }

    /// Begins to let candidates in.
    fn begin_start(&mut self, row: &LogRow) {
        let (feelers, waiting): (Vec<usize>, Vec<Observation>) = self.record.waiting.drain(..).unzip();
        if let Some(region) = self.options.prior {
            self.samples = super::near(self.map, self.robot, region, &waiting, &self.options);
        }
        let start = Box::new(Start::new(&self.states, &self.samples, &waiting, &self.options));
        self.agenda.push(Task::Start { row: row.clone(), start, feelers, waiting });
    }

    /// The set has started.
    fn started(&mut self, row: &LogRow, feelers: &mut Vec<usize>, waiting: &mut Vec<Observation>) {
        self.record.first_row = Some(self.rows.len() - 1);
        self.record.first_states = self.states.states(row.odom_from_robot).collect();
        let observations = feelers.drain(..).zip(waiting.drain(..));
        observations.for_each(|observation| self.record.observations.push(observation));
        self.agenda.push(Task::Note { row: row.clone(), places: None });
    }

    /// Tells the set what is due next; whether that was all for this row.
    fn work(&mut self, row: &LogRow, meetings: &mut usize, budget: &mut WorkBudget) -> bool {
        if self.record.empty_at.is_some() {
            self.due.clear();
        }
        match self.due.front_mut() {
            None => true,
            Some(Due::LiftOff(robot_from_whisker)) => {
                self.states.lift_off(*robot_from_whisker);
                self.due.pop_front();
                false
            }
            Some(Due::Meet { observation, pass, .. }) => {
                match pass.advance(&mut self.states, self.map, observation, &self.options, meetings, budget) {
                    Progress::Waits => return true,
                    Progress::Paused => return false,
                    Progress::Done => {}
                }
                if let Some(Due::Meet { feeler, observation, .. }) = self.due.pop_front() {
                    self.record.observations.push((feeler, *observation));
                }
                self.agenda.push(Task::Note { row: row.clone(), places: None });
                false
            }
        }
    }

    /// Writes down what the last update did.
    fn note(&mut self, row: &LogRow, places: &mut Option<usize>, budget: &mut WorkBudget) -> bool {
        budget.spend(self.states.candidates().len() / MEASURED_FOR_ONE);
        let Some(components) = *places else {
            *places = Some(self.states.places(row.odom_from_robot));
            return false;
        };
        let (area_m2, volume) = self.states.size(row.odom_from_robot, self.options.boundary_spacing);
        self.record.steps.push(StepRecord { t: row.t, components, area_m2, volume });
        let now = self.rows.len() - 1;
        match self.states.best() {
            Some(best) => self.record.last = Some((*best, now)),
            None => self.record.emptied(row.t, now),
        }
        true
    }
}
