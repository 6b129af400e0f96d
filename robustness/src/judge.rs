//! What becomes of one trial.

use crate::cells::Trial;
use crate::region::{CHI2_95, distance};
use crate::ridge::off_ridge;
use vibrissa::flow::pose::{Hypothesis, Localization, Status};
use vibrissa::plane::{Pose2, wrap_angle};
use vibrissa::{Method, localize};

/// From here on a place is not right (m), and from here on it is another place.
const OFF: f64 = 5e-3;
const WRONG: f64 = 0.05;
/// A truth this near to a ridge is on it: m, rad.
const ON_RIDGE: (f64, f64) = (1e-3, 0.02);
/// A truth this near to a place counts as being among places without a region (m).
const AMONG: f64 = 5e-3;

/// The verdict against the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Localized, nearer than 5 mm.
    Right,
    /// Localized, 5 mm or more off.
    Off,
    /// Localized, more than 5 cm off.
    Wrong,
    /// Ambiguous, the truth among its places, or all places possible.
    AmbiguousWith,
    /// Ambiguous without the truth.
    AmbiguousWithout,
    /// Inconsistent, no contact, or refused.
    Inconsistent,
}

/// One trial.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Judged {
    pub(crate) outcome: Outcome,
    /// Whether the truth is in what the method tells as possible: a 95 % region or a ridge, or the set.
    pub(crate) held: bool,
    /// Squared Mahalanobis distance of the truth to the nearest place.
    pub(crate) distance: f64,
    /// Error of the estimate (m, rad) where the verdict is `localized`.
    pub(crate) error: Option<(f64, f64)>,
    /// What the method says of it (m).
    pub(crate) bound: Option<f64>,
    /// Whether the place is open along a curve.
    pub(crate) ridge: bool,
    /// The Cramer-Rao bound of the position (m), where there is one.
    pub(crate) least: Option<f64>,
}

/// Localizes and compares.
pub(crate) fn judged(trial: &Trial, method: &Method, least: Option<f64>, told: &str) -> Judged {
    match localize(&trial.log, &trial.map, &trial.robot, method, &mut |_| {}) {
        Ok(answer) => compared(&answer, trial.truth, least),
        Err(error) => {
            eprintln!("{told}: {error}");
            Judged {
                outcome: Outcome::Inconsistent,
                held: false,
                distance: f64::INFINITY,
                error: None,
                bound: None,
                ridge: false,
                least,
            }
        }
    }
}

fn compared(answer: &Localization, truth: Option<Pose2>, least: Option<f64>) -> Judged {
    let off = |h: &Hypothesis| truth.map_or(f64::INFINITY, |truth| h.pose.position().distance(truth.position()));
    let anywhere = answer.status == Status::Ambiguous && answer.hypotheses.is_empty();
    let held = truth.is_some_and(|truth| anywhere || holds(answer, truth));
    let best = answer.hypotheses.first().filter(|_| answer.status == Status::Localized);
    let outcome = match (answer.status, best) {
        (Status::Localized, Some(best)) if off(best) > WRONG => Outcome::Wrong,
        (Status::Localized, Some(best)) if off(best) >= OFF => Outcome::Off,
        (Status::Localized, Some(_)) => Outcome::Right,
        (Status::Ambiguous, _) if held || answer.hypotheses.iter().any(|h| off(h) < AMONG) => Outcome::AmbiguousWith,
        (Status::Ambiguous, _) => Outcome::AmbiguousWithout,
        _ => Outcome::Inconsistent,
    };
    let error = best.zip(truth).map(|(h, truth)| (off(h), wrap_angle(h.pose.theta - truth.theta).abs()));
    let ridge = best.is_some_and(|h| !h.ridge.is_empty());
    Judged { outcome, held, distance: nearest(answer, truth), error, bound: best.map(told_error), ridge, least }
}

/// What the method says of the error of a place (m): that to be expected, or the largest that its extent allows.
fn told_error(h: &Hypothesis) -> f64 {
    h.bound().map_or_else(
        || {
            let reach = |lo: f64, hi: f64, at: f64| (hi - at).max(at - lo);
            let (x, y) = (h.extent.x, h.extent.y);
            reach(x.lo(), x.hi(), h.pose.x).hypot(reach(y.lo(), y.hi(), h.pose.y))
        },
        |bound| bound.0,
    )
}

/// The least squared Mahalanobis distance of the truth to a place that has a covariance.
fn nearest(answer: &Localization, truth: Option<Pose2>) -> f64 {
    let to =
        |h: &Hypothesis| truth.filter(|_| h.covariance.is_some()).map_or(f64::INFINITY, |truth| distance(h, truth));
    answer.hypotheses.iter().map(to).fold(f64::INFINITY, f64::min)
}

/// Whether a region, a ridge or the set holds the truth.
fn holds(answer: &Localization, truth: Pose2) -> bool {
    if answer.status == Status::Inconsistent {
        return false;
    }
    if answer.encloses {
        return answer.states.iter().any(|b| {
            let middle = 0.5 * (b.theta.lo() + b.theta.hi());
            let theta = middle + wrap_angle(truth.theta - middle);
            b.x.contains(truth.x) && b.y.contains(truth.y) && b.theta.contains(theta)
        });
    }
    let near = |h: &Hypothesis| off_ridge(&h.ridge, truth).is_some_and(|off| off.0 < ON_RIDGE.0 && off.1 < ON_RIDGE.1);
    let inside = |h: &Hypothesis| match h.covariance {
        Some(_) => distance(h, truth) <= CHI2_95,
        // The deterministic method tells extents only.
        None => h.extent.x.contains(truth.x) && h.extent.y.contains(truth.y),
    };
    answer.hypotheses.iter().any(|h| inside(h) || near(h))
}
