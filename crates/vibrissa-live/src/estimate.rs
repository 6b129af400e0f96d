//! Rows to estimates: any estimator, thinned to what is written.

use crate::join::JoinedRow;
use crate::output::json_line;
use crate::{Error, Result};
use vibrissa_core::flow::pose::{Estimate, Localization};
use vibrissa_core::flow::sensor_log::Channel;
use vibrissa_core::localizer::{Localizer, Method, ProbabilisticEstimator};
use vibrissa_core::plane::Pose2;
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
    /// The number of the row that it is of,
    pub row: u64,
    /// and that of the row after which the estimator said it: an earlier one where odometry carried it on.
    pub from: u64,
    /// How much older (s) that row is.
    pub carried: f64,
    /// The robot in the odometry frame.
    pub odom_from_robot: Pose2,
    /// How far the odometry went since its first row (m, rad).
    pub travel: [f64; 2],
}

/// The row time (s) from which the next estimate is told after one at `t`: even in row time, whatever rows are missing.
#[must_use]
pub(crate) fn next_due(t: f64, period: f64) -> f64 {
    period * ((t / period).floor() + 1.0)
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
    pub fn step(&mut self, joined: &JoinedRow) -> core::result::Result<Option<Told>, Error> {
        let row = &joined.row;
        if let Err(error) = self.localizer.step(row) {
            self.refused += 1;
            return Err(error);
        }
        if row.t < self.due {
            return Ok(None);
        }
        self.due = next_due(row.t, self.period);
        let estimate = self.localizer.estimate();
        Ok(Some(Told {
            t: row.t,
            line: json_line(row.t, 0.0, &estimate),
            estimate,
            row: row.line as u64,
            from: row.line as u64,
            carried: 0.0,
            odom_from_robot: row.odom_from_robot,
            travel: joined.travel,
        }))
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
                travel: [0.0; 2],
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
