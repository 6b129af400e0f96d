//! The intersection with one observation, which can pause.

use super::membership::Tolerance;
use super::{Candidate, OUTSIDE, StateSet, allowed_misses};
use crate::WorkBudget;
use crate::config::DeterministicOptions;
use crate::flow::preimage::Observation;
use crate::plane::Pose2;
use crate::world::Map;

/// What it costs that a candidate meets an observation, and that its stand is looked at.
pub(super) const MEETING_COST: usize = 10;
const STAND_COST: usize = 2;
/// What it costs to merge candidates, of so many for a unit.
const MERGED_FOR_ONE: usize = 10;

/// How far an intersection has got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    Done,
    /// The budget is spent.
    Paused,
    /// No more candidates may meet the observation now.
    Waits,
}

/// An intersection that is under way.
pub(crate) struct Pass {
    odom_from_robot: Pose2,
    travelled: f64,
    turned: f64,
    /// How many candidates have met the observation.
    met: usize,
    /// Once all have, which of those that are left stand where no robot can.
    outside: Option<OutsideSearch>,
}

impl Pass {
    pub(super) fn new(odom_from_robot: Pose2, travelled: f64, turned: f64) -> Self {
        Self { odom_from_robot, travelled, turned, met: 0, outside: None }
    }

    /// Lets the next candidates, `most` at most, meet the observation, and drops those that do not explain it once all have. Passes are done
    /// one after the other, in the order in which they were begun.
    pub(crate) fn advance(
        &mut self,
        set: &mut StateSet,
        map: &Map,
        observation: &Observation,
        options: &DeterministicOptions,
        most: &mut usize,
        budget: &mut WorkBudget,
    ) -> Progress {
        let tolerance = Tolerance::new(observation, options);
        while let Some(candidate) = set.candidates.get_mut(self.met).filter(|_| self.outside.is_none()) {
            if *most == 0 {
                return Progress::Waits;
            }
            if budget.is_spent() {
                return Progress::Paused;
            }
            candidate.widen(self.odom_from_robot, self.travelled, self.turned);
            candidate.meet(map, observation, &tolerance);
            self.met += 1;
            *most -= 1;
            budget.spend(MEETING_COST);
        }
        let outside = self.outside.get_or_insert_with(|| {
            set.observations += 1;
            let allowed = allowed_misses(options.missed_share, set.observations);
            set.candidates.retain(|c| c.missed <= allowed);
            OutsideSearch::new(observation.robot_from_whisker, self.odom_from_robot)
        });
        if !outside.advance(map, &set.candidates, budget) {
            return Progress::Paused;
        }
        outside.drop_from(&mut set.candidates);
        set.merge(self.odom_from_robot);
        budget.spend(set.candidates.len() / MERGED_FOR_ONE);
        Progress::Done
    }
}

/// The search for candidates whose robot or base of a whisker is far outside free space, which no observation that may be missed
/// excuses.
pub(super) struct OutsideSearch {
    robot_from_whisker: Pose2,
    odom_from_robot: Pose2,
    is_far: Vec<bool>,
}

impl OutsideSearch {
    pub(super) fn new(robot_from_whisker: Pose2, odom_from_robot: Pose2) -> Self {
        Self { robot_from_whisker, odom_from_robot, is_far: Vec::new() }
    }

    /// Looks at the next candidates; whether all are looked at.
    pub(super) fn advance(&mut self, map: &Map, candidates: &[Candidate], budget: &mut WorkBudget) -> bool {
        let far = |pose: Pose2| !map.is_free(pose.position()) && map.nearest_within(pose.position(), OUTSIDE).is_none();
        while let Some(candidate) = candidates.get(self.is_far.len()) {
            if budget.is_spent() {
                return false;
            }
            let map_from_robot = candidate.map_from_odom.compose(self.odom_from_robot);
            self.is_far.push(far(map_from_robot) || far(map_from_robot.compose(self.robot_from_whisker)));
            budget.spend(STAND_COST);
        }
        true
    }

    pub(super) fn drop_from(&self, candidates: &mut Vec<Candidate>) {
        let mut is_far = self.is_far.iter();
        candidates.retain(|_| !is_far.next().is_some_and(|far| *far));
    }
}
