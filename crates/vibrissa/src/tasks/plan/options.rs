//! What the robot can do, and how long may be thought about it.

use crate::world::{MountedWhisker, Robot};
use crate::{Error, Result};

/// Largest moment unless said otherwise, over `EI / L`: 7.7 mN m of the paper's whisker, which bends it by a right angle or so.
const GENTLE: f64 = 2.0;
/// The robot stops at this share of the largest moment: between two readings it goes on to press.
const STOP_AT: f64 = 0.6;

/// Readings of the forward model unless said otherwise: at some 5 µs each a plan takes a fifth of a second.
const BUDGET: usize = 40_000;

/// What motions are judged by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Criterion {
    /// The information that is expected: the entropy of the states that is taken away.
    #[default]
    Expected,
    /// The extent of what is left at worst.
    Worst,
}

/// What the robot can do, and how long may be thought about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanOptions {
    /// Longest motion (m).
    pub longest: f64,
    /// Whether the robot turns on the spot.
    pub turns: bool,
    /// Whether the robot goes in any direction without turning; else along its heading and arcs alone.
    pub sideways: bool,
    /// Radius of the robot around its origin (m), which must stay clear of all boundaries.
    pub footprint: f64,
    /// Largest moment at a whisker's base (N m); none takes twice `EI / L` of each whisker.
    pub largest_moment: Option<f64>,
    /// What motions are judged by.
    pub criterion: Criterion,
    /// Whether only what tells places apart as a whole counts, not what narrows them, where there are several.
    pub places_only: bool,
    /// Readings of the forward model that may be taken.
    pub budget: usize,
    /// Most states that stand for all that is left.
    pub states: usize,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            longest: 0.24,
            turns: true,
            sideways: true,
            footprint: 0.01,
            largest_moment: None,
            criterion: Criterion::Expected,
            places_only: false,
            budget: BUDGET,
            states: 64,
        }
    }
}

impl PlanOptions {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    ///
    /// Usage: names the option, its value and what is allowed.
    pub fn check(&self) -> Result<()> {
        let fault = |name: &str, value: f64, allowed: &str| Err(Error::usage(name).value(value).allowed(allowed));
        if !(self.longest >= 0.02 && self.longest <= 10.0) {
            return fault("the longest motion", self.longest, "0.02 to 10 m");
        }
        if !(self.footprint >= 0.0 && self.footprint <= 10.0) {
            return fault("the radius of the footprint", self.footprint, "0 to 10 m");
        }
        if !(1..=10_000).contains(&self.states) {
            return fault("the number of states", self.states as f64, "1 to 10000");
        }
        match self.largest_moment {
            Some(moment) if !(moment > 0.0 && moment.is_finite()) => fault("the largest moment", moment, "above 0 N m"),
            _ => Ok(()),
        }
    }

    /// The largest moment that a whisker may feel (N m).
    #[must_use]
    pub fn most(&self, whisker: &MountedWhisker) -> f64 {
        self.largest_moment.unwrap_or(GENTLE * whisker.beam.flexural_rigidity / whisker.beam.length)
    }

    /// The size of each whisker's reading (N m) at which the robot ends a motion.
    #[must_use]
    pub fn stop_at(&self, robot: &Robot) -> Vec<f64> {
        robot.whiskers.iter().map(|whisker| STOP_AT * self.most(whisker)).collect()
    }
}
