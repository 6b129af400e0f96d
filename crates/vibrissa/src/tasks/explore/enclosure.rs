//! What the guaranteed method leaves open of a log of which the probabilistic one is sure, or which that does not explain: set inversion
//! \[jaulin2009robust\] as a second opinion. The true state is in the set as long as the declared bounds hold.

use crate::Stop;
use crate::config::ProbabilisticOptions;
use crate::flow::pose::{Hypothesis, Localization, Status};
use crate::flow::sensor_log::SensorLog;
use crate::plane::Pose2;
use crate::sets::Interval;
use crate::tasks::second_opinion::Told;
use crate::world::{Map, Robot};

/// A set is one place with what was told if none of it is further off than this (m).
pub(super) const SAME_PLACE: f64 = 0.02;
/// Sets of more places than this say nothing, since little was felt: beside a place that was told, and where none was.
const MOST_BESIDE: usize = 4;
const MOST_PLACES: usize = 100;

/// What the set says of a place that was told, or of none.
#[derive(Debug)]
pub(super) enum Opinion {
    /// Nothing: the method does not take the robot, the bounds are broken, or the set says little.
    None,
    /// The robot can be nowhere else.
    Proved,
    /// It can be there only, where the other method does not have it.
    Elsewhere(Box<Localization>),
    /// It can be at several places.
    Open(Vec<Hypothesis>),
}

/// The opinion of the set of all states that a log leaves open, by what the other method was told.
pub(super) fn opinion(
    log: &SensorLog,
    map: &Map,
    robot: &Robot,
    options: &ProbabilisticOptions,
    told: Option<Pose2>,
) -> Opinion {
    let Some(mut set) = Told { log, rows: &log.rows, map, robot, options, stop: &Stop::default() }.enclosure() else {
        return Opinion::None;
    };
    let places = &mut set.hypotheses;
    let most = if told.is_some() { MOST_BESIDE } else { MOST_PLACES };
    if matches!(set.status, Status::Inconsistent | Status::NoContact) || places.is_empty() || places.len() > most {
        return Opinion::None;
    }
    places.iter_mut().for_each(|place| place.covariance = Some(even_over(place)));
    let [place] = &places[..] else {
        let all = |told: Pose2| places.iter().all(|place| is_within(place, told));
        return if told.is_some_and(all) { Opinion::Proved } else { Opinion::Open(set.hypotheses) };
    };
    match told {
        Some(told) if is_within(place, told) => Opinion::Proved,
        _ if is_within(place, place.pose) => Opinion::Elsewhere(Box::new(set)),
        _ => Opinion::None,
    }
}

/// Whether all of a place is near a pose.
fn is_within(place: &Hypothesis, pose: Pose2) -> bool {
    let near = |range: Interval, at: f64| range.lo() >= at - SAME_PLACE && range.hi() <= at + SAME_PLACE;
    near(place.extent.x, pose.x) && near(place.extent.y, pose.y)
}

/// The covariance of what lies evenly within the box around a place.
fn even_over(place: &Hypothesis) -> [[f64; 3]; 3] {
    let variance = |range: Interval| range.width() * range.width() / 12.0;
    let mut covariance = [[0.0; 3]; 3];
    let extent = [place.extent.x, place.extent.y, place.extent.theta];
    extent.into_iter().enumerate().for_each(|(axis, range)| covariance[axis][axis] = variance(range));
    covariance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tasks::second_opinion::tests::swept;

    #[test]
    fn a_set_proves_a_place_disputes_it_or_knows_a_better_one() {
        let ask = |map: &Map, robot: &Robot, log: &SensorLog, told| {
            opinion(log, map, robot, &ProbabilisticOptions::default(), told)
        };
        let (map, robot, log, truth) = swept(0.12, 0.4, false);
        assert!(matches!(ask(&map, &robot, &log, Some(truth)), Opinion::Proved));
        let wrong = Pose2::new(truth.x - 0.2, truth.y, truth.theta);
        for told in [Some(wrong), None] {
            let Opinion::Elsewhere(set) = ask(&map, &robot, &log, told) else { panic!("{told:?}") };
            assert!(set.hypotheses[0].pose.position().distance(truth.position()) < 1e-3);
            assert!(set.hypotheses[0].covariance.is_some());
        }
        // Of two bays it leaves both, whichever is told.
        let (both, _, alike, end) = swept(0.12, 0.4, true);
        for told in [Some(end), None] {
            let Opinion::Open(places) = ask(&both, &robot, &alike, told) else { panic!("{told:?}") };
            assert_eq!(places.len(), 2);
        }
        // A straight wall is no place: many are left, which say nothing against one that is told.
        let (.., short, end) = swept(0.06, 0.15, false);
        assert!(matches!(ask(&map, &robot, &short, Some(end)), Opinion::None));
        let Opinion::Open(places) = ask(&map, &robot, &short, None) else { panic!() };
        assert!(places.len() > MOST_BESIDE);
        // Where the declared bounds do not hold it says nothing.
        let mut sure = robot.clone();
        (sure.whiskers[0].noise.moment_relative, sure.whiskers[0].noise.moment_absolute) = (1e-4, 1e-8);
        assert!(matches!(ask(&map, &sure, &log, Some(truth)), Opinion::None));
    }
}
