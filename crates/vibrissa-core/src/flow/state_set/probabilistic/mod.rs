//! Multi-hypothesis fixed-lag smoother \[reid1979algorithm, sibley2010sliding\].
//!
//! Each hypothesis is a Gaussian around one place, refined by Gauss-Newton steps over a window of rows; older rows are
//! marginalised \[dellaert2017factor\]. The unknowns are the pose of the odometry frame, a calibration of the odometry and a gain.

mod bank;
mod calibrated_path;
mod calibration_search;
mod congruent_places;
mod consistency;
mod grid_search;
mod hypothesis;
mod importance_sampling;
mod information;
mod line_search;
mod log_window;
mod map_symmetry;
mod multistart;
mod odometry_calibration;
mod odometry_path;
mod packed_hypothesis;
mod places;
mod relinearisation;
mod running_estimate;
mod sensor;
mod shared_runs;
mod smoother;
mod unobservable;

pub use crate::contact::SensedQuantity;
pub(crate) use calibrated_path::calibrated;
pub use consistency::Consistency;
pub use places::PosteriorPlace;
pub use smoother::{ProbabilisticSet, StepOutcome};

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
    let forward =
        ForwardModel { map, boundaries: &boundaries, length, mechanics, whole: true, quantity: SensedQuantity::Moment };
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
