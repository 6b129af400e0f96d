//! The probabilistic method's hypotheses: Gaussians around single places, each refined by all readings so far.

mod bank;
mod feeler;
mod fit;
mod history;
mod hypothesis;
mod images;
mod information;
mod joint;
mod now;
mod odometry_calibration;
mod places;
mod rerun;
mod ridge;
mod seed;
mod seeds;
mod set;
mod shake;
mod shares;
mod slide;
mod spread;
mod symmetry;
mod twins;
mod way;

pub use crate::contact::Sense;
pub use fit::Fit;
pub use places::Place;
pub use set::{Happened, ProbabilisticSet};
pub(crate) use shares::corrected;

use crate::beam::TipModel;
use crate::contact::Boundaries;
use crate::contact::follow::{ForwardModel, Mechanics, WhiskerState};
use crate::plane::Pose2;
use crate::world::Map;

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
    let boundaries = Boundaries::new(map).with_clearance(map);
    let length = tip.whisker().length;
    let mechanics = if tip.is_uniform() { Mechanics::ClosedForm } else { Mechanics::Model(tip) };
    let forward = ForwardModel { map, boundaries: &boundaries, length, mechanics, whole: true, sense: Sense::Moment };
    let scale = tip.rigidity() / length;
    let mut state = WhiskerState::Free;
    let mut last = path.first().copied().unwrap_or_default();
    let mut predict = |&pose: &Pose2| {
        let felt = forward.advance(&mut state, last, pose, false);
        last = pose;
        let pressed = matches!(state, WhiskerState::Touching(touch) if touch.q > 0.0);
        let moment = if pressed { felt.value * scale } else { 0.0 };
        PredictedMoment { moment, gradient: felt.gradient.map(|g| g * scale), touching: pressed }
    };
    path.iter().map(&mut predict).collect()
}
