//! A packed hypothesis: on a large map global localization finds hundreds of thousands, of which few are ever followed.

use super::hypothesis::GaussianHypothesis;
use super::information::Information;
use super::odometry_calibration::Belief;
use crate::contact::follow::{Packed, WhiskerState};
use crate::plane::Pose2;

/// What it takes to run a hypothesis anew: where it begins, and what the readings have said.
#[derive(Clone, Debug)]
pub(super) struct PackedHypothesis {
    pub(super) map_from_odom: Pose2,
    /// The information around its place and the gain.
    pub(super) told: Information<4>,
    start: PackedStates,
    /// See [`GaussianHypothesis::heading_class`].
    heading_class: Option<u32>,
}

/// How each whisker stands to the map where it begins.
#[derive(Clone, Debug)]
enum PackedStates {
    One(Packed),
    All(Box<[WhiskerState]>),
}

impl PackedHypothesis {
    /// What is kept of a hypothesis by which no rows have been marginalised.
    pub(super) fn of(h: &GaussianHypothesis) -> Self {
        let one = if let [state] = h.start() { Packed::of(state) } else { None };
        let start = one.map_or_else(|| PackedStates::All(h.start().into()), PackedStates::One);
        Self { map_from_odom: h.map_from_odom, told: h.belief.place_and_gain(), start, heading_class: h.heading_class }
    }

    /// Its place with the gain marginalised, of this standard deviation.
    pub(super) fn place(&self, gain: f64) -> Information<3> {
        self.told.without_gain(gain)
    }

    /// The hypothesis, from the row on at which it begins; it has taken no row.
    pub(super) fn into_hypothesis(self, row: usize) -> GaussianHypothesis {
        let states = match self.start {
            PackedStates::One(packed) => vec![packed.state()],
            PackedStates::All(states) => states.into_vec(),
        };
        let mut h = GaussianHypothesis::new(self.map_from_odom, states, row);
        (h.belief, h.heading_class) = (Belief::of_place(&self.told), self.heading_class);
        h
    }
}
