//! A path by odometry, and how errors of the odometry move its end.

use super::calibrated_path::{CALIBRATION_SIZE, OdometryCalibration};
use crate::linear_algebra::dot;
use crate::plane::{Pose2, Vec2};

/// A path by odometry, as far as its errors depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct OdometryPath {
    /// From its first row (odometry frame, m), the turn since then (rad), and where turning too far by its own amount would have taken
    /// it (m).
    reach: Vec2,
    turned: f64,
    swept: Vec2,
}

impl OdometryPath {
    /// The robot's way along these odometry poses.
    pub(super) fn along(poses: &[Pose2]) -> Self {
        let mut way = Self::default();
        poses.windows(2).for_each(|pair| way.travel(pair[0], pair[1]));
        way
    }

    /// Goes on from one odometry pose to the next.
    pub(super) fn travel(&mut self, from: Pose2, to: Pose2) {
        let step = to.position() - from.position();
        let turn = from.between(to).theta;
        self.swept += step.perp() * (self.turned + 0.5 * turn);
        self.reach += step;
        self.turned += turn;
    }

    /// How far a change of the calibration moves one end of the way against the other (m, rad).
    pub(super) fn moves(&self, by: OdometryCalibration) -> [f64; 2] {
        let errors = self.errors(0.0);
        let sum = |i: usize| (0..CALIBRATION_SIZE).map(|way| errors[way][i] * by[way]).sum::<f64>();
        [sum(0).hypot(sum(1)), sum(2).abs()]
    }

    /// The error of the robot's pose (x, y, heading; map frame), for a unit of each way, in a frame turned by `theta`.
    pub(super) fn errors(&self, theta: f64) -> [[f64; 3]; CALIBRATION_SIZE] {
        let (along, swept) = (self.reach.rotated(theta), self.swept.rotated(theta));
        [[along.x, along.y, 0.0], [-along.y, along.x, 0.0], [swept.x, swept.y, self.turned]]
    }

    /// How the frame moves for a unit of each way if the robot stays where it is now; it is `arm` from the pivot.
    pub(super) fn holding(&self, theta: f64, arm: Vec2) -> [[f64; 3]; CALIBRATION_SIZE] {
        let turned = arm.perp();
        self.errors(theta).map(|e| [e[2] * turned.x - e[0], e[2] * turned.y - e[1], -e[2]])
    }

    /// The derivatives of a reading by the calibration, where those by the whisker base's pose are `at_base`; the base is `arm`
    /// from the robot, map frame.
    pub(super) fn slopes(&self, theta: f64, arm: Vec2, at_base: [f64; 3]) -> [f64; CALIBRATION_SIZE] {
        let turned = arm.perp();
        self.errors(theta).map(|e| dot(at_base, [e[0] + e[2] * turned.x, e[1] + e[2] * turned.y, e[2]]))
    }

    /// What is left of it after its first part.
    pub(super) fn after(&self, first: &Self) -> Self {
        let reach = self.reach - first.reach;
        let swept = self.swept - first.swept - reach.perp() * first.turned;
        Self { reach, swept, turned: self.turned - first.turned }
    }
}
