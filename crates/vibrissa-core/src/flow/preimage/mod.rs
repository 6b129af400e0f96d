//! The fourth door: all robot states that explain an observation.
//!
//! The whisker's shape is laid against every point of the boundary at the angle that its recent history shows
//! \[routray, eq. "configFromAlignment"\]. The paper aligns one shape at one angle; here the angle has a tolerance,
//! since readings have errors, and the shape follows the angle, since the force is normal to the boundary.

mod alignment;
mod observation;
mod painter;
mod reading_preimage;
mod solid;
mod state_grid;
mod thin;
mod touch;

use crate::WorkBudget;
use crate::math;
pub use alignment::Alignment;
pub(crate) use observation::observed_moments;
pub use observation::{Branch, Observation};
pub use reading_preimage::{
    Construction, PreimageOptions, ReadingPreimage, distances, fused_preimage, reading_preimage, region_preimage,
};
pub use state_grid::{Raster, StateGrid};

use crate::plane::{Pose2, Vec2};
use crate::world::{BoundarySample, Map};
use core::f64::consts::FRAC_PI_2;

/// Spacing of the headings that are tried where the boundary's slope is uncertain (rad).
pub(crate) const HEADING_SPACING: f64 = 0.06;
/// Least spread of a heading (rad): a wall is not quite a parabola.
const LEAST_SPREAD: f64 = 0.02;
/// In a range of slopes wider than this (rad) headings are laid out twice as far apart.
const WIDE: f64 = 0.8;

/// A robot state that explains an observation at one point of the boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlignedState {
    /// The robot in the map frame.
    pub map_from_robot: Pose2,
    /// The touched point of the boundary (m), map frame.
    pub contact: Vec2,
    /// Direction of the boundary's normal there, towards free space (rad), map frame.
    pub normal: f64,
    /// The spacing to the next heading (rad), which this one stands for.
    pub heading_std: f64,
}

/// All robot states on the boundary that explain the observation: the paper's `Q_t`.
///
/// With `T_k` the boundary's frame at a sample (x along the boundary, free space on its left), `phi_a` the whisker's
/// slope at the contact and `gamma` the angle from boundary to whisker, the whisker base stands at
/// `T_k R(gamma - phi_a) [-x(s_a), -y(s_a)]`, which is the paper's equation with its clockwise angles turned round.
/// States whose whisker base is not in free space, or whose whisker crosses a boundary, are left out.
#[must_use]
pub fn aligned_states(map: &Map, samples: &[BoundarySample], observation: &Observation) -> Vec<AlignedState> {
    coarsely_aligned_states(map, samples, observation, 1)
}

/// How many states [`aligned_states`] looks at.
pub(crate) fn alignments(samples: &[BoundarySample], observation: &Observation) -> usize {
    let all = observation.branches.iter().flat_map(|branch| &branch.alignments);
    all.map(|alignment| headings(alignment).len() * samples.len()).sum()
}

/// As [`aligned_states`] at every `thinned`-th sample.
fn coarsely_aligned_states(
    map: &Map,
    samples: &[BoundarySample],
    observation: &Observation,
    thinned: usize,
) -> Vec<AlignedState> {
    let mut search = AlignmentSearch::new(observation, thinned);
    search.advance(map, samples, observation, &mut WorkBudget::unlimited());
    search.take_states()
}

/// What it costs to bend a whisker, and to lay it against a point of the boundary.
const BEND_COST: usize = 20;
const LAY_COST: usize = 2;

/// A search for the states that an observation allows, which can pause.
pub(crate) struct AlignmentSearch {
    thinned: usize,
    /// Branch, slope and spread of each heading that is tried, the next one last.
    headings: Vec<(usize, f64, f64)>,
    laying: Option<Laying>,
    states: Vec<AlignedState>,
}

/// A bent whisker that is laid against one point of the boundary after the other.
struct Laying {
    slope: f64,
    heading_std: f64,
    tip: Vec2,
    body: Vec<Vec2>,
    next: usize,
}

impl AlignmentSearch {
    /// At every `thinned`-th sample.
    pub(crate) fn new(observation: &Observation, thinned: usize) -> Self {
        let mut all = Vec::new();
        for (index, branch) in observation.branches.iter().enumerate() {
            for alignment in &branch.alignments {
                let slope = |(offset, std)| (index, alignment.boundary_slope + offset, std);
                all.extend(headings(alignment).into_iter().map(slope));
            }
        }
        all.reverse();
        Self { thinned: thinned.max(1), headings: all, laying: None, states: Vec::new() }
    }

    /// Goes on until the budget is spent; whether all states are found.
    pub(crate) fn advance(
        &mut self,
        map: &Map,
        samples: &[BoundarySample],
        observation: &Observation,
        budget: &mut WorkBudget,
    ) -> bool {
        loop {
            let Some(laying) = &mut self.laying else {
                let Some(heading) = self.headings.pop() else { return true };
                self.laying = Laying::new(observation, heading);
                budget.spend(BEND_COST);
                continue;
            };
            while let Some(sample) = samples.get(laying.next) {
                if budget.is_spent() {
                    return false;
                }
                laying.next += self.thinned;
                self.states.extend(laying.state(map, sample, observation));
                budget.spend(LAY_COST);
            }
            self.laying = None;
        }
    }

    /// What was found since the last call.
    pub(crate) fn take_states(&mut self) -> Vec<AlignedState> {
        core::mem::take(&mut self.states)
    }
}

impl Laying {
    fn new(observation: &Observation, (branch, slope, heading_std): (usize, f64, f64)) -> Option<Self> {
        let contact = observation.branches.get(branch)?.contacts.at_direction(slope + FRAC_PI_2)?;
        Some(Self { slope, heading_std, tip: contact.position, body: observation.body(&contact), next: 0 })
    }

    fn state(&self, map: &Map, sample: &BoundarySample, observation: &Observation) -> Option<AlignedState> {
        let map_from_whisker = align(sample, self.slope, self.tip);
        let possible = map.is_free(map_from_whisker.position()) && !crosses(map, map_from_whisker, &self.body);
        possible.then(|| AlignedState {
            map_from_robot: map_from_whisker.compose(observation.robot_from_whisker.inverse()),
            contact: sample.position,
            normal: sample.tangent + FRAC_PI_2,
            heading_std: self.heading_std,
        })
    }
}

/// Whether a chain of points in the whisker frame meets a boundary.
fn crosses(map: &Map, map_from_whisker: Pose2, chain: &[Vec2]) -> bool {
    let (sin, cos) = math::sin_cos(map_from_whisker.theta);
    let place = |p: &Vec2| map_from_whisker.position() + Vec2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y);
    let mut from = chain.first().map(place);
    chain.iter().skip(1).map(place).any(|to| from.replace(to).is_some_and(|from| map.crosses(from, to)))
}

/// The whisker frame laid against one boundary point: `T_k R(-slope) (-tip)`, with `slope = phi_a - gamma`.
fn align(sample: &BoundarySample, slope: f64, tip: Vec2) -> Pose2 {
    let boundary = Pose2::new(sample.position.x, sample.position.y, sample.tangent);
    let turned = boundary.compose(Pose2::new(0.0, 0.0, -slope));
    turned.compose(Pose2::new(-tip.x, -tip.y, 0.0))
}

/// Offsets from the best slope over all admissible ones, and the spread that each stands for (rad).
fn headings(alignment: &Alignment) -> Vec<(f64, f64)> {
    let (lo, width) = (alignment.offsets.lo(), alignment.offsets.width());
    let spacing = if width > WIDE { 2.0 * HEADING_SPACING } else { HEADING_SPACING };
    let steps = (width / spacing).ceil().max(1.0) as usize;
    let step = width / steps as f64;
    (0..=steps).map(|k| (lo + k as f64 * step, step.max(LEAST_SPREAD))).collect()
}
