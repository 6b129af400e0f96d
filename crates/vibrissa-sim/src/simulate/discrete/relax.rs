//! The way to the nearest minimum of the energy.

use super::energy::{Barrier, Base, Derivatives};
use super::near::safe_share;
use super::{DiscreteRod, REACH, Relaxed};
use crate::Stop;
use crate::plane::{Pose2, Vec2};
use crate::world::Map;

/// Farthest that a node moves in one step, over the whisker's length.
const LARGEST_STEP: f64 = 0.02;
/// The rod and the map are paired within this distance, over the whisker's length.
const MARGIN: f64 = 0.05;
/// Reaches of the barrier, one after the other, and the step at which each is left; over the whisker's length.
const STAGES: [(f64, f64); 3] = [(1e-3, 1e-4), (3e-5, 1e-6), (REACH, 1e-9)];
/// Newton steps of one stage.
const MOST_STEPS: usize = 150;
/// Step below which a rod on a saddle is helped off it, over the whisker's length.
const SADDLE: f64 = 1e-5;

/// How one stage ended.
enum Stage {
    Done,
    Unfinished,
}

impl DiscreteRod {
    /// Moves the base to `map_from_whisker` and lets the rod follow to the nearest equilibrium.
    ///
    /// Bounded in steps, whatever the map; the rod never passes through a boundary.
    pub fn advance(&mut self, map: &Map, map_from_whisker: Pose2) -> Relaxed {
        self.advance_until(map, map_from_whisker, &Stop::default())
    }

    /// As [`Self::advance`], unfinished where it is asked to stop.
    pub(in super::super) fn advance_until(&mut self, map: &Map, map_from_whisker: Pose2, stop: &Stop) -> Relaxed {
        self.base = Base { position: map_from_whisker.position(), heading: map_from_whisker.theta };
        let mut finished = true;
        for (reach, tolerance) in STAGES {
            finished = matches!(self.stage(map, self.barrier(reach), tolerance, stop), Stage::Done);
            self.hold_lengths();
        }
        // With the multipliers known, once more.
        finished &= matches!(self.stage(map, self.barrier(REACH), STAGES[2].1, stop), Stage::Done);
        let arrived = self.nodes[0].distance(self.base.position) <= 1e-3 * self.springs.h;
        if !arrived && map.crosses(self.nodes[0], self.base.position) {
            return Relaxed::Blocked;
        }
        if finished && arrived { Relaxed::Converged } else { Relaxed::Unfinished }
    }

    /// Hands the force of stretched links over to their multipliers.
    fn hold_lengths(&mut self) {
        for i in 0..self.springs.tension.len() {
            let longer = self.nodes[i + 1].distance(self.nodes[i]) - self.springs.h;
            self.springs.tension[i] += self.springs.stretch * longer;
        }
    }

    /// Steps of Newton's method since this was last asked.
    pub(in super::super) fn take_steps(&mut self) -> u64 {
        core::mem::take(&mut self.steps)
    }

    fn stage(&mut self, map: &Map, barrier: Barrier, tolerance: f64, stop: &Stop) -> Stage {
        let count = self.nodes.len();
        let mut work = Work { derivatives: Derivatives::new(count), factor: Derivatives::new(count).hessian };
        let mut room = 0.0;
        for _ in 0..MOST_STEPS {
            if stop.is_asked() {
                break;
            }
            self.steps += 1;
            if room <= 0.0 {
                self.gather(map, MARGIN * self.length);
                room = 0.5 * MARGIN * self.length;
            }
            let Some((mut step, shifted)) = self.newton_step(barrier, &mut work) else { return Stage::Unfinished };
            let mut largest = step.iter().map(|v| v.norm()).fold(0.0, f64::max);
            if !shifted && largest < tolerance * self.length {
                self.walk(barrier, &step, 1.0);
                return Stage::Done;
            }
            let wanted = if shifted { largest.max(SADDLE * self.length) } else { largest };
            let scale = wanted.min(LARGEST_STEP * self.length) / largest;
            if scale.is_finite() {
                step.iter_mut().for_each(|v| *v = *v * scale);
                largest *= scale;
            }
            let share = self.walk(barrier, &step, 1.0);
            if share <= 0.0 {
                // No lower point along the step: rounding, if the step is small.
                let small = largest < 100.0 * tolerance * self.length;
                return if small && !shifted { Stage::Done } else { Stage::Unfinished };
            }
            room -= share * largest;
        }
        Stage::Unfinished
    }

    /// The step of Newton's method, and whether the Hessian had to be made positive definite.
    fn newton_step(&self, barrier: Barrier, work: &mut Work) -> Option<(Vec<Vec2>, bool)> {
        self.springs.derivatives(self.base, &self.nodes, &self.pairs, barrier, &mut work.derivatives);
        let mut shift = 0.0;
        // The stiffness of a joint against a node's sideways motion.
        let first = 1e-4 * self.unit * self.length * self.length / self.springs.h.powi(3);
        let last = work.derivatives.hessian.scale();
        let mut right = Vec::new();
        while shift <= last && last.is_finite() {
            right.clone_from(&work.derivatives.gradient);
            if work.derivatives.hessian.solve(shift, &mut work.factor, &mut right) {
                let step = right.chunks_exact(2).map(|v| Vec2::new(-v[0], -v[1])).collect();
                return Some((step, shift > 0.0));
            }
            shift = if shift > 0.0 { 4.0 * shift } else { first };
        }
        None
    }

    /// Goes along `step` as far as it is safe and the energy falls; the share of the step gone.
    fn walk(&mut self, barrier: Barrier, step: &[Vec2], most: f64) -> f64 {
        let mut share = most;
        for pair in &self.pairs {
            share = safe_share(pair, &self.nodes, step, share);
        }
        let energy = |nodes: &[Vec2]| self.springs.energy(self.base, nodes, &self.pairs, barrier);
        let start = energy(&self.nodes);
        for _ in 0..30 {
            let there: Vec<Vec2> = self.nodes.iter().zip(step).map(|(p, v)| *p + *v * share).collect();
            if energy(&there) <= start {
                self.nodes = there;
                return share;
            }
            share *= 0.5;
        }
        0.0
    }
}

/// Room for the linear equations.
struct Work {
    derivatives: Derivatives,
    factor: super::banded::Banded,
}
