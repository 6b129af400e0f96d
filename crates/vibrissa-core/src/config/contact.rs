//! How contact points and outlines are found.

use crate::{Error, Result};

/// The knobs of contact points and outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactOptions {
    /// Readings are merged into one step while the base is nearer than this to their mean (m): finer than any wall of interest.
    pub spacing: f64,
    /// The same for whiskers that are integrated (m): each of their shapes takes thousands of times as long.
    pub rod_spacing: f64,
    /// How far a step of a sliding tip may miss the wall's direction (m); walls are smooth at 10 µm.
    pub step_std: f64,
    /// How much a wall turns along the way (rad per root of a metre): 0.03 rad over a millimetre.
    pub turn: f64,
    /// What the odometry's places are rounded to (m): a base that moves evenly within it is taken to move evenly. The paper's stage.
    pub odometry_resolution: f64,
    /// Whether a contact that jumped may be one of a whisker that is curled back over itself: moments alone hardly tell it from other
    /// contacts, and an outline is better without.
    pub curled: bool,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self {
            spacing: 0.1e-3,
            rod_spacing: 0.75e-3,
            step_std: 1e-5,
            turn: 1.0,
            odometry_resolution: 1e-5,
            curled: true,
        }
    }
}

impl ContactOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        for (name, value, lo, hi) in [
            ("spacing", self.spacing, 0.0, 0.01),
            ("rod_spacing", self.rod_spacing, 0.0, 0.01),
            ("step_std", self.step_std, 1e-7, 1e-2),
            ("turn", self.turn, 1e-3, 1e3),
            ("odometry_resolution", self.odometry_resolution, 0.0, 1e-3),
        ] {
            if !(value >= lo && value <= hi) {
                return Err(Error::usage(format!("the option {name} is out of range"))
                    .value(value)
                    .allowed(format!("{lo} to {hi}")));
            }
        }
        Ok(())
    }
}

/// The knobs of outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileOptions {
    /// Spacing of an outline's points (m).
    pub resolution: f64,
    /// How near runs of contact are taken to be the same wall (m): several times a sweep's error.
    pub reach: f64,
    /// Largest standard deviation of a contact on an outline (m).
    pub largest_std: f64,
    /// Largest gap within a run (m).
    pub largest_gap: f64,
    /// Fewest contacts of a run.
    pub fewest: usize,
    /// Shortest run (m).
    pub shortest: f64,
}

impl Default for ProfileOptions {
    fn default() -> Self {
        Self { resolution: 0.5e-3, reach: 2e-3, largest_std: 1e-3, largest_gap: 5e-3, fewest: 8, shortest: 2e-3 }
    }
}

impl ProfileOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        for (name, value, lo, hi) in [
            ("resolution", self.resolution, 1e-5, 0.1),
            ("reach", self.reach, 1e-5, 0.1),
            ("largest_std", self.largest_std, 1e-6, 1.0),
            ("largest_gap", self.largest_gap, 1e-5, 1.0),
            ("shortest", self.shortest, 0.0, 1.0),
        ] {
            if !(value >= lo && value <= hi) {
                return Err(Error::usage(format!("the option {name} is out of range"))
                    .value(value)
                    .allowed(format!("{lo} to {hi} m")));
            }
        }
        Ok(())
    }
}

/// How felt lines are put together to a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapAssemblyOptions {
    /// Ends of lines that are farther apart are not joined (m): two whiskers' lengths, across which a robot turns in a corner.
    pub largest_gap: f64,
    /// Ends that are as near as this are joined without more (m): several times the spacing of an outline's points.
    pub touching: f64,
    /// Shortest length of its end over which a wall has a direction (m): long beside the error of its points, short beside a robot's walls.
    pub corner_fit: f64,
    /// How far from its straight line a wall may lie that has a corner (m); or some standard deviations, where they are more.
    pub straight: f64,
    /// How far ahead of a felt end a corner may lie (m), and no farther than the wall was felt to be straight.
    pub corner_reach: f64,
    /// How far a felt end may reach beyond its corner (m): a tip that snaps is followed for a row or two more.
    pub overshoot: f64,
    /// Walls that turn by less have no corner (rad): 15 degrees.
    pub sharpest_flat: f64,
    /// A corner that is known no better is left unknown (m).
    pub widest_corner: f64,
    /// How far beyond the end of what was felt anything may be (m).
    pub end_reach: f64,
    /// Points within this of a straight line, or within twice the middle standard deviation, are left out (m); their bands hold it.
    pub simplified: f64,
    /// Over which length the error of a felt wall is alike (m): as far as a tip slides in one contact, measured on simulated laps.
    pub correlation_length: f64,
    /// Over which length what key poses leave open is alike (m): a few of the legs between them.
    pub drift_length: f64,
    /// The bound of a felt point, over its standard deviation, and the least bound (m): the errors of contacts are no Gaussians, and
    /// what is followed over a few millimetres too much is off by tenths of a millimetre.
    pub stds_in_bound: f64,
    /// See `stds_in_bound`.
    pub least_bound: f64,
}

impl Default for MapAssemblyOptions {
    fn default() -> Self {
        Self {
            largest_gap: 150e-3,
            touching: 3e-3,
            corner_fit: 15e-3,
            straight: 0.1e-3,
            corner_reach: 120e-3,
            overshoot: 3e-3,
            sharpest_flat: 0.26,
            widest_corner: 5e-3,
            end_reach: 30e-3,
            simplified: 20e-6,
            correlation_length: 20e-3,
            drift_length: 0.3,
            stds_in_bound: 4.0,
            least_bound: 0.1e-3,
        }
    }
}
