//! The fifth door: the set of robot states that explain every observation so far.
//!
//! Known motion carries the set along, the next observation's preimage is intersected with it, in (x, y, theta), and
//! fewer and fewer candidates are left \[routray, section "Localization: Deterministic Method"\]. A candidate is kept as
//! the pose of the odometry frame in the map, so forward projection is exact and free: `T_k' = T_k T_local`.
//!
//! The paper intersects sampled curves, which meet exactly almost never; here a candidate stays if the nearest state of
//! the preimage lies within a tolerance that the readings' declared errors set. Each candidate remembers what it has
//! explained as a running least-squares mean, so that it can neither creep along a wall step by step nor keep the error
//! of the reading that it was born from.

mod candidate;
mod components;
mod membership;
#[cfg(test)]
mod tests;

pub use candidate::Candidate;
pub use components::{Component, components};

use crate::config::DeterministicOptions;
use crate::flow::preimage::{Observation, aligned_states};
use crate::plane::Pose2;
use crate::world::{BoundarySample, Map, Odometry};
use membership::Tolerance;

/// Observations from which new candidates still enter: the first one or two may lie at a corner and align with nothing.
const ENTRY_OBSERVATIONS: u32 = 2;
/// Fewest observations that a candidate may miss where any may be missed at all.
const FEWEST_MISSES: u32 = 3;
/// Candidates nearer to each other than this are one (m and rad): well below the boundary's sampling.
const SAME_PLACE: f64 = 0.5e-3;
const SAME_HEADING: f64 = 6e-3;

/// The candidates that explain the observations so far.
#[derive(Clone, Debug)]
pub struct StateSet {
    candidates: Vec<Candidate>,
    observations: u32,
    odom_from_robot: Pose2,
    travelled: f64,
    turned: f64,
}

impl Default for StateSet {
    fn default() -> Self {
        Self { candidates: Vec::new(), observations: 0, odom_from_robot: Pose2::IDENTITY, travelled: 0.0, turned: 0.0 }
    }
}

impl StateSet {
    /// The candidates.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// How many observations the set has seen.
    #[must_use]
    pub fn observations(&self) -> u32 {
        self.observations
    }

    /// Whether no more candidates enter.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.observations >= ENTRY_OBSERVATIONS
    }

    /// Whether no state explains the observations.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// The candidates as robot states, with the odometry at `odom_from_robot`.
    pub fn states(&self, odom_from_robot: Pose2) -> impl Iterator<Item = Pose2> {
        self.candidates.iter().map(move |c| c.map_from_odom.compose(odom_from_robot))
    }

    /// Carries the set along by the known motion; odometry errors widen the candidates.
    pub fn project(&mut self, odom_from_robot: Pose2, odometry: &Odometry) {
        let step = self.odom_from_robot.between(odom_from_robot);
        self.odom_from_robot = odom_from_robot;
        self.travelled += (step.position().norm() * odometry.translation_relative).powi(2) / 3.0;
        self.turned += (step.theta * odometry.rotation_relative).powi(2) / 3.0;
    }

    /// Intersects the set with the preimage of an observation; the first observations also let candidates in.
    pub fn intersect(
        &mut self,
        map: &Map,
        samples: &[BoundarySample],
        observation: &Observation,
        options: &DeterministicOptions,
    ) {
        self.observations += 1;
        let (travelled, turned) = (std::mem::take(&mut self.travelled), std::mem::take(&mut self.turned));
        let tolerance = Tolerance::new(observation, options);
        for candidate in &mut self.candidates {
            candidate.widen(self.odom_from_robot, travelled, turned);
            candidate.meet(map, observation, &tolerance);
        }
        if self.observations <= ENTRY_OBSERVATIONS {
            let enter = |state| Candidate::at(&state, observation, options.boundary_spacing, self.observations - 1);
            self.candidates.extend(aligned_states(map, samples, observation).into_iter().map(enter));
        }
        let allowed = self.allowed_misses(options.missed_share);
        self.candidates.retain(|c| c.missed <= allowed);
        self.merge();
    }

    /// How many of the observations so far a candidate may have missed.
    fn allowed_misses(&self, share: f64) -> u32 {
        if share <= 0.0 {
            return 0;
        }
        FEWEST_MISSES.max((share * f64::from(self.observations)).floor() as u32)
    }

    /// Keeps the best of candidates that have run into each other.
    fn merge(&mut self) {
        let cell = |c: &Candidate| {
            let state = c.map_from_odom.compose(self.odom_from_robot);
            let round = |v: f64, by: f64| (v / by).round() as i64;
            (round(state.x, SAME_PLACE), round(state.y, SAME_PLACE), round(state.theta, SAME_HEADING))
        };
        let mut keyed: Vec<_> = self.candidates.drain(..).map(|c| (cell(&c), c)).collect();
        keyed.sort_by(|(a, p), (b, q)| a.cmp(b).then(p.rank().total_cmp(&q.rank())));
        keyed.dedup_by(|later, kept| later.0 == kept.0);
        self.candidates = keyed.into_iter().map(|(_, c)| c).collect();
    }

    /// The candidate that explains the observations best.
    #[must_use]
    pub fn best(&self) -> Option<&Candidate> {
        self.candidates.iter().min_by(|a, b| a.rank().total_cmp(&b.rank()))
    }

    /// Area of the set's projection onto the plane (m²) and its volume (m² rad), by counting occupied cells of this
    /// size (m) and of one degree.
    #[must_use]
    pub fn size(&self, odom_from_robot: Pose2, cell: f64) -> (f64, f64) {
        let degree = 1.0_f64.to_radians();
        let key = |s: Pose2| [s.x / cell, s.y / cell, s.theta / degree].map(|v| v.floor() as i64);
        let mut keys: Vec<[i64; 3]> = self.states(odom_from_robot).map(key).collect();
        keys.sort_unstable();
        keys.dedup();
        let volume = keys.len() as f64 * cell * cell * degree;
        keys.dedup_by_key(|k| [k[0], k[1]]);
        (keys.len() as f64 * cell * cell, volume)
    }

    /// The separate places of the set, with the odometry at `odom_from_robot`.
    #[must_use]
    pub fn components(&self, odom_from_robot: Pose2) -> Vec<Component> {
        components(&self.candidates, odom_from_robot)
    }
}
