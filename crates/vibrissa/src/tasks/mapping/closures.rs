//! Where along the way the robot may have come back: candidates, the bounds of odometry and of what is proved already, and the verdicts.
//!
//! Once one closure is proved, the way to the next one is short, so that the robot keeps its place in its own outline. Where a submap leaves more than one place
//! open a longer one is looked at, with what the shorter one left.

use super::closure::{PoseBounds, Proof, Resolution, by_longer_submaps, prove};
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

/// All places along the way of a log where the robot may have come back, and ties of those that are proved; `start` is what ties a later
/// log to those before.
pub(super) fn closures(
    (front, visit): (&FrontEnd, usize),
    robot: &Robot,
    options: &MappingOptions,
    start: Option<Tie>,
    stop: &Stop,
) -> (Vec<Closure>, Vec<Tie>) {
    let mut ways = vec![0.0; front.keys.len()];
    for k in 1..ways.len() {
        ways[k] = ways[k - 1] + front.keys[k].leg.way;
    }
    let mut search = Search { front, robot, options, stop, ways, ties: start.into_iter().collect() };
    let mut candidates = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for later in front.visit(visit) {
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
        // Odometry compares with that of the log that the closure leads to.
        let visit = keys[nearest_tie.map_or(later, |tie| tie.earlier)].visit;
        let apart =
            |k: &usize| visit != keys[later].visit || self.ways[later] - self.ways[*k] >= 2.0 * self.options.submap;
        let of_visit = self.front.visit(visit);
        let others = of_visit.start..of_visit.end.min(later);
        // Since the last closure the robot has gone about as far along the pass that it led to. Other passes of the same place lie a long way of
        // odometry from there, whose bounds say little.
        let is_on_pass = |k: &usize| {
            nearest_tie.is_some_and(|tie| {
                let way = (self.ways[later] - self.ways[tie.later]).abs();
                (self.ways[*k] - self.ways[tie.earlier]).abs() <= way + self.options.submap
            })
        };
        let nearest = |of: &dyn Fn(&usize) -> bool| {
            let all = others.clone().filter(|k| apart(k) && of(k));
            let earlier = all.min_by(|a, b| near(a).total_cmp(&near(b)))?;
            let bounds = self.bounds((earlier, later), nearest_tie);
            // Stretches that lie apart by more have no wall in common.
            let reach = bounds.half[0].hypot(bounds.half[1]) + 0.5 * self.options.submap;
            (bounds.middle.position().norm() <= reach).then_some((earlier, bounds))
        };
        let (earlier, bounds) = nearest(&is_on_pass).or_else(|| nearest(&|_| true))?;
        let proof = self.prove((earlier, later), bounds)?;
        if let Proof::Unique(PoseBounds { middle, half }) = proof {
            self.ties.push(Tie { earlier, later, earlier_from_later: middle, extent: half });
        }
        Some(Candidate { keys: (earlier, later), proof })
    }

    /// The poses of a later key pose in an earlier one that the odometry's bounds allow, along the way or by a closure: what is smaller.
    fn bounds(&self, (earlier, later): (usize, usize), tie: Option<&Tie>) -> PoseBounds {
        let way = |from, to| way_bounds(self.front, self.robot, self.options.drift, (from, to));
        let along = || way(earlier, later);
        let Some(tie) = tie else { return along() };
        let closure = PoseBounds { middle: tie.earlier_from_later, half: tie.extent };
        let by_tie = way(earlier, tie.earlier).then(closure).then(way(tie.later, later));
        if self.front.keys[earlier].visit != self.front.keys[later].visit {
            return by_tie;
        }
        Some(along()).filter(|along| along.half[0] < by_tie.half[0]).unwrap_or(by_tie)
    }

    /// What submaps around both key poses leave; none with too few contacts.
    fn prove(&self, (earlier, later): (usize, usize), bounds: PoseBounds) -> Option<Proof> {
        by_longer_submaps(self.options, bounds, self.stop, &|reach, bounds| {
            let around = |key| submap(self.front, self.robot, self.options, (key, reach));
            Some(prove(&around(earlier)?, &around(later)?, bounds, Resolution::of(self.options), self.stop))
        })
    }

    fn told(&self, candidate: &Candidate) -> Closure {
        let (verdict, places, extent) = match candidate.proof {
            Proof::Unique(PoseBounds { half, .. }) => (ClosureVerdict::Proved, 1, half),
            Proof::Open(places, PoseBounds { half, .. }) => (ClosureVerdict::Hypothesis, places, half),
            Proof::Contradiction => (ClosureVerdict::Contradiction, 0, [0.0; 3]),
            Proof::Unfinished => (ClosureVerdict::Unfinished, 0, [0.0; 3]),
        };
        let [earlier, later] = [candidate.keys.0, candidate.keys.1].map(|key| &self.front.keys[key]);
        let logs = (later.visit, earlier.visit);
        Closure { later: later.t, earlier: earlier.t, logs, verdict, places, extent }
    }
}

#[cfg(test)]
mod tests;
