//! Multi-hypothesis smoother over pose and nuisance parameters \[reid1979algorithm, sibley2010sliding, dellaert2017factor\]: modes of the
//! posterior, each a least-squares fit of all rows of a window; older rows are marginalised.
//!
//! The unknowns are the robot's pose and the nuisance parameters that the robot declares: errors of odometry, mounts, lengths, gains,
//! zeros, delay and map. Errors of the readings may stay alike for a while. Modes come from a grid over the first contact, are
//! refitted as the window grows, and are weighed by importance sampling at the end.

mod adaptive_sampling;
mod admission;
mod bank;
mod contact_episodes;
mod corrected_path;
mod correlated_noise;
mod error_filter;
mod goodness_of_fit;
mod grid_search;
mod importance_sampling;
mod information;
mod log_window;
mod map_symmetry;
mod measurement;
mod normal_equations;
mod odometry_drift;
mod optimisation;
mod places;
mod scene;
mod sensor;
mod shared_runs;
mod smoother;
mod state;
mod unknowns;
mod unobservable;
mod wall_error;

pub use crate::contact::SensedQuantity;
pub(crate) use corrected_path::calibrated;
pub use goodness_of_fit::Fit;
pub(crate) use goodness_of_fit::STRETCHES;
pub use places::PosteriorPlace;
pub use smoother::{MultiHypothesisSmoother, StepOutcome};

use crate::beam::TipModel;
use crate::contact::Boundaries;
use crate::contact::follow::{ElasticBase, ForwardModel, Mechanics, WhiskerState};
use crate::plane::Pose2;
use crate::world::{Map, MomentNoise};

/// So many readings in a row that contradict are of another branch of equilibria; fewer may be false ones.
const CONTRADICTIONS: usize = 2;

/// What a whisker feels at one pose of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedMoment {
    /// Moment at the base (N m); 0 where the whisker is free.
    pub moment: f64,
    /// Derivatives by the base's x and y (N, map frame) and by its heading (N m/rad).
    pub gradient: [f64; 3],
    /// Whether a boundary holds the whisker.
    pub touching: bool,
}

/// The moments along a path of base poses `map_from_whisker`, the first of which is free of contact.
///
/// Contact of the tip, and of uniform whiskers of the side or of both at once, without friction; the branch of solutions
/// is followed from pose to pose, so these must be no further apart than a few millimetres.
#[must_use]
pub fn predicted_moments(map: &Map, tip: &TipModel, path: &[Pose2]) -> Vec<PredictedMoment> {
    followed(map, tip, path, None)
}

/// The same where readings (N m), one for each pose from the first on, tell on which branch of equilibria a whisker is that two in a row contradict;
/// they hold within this bound. Poses beyond the last reading are followed without.
#[must_use]
pub fn predicted_moments_by_readings(
    map: &Map,
    tip: &TipModel,
    path: &[Pose2],
    readings: &[f64],
    bound: MomentNoise,
) -> Vec<PredictedMoment> {
    followed(map, tip, path, Some((readings, bound)))
}

fn followed(
    map: &Map,
    tip: &TipModel,
    path: &[Pose2],
    readings: Option<(&[f64], MomentNoise)>,
) -> Vec<PredictedMoment> {
    let boundaries = Boundaries::new(map).with_clearance(map);
    let length = tip.whisker().length;
    let quantity = SensedQuantity::Moment;
    let base = ElasticBase::of(tip, quantity);
    let is_uniform = tip.is_uniform() || base.is_some();
    let mechanics = if is_uniform { Mechanics::ClosedForm } else { Mechanics::Model(tip) };
    let forward = ForwardModel { map, boundaries: &boundaries, length, mechanics, whole: true, quantity, base };
    let scale = tip.rigidity() / length;
    let mut state = WhiskerState::Free;
    let mut last = path.first().copied().unwrap_or_default();
    let mut lost = 0;
    let mut predict = |(row, &pose): (usize, &Pose2)| {
        let mut felt = forward.advance(&mut state, last, pose, false);
        last = pose;
        let is_pressed = |state: &WhiskerState| matches!(state, WhiskerState::Touching(touch) if touch.q > 0.0);
        if let Some((&z, noise)) = readings.and_then(|(readings, noise)| Some((readings.get(row)?, noise))) {
            let bound = noise.moment_relative * z.abs() + noise.moment_absolute;
            let off = |value: f64| (value * scale - z).abs() / bound;
            let is_off = off(if is_pressed(&state) { felt.value } else { 0.0 }) > 1.0;
            lost = if is_off { lost + 1 } else { 0 };
            if lost >= CONTRADICTIONS
                && let Some(found) = forward.equilibrium_that_reads(pose, z / scale, &off, 1.0)
            {
                ((state, felt), lost) = (found, 0);
            }
        }
        let pressed = is_pressed(&state);
        let moment = if pressed { felt.value * scale } else { 0.0 };
        PredictedMoment { moment, gradient: felt.gradient.map(|g| g * scale), touching: pressed }
    };
    path.iter().enumerate().map(&mut predict).collect()
}
