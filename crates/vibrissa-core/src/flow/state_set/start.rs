//! The first candidates, by work that can pause.

use super::membership::Tolerance;
use super::pass::{MEETING_COST, OutsideSearch};
use super::{Candidate, StateSet, admits, allowed_misses, cell};
use crate::WorkBudget;
use crate::config::DeterministicOptions;
use crate::flow::preimage::{AlignmentSearch, HEADING_SPACING, Observation, alignments};
use crate::world::{BoundarySample, Map};

/// From how many observations candidates enter: one of them may lie at a corner and align with nothing.
const ENTRIES: usize = 2;
/// Where more candidates than this would enter from an observation, they enter further apart,
const MOST_ENTERING: f64 = 8000.0;
/// but no further than at every second point of the boundary: what lies in between must still be near enough to be found.
const MOST_THINNED: f64 = 2.0;

/// A start that is under way: the states that explain one of the two observations which leave the fewest slopes open,
/// intersected with the preimages of the others. The set gets them when they are whole.
pub(crate) struct Start {
    /// The observations from which candidates enter, the next one last.
    entries: Vec<usize>,
    found: Vec<Candidate>,
    stage: Stage,
}

enum Stage {
    /// The states that one observation lets in are sought.
    Entering(Box<Entering>),
    /// They meet the other observations, this one now.
    Meeting { entry: usize, candidates: Vec<Candidate>, observation: usize, met: usize },
    /// All have: those that stand where no robot can are sought.
    Outside(OutsideSearch),
    /// No observation to enter from is left.
    Ended,
}

/// The candidates that one observation lets in, but for those that are among those found before.
struct Entering {
    entry: usize,
    spacing: f64,
    search: AlignmentSearch,
    /// The cells of what was found before, in order.
    known: Vec<[i64; 3]>,
    candidates: Vec<Candidate>,
}

impl Entering {
    /// The cells in which candidates that enter are the same.
    fn cell(set: &StateSet, spacing: f64) -> impl Fn(&Candidate) -> [i64; 3] {
        let odom_from_robot = set.odom_from_robot;
        move |candidate| cell(candidate, odom_from_robot, 2.0 * spacing, 4.0 * HEADING_SPACING)
    }

    /// Lets in what was found by now.
    fn enter(&mut self, set: &StateSet, observation: &Observation, options: &DeterministicOptions) {
        let cell = Self::cell(set, self.spacing);
        let enter = |state| Candidate::at(&state, observation, self.spacing);
        let new = |c: &Candidate| admits(options, c.map_from_odom) && self.known.binary_search(&cell(c)).is_err();
        self.candidates.extend(self.search.take_states().into_iter().map(enter).filter(new));
    }
}

impl Start {
    pub(crate) fn new(
        set: &StateSet,
        samples: &[BoundarySample],
        observations: &[Observation],
        options: &DeterministicOptions,
    ) -> Self {
        let mut order: Vec<usize> = (0..observations.len()).collect();
        order.sort_by(|&a, &b| observations[a].open_slopes().total_cmp(&observations[b].open_slopes()));
        order.truncate(ENTRIES);
        order.reverse();
        let mut start = Self { entries: order, found: set.candidates.clone(), stage: Stage::Ended };
        start.enter(set, samples, observations, options);
        start
    }

    /// Begins with the next observation to enter from, or with the end.
    fn enter(
        &mut self,
        set: &StateSet,
        samples: &[BoundarySample],
        observations: &[Observation],
        options: &DeterministicOptions,
    ) {
        self.stage = match (self.entries.pop(), observations.last()) {
            (Some(entry), _) => {
                let observation = &observations[entry];
                let wanted = (alignments(samples, observation) as f64 / MOST_ENTERING).sqrt().ceil();
                let thinned = wanted.clamp(1.0, MOST_THINNED);
                let search = AlignmentSearch::new(observation, thinned as usize);
                let spacing = thinned * options.boundary_spacing;
                let mut known: Vec<_> = self.found.iter().map(Entering::cell(set, spacing)).collect();
                known.sort_unstable();
                Stage::Entering(Box::new(Entering { entry, spacing, search, known, candidates: Vec::new() }))
            }
            (None, Some(last)) => Stage::Outside(OutsideSearch::new(last.robot_from_whisker, set.odom_from_robot)),
            (None, None) => Stage::Ended,
        };
    }

    /// Goes on until the budget is spent; whether the set has started.
    pub(crate) fn advance(
        &mut self,
        set: &mut StateSet,
        map: &Map,
        samples: &[BoundarySample],
        observations: &[Observation],
        options: &DeterministicOptions,
        budget: &mut WorkBudget,
    ) -> bool {
        loop {
            match &mut self.stage {
                Stage::Entering(entering) => {
                    let observation = &observations[entering.entry];
                    let is_done = entering.search.advance(map, samples, observation, budget);
                    entering.enter(set, observation, options);
                    if !is_done {
                        return false;
                    }
                    let (entry, candidates) = (entering.entry, core::mem::take(&mut entering.candidates));
                    self.stage = Stage::Meeting { entry, candidates, observation: 0, met: 0 };
                }
                Stage::Meeting { entry, candidates, observation, met } => {
                    if observation == entry {
                        *observation += 1;
                    }
                    let Some(other) = observations.get(*observation) else {
                        self.found.append(candidates);
                        self.enter(set, samples, observations, options);
                        continue;
                    };
                    let tolerance = Tolerance::new(other, options);
                    while let Some(candidate) = candidates.get_mut(*met) {
                        if budget.is_spent() {
                            return false;
                        }
                        candidate.meet(map, other, &tolerance);
                        *met += 1;
                        budget.spend(MEETING_COST);
                    }
                    let seen = *observation as u32 + 1;
                    candidates.retain(|c| c.missed <= allowed_misses(options.missed_share, seen));
                    (*observation, *met) = (*observation + 1, 0);
                }
                Stage::Outside(outside) => {
                    if !outside.advance(map, &self.found, budget) {
                        return false;
                    }
                    outside.drop_from(&mut self.found);
                    self.stage = Stage::Ended;
                }
                Stage::Ended => {
                    set.observations = observations.len() as u32;
                    set.candidates = core::mem::take(&mut self.found);
                    set.merge(set.odom_from_robot);
                    return true;
                }
            }
        }
    }
}
