//! The probabilistic estimator: rows in, hypotheses that fit all of them, weighed places at the end.

mod record;

use super::method::MethodOptions;
use super::{Estimator, STRAIGHT_ONLY};
use crate::beam::Whisker;
use crate::config::{ProbabilisticOptions, Setting};
use crate::coroutine::{Coroutine, completed};
use crate::flow::pose::{Estimate, Localization};
use crate::flow::sensor_log::{Channel, LogRow};
use crate::plane::Pose2;
use crate::world::{Map, Robot};
use crate::{Error, Result, Stop, WorkBudget};
use record::{Record, TakenRow};

/// States that are told while the work of a row is under way: each takes some microseconds before it.
const MOST_STATES: usize = 500;

/// Units of work after which the end of a log looks whether it is to end early: a millisecond.
const PIECE: usize = 1000;

/// The probabilistic estimator: hypotheses from no prior, each a least-squares fit of all readings.
///
/// What it says before the end rests on the linearisation of each hypothesis at the rows that it has taken: weights and
/// covariances are those of Gaussians, not sampled, only the most likely hypotheses are looked at, no place has a ridge, and
/// the verdict leaves out how well the readings fit. While the work of a row is not done it says what it said before that row. Where the end
/// is asked for early, the answer is of that kind, too.
pub struct ProbabilisticEstimator<'a> {
    /// None while its work is under way, and after the end.
    record: Option<Box<Record<'a>>>,
    row: Option<Coroutine<'a, Box<Record<'a>>>>,
    end: Option<Coroutine<'a, Localization>>,
    answer: Option<Localization>,
    /// What was said before the work under way: places, and the robot by each mode.
    before: (Estimate, Vec<Pose2>),
}

impl<'a> ProbabilisticEstimator<'a> {
    /// An estimator for logs with these channels.
    ///
    /// # Errors
    ///
    /// Options out of range, a whisker without a channel of moment, force or slope, or a whisker that is curved at rest.
    pub fn new(map: &'a Map, robot: &'a Robot, channels: &[Channel], options: ProbabilisticOptions) -> Result<Self> {
        let record = Some(Box::new(Record::new(map, robot, channels, options)?));
        Ok(Self { record, row: None, end: None, answer: None, before: (Estimate::default(), Vec::new()) })
    }

    /// The same without a record of the way, for robots that never stop: the answer has no trajectory, no steps and only
    /// the last few events, and memory does not grow with the rows.
    #[must_use]
    pub fn without_record(mut self) -> Self {
        self.record.iter_mut().for_each(|record| record.forget_way());
        self
    }

    /// How many rows are kept to be fitted again; none are told of while the work of a row is under way.
    #[must_use]
    pub fn rows_kept(&self) -> usize {
        self.record.as_ref().map_or(0, |record| record.rows_kept())
    }

    /// Does the work that is left of the last row.
    fn rest(&mut self) {
        if self.row.is_some() {
            self.advance(&mut WorkBudget::unlimited());
        }
    }

    /// Keeps what is said while work is under way.
    fn remember(&mut self) {
        if let Some(record) = &self.record {
            self.before = (record.estimate(), record.states_now(MOST_STATES));
        }
    }

    /// Takes the record to do a row's work with it.
    fn take(&mut self, row: &LogRow) -> Result<(Box<Record<'a>>, TakenRow)> {
        self.rest();
        let after_end = || Error::usage("a row after the end of the log").value(row.t);
        let mut record = self.record.take().ok_or_else(after_end)?;
        match record.take(row) {
            Ok(taken) => Ok((record, taken)),
            Err(error) => {
                self.record = Some(record);
                Err(error)
            }
        }
    }
}

/// The word for the method.
const NAME: &str = "probabilistic";

impl MethodOptions for ProbabilisticOptions {
    fn name(&self) -> &'static str {
        NAME
    }

    fn summary(&self) -> &'static str {
        "The most accurate estimate with calibrated weights"
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
        Ok(Box::new(ProbabilisticEstimator::new(map, robot, channels, *self)?))
    }
}

impl Estimator for ProbabilisticEstimator<'_> {
    fn step(&mut self, row: &LogRow) -> Result<()> {
        let (mut record, taken) = self.take(row)?;
        completed(record.work(taken));
        self.record = Some(record);
        Ok(())
    }

    fn begin(&mut self, row: &LogRow) -> Result<()> {
        self.rest();
        if !self.record.as_ref().is_some_and(|record| record.is_due()) {
            return self.step(row);
        }
        self.remember();
        let (mut record, taken) = self.take(row)?;
        self.row = Some(Coroutine::new(record.pace(), async move {
            record.work(taken).await;
            record
        }));
        Ok(())
    }

    fn advance(&mut self, budget: &mut WorkBudget) -> bool {
        if let Some(row) = &mut self.row {
            let Some(record) = row.resume(budget) else { return false };
            (self.record, self.row) = (Some(record), None);
        }
        if let Some(end) = &mut self.end {
            let Some(answer) = end.resume(budget) else { return false };
            (self.answer, self.end) = (Some(answer), None);
        }
        true
    }

    fn end(&mut self) {
        self.rest();
        self.remember();
        if let Some(record) = self.record.take() {
            self.end = Some(Coroutine::new(record.pace(), record.finish()));
        }
    }

    fn heed(&mut self, stop: &Stop) {
        self.rest();
        self.record.iter_mut().for_each(|record| record.heed(stop));
    }

    fn estimate(&self) -> Estimate {
        self.record.as_ref().map_or_else(|| self.before.0.clone(), |record| record.estimate())
    }

    fn states_now(&self) -> Vec<Pose2> {
        self.record.as_ref().map_or_else(|| self.before.1.clone(), |record| record.states_now(usize::MAX))
    }

    fn finish(mut self: Box<Self>) -> Localization {
        self.end();
        while !self.advance(&mut WorkBudget::new(PIECE)) {}
        self.answer.unwrap_or_default()
    }
}
