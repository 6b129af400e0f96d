//! Where along the way the robot may have come back: candidates, the bounds of odometry and of what is proved already, and the verdicts.
//!
//! Once one closure is proved, the way to the next one is short, so that the robot keeps its place in its own outline. Where a submap leaves more than one place
//! open a longer one is looked at, with what the shorter one left.

use super::closure::{PoseBounds, Proof, Resolution, prove};
use super::front_end::FrontEnd;
use super::overlap::Tie;
use super::submap::{submap, way_bounds};
use super::{Closure, ClosureVerdict};
use crate::Stop;
use crate::config::MappingOptions;
use crate::world::Robot;

/// What is known of a place where the robot may have come back: two key poses, the earlier first.
struct Candidate {
    keys: (usize, usize),
    proof: Proof,
}

struct Search<'a> {
    front: &'a FrontEnd,
    robot: &'a Robot,
    options: &'a MappingOptions,
    stop: &'a Stop,
    /// The way up to each key pose (m).
    ways: Vec<f64>,
    ties: Vec<Tie>,
}

/// All places along the way where the robot may have come back, and ties of those that are proved.
pub(super) fn closures(
    front: &FrontEnd,
    robot: &Robot,
    options: &MappingOptions,
    stop: &Stop,
) -> (Vec<Closure>, Vec<Tie>) {
    let mut ways = vec![0.0; front.keys.len()];
    for k in 1..ways.len() {
        ways[k] = ways[k - 1] + front.keys[k].leg.way;
    }
    let mut search = Search { front, robot, options, stop, ways, ties: Vec::new() };
    let mut candidates = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for later in 0..front.keys.len() {
        if search.ways[later] - last < options.closure_every || stop.is_asked() {
            continue;
        }
        if let Some(candidate) = search.candidate(later) {
            last = search.ways[later];
            candidates.push(candidate);
        }
    }
    // What the first proof says of places before it.
    if !search.ties.is_empty() {
        for candidate in candidates.iter_mut().rev().filter(|c| matches!(c.proof, Proof::Open(..) | Proof::Unfinished))
        {
            if let Some(again) = search.candidate(candidate.keys.1) {
                *candidate = again;
            }
        }
    }
    search.ties.sort_by_key(|tie| tie.later);
    (candidates.iter().map(|candidate| search.told(candidate)).collect(), search.ties)
}

impl Search<'_> {
    /// What is known of a return at a key pose; none where no earlier stretch comes near.
    fn candidate(&mut self, later: usize) -> Option<Candidate> {
        let keys = &self.front.keys;
        let nearest_tie = self.ties.iter().min_by(|a, b| {
            let apart = |tie: &Tie| (self.ways[tie.later] - self.ways[later]).abs();
            apart(a).total_cmp(&apart(b))
        });
        let here = keys[later].odom_from_key;
        // Where the odometry puts it, on the pass of the earlier key pose where a closure leads there.
        let place = nearest_tie.map_or(here, |tie| {
            let on = keys[tie.earlier].odom_from_key.compose(tie.earlier_from_later);
            on.compose(keys[tie.later].odom_from_key.between(here))
        });
        let near = |k: &usize| keys[*k].odom_from_key.position().distance(place.position());
        let apart = |k: &usize| self.ways[later] - self.ways[*k] >= 2.0 * self.options.submap;
        let earlier = (0..later).filter(apart).min_by(|a, b| near(a).total_cmp(&near(b)))?;
        let bounds = self.bounds((earlier, later), nearest_tie);
        // Stretches that lie apart by more have no wall in common.
        if bounds.middle.position().norm() > bounds.half[0].hypot(bounds.half[1]) + 0.5 * self.options.submap {
            return None;
        }
        let proof = self.prove((earlier, later), bounds)?;
        if let Proof::Unique(PoseBounds { middle, half }) = proof {
            self.ties.push(Tie { earlier, later, earlier_from_later: middle, extent: half });
        }
        Some(Candidate { keys: (earlier, later), proof })
    }

    /// The poses of a later key pose in an earlier one that the odometry's bounds allow, along the way or by a closure: what is smaller.
    fn bounds(&self, (earlier, later): (usize, usize), tie: Option<&Tie>) -> PoseBounds {
        let way = |from, to| way_bounds(self.front, self.robot, self.options.drift, (from, to));
        let along = way(earlier, later);
        let Some(tie) = tie else { return along };
        let closure = PoseBounds { middle: tie.earlier_from_later, half: tie.extent };
        let by_tie = way(earlier, tie.earlier).then(closure).then(way(tie.later, later));
        if by_tie.half[0] < along.half[0] { by_tie } else { along }
    }

    /// What submaps around both key poses leave, the shortest first; none with too few contacts.
    fn prove(&self, (earlier, later): (usize, usize), mut bounds: PoseBounds) -> Option<Proof> {
        let options = self.options;
        let mut best = None;
        let mut reach = options.submap;
        while reach <= options.longest_submap && !self.stop.is_asked() {
            let [a, b] = [earlier, later].map(|key| submap(self.front, self.robot, options, (key, reach)));
            let (Some(a), Some(b)) = (a, b) else { break };
            let grain = Resolution {
                place: options.closure_resolution,
                arm: options.submap,
                largest: (options.largest_place, options.largest_turn),
                work: options.closure_work,
            };
            let proof = prove(&a, &b, bounds, grain, self.stop);
            if let Proof::Open(_, left) = proof {
                bounds = left;
            }
            let is_decided = matches!(proof, Proof::Unique(..) | Proof::Contradiction);
            best = Some(proof);
            if is_decided {
                break;
            }
            reach *= 2.0;
        }
        best
    }

    fn told(&self, candidate: &Candidate) -> Closure {
        let (verdict, places, extent) = match candidate.proof {
            Proof::Unique(PoseBounds { half, .. }) => (ClosureVerdict::Proved, 1, half),
            Proof::Open(places, PoseBounds { half, .. }) => (ClosureVerdict::Hypothesis, places, half),
            Proof::Contradiction => (ClosureVerdict::Contradiction, 0, [0.0; 3]),
            Proof::Unfinished => (ClosureVerdict::Unfinished, 0, [0.0; 3]),
        };
        let t = |key: usize| self.front.keys[key].t;
        Closure { later: t(candidate.keys.1), earlier: t(candidate.keys.0), verdict, places, extent }
    }
}
