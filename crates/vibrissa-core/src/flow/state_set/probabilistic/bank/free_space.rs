//! Pruning of hypotheses whose whisker base has left the free space.
//!
//! They were in it where the contact began, but a wrong one may go through a wall further on. The forward model finds no
//! equilibrium there and looks for one anew with every reading, which costs ten times what a possible place does.

use super::super::hypothesis::moved;
use super::super::log_window::LogWindow;
use super::{BankContext, HypothesisBank, trust_region_step};
use crate::plane::Pose2;

/// How far beyond a boundary a base may be (steps of the search): hypotheses are followed before they are where they fit.
const SLACK: f64 = 2.0;

impl HypothesisBank {
    /// Drops those that have a whisker's base beyond a boundary at this row, where they are and where they would fit best.
    pub(super) fn prune_outside(&mut self, context: &BankContext<'_>, history: &LogWindow, row: usize) {
        let pivot = self.pivot;
        self.hypotheses.retain(|h| {
            let best = || moved(h.map_from_odom, pivot, trust_region_step(h.predicted.1));
            context.bases_are_free(history, h.map_from_odom, row) || context.bases_are_free(history, best(), row)
        });
    }
}

impl BankContext<'_> {
    /// Whether all whiskers' bases are in free space at a row, give or take what a hypothesis may be wrong.
    fn bases_are_free(&self, history: &LogWindow, map_from_odom: Pose2, row: usize) -> bool {
        (0..self.sensors.len()).all(|sensor| {
            let base = map_from_odom.transform_point(history.base(row, sensor).position());
            self.map.is_free(base) || self.map.nearest_within(base, SLACK * self.options.seed_spacing).is_some()
        })
    }
}
