//! What errors of the odometry do to an estimate that takes it as given.
//!
//! Each increment may be off by a share of itself. The worst that does not average out is one share for all: the path
//! stretched, sheared aside or turned too far. A readings' fit that does not know of it ends somewhere else; how far, per
//! unit of the share, follows from the normal equations, and its square adds to the covariance.

use super::normal::{Matrix, Normal, dot, inverse, times};
use crate::plane::{Pose2, Vec2};
use crate::world::Odometry;

/// Ways in which odometry goes wrong: too long, aside, turned too far.
const WAYS: usize = 3;

/// The path so far, and what its errors do to the readings' normal equations.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Drift {
    /// Way from the first row (odometry frame, m), turn since then (rad), and where turning too far by its own amount
    /// would have taken it (m).
    reach: Vec2,
    turned: f64,
    swept: Vec2,
    /// For each way: the mixed part of the normal equations, with moves and with a shared relative error.
    mixed: [[f64; 3]; WAYS],
    by_shared: [f64; WAYS],
    /// The weighted squares of what they do to the readings.
    squares: [f64; WAYS],
}

impl Drift {
    /// Goes on from one odometry pose to the next.
    pub(super) fn travel(&mut self, from: Pose2, to: Pose2) {
        let step = to.position() - from.position();
        self.swept += step.perp() * (self.turned + 0.5 * from.between(to).theta);
        self.reach += step;
        self.turned += from.between(to).theta;
    }

    /// The error of the robot's pose (x, y, heading; map frame), for a unit of each way, in a frame turned by `theta`.
    fn errors(&self, theta: f64) -> [[f64; 3]; WAYS] {
        let (along, swept) = (self.reach.rotated(theta), self.swept.rotated(theta));
        [[along.x, along.y, 0.0], [-along.y, along.x, 0.0], [swept.x, swept.y, self.turned]]
    }

    /// Adds a reading with its derivatives by the whisker base's pose (`at_base`; the base is `arm` from the robot, map
    /// frame), by a move, and by a shared relative error.
    pub(super) fn add(&mut self, theta: f64, arm: Vec2, at_base: [f64; 3], by: [f64; 3], by_shared: f64, weight: f64) {
        let turned = arm.perp();
        for (way, error) in self.errors(theta).into_iter().enumerate() {
            let base = [error[0] + error[2] * turned.x, error[1] + error[2] * turned.y, error[2]];
            let change = weight * dot(at_base, base);
            self.squares[way] += change * dot(at_base, base);
            (0..3).for_each(|i| self.mixed[way][i] += by[i] * change);
            self.by_shared[way] += by_shared * change;
        }
    }

    /// The sum of squares, in standard deviations of the readings' noise, that the declared bounds may add to the residuals.
    pub(super) fn squares(&self, bounds: &Odometry) -> f64 {
        let std = stds(bounds);
        (0..WAYS).map(|way| std[way] * std[way] * self.squares[way]).sum()
    }

    /// What the declared bounds add to the covariance of the robot's pose at the last row; `arm` goes from the pivot to
    /// the robot, map frame.
    pub(super) fn covariance(
        &self,
        normal: &Normal,
        shared: f64,
        open: [f64; 3],
        theta: f64,
        arm: Vec2,
        bounds: &Odometry,
    ) -> Matrix {
        let per = if shared > 0.0 { 1.0 / (normal.shared[0] + 1.0 / (shared * shared)) } else { 0.0 };
        let inverse = inverse(&normal.marginal(shared).damped(open)).unwrap_or_default();
        let std = stds(bounds);
        let mut out = [[0.0; 3]; 3];
        for (way, error) in self.errors(theta).into_iter().enumerate() {
            let pull = [0, 1, 2].map(|i| self.mixed[way][i] - normal.mixed[i] * self.by_shared[way] * per);
            let d = times(&inverse, pull).map(|v| -v);
            let turned = arm.perp();
            let off = [error[0] + d[0] + d[2] * turned.x, error[1] + d[1] + d[2] * turned.y, error[2] + d[2]];
            let variance = std[way] * std[way];
            (0..3).for_each(|i| (0..3).for_each(|j| out[i][j] += variance * off[i] * off[j]));
        }
        out
    }
}

/// Standard deviations of the three shares: errors spread evenly over a disc, and between two bounds.
fn stds(bounds: &Odometry) -> [f64; WAYS] {
    let place = 0.5 * bounds.translation_relative;
    [place, place, bounds.rotation_relative / SQRT_3]
}

const SQRT_3: f64 = 1.732_050_807_568_877_2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_that_is_too_long_leaves_the_middle_fixed() {
        // Five readings of x alone along a straight metre: the fit moves the path so that its middle is right, and the
        // last row is off by half of the stretch; y and heading are not read and stay open.
        let (mut drift, mut normal) = (Drift::default(), Normal::default());
        for row in 0..5 {
            if row > 0 {
                drift.travel(
                    Pose2::new(0.25 * f64::from(row - 1), 0.0, 0.0),
                    Pose2::new(0.25 * f64::from(row), 0.0, 0.0),
                );
            }
            normal.add(0.0, [1.0, 0.0, 0.0], 0.0, 1.0);
            drift.add(0.0, Vec2::ZERO, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0, 1.0);
        }
        let bounds = Odometry { translation_relative: 0.02, rotation_relative: 0.0 };
        let added = drift.covariance(&normal, 0.0, [0.0, 1.0, 1.0], 0.0, Vec2::ZERO, &bounds);
        assert!((added[0][0].sqrt() - 0.01 * 0.5).abs() < 1e-12, "{added:?}");
        assert!((added[1][1].sqrt() - 0.01).abs() < 1e-12, "{added:?}");
    }
}
