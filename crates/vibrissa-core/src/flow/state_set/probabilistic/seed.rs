//! A hypothesis at rest: on a large map a search finds hundreds of thousands, of which few are ever followed.

use super::hypothesis::Hypothesis;
use super::information::Information;
use super::odometry_calibration::Belief;
use crate::contact::follow::{Packed, WhiskerState};
use crate::plane::Pose2;

/// What it takes to run a hypothesis anew: where it begins, and what the readings have said.
#[derive(Clone, Debug)]
pub(super) struct Seed {
    pub(super) map_from_odom: Pose2,
    /// The information around its place and the gain.
    pub(super) told: Information<4>,
    start: Start,
    /// See [`Hypothesis::family`].
    family: Option<u32>,
}

/// How each whisker stands to the map where it begins.
#[derive(Clone, Debug)]
enum Start {
    One(Packed),
    All(Box<[WhiskerState]>),
}

impl Seed {
    /// What is kept of a hypothesis by which no rows have been summed up.
    pub(super) fn of(h: &Hypothesis) -> Self {
        let one = if let [state] = h.start() { Packed::of(state) } else { None };
        let start = one.map_or_else(|| Start::All(h.start().into()), Start::One);
        Self { map_from_odom: h.map_from_odom, told: h.belief.place_and_gain(), start, family: h.family }
    }

    /// Its place with the gain marginalised, of this standard deviation.
    pub(super) fn place(&self, gain: f64) -> Information<3> {
        self.told.without_gain(gain)
    }

    /// The hypothesis, from the row on at which it begins; it has taken no row.
    pub(super) fn grown(self, row: usize) -> Hypothesis {
        let states = match self.start {
            Start::One(packed) => vec![packed.state()],
            Start::All(states) => states.into_vec(),
        };
        let mut h = Hypothesis::new(self.map_from_odom, states, row);
        (h.belief, h.family) = (Belief::of_place(&self.told), self.family);
        h
    }
}
