//! A hypothesis at rest: on a large map a search finds hundreds of thousands, of which few are ever followed.

use super::contact::State;
use super::hypothesis::Hypothesis;
use super::normal::Normal;
use crate::plane::Pose2;

/// What it takes to run a hypothesis anew: where it begins, and what the readings have said.
#[derive(Clone, Debug)]
pub(super) struct Seed {
    pub(super) map_from_odom: Pose2,
    pub(super) normal: Normal,
    /// How each whisker stands to the map where it begins.
    start: Box<[State]>,
    /// See [`Hypothesis::family`].
    family: Option<u32>,
}

impl Seed {
    /// What is kept of a hypothesis by which no rows have been summed up.
    pub(super) fn of(h: &Hypothesis) -> Self {
        Self { map_from_odom: h.map_from_odom, normal: h.normal, start: h.start().into(), family: h.family }
    }

    /// The hypothesis, from the row on at which it begins; it has taken no row.
    pub(super) fn grown(self, row: usize) -> Hypothesis {
        let mut h = Hypothesis::new(self.map_from_odom, self.start.into_vec(), row);
        (h.normal, h.family) = (self.normal, self.family);
        h
    }
}
