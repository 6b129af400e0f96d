//! Loop closures proved by set inversion \[jaulin2001applied, ch. 3\]: all poses of what was felt later in what was felt earlier that the
//! odometry's bounds allow, and that contradict nothing that was felt.
//!
//! Where a whisker or the robot passed there is no wall, and where a whisker touched there is one. So no later contact lies deep in the
//! space that was passed earlier, nor an earlier contact deep in the space that was passed later; deep by more than all declared errors
//! together. Boxes of poses of which every pose breaks this are out. If what is left is one small place, the robot has come back, whatever
//! else there may be in the world: walls that nobody has felt yet included, since a contact with one of these would have to lie
//! where nobody has been.

use super::free_space::PassedSpace;
use crate::Stop;
use crate::config::MappingOptions;
use crate::plane::{Pose2, Vec2};
use std::collections::VecDeque;
use vibrissa_core::math;

/// What was felt and passed over a stretch of the way, in the frame of its middle key pose.
pub(super) struct Submap {
    /// Contacts, and how far each may be off (m): contact and odometry together.
    pub(super) contacts: Vec<(Vec2, f64)>,
    /// The space that was passed, with what it may be off.
    pub(super) passed: PassedSpace,
}

/// Poses that are possible: a middle, and half of the ranges of x, y (m) and heading (rad).
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseBounds {
    pub(super) middle: Pose2,
    pub(super) half: [f64; 3],
}

impl PoseBounds {
    /// Poses after these, seen from where these are.
    pub(super) fn then(self, next: Self) -> Self {
        let Self { middle, half: [x, y, turn] } = self;
        // A box that is turned lies within the disc around it.
        let place = next.half[0].hypot(next.half[1]);
        let off = place + turn * (next.middle.position().norm() + place);
        Self { middle: middle.compose(next.middle), half: [x + off, y + off, turn + next.half[2]] }
    }
}

/// What came of a closure.
#[derive(Clone, Copy, Debug)]
pub(super) enum Proof {
    /// One small place is left.
    Unique(PoseBounds),
    /// More is left than one small place: how many separate ones, and the bounds of all.
    Open(usize, PoseBounds),
    /// Nothing: the declared bounds do not hold.
    Contradiction,
    /// The search was too long, or stopped.
    Unfinished,
}

/// How finely poses are told apart, and how much may be searched.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resolution {
    /// Half of the smallest box (m), and what a turn counts for (m).
    pub(super) place: f64,
    pub(super) arm: f64,
    /// Largest half extent of one place (m, rad).
    pub(super) largest: (f64, f64),
    /// Most boxes.
    pub(super) work: usize,
}

impl Resolution {
    pub(super) fn of(options: &MappingOptions) -> Self {
        Self {
            place: options.closure_resolution,
            arm: options.submap,
            largest: (options.largest_place, options.largest_turn),
            work: options.closure_work,
        }
    }
}

/// Poses by their middle, and half of the ranges of x, y (m) and heading (rad).
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseBox {
    middle: [f64; 3],
    half: [f64; 3],
}

/// Whether the poses of a later submap in an earlier one are one place.
///
/// The largest boxes come first. The search ends as soon as two poses that contradict nothing are too far apart for one place.
pub(super) fn prove(earlier: &Submap, later: &Submap, bounds: PoseBounds, grain: Resolution, stop: &Stop) -> Proof {
    one_place(&|poses| contradicts(earlier, later, poses), bounds, grain, stop)
}

/// What ever longer submaps leave of poses within bounds: `search` takes the way before and after its middle (m) and what is left so far, and
/// gives none where it has no submap of that length.
pub(super) fn by_longer_submaps(
    options: &MappingOptions,
    mut bounds: PoseBounds,
    stop: &Stop,
    search: &dyn Fn(f64, PoseBounds) -> Option<Proof>,
) -> Option<Proof> {
    let (mut last, mut reach) = (None, options.submap);
    while reach <= options.longest_submap && !stop.is_asked() {
        let Some(proof) = search(reach, bounds) else { break };
        last = Some(proof);
        match proof {
            Proof::Unique(..) | Proof::Contradiction => break,
            Proof::Open(_, left) => bounds = left,
            Proof::Unfinished => {}
        }
        reach *= 2.0;
    }
    last
}

/// Whether the poses within bounds that contradict nothing are one place: set inversion by bisection.
pub(super) fn one_place(
    contradicts: &dyn Fn(&PoseBox) -> bool,
    bounds: PoseBounds,
    grain: Resolution,
    stop: &Stop,
) -> Proof {
    let Pose2 { x, y, theta } = bounds.middle;
    let whole = PoseBox { middle: [x, y, theta], half: bounds.half };
    let largest = [grain.largest.0, grain.largest.0, grain.largest.1];
    let (mut queue, mut left, mut work) = (VecDeque::from([whole]), Vec::new(), 0);
    let mut possible: Vec<PoseBox> = Vec::new();
    while let Some(next) = queue.pop_front() {
        work += 1;
        if work > grain.work || stop.is_asked() {
            return Proof::Unfinished;
        }
        if contradicts(&next) {
            continue;
        }
        let middle = PoseBox { middle: next.middle, half: [0.0; 3] };
        if !contradicts(&middle) {
            possible.push(middle);
            let (middle, half) = hull(&possible);
            possible = vec![PoseBox { middle, half }];
            if (0..3).any(|k| half[k] > largest[k]) {
                left.extend(queue);
                left.push(next);
                return Proof::Open(places(&left), bounds_of(&left));
            }
        }
        match next.halves(&grain) {
            Some(halves) => queue.extend(halves),
            None => left.push(next),
        }
    }
    if left.is_empty() {
        return Proof::Contradiction;
    }
    let (places, bounds) = (places(&left), bounds_of(&left));
    let small = (0..3).all(|k| bounds.half[k] <= largest[k]);
    if places == 1 && small { Proof::Unique(bounds) } else { Proof::Open(places, bounds) }
}

fn bounds_of(boxes: &[PoseBox]) -> PoseBounds {
    let ([x, y, theta], half) = hull(boxes);
    PoseBounds { middle: Pose2 { x, y, theta }, half }
}

/// Whether every pose of a box puts a contact deep in passed space.
fn contradicts(earlier: &Submap, later: &Submap, poses: &PoseBox) -> bool {
    later.contacts.iter().any(|(contact, off)| {
        let (there, open) = poses.there(*contact);
        earlier.passed.depth(there) > open + off
    }) || poses.is_in_passed(&earlier.contacts, &later.passed)
}

impl PoseBox {
    /// Where a place of the later frame is in the earlier one, and how far off that may be at the box's other poses (m).
    pub(super) fn there(&self, place: Vec2) -> (Vec2, f64) {
        let [x, y, theta] = self.middle;
        let open = math::hypot(self.half[0], self.half[1]) + place.norm() * self.half[2];
        (Vec2::new(x, y) + place.rotated(theta), open)
    }

    /// Whether every pose puts one of the earlier frame's contacts deep in what was passed later.
    pub(super) fn is_in_passed(&self, earlier: &[(Vec2, f64)], later: &PassedSpace) -> bool {
        let [x, y, theta] = self.middle;
        let (sin, cos) = math::sin_cos(theta);
        let place = math::hypot(self.half[0], self.half[1]);
        earlier.iter().any(|(contact, off)| {
            let from = *contact - Vec2::new(x, y);
            let there = Vec2::new(cos * from.x + sin * from.y, cos * from.y - sin * from.x);
            later.depth(there) > place + (from.norm() + place) * self.half[2] + off
        })
    }
}

impl PoseBox {
    /// Its halves along the longest side; none where it is small enough.
    fn halves(&self, grain: &Resolution) -> Option<[Self; 2]> {
        let size = |axis: usize| self.half[axis] * if axis == 2 { grain.arm } else { 1.0 };
        let axis = (0..3).max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
        if size(axis) <= grain.place {
            return None;
        }
        let (mut a, mut b) = (*self, *self);
        let half = 0.5 * self.half[axis];
        (a.half[axis], b.half[axis]) = (half, half);
        a.middle[axis] -= half;
        b.middle[axis] += half;
        Some([a, b])
    }

    fn touches(&self, other: &Self) -> bool {
        (0..3).all(|k| (self.middle[k] - other.middle[k]).abs() <= (self.half[k] + other.half[k]) * (1.0 + 1e-9))
    }
}

fn hull(boxes: &[PoseBox]) -> ([f64; 3], [f64; 3]) {
    let edge = |k: usize, sign: f64| {
        let all = boxes.iter().map(|b| sign * (b.middle[k] + sign * b.half[k]));
        sign * all.fold(f64::NEG_INFINITY, f64::max)
    };
    let (lo, hi) = ([0, 1, 2].map(|k| edge(k, -1.0)), [0, 1, 2].map(|k| edge(k, 1.0)));
    ([0, 1, 2].map(|k| 0.5 * (lo[k] + hi[k])), [0, 1, 2].map(|k| 0.5 * (hi[k] - lo[k])))
}

/// How many groups of boxes that touch there are.
fn places(boxes: &[PoseBox]) -> usize {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    let low = |k: usize| boxes[k].middle[0] - boxes[k].half[0];
    order.sort_by(|&a, &b| low(a).total_cmp(&low(b)));
    let mut parent: Vec<usize> = (0..boxes.len()).collect();
    fn root(parent: &mut [usize], mut at: usize) -> usize {
        while parent[at] != at {
            parent[at] = parent[parent[at]];
            at = parent[at];
        }
        at
    }
    for (rank, &a) in order.iter().enumerate() {
        let end = boxes[a].middle[0] + boxes[a].half[0] + 1e-9;
        for &b in order[rank + 1..].iter().take_while(|&&b| low(b) <= end) {
            if boxes[a].touches(&boxes[b]) {
                let (p, q) = (root(&mut parent, a), root(&mut parent, b));
                parent[p.max(q)] = p.min(q);
            }
        }
    }
    (0..boxes.len()).filter(|&k| parent[k] == k).count()
}

#[cfg(test)]
mod tests {
    use super::super::free_space::FreeSpace;
    use super::*;

    const GRAIN: Resolution = Resolution { place: 1e-3, arm: 0.3, largest: (0.03, 0.15), work: 400_000 };

    /// A submap of a robot that went along these corners of a wall on its right, seen from `frame`: contacts, and the space between way
    /// and wall.
    fn submap(corners: &[Vec2], frame: Pose2) -> Submap {
        let (mut contacts, mut places) = (Vec::new(), Vec::new());
        let local = |p: Vec2| frame.inverse_transform_point(p);
        for pair in corners.windows(2) {
            let along = (pair[1] - pair[0]) * (1.0 / pair[0].distance(pair[1]));
            let steps = (pair[0].distance(pair[1]) / 5e-4) as usize;
            for k in 0..=steps {
                let wall = pair[0] + along * (k as f64 * 5e-4);
                if k % 8 == 0 {
                    contacts.push((local(wall), 1e-3));
                }
                places.extend((0..=160).map(|j| (local(wall + along.perp() * (5e-4 * f64::from(j))), 1e-3)));
            }
        }
        Submap { contacts, passed: PassedSpace(vec![FreeSpace::new(&places, (&[], 0.0), 1e-3)]) }
    }

    fn at(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    fn proof(earlier: &[Vec2], later: &[Vec2], place: f64, turn: f64) -> Proof {
        let frame = Pose2::new(0.02, 0.06, 0.1);
        let off = Pose2::new(0.7 * place, -0.6 * place, 0.8 * turn);
        let bounds = PoseBounds { middle: off, half: [place, place, turn] };
        prove(&submap(earlier, frame), &submap(later, frame), bounds, GRAIN, &Stop::default())
    }

    #[test]
    fn a_corner_that_is_felt_again_is_one_place() {
        let corner = [at(0.25, 0.0), at(0.0, 0.0), at(0.0, 0.25)].map(|p| at(p.y, p.x));
        let Proof::Unique(PoseBounds { middle: pose, half }) = proof(&corner, &corner, 0.03, 0.05) else {
            panic!("no proof")
        };
        for (value, half) in [pose.x, pose.y, pose.theta].into_iter().zip(half) {
            assert!(value.abs() <= half, "the truth is lost: {pose:?} {half:?}");
        }
    }

    #[test]
    fn a_straight_wall_is_no_proof() {
        let wall = [at(-0.3, 0.0), at(0.3, 0.0)];
        assert!(matches!(proof(&wall, &wall, 0.05, 0.05), Proof::Open(..)));
    }

    #[test]
    fn an_equal_bay_within_the_bounds_is_no_proof() {
        // The wall jumps back by 40 mm every 80 mm: the next bay looks alike.
        let step = |k: i32| {
            [at(0.08 * f64::from(k), 0.04 * f64::from(k % 2)), at(0.08 * f64::from(k), 0.04 * f64::from((k + 1) % 2))]
        };
        let bays: Vec<Vec2> = (-4..5).flat_map(step).collect();
        assert!(!matches!(proof(&bays, &bays, 0.18, 0.03), Proof::Unique(..)));
    }

    #[test]
    fn bounds_without_the_truth_are_a_contradiction_or_leave_it_open() {
        let corner = [at(0.0, 0.25), at(0.0, 0.0), at(0.25, 0.0)];
        let frame = Pose2::new(0.02, 0.06, 0.1);
        let bounds = PoseBounds { middle: Pose2::new(0.03, 0.03, 0.0), half: [5e-3, 5e-3, 0.01] };
        let found = prove(&submap(&corner, frame), &submap(&corner, frame), bounds, GRAIN, &Stop::default());
        assert!(matches!(found, Proof::Contradiction), "{found:?}");
    }
}
