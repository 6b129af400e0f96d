//! The last door: the only place that decides which places are told and what the verdict is.
//!
//! Every method hands over its evidence; all thresholds of the verdict stand here.

mod answer;

use crate::math;
pub use answer::{
    ConsistencyReport, Estimate, Event, Hypothesis, Localization, Nuisance, NuisanceQuantity, OdometryEstimate, Remedy,
    ShapeRecord, StampedPose, Status, StepRecord, Stretch,
};

use super::state_set::possibilistic;
use super::state_set::probabilistic::{self, Fit};
use super::state_set::{Candidate, StateSet, components};
use crate::config::DeterministicOptions;
use crate::plane::{Pose2, wrap_angle};
use crate::sets::{Interval, StateBox};

/// A single place larger than this (m, rad) is not called localized: what it holds does not agree on where it is.
const LARGEST_PLACE: f64 = 0.02;
const LARGEST_TURN: f64 = 0.35;
/// Candidates less likely than the best by this factor stay in the state set, but nobody would bet on them.
const LEAST_LIKELIHOOD: f64 = 1e-2;
/// Places with less weight are told, but do not make a verdict ambiguous,
const LEAST_RIVAL: f64 = 0.02;
/// unless no more of the readings than this break their bounds there, beyond the share that does at the best place: bounds
/// say nothing about which of two places that obey them is the more likely.
const OBEYED: f64 = 0.02;
/// Rows of contact that a set has to explain anew before it is believed again, once no state was left.
pub(crate) const RECOVERED: usize = 150;
/// Share of readings beyond 2.5 standard deviations that single false readings explain, on top of the tolerated share.
const FALSE_SHARE: f64 = 0.1;
/// The largest mean square of residuals, in units of what even errors give, of errors that obey their bounds: 3 where all are at the ends;
const MOST_SQUARE_WITHIN: f64 = 3.3;
/// and of errors that are taken for independent, in about standard deviations of that mean.
const MOST_SQUARE: f64 = 3.5;
/// The mean square of block means of independent errors, in standard deviations of that mean, and fewest blocks that speak about it.
const MOST_DRIFT: f64 = 4.0;
const FEWEST_BLOCKS: usize = 6;
/// A nuisance parameter this many times beyond its bound is a contradiction: bounds are told in round numbers.
const MOST_OF_BOUND: f64 = 2.0;
/// Half the side of the box around the region that holds 95 % of a Gaussian in three dimensions (standard deviations).
const HALF_BOX: f64 = 2.795;

/// What a method knows when a verdict is passed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Evidence<'a> {
    /// Whether a whisker has touched.
    pub(crate) touched: bool,
    /// Whether at some row no state explained the readings any more.
    pub(crate) emptied: bool,
    /// Rows of contact that the set explains which was started after that.
    pub(crate) explained_since: usize,
    /// The places, heaviest first.
    pub(crate) places: &'a [Hypothesis],
    /// What is known about readings that break their declared bounds.
    pub(crate) broken: Broken<'a>,
    /// How well the best place fits the readings, where the method has statistics of that.
    pub(crate) fit: Option<&'a Fit>,
    /// Share of the rows that no equilibrium needs to explain.
    pub(crate) tolerated_share: f64,
}

/// The shares of readings that break their declared bounds at the places.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum Broken<'a> {
    /// The method rules out places where bounds are broken: no weight makes one place more likely than another.
    #[default]
    Nowhere,
    /// Not known: weights alone decide.
    Unknown,
    /// The share at each place.
    Shares(&'a [f64]),
}

/// A verdict, and what is to be told with it.
pub(crate) struct Verdict {
    pub(crate) status: Status,
    /// Kind and detail of the event that explains the verdict.
    pub(crate) reason: Option<(&'static str, String)>,
}

/// The verdict on a log.
#[must_use]
pub(crate) fn verdict(evidence: &Evidence<'_>) -> Verdict {
    let plain = |status| Verdict { status, reason: None };
    let Evidence { touched, emptied, places, .. } = *evidence;
    if !touched {
        return plain(Status::NoContact);
    }
    let Some(first) = places.first() else {
        return plain(if emptied { Status::Inconsistent } else { Status::Ambiguous });
    };
    if let Some(detail) = evidence.fit.and_then(|fit| contradiction(fit, evidence.tolerated_share)) {
        return Verdict { status: Status::Inconsistent, reason: Some(("inconsistent", detail)) };
    }
    let rivals = rivals(evidence);
    // A set that died once has to explain much before it is believed again; whether it is one place counts where nothing else speaks
    // against the readings.
    let judged = evidence.fit.is_some();
    if emptied && !((rivals == 1 || judged) && evidence.explained_since >= RECOVERED) {
        return plain(Status::Inconsistent);
    }
    // A place that leaves as much unexplained as side contact may can be wrong: it is told, but not believed alone.
    if let Some(detail) = evidence.fit.and_then(|fit| contradiction(fit, 0.0)) {
        let detail = format!("told all the same, since side contact, a snap or slip on the way may be why: {detail}");
        return Verdict { status: Status::Ambiguous, reason: Some(("tolerated", detail)) };
    }
    if evidence.fit.is_some_and(|fit| fit.is_disputed) {
        let detail = "a likelier place than those that explain the readings leaves many of them unexplained; more contacts will tell";
        return Verdict { status: Status::Ambiguous, reason: Some(("disputed", detail.to_owned())) };
    }
    plain(if rivals == 1 && is_small(&first.extent) { Status::Localized } else { Status::Ambiguous })
}

/// Whether a place is small enough to be called known.
fn is_small(extent: &StateBox) -> bool {
    math::hypot(extent.x.width(), extent.y.width()) <= LARGEST_PLACE && extent.theta.width() <= LARGEST_TURN
}

/// How many places may be the true one, the best among them.
fn rivals(evidence: &Evidence<'_>) -> usize {
    let obeys = |index: usize| match evidence.broken {
        Broken::Nowhere => true,
        Broken::Unknown => false,
        Broken::Shares(shares) => shares[index] <= shares[0] + OBEYED,
    };
    let may = |&(index, place): &(usize, &Hypothesis)| place.weight >= LEAST_RIVAL || obeys(index);
    evidence.places.iter().enumerate().filter(may).count()
}

/// Why the readings contradict the best place, if they do even when this share of them is tolerated.
fn contradiction(fit: &Fit, tolerated_share: f64) -> Option<String> {
    if fit.beyond > FALSE_SHARE + tolerated_share {
        return Some(beyond(fit.beyond));
    }
    if fit.of_bound > MOST_OF_BOUND {
        return Some(out_of_bound(fit.of_bound));
    }
    if fit.square > most_statistic(fit) {
        return Some(scattered(fit.square));
    }
    let most = 1.0 + MOST_DRIFT * (2.0 / fit.blocks.max(1) as f64).sqrt();
    (fit.independent && fit.blocks >= FEWEST_BLOCKS && fit.drift > most).then(|| strays(fit.drift))
}

/// The largest mean normalised residual squared that is no contradiction.
pub(crate) fn most_statistic(fit: &Fit) -> f64 {
    most_square(fit, 1)
}

/// The same of one of so many stretches of the readings.
pub(crate) fn most_of_stretch(fit: &Fit, stretches: usize) -> f64 {
    most_square(fit, stretches)
}

fn most_square(fit: &Fit, stretches: usize) -> f64 {
    if fit.independent {
        let readings = (fit.touching / stretches.max(1)).max(1);
        1.0 + MOST_SQUARE / f64::from(readings as u32).sqrt()
    } else {
        MOST_SQUARE_WITHIN
    }
}

fn strays(drift: f64) -> String {
    format!(
        "the readings stray from the best place for many rows on end ({:.1} times what independent noise does); is it the right map, and is \
         the whisker's stiffness right? `--noise-model correlated` takes errors that stay alike",
        drift.sqrt()
    )
}

fn out_of_bound(times: f64) -> String {
    format!(
        "to explain the readings, the gain or another quantity that is estimated along would have to be off by {times:.1} times its bound; \
         are the whisker's length, stiffness and calibration right?"
    )
}

fn beyond(share: f64) -> String {
    format!(
        "{:.0} % of the readings lie beyond their declared noise even at the best place; is it the right map, and \
         does the whisker touch with its tip?",
        100.0 * share
    )
}

fn scattered(square: f64) -> String {
    format!(
        "the readings scatter {:.2} times as far from the best place as their declared noise does; is it the right map, \
         and are the noise bounds right?",
        square.sqrt()
    )
}

/// One hypothesis for each separate place that is worth a bet, at the odometry's `odom_from_robot`, the heaviest first.
///
/// A candidate's likelihood is that of its misfit, if the tolerance is as many standard deviations as it says and a
/// missed observation was missed by a whole tolerance. Candidates within a factor of 100 of the best are grouped into
/// separate places; each place stands for its best candidate, and is as wide as its group with the `tolerance` standard
/// deviations of each.
#[must_use]
pub fn choose(states: &StateSet, odom_from_robot: Pose2, options: &DeterministicOptions) -> Vec<Hypothesis> {
    let Some(best) = states.best() else { return Vec::new() };
    let independent = (options.update_travel / options.history_travel).min(1.0);
    let half_chi = 0.5 * options.tolerance * options.tolerance * independent;
    let likelihood = |c: &Candidate| math::exp(-half_chi * (c.rank() - best.rank()));
    let likely: Vec<Candidate> =
        states.candidates().iter().filter(|c| likelihood(c) >= LEAST_LIKELIHOOD).copied().collect();
    let mut hypotheses: Vec<Hypothesis> = components(&likely, odom_from_robot)
        .iter()
        .map(|place| {
            let chosen = &likely[place.members[0]];
            let pose = chosen.map_from_odom.compose(odom_from_robot);
            let own = |&i: &usize| likely[i].extent(odom_from_robot, options.tolerance);
            let extent = place.members.iter().map(own).fold(StateBox::EMPTY, |all, one| all.hull(&one));
            Hypothesis { pose, weight: likelihood(chosen), extent, covariance: None, ridge: Vec::new() }
        })
        .collect();
    let total: f64 = hypotheses.iter().map(|h| h.weight).sum();
    hypotheses.iter_mut().for_each(|h| h.weight /= total);
    hypotheses.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    hypotheses
}

/// The place of the possibilistic method as a hypothesis, its headings brought near those of its pose.
#[must_use]
pub(crate) fn enclosed(place: &possibilistic::EnclosedPlace) -> Hypothesis {
    let theta = place.extent.theta;
    let middle = 0.5 * (theta.lo() + theta.hi());
    let turn = middle - wrap_angle(middle);
    let extent = StateBox { theta: Interval::new(theta.lo() - turn, theta.hi() - turn), ..place.extent };
    Hypothesis { pose: place.pose, weight: place.share, extent, covariance: None, ridge: Vec::new() }
}

/// The place of the probabilistic method as a hypothesis, as wide as the boxes around all its members.
#[must_use]
pub(crate) fn fitted(place: &probabilistic::PosteriorPlace) -> Hypothesis {
    let boxes = place.members.iter().map(|(pose, covariance)| box_95(*pose, covariance));
    Hypothesis {
        pose: place.members[0].0,
        weight: place.weight,
        extent: boxes.fold(StateBox::EMPTY, |all, one| all.hull(&one)),
        covariance: Some(place.covariance),
        ridge: place.ridge.clone(),
    }
}

/// The box around the region that holds the state with 95 %.
#[must_use]
pub(crate) fn box_95(pose: Pose2, covariance: &[[f64; 3]; 3]) -> StateBox {
    let around = |value: f64, i: usize| {
        let half = HALF_BOX * covariance[i][i].max(0.0).sqrt();
        Interval::new(value - half, value + half)
    };
    StateBox { x: around(pose.x, 0), y: around(pose.y, 1), theta: around(pose.theta, 2) }
}

#[cfg(test)]
mod tests {
    use super::{Evidence, Fit, Hypothesis, Pose2, Status, box_95, verdict};

    /// The status of a log with one small place that the readings fit.
    fn status(is_disputed: bool) -> (Status, Option<&'static str>) {
        let pose = Pose2::new(0.1, 0.2, 0.3);
        let covariance = [[1e-8, 0.0, 0.0], [0.0, 1e-8, 0.0], [0.0, 0.0, 1e-6]];
        let extent = box_95(pose, &covariance);
        let places = [Hypothesis { pose, weight: 1.0, extent, covariance: Some(covariance), ridge: Vec::new() }];
        let fit = Fit { is_disputed, touching: 100, ..Fit::default() };
        let told = verdict(&Evidence { touched: true, places: &places, fit: Some(&fit), ..Evidence::default() });
        (told.status, told.reason.map(|(kind, _)| kind))
    }

    #[test]
    fn a_small_place_is_localized_unless_a_likelier_one_disputes_it() {
        assert_eq!(status(false), (Status::Localized, None));
        assert_eq!(status(true), (Status::Ambiguous, Some("disputed")));
    }
}
