//! Dropping hypotheses by which a whisker's base has left the free space.
//!
//! They were in it where the contact began, but a wrong one may go through a wall further on. The forward model finds no
//! equilibrium there and looks for one anew with every reading, which costs ten times what a possible place does.

use super::super::history::History;
use super::super::hypothesis::moved;
use super::{Bank, Field, cut};
use crate::plane::Pose2;

/// How far beyond a boundary a base may be (steps of the search): hypotheses are followed before they are where they fit.
const SLACK: f64 = 2.0;

impl Bank {
    /// Drops those that have a whisker's base beyond a boundary at this row, where they are and where they would fit best.
    pub(super) fn drop_outside(&mut self, field: &Field<'_>, history: &History, row: usize) {
        let pivot = self.pivot;
        self.hypotheses.retain(|h| {
            let best = || moved(h.map_from_odom, pivot, cut(h.promise.1));
            field.bases_stand(history, h.map_from_odom, row) || field.bases_stand(history, best(), row)
        });
    }
}

impl Field<'_> {
    /// Whether all whiskers' bases are in free space at a row, give or take what a hypothesis may be wrong.
    fn bases_stand(&self, history: &History, map_from_odom: Pose2, row: usize) -> bool {
        (0..self.feelers.len()).all(|feeler| {
            let base = map_from_odom.transform_point(history.base(row, feeler).position());
            self.map.is_free(base) || self.map.nearest_within(base, SLACK * self.options.seed_spacing).is_some()
        })
    }
}
