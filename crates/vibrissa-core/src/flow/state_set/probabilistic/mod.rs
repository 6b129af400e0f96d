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
mod nuisance_smoother;
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
pub(crate) use consistency::STRETCHES;
pub use nuisance_smoother::{Fit, NuisanceSmoother};
pub use places::PosteriorPlace;
pub use smoother::{ProbabilisticSet, StepOutcome};

use crate::beam::TipModel;
use crate::contact::Boundaries;
use crate::contact::follow::{ElasticBase, ForwardModel, Mechanics, WhiskerState};
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
    let quantity = SensedQuantity::Moment;
    let base = ElasticBase::of(tip, quantity);
    let is_uniform = tip.is_uniform() || base.is_some();
    let mechanics = if is_uniform { Mechanics::ClosedForm } else { Mechanics::Model(tip) };
    let forward = ForwardModel { map, boundaries: &boundaries, length, mechanics, whole: true, quantity, base };
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

/// The modes of one robot on one map, by whatever smoother.
pub trait ModeSet: Send {
    /// Takes in one row: its time (s), the robot in the odometry frame, one reading for each sense (N m, N, rad), and the absolute
    /// heading (map frame, rad) where there is one.
    fn step(&mut self, t: f64, odom_from_robot: Pose2, readings: &[f64], heading: Option<f64>) -> StepOutcome;

    /// How many modes there are.
    fn count(&self) -> usize;

    /// How many rows are kept: as many as the window, and a few.
    fn rows_kept(&self) -> usize;

    /// The odometry frame in the map frame by the best mode of the set that was last given up.
    fn abandoned(&self) -> Option<Pose2>;

    /// The robot's pose by each mode, with the odometry at `odom_from_robot`.
    fn states(&self, odom_from_robot: Pose2) -> Vec<Pose2>;

    /// Area of the modes' projection onto the plane (m²) and their volume (m² rad): ellipses that hold 95 %.
    fn size(&self) -> (f64, f64);

    /// The places by the modes as they are linearised now, at the last row.
    fn places(&self) -> Vec<PosteriorPlace>;

    /// Ends the log: every mode moved to its least cost over all rows that are kept, weighed and grouped.
    fn finish(&mut self) -> (Vec<PosteriorPlace>, Option<Agreement>);
}

/// How well the best mode explains the readings: errors of which are independent, or may stay alike.
#[derive(Clone, Debug, PartialEq)]
pub enum Agreement {
    /// Independent.
    Independent(Consistency),
    /// Alike for a while.
    Correlated(Fit),
}

impl Agreement {
    /// Readings with a whisker held by a boundary.
    #[must_use]
    pub fn touching(&self) -> usize {
        match self {
            Self::Independent(fit) => fit.touching,
            Self::Correlated(fit) => fit.touching,
        }
    }
}

impl ModeSet for ProbabilisticSet<'_> {
    fn step(&mut self, _: f64, odom_from_robot: Pose2, readings: &[f64], heading: Option<f64>) -> StepOutcome {
        self.step(odom_from_robot, readings, heading)
    }

    fn count(&self) -> usize {
        self.len()
    }

    fn rows_kept(&self) -> usize {
        self.rows_kept()
    }

    fn abandoned(&self) -> Option<Pose2> {
        self.abandoned()
    }

    fn states(&self, odom_from_robot: Pose2) -> Vec<Pose2> {
        self.states(odom_from_robot)
    }

    fn size(&self) -> (f64, f64) {
        self.size()
    }

    fn places(&self) -> Vec<PosteriorPlace> {
        self.places()
    }

    fn finish(&mut self) -> (Vec<PosteriorPlace>, Option<Agreement>) {
        let (places, fit) = self.finish();
        (places, fit.map(Agreement::Independent))
    }
}
