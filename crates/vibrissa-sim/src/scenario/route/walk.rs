//! Poses with times.

use crate::config::scenario::MOST_ROWS;
use crate::flow::pose::StampedPose;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::simulate::{Pace, leg_time};
use crate::{Error, Result};
use core::f64::consts::FRAC_PI_2;

/// Places closer than this are the same (m).
const SAME_PLACE: f64 = 1e-6;
/// Headings closer than this are the same (rad).
const SAME_HEADING: f64 = 1e-12;

/// The way so far.
#[derive(Clone, Debug)]
pub(in crate::scenario) struct Walk {
    /// The poses at which the motion changes.
    pub(in crate::scenario) nodes: Vec<StampedPose>,
    /// How fast it goes on.
    pub(in crate::scenario) pace: Pace,
}

impl Walk {
    /// Starts at time 0.
    pub(in crate::scenario) fn new(start: Pose2, pace: Pace) -> Self {
        Self { nodes: vec![StampedPose { t: 0.0, map_from_robot: start }], pace }
    }

    fn last(&self) -> StampedPose {
        self.nodes.last().copied().unwrap_or(StampedPose { t: 0.0, map_from_robot: Pose2::IDENTITY })
    }

    /// The heading with which the robot first leaves its place (rad); the present one if it never does.
    pub(in crate::scenario) fn first_heading(&self) -> f64 {
        let leaves = |w: &&[StampedPose]| w[1].map_from_robot.position() != w[0].map_from_robot.position();
        self.nodes.windows(2).find(leaves).map_or(self.pose().theta, |w| w[0].map_from_robot.theta)
    }

    /// Where the robot is now.
    pub(super) fn pose(&self) -> Pose2 {
        self.last().map_from_robot
    }

    /// The time now (s).
    pub(in crate::scenario) fn time(&self) -> f64 {
        self.last().t
    }

    /// Straight to a pose, turning on the way.
    pub(super) fn go(&mut self, to: Pose2) -> Result<()> {
        let time = leg_time(self.pose(), to, &self.pace);
        self.push(to, time)
    }

    /// Stands still.
    pub(super) fn wait(&mut self, time: f64) -> Result<()> {
        self.push(self.pose(), time)
    }

    /// Turns on the spot, the shorter way.
    pub(super) fn turn_to(&mut self, theta: f64) -> Result<()> {
        self.turn_by(wrap_angle(theta - self.pose().theta))
    }

    /// Turns on the spot by any angle (rad).
    pub(super) fn turn_by(&mut self, by: f64) -> Result<()> {
        if by.abs() <= SAME_HEADING {
            return Ok(());
        }
        let (from, parts) = (self.pose(), (by.abs() / FRAC_PI_2).ceil().max(1.0));
        for part in 1..=parts as usize {
            self.go(Pose2::new(from.x, from.y, from.theta + by * part as f64 / parts))?;
        }
        Ok(())
    }

    /// Along a chain of points with the directions there (rad); `heading` makes headings of them.
    pub(super) fn follow(&mut self, chain: &[(Vec2, f64)], heading: impl Fn(f64) -> f64) -> Result<()> {
        if let Some((point, direction)) = chain.first() {
            // To the chain's start without turning towards it: most often it is there already, or all but.
            if point.distance(self.pose().position()) > SAME_PLACE {
                self.go(Pose2::new(point.x, point.y, heading(*direction)))?;
            }
            self.turn_to(heading(*direction))?;
        }
        for (point, direction) in chain.iter().skip(1) {
            self.go(Pose2::new(point.x, point.y, heading(*direction)))?;
        }
        Ok(())
    }

    fn push(&mut self, map_from_robot: Pose2, time: f64) -> Result<()> {
        let t = self.time() + time;
        let rows = t * self.pace.rate;
        if rows.is_nan() || rows > MOST_ROWS {
            return Err(Error::data("the path takes too many rows")
                .value(format!("{rows:.0} rows by the time t = {t:.0} s"))
                .allowed(format!("up to {MOST_ROWS}"))
                .remedy("shorten the path, raise the speed or lower the rate; bare numbers are m, m/s and Hz"));
        }
        if time > 0.0 {
            self.nodes.push(StampedPose { t, map_from_robot });
        }
        Ok(())
    }
}
