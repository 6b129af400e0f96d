//! What the hypotheses say before the end, as they are linearised now: nothing is run again and nothing is sampled.

use super::bank::{HypothesisBank, WEAK_PRIOR, trust_region_step};
use super::hypothesis::{GaussianHypothesis, arm, moved};
use super::log_window::LogWindow;
use super::map_symmetry::MapSymmetries;
use super::odometry_calibration::Matrix;
use super::places::{PosteriorPlace, REPORTED, are_linked, at_robot, covariance, images_of, mass, rest};
use crate::linear_algebra::add;
use crate::plane::Pose2;
use crate::world::Odometry;

/// Only so many of the most likely hypotheses are looked at, which bounds the time: all pairs of them are compared.
const MOST: usize = 40;

/// One hypothesis at its best place.
struct Likely<'a> {
    hypothesis: &'a GaussianHypothesis,
    cost: f64,
    /// The odometry frame in the map frame, and the covariance about the pivot.
    frame: Pose2,
    own: Matrix,
}

/// The frame that a hypothesis estimates for the odometry, the robot's place in which is this one now.
pub(super) fn frame(one: &GaussianHypothesis, bank: &HypothesisBank, odom_from_robot: Pose2) -> Pose2 {
    let d = trust_region_step(one.calibrated_step(WEAK_PRIOR, bank.shared).1);
    let there = moved(one.map_from_odom, bank.pivot, d);
    let Some(response) = one.belief.calibration(bank.shared) else { return there };
    // What the calibration parameters that the readings ask for do to the way from the first row on.
    let (errors, by) = (one.belief.way.errors(there.theta), response.given(d));
    let off = |i: usize| (0..3).map(|way| errors[way][i] * by[way]).sum::<f64>();
    let robot = there.compose(odom_from_robot);
    Pose2::new(robot.x + off(0), robot.y + off(1), robot.theta + off(2)).compose(odom_from_robot.inverse())
}

/// The pose of the odometry frame that the best hypothesis estimates, the robot's place in which is this one now.
pub(super) fn best(bank: &HypothesisBank, odom_from_robot: Pose2) -> Option<Pose2> {
    let predicted_cost = |h: &GaussianHypothesis| h.predicted_cost(WEAK_PRIOR, bank.shared);
    let one = bank.hypotheses.iter().min_by(|a, b| predicted_cost(a).total_cmp(&predicted_cost(b)))?;
    Some(frame(one, bank, odom_from_robot))
}

/// The places at the last row of the history.
pub(super) fn places(
    bank: &HypothesisBank,
    symmetries: &MapSymmetries,
    history: &LogWindow,
    bounds: &Odometry,
) -> Vec<PosteriorPlace> {
    let last = history.pose(history.len() - 1);
    let likely = likely(bank, last);
    let rest = rest(bounds, history.len());
    let one = |one: &Likely<'_>| {
        let (pose, mut covariance) = at_robot(one.frame, bank, &one.own, last);
        let (h, frame) = (one.hypothesis, one.hypothesis.map_from_odom);
        let arm = arm(frame, bank.pivot, last);
        add(&mut covariance, &h.belief.covariance(bank.shared, WEAK_PRIOR, frame.theta, arm, &rest));
        (pose, covariance)
    };
    let least = likely.first().map_or(0.0, |one| one.cost);
    let place = |group: Vec<&Likely<'_>>| {
        let calibration = group.iter().map(|one| mass(least - one.cost, &one.own, group.len() > 1));
        let members: Vec<(Pose2, Matrix)> = group.iter().map(|member| one(member)).collect();
        PosteriorPlace {
            map_from_odom: group[0].frame,
            weight: calibration.sum(),
            covariance: members[0].1,
            members,
            ridge: Vec::new(),
            broken: 0.0,
            calibration: None,
            nuisances: Vec::new(),
        }
    };
    let mut places: Vec<PosteriorPlace> = groups(&likely, bank).into_iter().map(place).collect();
    if bank.by_symmetry {
        places = places.iter().flat_map(|place| images_of(symmetries, place)).collect();
    }
    let total: f64 = places.iter().map(|p| p.weight).sum();
    places.iter_mut().for_each(|p| p.weight /= total);
    places.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    places
}

/// The hypotheses that would be told, the best first.
fn likely(bank: &HypothesisBank, last: Pose2) -> Vec<Likely<'_>> {
    let outlook =
        |h| -> (f64, &GaussianHypothesis) { (GaussianHypothesis::predicted_cost(h, WEAK_PRIOR, bank.shared), h) };
    let mut costs: Vec<(f64, &GaussianHypothesis)> = bank.hypotheses.iter().map(outlook).collect();
    let least = costs.iter().map(|one| one.0).fold(f64::INFINITY, f64::min);
    costs.retain(|one| one.0 <= least + REPORTED);
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    costs.truncate(MOST);
    let at_best = |(cost, hypothesis)| Likely {
        hypothesis,
        cost,
        frame: frame(hypothesis, bank, last),
        own: covariance(hypothesis, bank),
    };
    costs.into_iter().map(at_best).collect()
}

/// Those that are linked, directly or through others, the best first.
fn groups<'a, 'b>(likely: &'b [Likely<'a>], bank: &HypothesisBank) -> Vec<Vec<&'b Likely<'a>>> {
    let mut open: Vec<&Likely<'_>> = likely.iter().collect();
    let mut groups = Vec::new();
    while !open.is_empty() {
        let mut members = vec![open.remove(0)];
        let mut next = 0;
        while next < members.len() {
            let at = members[next];
            let near = |one: &&Likely<'_>| are_linked((at.frame, &at.own), (one.frame, &one.own), bank.pivot);
            let (joined, left): (Vec<_>, Vec<_>) = open.into_iter().partition(near);
            members.extend(joined);
            open = left;
            next += 1;
        }
        groups.push(members);
    }
    groups
}
