//! One candidate: where it says the odometry frame is in the map, and how well it has explained what was felt.

use super::membership::{Match, Tolerance, nearest_state};
use crate::config::DeterministicOptions;
use crate::flow::contact_set::TipContact;
use crate::flow::preimage::{AlignedState, Observation};
use crate::math;
use crate::plane::{Pose2, Vec2};
use crate::sets::{Interval, StateBox};
use crate::world::Map;

/// A symmetric matrix over (x, y, theta).
type Covariance = [[f64; 3]; 3];

/// One way in which the odometry frame can lie in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The odometry frame in the map frame.
    pub map_from_odom: Pose2,
    /// Observations that it does not explain.
    pub missed: u32,
    /// Observations that it explains.
    pub explained: u32,
    /// Sum over these of the squared distance from the preimage, in units of the tolerance.
    pub misfit: f64,
    /// Direction of the boundary's normal at the last contact (rad), map frame.
    pub(super) normal: f64,
    /// The point of the boundary touched last (m), map frame.
    pub(super) touched: Vec2,
    /// The mount of the whisker that felt it, as long as it has kept touching.
    pub(super) felt_with: Option<Pose2>,
    /// How far an error that all readings share may have moved the contact, on average over what is explained (m).
    shared: f64,
    /// Over which length such an error may turn the heading (m).
    arm: f64,
    covariance: Covariance,
}

impl Candidate {
    /// The candidate that a state of the first observation's preimage makes.
    pub(super) fn at(state: &AlignedState, observation: &Observation, spacing: f64) -> Self {
        let odom_from_robot = observation.odom_from_whisker.compose(observation.robot_from_whisker.inverse());
        let map_from_odom = state.map_from_robot.compose(odom_from_robot.inverse());
        // The whisker may stand half a spacing beside the sample, and turned about the contact.
        let mut covariance = [[0.0; 3]; 3];
        let place = 0.5 * math::hypot(spacing, 0.5e-3);
        covariance[0][0] = place * place;
        covariance[1][1] = place * place;
        let turn = turning(state.contact, map_from_odom);
        add_outer(&mut covariance, turn, state.heading_std.powi(2));
        Self {
            map_from_odom,
            missed: 0,
            explained: 1,
            misfit: 0.0,
            normal: state.normal,
            touched: state.contact,
            felt_with: Some(observation.robot_from_whisker),
            shared: 0.0,
            arm: f64::INFINITY,
            covariance,
        }
    }

    /// Widens the candidate by odometry errors: variances of the travelled way (m²) and of the turn (rad²).
    pub(super) fn widen(&mut self, odom_from_robot: Pose2, travelled: f64, turned: f64) {
        if travelled > 0.0 || turned > 0.0 {
            self.covariance[0][0] += travelled;
            self.covariance[1][1] += travelled;
            let robot = self.map_from_odom.transform_point(odom_from_robot.position());
            add_outer(&mut self.covariance, turning(robot, self.map_from_odom), turned);
        }
    }

    /// Compares the candidate with the observation's preimage and moves it towards the nearest state in there.
    pub(super) fn meet(&mut self, map: &Map, observation: &Observation, tolerance: &Tolerance) {
        match nearest_state(map, self, observation, tolerance) {
            Some(found) => {
                self.explained += 1;
                self.misfit += found.cost;
                self.normal = found.normal;
                self.touched = found.touched;
                self.felt_with = Some(observation.robot_from_whisker);
                self.arm = tolerance.arm;
                self.shared += (found.shared - self.shared) / f64::from(self.explained - 1).max(1.0);
                self.fuse(&found, tolerance);
            }
            None => self.missed += 1,
        }
    }

    /// The tip contact with which the candidate explains an observation, whisker frame; none if it does not.
    #[must_use]
    pub fn contact(&self, map: &Map, observation: &Observation, options: &DeterministicOptions) -> Option<TipContact> {
        nearest_state(map, self, observation, &Tolerance::new(observation, options)).map(|found| found.contact)
    }

    /// Orders candidates by how well they explain what was felt: the best has the least rank.
    #[must_use]
    pub fn rank(&self) -> f64 {
        f64::from(self.missed) + self.misfit
    }

    /// Where the robot may be by this candidate alone, with the odometry at `odom_from_robot`: its state, give or take
    /// `std_devs` standard deviations of what it has explained, and what an error shared by all readings leaves open.
    #[must_use]
    pub fn extent(&self, odom_from_robot: Pose2, std_devs: f64) -> StateBox {
        let state = self.map_from_odom.compose(odom_from_robot);
        let arm = (state.position() - self.map_from_odom.position()).perp();
        let around = |value: f64, gradient: [f64; 3], shared: f64| {
            let half = std_devs * self.variance(gradient).max(0.0).sqrt() + shared;
            Interval::new(value - half, value + half)
        };
        StateBox {
            x: around(state.x, [1.0, 0.0, arm.x], self.shared),
            y: around(state.y, [0.0, 1.0, arm.y], self.shared),
            theta: around(state.theta, [0.0, 0.0, 1.0], self.shared / self.arm),
        }
    }

    /// Variance of a linear function of (x, y, theta).
    pub(super) fn variance(&self, gradient: [f64; 3]) -> f64 {
        let along = self.times(gradient);
        (0..3).map(|i| gradient[i] * along[i]).sum()
    }

    fn times(&self, gradient: [f64; 3]) -> [f64; 3] {
        self.covariance.map(|row| (0..3).map(|j| row[j] * gradient[j]).sum())
    }

    /// The least-squares mean of the candidate and the state found: the recursive form, one scalar at a time.
    fn fuse(&mut self, found: &Match, tolerance: &Tolerance) {
        self.absorb(found.gradient, found.offset, found.std * tolerance.dependence);
        if let Some((turn, std)) = found.turn {
            self.absorb([0.0, 0.0, 1.0], turn, std * tolerance.dependence);
        }
    }

    /// Moves the candidate so that `gradient · move` approaches `wanted`, known to `std`.
    fn absorb(&mut self, gradient: [f64; 3], wanted: f64, std: f64) {
        let along = self.times(gradient);
        let total = (0..3).map(|i| gradient[i] * along[i]).sum::<f64>() + std * std;
        if total <= 0.0 {
            return;
        }
        let step = along.map(|v| v * wanted / total);
        let Pose2 { x, y, theta } = self.map_from_odom;
        self.map_from_odom = Pose2::new(x + step[0], y + step[1], theta + step[2]);
        add_outer(&mut self.covariance, along, -1.0 / total);
    }
}

/// How (x, y, theta) change when the frame turns about `center` by one radian.
fn turning(center: Vec2, frame: Pose2) -> [f64; 3] {
    let arm = (frame.position() - center).perp();
    [arm.x, arm.y, 1.0]
}

fn add_outer(matrix: &mut Covariance, v: [f64; 3], factor: f64) {
    for i in 0..3 {
        for j in 0..3 {
            matrix[i][j] += factor * v[i] * v[j];
        }
    }
}
