//! Odometry between key poses, with its derivatives by the shares by which it may be wrong \[borenstein1996measurement\].

use crate::plane::{Pose2, Vec2};

/// Shares that all of a log's odometry has in common: ways too short, turns too small, and a drift of the heading (rad/m).
pub(super) const SHARES: usize = 3;

/// A chain of steps as one, and how it changes with the shares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Leg {
    /// What the odometry says.
    pub(super) step: Pose2,
    /// Derivatives of place and turn by each share.
    pub(super) by_share: [(Vec2, f64); SHARES],
    /// The way (m) and the turns (rad) of its steps, summed.
    pub(super) way: f64,
    pub(super) turned: f64,
}

impl Leg {
    /// With one step more.
    pub(super) fn add(&mut self, step: Pose2) {
        let moved = step.position().rotated(self.step.theta);
        let way = step.position().norm();
        for (k, (place, turn)) in self.by_share.iter_mut().enumerate() {
            *place += moved.perp() * *turn + if k == 0 { moved } else { Vec2::ZERO };
            *turn += [0.0, step.theta, way][k];
        }
        self.step = self.step.compose(step);
        self.way += way;
        self.turned += step.theta.abs();
    }

    /// The step with these shares taken into account, linearly.
    pub(super) fn corrected(&self, shares: &[f64; SHARES]) -> Pose2 {
        let (place, turn) = self
            .by_share
            .iter()
            .zip(shares)
            .fold((self.step.position(), self.step.theta), |(p, t), ((by, turn), share)| {
                (p + *by * *share, t + turn * share)
            });
        Pose2 { x: place.x, y: place.y, theta: turn }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_steps_themselves() {
        let steps: Vec<Pose2> =
            (0..60).map(|k| Pose2::new(2e-3, 4e-4 * f64::from(k % 5), 0.02 * (0.3 * f64::from(k)).sin())).collect();
        let along = |shares: [f64; SHARES]| {
            steps.iter().fold(Pose2::IDENTITY, |pose, step| {
                let way = step.position().norm();
                let turn = step.theta * (1.0 + shares[1]) + shares[2] * way;
                pose.compose(Pose2::new(step.x * (1.0 + shares[0]), step.y * (1.0 + shares[0]), turn))
            })
        };
        let mut leg = Leg::default();
        steps.iter().for_each(|step| leg.add(*step));
        for k in 0..SHARES {
            let mut shares = [0.0; SHARES];
            shares[k] = 1e-5;
            let (exact, told) = (along(shares), leg.corrected(&shares));
            let off = exact.position().distance(told.position()) + (exact.theta - told.theta).abs();
            assert!(off < 1e-8, "{k}: {off:e}");
        }
    }
}
