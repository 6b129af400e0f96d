//! What the robot can do, and what it keeps.

use crate::config::wall_following::{BAND, GENTLE};
use crate::world::{MountedWhisker, Robot};
use crate::{Error, Result};

/// The side of the robot on which the wall is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// To its left.
    Left,
    /// To its right.
    Right,
}

/// What the robot can do, and what it keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowOptions {
    /// On which side the wall is to be; none takes that to which the first whisker points.
    pub side: Option<Side>,
    /// Largest speed (m/s).
    pub speed: f64,
    /// Largest turning rate (rad/s).
    pub turn_rate: f64,
    /// Whether the robot goes sideways as well (omnidirectional); else ahead, back and around (differential drive).
    pub sideways: bool,
    /// Radius of the robot around its origin (m).
    pub footprint: f64,
    /// The moments at the base between which the whisker is kept (N m); none takes 0.3 to 0.9 `EI / L` of each whisker.
    pub band: Option<[f64; 2]>,
    /// Largest moment at a whisker's base (N m); none takes twice `EI / L` of each whisker.
    pub largest_moment: Option<f64>,
}

impl Default for FollowOptions {
    fn default() -> Self {
        Self {
            side: None,
            speed: 0.1,
            turn_rate: 1.0,
            sideways: false,
            footprint: 0.01,
            band: None,
            largest_moment: None,
        }
    }
}

impl FollowOptions {
    /// The moments between which a whisker is kept (N m).
    #[must_use]
    pub fn band_of(&self, whisker: &MountedWhisker) -> [f64; 2] {
        self.band.unwrap_or(BAND.map(|share| share * unit(whisker)))
    }

    /// The largest moment that a whisker may feel (N m).
    #[must_use]
    pub fn most_of(&self, whisker: &MountedWhisker) -> f64 {
        self.largest_moment.unwrap_or(GENTLE * unit(whisker))
    }

    /// The side on which the wall is.
    #[must_use]
    pub fn side_of(&self, robot: &Robot) -> Side {
        let left = robot.whiskers.first().is_some_and(|w| w.robot_from_whisker.theta > 0.0);
        self.side.unwrap_or(if left { Side::Left } else { Side::Right })
    }

    pub(super) fn check(&self, robot: &Robot) -> Result<()> {
        let fault = |name: &str, value: f64, allowed: &str| Err(Error::usage(name).value(value).allowed(allowed));
        if !(self.speed > 0.0 && self.speed <= 10.0) {
            return fault("the speed", self.speed, "above 0, to 10 m/s");
        }
        if !(self.turn_rate > 0.0 && self.turn_rate <= 100.0) {
            return fault("the turning rate", self.turn_rate, "above 0, to 100 rad/s");
        }
        if !(self.footprint >= 0.0 && self.footprint <= 10.0) {
            return fault("the radius of the footprint", self.footprint, "0 to 10 m");
        }
        for whisker in &robot.whiskers {
            let ([low, high], most) = (self.band_of(whisker), self.most_of(whisker));
            if !(low > 0.0 && low < high && high < most && most.is_finite()) {
                return Err(Error::usage("the band of moments")
                    .value(format!("{low} to {high} N m"))
                    .allowed(format!("above 0, and below the largest moment, {most} N m")));
            }
        }
        Ok(())
    }
}

/// `EI / L` (N m).
pub(super) fn unit(whisker: &MountedWhisker) -> f64 {
    whisker.beam.flexural_rigidity / whisker.beam.length
}
