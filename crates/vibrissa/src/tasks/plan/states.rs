//! The states that are left: the poses of places, and samples of their ridges.

use crate::flow::pose::Hypothesis;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, Robot};

/// Spacing of samples along a ridge (m), unless they would be too many.
const SPACING: f64 = 8e-3;

/// A state that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemainingState {
    /// The robot, map frame.
    pub pose: Pose2,
    /// Its share; shares need not sum to 1. Beside others a state without any is told apart from none, but motions are free of collision and gentle
    /// for it, too.
    pub weight: f64,
    /// Index of the place that it belongs to.
    pub place: usize,
    /// Covariance of (x, y, heading) around it in the map frame (m², m rad, rad²), without what its neighbours on a ridge stand for.
    pub covariance: [[f64; 3]; 3],
}

/// Places that are less likely than this together weigh nothing.
const UNLIKELY: f64 = 5e-3;
/// What a place may be off besides (m).
const CLEAR: f64 = 2e-3;
/// A place without a ridge is sampled along its longest axis where that is longer than this (m, one standard deviation),
const LONG: f64 = 3e-3;
/// as far as this to both sides (standard deviations), in so many steps.
const FAR: f64 = 2.0;
const STEPS: i32 = 2;

/// The states that hypotheses stand for, at most about so many: one for each place, and the others along ridges. Where a method gives no ridge
/// the longest axis of a place's covariance stands for it. Places that are less likely than 0.5 % together weigh nothing.
#[must_use]
pub fn remaining(hypotheses: &[Hypothesis], most: usize) -> Vec<RemainingState> {
    let all: f64 = hypotheses.iter().map(|h| h.weight).sum();
    let (mut sum, mut count) = (0.0, 0);
    // The heaviest come first.
    while count < hypotheses.len().min(most.max(1)) && sum <= (1.0 - UNLIKELY) * all {
        sum += hypotheses[count].weight;
        count += 1;
    }
    let kept: Vec<(f64, [[f64; 3]; 3], Vec<Pose2>)> = hypotheses[..count].iter().map(curve).collect();
    let lengths: Vec<f64> = kept.iter().map(|(.., ridge)| length(ridge)).collect();
    let spacing = SPACING.max(lengths.iter().sum::<f64>() / (most.saturating_sub(2 * count)).max(1) as f64);
    let mut states = Vec::new();
    for (place, ((weight, own, ridge), length)) in kept.iter().zip(lengths).enumerate() {
        let count = if ridge.len() < 2 { 1 } else { (length / spacing).ceil().max(1.0) as usize + 1 };
        for k in 0..count {
            let (pose, way) = on_ridge(ridge, length * k as f64 / (count - 1).max(1) as f64);
            let covariance = across(*own, way);
            states.push(RemainingState { pose, weight: weight / count as f64, place, covariance });
        }
    }
    let unlikely = hypotheses.iter().enumerate().skip(count).take(most.saturating_sub(states.len()));
    states.extend(unlikely.map(|(place, h)| RemainingState {
        pose: h.pose,
        weight: 0.0,
        place,
        covariance: [[0.0; 3]; 3],
    }));
    states
}

/// The states with a weight first, and how many these are; all where none has one.
pub(super) fn weighty_first(states: &[RemainingState]) -> (Vec<RemainingState>, usize) {
    let (mut weighty, others): (Vec<_>, Vec<_>) = states.iter().copied().partition(|state| state.weight > 0.0);
    let count = if weighty.is_empty() { others.len() } else { weighty.len() };
    weighty.extend(others);
    (weighty, count)
}

/// Weight and covariance of a place, and the curve that it lies on.
fn curve(h: &Hypothesis) -> (f64, [[f64; 3]; 3], Vec<Pose2>) {
    let own = h.covariance.unwrap_or_default();
    if h.ridge.len() > 1 {
        return (h.weight, own, h.ridge.clone());
    }
    // The longest axis of the position's ellipse.
    let (a, b, c) = (own[0][0], own[0][1], own[1][1]);
    let half = (0.25 * (a - c) * (a - c) + b * b).sqrt();
    let longest = (0.5 * (a + c) + half).max(0.0).sqrt();
    if longest < LONG {
        return (h.weight, own, vec![h.pose]);
    }
    let angle = 0.5 * (2.0 * b).atan2(a - c);
    let (x, y) = (angle.cos(), angle.sin());
    // The heading that goes with the place on it.
    let turn = (own[2][0] * x + own[2][1] * y) / (longest * longest);
    let at = |k: i32| {
        let s = FAR * longest * f64::from(k) / f64::from(STEPS);
        Pose2::new(h.pose.x + s * x, h.pose.y + s * y, h.pose.theta + s * turn)
    };
    (h.weight, own, (-STEPS..=STEPS).map(at).collect())
}

fn length(ridge: &[Pose2]) -> f64 {
    ridge.windows(2).map(|w| w[0].position().distance(w[1].position())).sum()
}

/// Those of the states in which the robot can be: origin and whisker bases in free space, its footprint clear of all boundaries. All of them
/// where it can be in none.
pub(super) fn possible(map: &Map, robot: &Robot, states: &[RemainingState], footprint: f64) -> Vec<RemainingState> {
    let is_possible = |state: &&RemainingState| {
        let c = &state.covariance;
        let unsure = FAR * (c[0][0] + c[1][1]).max(0.0).sqrt() + CLEAR;
        // Inside by no more than what is not known.
        let off = |p: Vec2, least: f64| {
            let near = map.nearest_within(p, footprint + unsure).map_or(f64::INFINITY, |near| near.distance);
            if map.is_free(p) { near + unsure >= least } else { near <= unsure - least }
        };
        off(state.pose.position(), footprint)
            && robot.whiskers.iter().all(|w| off(state.pose.compose(w.robot_from_whisker).position(), 0.0))
    };
    let some: Vec<RemainingState> = states.iter().filter(is_possible).copied().collect();
    if some.is_empty() { states.to_vec() } else { some }
}

/// The pose at so many metres along a ridge, and how a pose goes along it there.
fn on_ridge(ridge: &[Pose2], at: f64) -> (Pose2, [f64; 3]) {
    let mut gone = 0.0;
    for (index, w) in ridge.windows(2).enumerate() {
        let step = w[1].position() - w[0].position();
        let (length, turn) = (step.norm(), wrap_angle(w[1].theta - w[0].theta));
        if length > 0.0 && (gone + length >= at || index + 2 == ridge.len()) {
            let share = ((at - gone) / length).clamp(0.0, 1.0);
            let place = w[0].position() + step * share;
            let way = [step.x / length, step.y / length, turn / length];
            return (Pose2::new(place.x, place.y, w[0].theta + share * turn), way);
        }
        gone += length;
    }
    (ridge.last().copied().unwrap_or_default(), [0.0; 3])
}

/// A covariance where the place along the ridge is given: the Gaussian's, conditioned on it.
fn across(c: [[f64; 3]; 3], way: [f64; 3]) -> [[f64; 3]; 3] {
    let n = [way[0], way[1], 0.0];
    let with = |i: usize| (0..3).map(|j| c[i][j] * n[j]).sum::<f64>();
    let with = [with(0), with(1), with(2)];
    let along: f64 = (0..3).map(|i| n[i] * with[i]).sum();
    if along <= 0.0 {
        return c;
    }
    let mut rest = c;
    for (i, row) in rest.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value -= with[i] * with[j] / along;
        }
    }
    rest
}
