//! Which samples get lost on their way to the log, and which come late.

use super::{Stream, in_range, stream, unit};
use crate::Result;
use crate::flow::pose::StampedPose;

/// The least difference between two stamps (s).
const LEAST_GAP: f64 = 1e-6;

/// Lost and late samples; the default has none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stamps {
    /// Share of the rows that are lost, at least 0 and below 1; the first is kept.
    pub dropped_share: f64,
    /// Share of the rows that are stamped late, at least 0 and below 1.
    pub late_share: f64,
    /// A late row is stamped up to this too late (s), uniform; rows behind it wait, as in a host's queue.
    pub late_by: f64,
}

impl Stamps {
    pub(super) fn check(&self) -> Result<()> {
        in_range("dropped_share", self.dropped_share, 1.0)?;
        in_range("late_share", self.late_share, 1.0)?;
        in_range("late_by", self.late_by, f64::INFINITY)
    }

    /// The rows that are kept, each with its stamp; stamps increase strictly.
    pub(super) fn kept(&self, seed: u64, truth: &[StampedPose]) -> Vec<(usize, f64)> {
        let (mut dropping, mut delaying) = (stream(seed, Stream::Dropped, 0), stream(seed, Stream::Late, 0));
        let mut kept: Vec<(usize, f64)> = Vec::with_capacity(truth.len());
        for (index, pose) in truth.iter().enumerate() {
            let lost = self.dropped_share > 0.0 && unit(&mut dropping) < self.dropped_share;
            let (chance, share) =
                if self.late_share > 0.0 { (unit(&mut delaying), unit(&mut delaying)) } else { (1.0, 0.0) };
            if lost && index > 0 {
                continue;
            }
            let late = if chance < self.late_share { share * self.late_by } else { 0.0 };
            let earliest = kept.last().map_or(f64::NEG_INFINITY, |(_, stamp)| stamp + LEAST_GAP);
            kept.push((index, (pose.t + late).max(earliest)));
        }
        kept
    }
}
