//! Odometry calibration \[censi2013simultaneous\]: three relative errors of all increments, their prior, and the corrected path.

use crate::plane::Pose2;
use crate::world::Odometry;

/// Ways in which odometry goes wrong: too long, aside, turned too far.
pub(super) const CALIBRATION_SIZE: usize = 3;

/// By which share of its increments the odometry is too short, goes aside (rad) and turns too little: what it has to be corrected by.
pub(super) type OdometryCalibration = [f64; CALIBRATION_SIZE];

/// Standard deviations of the errors that all readings share, before any of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CalibrationPrior {
    /// Of a relative error of the readings.
    pub(super) gain: f64,
    /// Of the odometry's calibration parameters; an error that is not looked for has none.
    pub(super) odometry: OdometryCalibration,
}

impl CalibrationPrior {
    /// With the declared bounds of the odometry; where one is declared right and another is not it is looked for within a hair.
    pub(super) fn new(gain: f64, bounds: &Odometry) -> Self {
        let own = prior_stds(bounds);
        let least = if own.iter().any(|&std| std > 0.0) { LEAST } else { 0.0 };
        Self { gain, odometry: own.map(|std| std.max(least)) }
    }

    /// Whether errors of the odometry are looked for.
    pub(super) fn has_odometry(&self) -> bool {
        self.odometry.iter().any(|&std| std > 0.0)
    }
}

/// One step of the odometry, corrected by these calibration parameters: so much longer, aside (rad) and turned so much further.
pub(crate) fn calibrated(step: Pose2, [long, aside, turn]: OdometryCalibration) -> Pose2 {
    let place = (step.position() * (1.0 + long)).rotated(aside);
    Pose2 { x: place.x, y: place.y, theta: (1.0 + turn) * step.theta }
}

/// The standard deviation of a share that is not looked for beside others that are: a micrometre in a metre.
const LEAST: f64 = 1e-6;

/// The largest that each share can be.
fn largest(bounds: &Odometry) -> OdometryCalibration {
    [bounds.translation_relative, bounds.translation_relative, bounds.rotation_relative]
        .map(|most| most.max(5.0 * LEAST))
}

/// These calibration parameters, no larger than errors within the bounds can be.
pub(super) fn within(calibration: OdometryCalibration, bounds: &Odometry) -> OdometryCalibration {
    let most = largest(bounds);
    [0, 1, 2].map(|way| calibration[way].clamp(-most[way], most[way]))
}

/// Whether errors within the bounds can be these calibration parameters.
pub(super) fn is_within(calibration: OdometryCalibration, bounds: &Odometry) -> bool {
    calibration.iter().zip(largest(bounds)).all(|(share, most)| share.abs() <= most)
}

/// Standard deviations of the three shares: errors spread evenly over a disc, and between two bounds.
pub(super) fn prior_stds(bounds: &Odometry) -> OdometryCalibration {
    let place = 0.5 * bounds.translation_relative;
    [place, place, bounds.rotation_relative / SQRT_3]
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_declared_right_beside_what_is_not_is_looked_for_within_a_hair() {
        let shared = |place: f64, turn: f64| {
            CalibrationPrior::new(
                0.0,
                &Odometry { translation_relative: place, rotation_relative: turn, ..Odometry::default() },
            )
        };
        assert!(!shared(0.0, 0.0).has_odometry());
        for (one, loose) in [(shared(0.01, 0.0), 0), (shared(0.0, 0.02), 2)] {
            assert!(one.has_odometry() && one.odometry[loose] > 4e-3);
            assert!((one.odometry[2 - loose] - LEAST).abs() < 1e-12);
        }
    }

    #[test]
    fn shares_are_cut_to_what_the_bounds_allow() {
        let bounds = Odometry { translation_relative: 0.01, rotation_relative: 0.02, ..Odometry::default() };
        for (calibration, cut) in
            [([0.01, -0.01, -0.02], [0.01, -0.01, -0.02]), ([-0.011, 0.0, 0.03], [-0.01, 0.0, 0.02])]
        {
            let ours = within(calibration, &bounds);
            assert!(ours.iter().zip(cut).all(|(ours, cut)| (ours - cut).abs() < 1e-15) && is_within(ours, &bounds));
        }
        assert!(!is_within([0.0, 0.011, 0.0], &bounds) && !is_within([0.0, 0.0, f64::NAN], &bounds));
    }

    #[test]
    fn a_corrected_step_is_longer_aside_and_turned_further() {
        let step = calibrated(Pose2::new(0.02, 0.0, 0.1), [0.01, 0.02, -0.03]);
        assert!((step.position().norm() - 0.0202).abs() < 1e-12 && (step.position().angle() - 0.02).abs() < 1e-12);
        assert!((step.theta - 0.097).abs() < 1e-12);
    }
}
