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
pub mod possibilistic;
pub mod probabilistic;
#[cfg(test)]
mod tests;

pub use candidate::Candidate;
pub use components::{Component, components};

use crate::config::DeterministicOptions;
use crate::flow::preimage::{HEADING_SPACING, Observation, alignments, coarsely_aligned_states};
use crate::plane::{Pose2, wrap_angle};
use crate::world::{BoundarySample, Map, Odometry};
use membership::Tolerance;

/// From how many observations candidates enter: one of them may lie at a corner and align with nothing.
const ENTRIES: usize = 2;
/// Where more candidates than this would enter from an observation, they enter further apart,
const MOST_ENTERING: f64 = 8000.0;
/// but no further than at every second point of the boundary: what lies in between must still be near enough to be found.
const MOST_THINNED: f64 = 2.0;
/// No true candidate is off so far that its robot or whisker stands further outside free space than this (m).
const OUTSIDE: f64 = 6e-3;
/// Fewest observations that a candidate may miss where any may be missed at all.
const FEWEST_MISSES: u32 = 3;
/// Candidates nearer to each other than this are one (m and rad): no more than the boundary's sampling, as a whisker's
/// base moves by a millimetre when it turns by so much.
const SAME_PLACE: f64 = 1e-3;
const SAME_HEADING: f64 = 0.02;

/// The candidates that explain the observations so far.
#[derive(Clone, Debug, Default)]
pub struct StateSet {
    candidates: Vec<Candidate>,
    observations: u32,
    odom_from_robot: Pose2,
    travelled: f64,
    turned: f64,
}

/// An intersection that is under way.
pub(crate) struct Pass {
    odom_from_robot: Pose2,
    travelled: f64,
    turned: f64,
    /// How many candidates have met the observation.
    met: usize,
}

impl Pass {
    /// How many of these candidates are still to meet the observation.
    pub(crate) fn open(&self, candidates: usize) -> usize {
        candidates.saturating_sub(self.met)
    }
}

impl StateSet {
    /// The candidates.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
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

    /// Starts the set from a few observations: the states that explain one of the two which leave the fewest slopes
    /// open, intersected with the preimages of the others.
    pub fn start(
        &mut self,
        map: &Map,
        samples: &[BoundarySample],
        observations: &[Observation],
        options: &DeterministicOptions,
    ) {
        let mut order: Vec<usize> = (0..observations.len()).collect();
        order.sort_by(|&a, &b| observations[a].open_slopes().total_cmp(&observations[b].open_slopes()));
        for &entry in order.iter().take(ENTRIES) {
            let mut candidates = self.entering(map, samples, &observations[entry], options);
            for (index, observation) in observations.iter().enumerate().filter(|&(index, _)| index != entry) {
                let tolerance = Tolerance::new(observation, options);
                candidates.iter_mut().for_each(|c| c.meet(map, observation, &tolerance));
                let seen = index as u32 + 1;
                candidates.retain(|c| c.missed <= allowed_misses(options.missed_share, seen));
            }
            self.candidates.extend(candidates);
        }
        self.observations = observations.len() as u32;
        if let Some(last) = observations.last() {
            self.drop_outside(map, last.robot_from_whisker, self.odom_from_robot);
        }
        self.merge(self.odom_from_robot);
    }

    /// The candidates that an observation lets in, but for those that are among the set's own.
    fn entering(
        &self,
        map: &Map,
        samples: &[BoundarySample],
        observation: &Observation,
        options: &DeterministicOptions,
    ) -> Vec<Candidate> {
        let wanted = (alignments(samples, observation) as f64 / MOST_ENTERING).sqrt().ceil();
        let thinned = wanted.clamp(1.0, MOST_THINNED);
        let spacing = thinned * options.boundary_spacing;
        let cell = |c: &Candidate| cell(c, self.odom_from_robot, 2.0 * spacing, 4.0 * HEADING_SPACING);
        let mut known: Vec<_> = self.candidates.iter().map(cell).collect();
        known.sort_unstable();
        let states = coarsely_aligned_states(map, samples, observation, thinned as usize);
        let enter = |state| Candidate::at(&state, observation, spacing);
        let new = |c: &Candidate| admits(options, c.map_from_odom) && known.binary_search(&cell(c)).is_err();
        states.into_iter().map(enter).filter(new).collect()
    }

    /// Intersects the set with the preimage of an observation.
    pub fn intersect(&mut self, map: &Map, observation: &Observation, options: &DeterministicOptions) {
        let mut pass = self.pass();
        self.advance(map, observation, options, &mut pass, usize::MAX);
    }

    /// The intersection with an observation of this moment, to be done now or in slices.
    pub(crate) fn pass(&mut self) -> Pass {
        let (travelled, turned) = (std::mem::take(&mut self.travelled), std::mem::take(&mut self.turned));
        Pass { odom_from_robot: self.odom_from_robot, travelled, turned, met: 0 }
    }

    /// Lets the next `most` candidates meet the observation of a pass; whether all have met it. Passes are done one after
    /// the other, in the order in which they were begun.
    pub(crate) fn advance(
        &mut self,
        map: &Map,
        observation: &Observation,
        options: &DeterministicOptions,
        pass: &mut Pass,
        most: usize,
    ) -> bool {
        let tolerance = Tolerance::new(observation, options);
        let end = self.candidates.len().min(pass.met.saturating_add(most));
        for candidate in &mut self.candidates[pass.met..end] {
            candidate.widen(pass.odom_from_robot, pass.travelled, pass.turned);
            candidate.meet(map, observation, &tolerance);
        }
        pass.met = end;
        if end < self.candidates.len() {
            return false;
        }
        self.observations += 1;
        let allowed = allowed_misses(options.missed_share, self.observations);
        self.candidates.retain(|c| c.missed <= allowed);
        self.drop_outside(map, observation.robot_from_whisker, pass.odom_from_robot);
        self.merge(pass.odom_from_robot);
        true
    }

    /// Drops the candidates whose robot or base of this whisker, with the odometry at `odom_from_robot`, is far outside free space, which no observation that may be missed excuses.
    fn drop_outside(&mut self, map: &Map, robot_from_whisker: Pose2, odom_from_robot: Pose2) {
        let far = |pose: Pose2| !map.is_free(pose.position()) && map.nearest_within(pose.position(), OUTSIDE).is_none();
        self.candidates.retain(|c| {
            let map_from_robot = c.map_from_odom.compose(odom_from_robot);
            !far(map_from_robot) && !far(map_from_robot.compose(robot_from_whisker))
        });
    }

    /// Notes that the whisker of this mount was free or jumped: what it touches next can be anywhere.
    pub(crate) fn lift_off(&mut self, robot_from_whisker: Pose2) {
        let touching = |c: &&mut Candidate| c.felt_with == Some(robot_from_whisker);
        self.candidates.iter_mut().filter(touching).for_each(|c| c.felt_with = None);
    }

    /// Keeps the best of candidates that have run into each other, with the odometry at `odom_from_robot`.
    fn merge(&mut self, odom_from_robot: Pose2) {
        let cell = |c: &Candidate| cell(c, odom_from_robot, SAME_PLACE, SAME_HEADING);
        let key = |(index, c): (usize, &Candidate)| (cell(c), ordered(c.rank()), index as u32);
        let mut keyed: Vec<_> = self.candidates.iter().enumerate().map(key).collect();
        keyed.sort_unstable();
        keyed.dedup_by_key(|k| k.0);
        self.candidates = keyed.into_iter().map(|(.., index)| self.candidates[index as usize]).collect();
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

    /// How many separate places the set has, with the odometry at `odom_from_robot`.
    #[must_use]
    pub fn places(&self, odom_from_robot: Pose2) -> usize {
        components::count(&self.candidates, odom_from_robot)
    }

    /// The separate places of the set, with the odometry at `odom_from_robot`.
    #[must_use]
    pub fn components(&self, odom_from_robot: Pose2) -> Vec<Component> {
        components(&self.candidates, odom_from_robot)
    }
}

/// The cell of this size (m, rad) that a candidate's robot state lies in, with the odometry at `odom_from_robot`.
fn cell(candidate: &Candidate, odom_from_robot: Pose2, place: f64, heading: f64) -> [i64; 3] {
    let state = candidate.map_from_odom.compose(odom_from_robot);
    let round = |v: f64, by: f64| (v / by).round() as i64;
    [round(state.x, place), round(state.y, place), round(state.theta, heading)]
}

/// Whether the robot is in the prior's region at the first row, where its frame is the odometry's, give or take a step
/// of the sampling.
fn admits(options: &DeterministicOptions, map_from_robot: Pose2) -> bool {
    options.prior.is_none_or(|[[a, b], [c, d], [e, f]]| {
        let place = options.boundary_spacing;
        let off = wrap_angle(map_from_robot.theta - 0.5 * (e + f)).abs();
        (a - place..=b + place).contains(&map_from_robot.x)
            && (c - place..=d + place).contains(&map_from_robot.y)
            && off <= 0.5 * (f - e) + HEADING_SPACING
    })
}

/// A number that grows with `value`, in the order of `total_cmp`.
fn ordered(value: f64) -> i64 {
    let bits = value.to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

/// How many of so many observations a candidate may have missed.
fn allowed_misses(share: f64, observations: u32) -> u32 {
    if share <= 0.0 {
        return 0;
    }
    FEWEST_MISSES.max((share * f64::from(observations)).floor() as u32)
}
