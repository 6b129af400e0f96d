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
mod pass;
pub mod possibilistic;
pub mod probabilistic;
mod start;
#[cfg(test)]
mod tests;

pub use candidate::Candidate;
pub use components::{Component, components};

use crate::WorkBudget;
use crate::config::DeterministicOptions;
use crate::flow::preimage::{HEADING_SPACING, Observation};
use crate::plane::{Pose2, wrap_angle};
use crate::world::{BoundarySample, Map, Odometry};
pub(crate) use pass::{Pass, Progress};
pub(crate) use start::Start;

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
        let mut start = Start::new(self, samples, observations, options);
        start.advance(self, map, samples, observations, options, &mut WorkBudget::unlimited());
    }

    /// Intersects the set with the preimage of an observation.
    pub fn intersect(&mut self, map: &Map, observation: &Observation, options: &DeterministicOptions) {
        let mut pass = self.pass();
        pass.advance(self, map, observation, options, &mut { usize::MAX }, &mut WorkBudget::unlimited());
    }

    /// The intersection with an observation of this moment, to be done now or in slices.
    pub(crate) fn pass(&mut self) -> Pass {
        Pass::new(self.odom_from_robot, core::mem::take(&mut self.travelled), core::mem::take(&mut self.turned))
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
