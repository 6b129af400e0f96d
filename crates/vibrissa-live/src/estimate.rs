//! Rows to estimates: any estimator, thinned to what is written.

use crate::join::JoinedRow;
use crate::output::json_line;
use crate::{Error, Result};
use vibrissa_core::flow::pose::{Estimate, Localization};
use vibrissa_core::flow::sensor_log::{Channel, LogRow};
use vibrissa_core::localizer::{Localizer, Method, ProbabilisticEstimator};
use vibrissa_core::world::{Map, Robot};

/// An estimate that is to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// Time of its row (s).
    pub t: f64,
    /// The estimate.
    pub estimate: Estimate,
    /// The same as a line of JSON.
    pub line: String,
}

/// A localizer that tells its estimate so many times a second of row time: what it tells depends on the rows alone.
pub struct LiveEstimator<'a> {
    localizer: Localizer<'a>,
    period: f64,
    /// Row time from which the next estimate is told.
    due: f64,
    refused: u64,
}

impl<'a> LiveEstimator<'a> {
    /// An estimator by a method whose estimate is told at this rate (Hz of row time). The probabilistic one keeps no record of the
    /// way, so that its memory does not grow.
    ///
    /// # Errors
    ///
    /// As [`Localizer::new`].
    pub fn new(map: &'a Map, robot: &'a Robot, channels: &[Channel], method: &Method, rate: f64) -> Result<Self> {
        let localizer = match method {
            Method::Probabilistic(options) => {
                Localizer::by(ProbabilisticEstimator::new(map, robot, channels, *options)?.without_record())
            }
            other => Localizer::new(map, robot, channels, other)?,
        };
        Ok(Self { localizer, period: 1.0 / rate, due: f64::NEG_INFINITY, refused: 0 })
    }

    /// Takes a row; the estimate where one is due. A row that the whisker cannot cause is left out and counted.
    ///
    /// # Errors
    ///
    /// The first row of a stretch that is refused, for words: the run goes on.
    pub fn step(&mut self, row: &LogRow) -> core::result::Result<Option<Told>, Error> {
        if let Err(error) = self.localizer.step(row) {
            self.refused += 1;
            return Err(error);
        }
        if row.t < self.due {
            return Ok(None);
        }
        // Even in row time, whatever rows are missing.
        self.due = self.period * ((row.t / self.period).floor() + 1.0);
        let estimate = self.localizer.estimate();
        Ok(Some(Told { t: row.t, line: json_line(row.t, &estimate), estimate }))
    }

    /// Rows that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// What can be said now.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        self.localizer.estimate()
    }

    /// Ends the run and chooses.
    #[must_use]
    pub fn finish(self) -> Localization {
        self.localizer.finish()
    }
}

/// A row that stands for itself and for those before it that were passed over.
#[derive(Clone, Debug, PartialEq)]
pub struct UsedRow {
    /// The row and its arrival.
    pub joined: JoinedRow,
    /// For how many rows it stands, itself among them.
    pub merged: u64,
}

/// Merges rows that piled up to at most `most`: of each stretch the newest stands for all, with its own odometry and readings.
///
/// Its readings were taken where it says, so that no bound on their error is broken; odometry sums up what was passed over.
#[must_use]
pub fn merged(rows: impl ExactSizeIterator<Item = UsedRow>, most: usize) -> Vec<UsedRow> {
    let count = rows.len();
    let groups = count.min(most.max(1));
    let mut out: Vec<UsedRow> = Vec::with_capacity(groups);
    for (index, row) in rows.enumerate() {
        let group = index * groups / count.max(1);
        match out.get_mut(group) {
            Some(kept) => *kept = UsedRow { merged: kept.merged + row.merged, ..row },
            None => out.push(row),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{UsedRow, merged};
    use crate::join::JoinedRow;
    use vibrissa_core::flow::sensor_log::LogRow;
    use vibrissa_core::plane::Pose2;

    #[test]
    fn the_newest_of_each_stretch_stands_for_all() {
        let row = |line: usize| UsedRow {
            joined: JoinedRow {
                row: LogRow { t: line as f64, odom_from_robot: Pose2::IDENTITY, readings: vec![], heading: None, line },
                arrival: 0.0,
            },
            merged: 1,
        };
        for (count, most) in [(0, 4), (3, 4), (4, 4), (5, 4), (103, 8), (7, 1)] {
            let rows: Vec<UsedRow> = (1..=count).map(row).collect();
            let kept = merged(rows.into_iter(), most);
            assert_eq!(kept.len(), count.min(most));
            assert_eq!(kept.iter().map(|row| row.merged).sum::<u64>(), count as u64);
            assert_eq!(kept.last().map(|row| row.joined.row.line), (count > 0).then_some(count));
            let mut line = 0;
            for one in &kept {
                line += one.merged as usize;
                assert_eq!(one.joined.row.line, line, "{count} to {most}");
            }
        }
    }
}
