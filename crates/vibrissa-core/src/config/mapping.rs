//! How a map is made of logs alone.

use crate::{Error, Result};

/// The knobs of mapping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappingOptions {
    /// Bound on the drift of the odometry's heading with the way (rad/m), beside what the robot declares.
    pub drift: f64,
    /// Radius of a disc around the robot's origin that its body fills (m): where it was there is no wall, which proves closures.
    pub body_radius: f64,
    /// Way (m) and turn (rad) between key poses: what lies between two is taken to be rigid.
    pub key_spacing: f64,
    /// See `key_spacing`.
    pub key_turn: f64,
    /// A log is traced each time the robot has come this far (m), turns by `turn_arm` included: a trace grows with the square of its rows.
    pub cut: f64,
    /// See `cut` (m).
    pub turn_arm: f64,
    /// The end of a cut with which the next begins (m): a trace that begins in the middle of a contact is not known at once.
    pub warm_up: f64,
    /// Readings are merged into one step while the base is nearer than this to their mean (m).
    pub spacing: f64,
    /// The whisker is not bent by more at a contact that is kept (rad): beyond, the moment alone leads to other shapes.
    pub largest_slope: f64,
    /// Largest standard deviation of a contact that is kept (m).
    pub largest_std: f64,
    /// Shortest trace (m) that is kept, and its fewest contacts: what is not a wall is seldom followed for long.
    pub shortest: f64,
    /// See `shortest`.
    pub fewest: usize,
    /// What is left out of the start and of the end of a trace (m): it is not known at once where it begins in the middle of a contact, and
    /// may be followed beyond its wall.
    pub trim_start: f64,
    /// See `trim_start`.
    pub trim_end: f64,
    /// How far back from its tip a whisker that reads nothing is taken to pass free space (m): a wall may touch it with less than the noise.
    pub free_tip: f64,
    /// Way before and after its middle that a submap takes (m): long enough to hold a corner.
    pub submap: f64,
    /// The longest that is looked at where a shorter one leaves more than one place (m): what holds two corners or three cannot be
    /// moved against itself, and beyond the odometry's own bounds leave more open than a longer way tells.
    pub longest_submap: f64,
    /// Way between the middles of later submaps for which a closure is looked for (m).
    pub closure_every: f64,
    /// Fewest contacts of a submap, thinned to one in so many metres.
    pub submap_contacts: usize,
    /// See `submap_contacts` (m).
    pub contact_spacing: f64,
    /// Shapes of a whisker that are farther apart (m) have nothing known between them.
    pub largest_gap: f64,
    /// Side of the cells in which passed space is kept (m).
    pub cell: f64,
    /// The bound of a contact's error, over its standard deviation, and the least (m).
    pub stds_in_bound: f64,
    /// See `stds_in_bound`.
    pub least_bound: f64,
    /// Half of the smallest box of poses in the search for closures (m).
    pub closure_resolution: f64,
    /// Half of the largest place that counts as one (m, and rad): no larger than what tells two walls of a room apart.
    pub largest_place: f64,
    /// See `largest_place` (rad).
    pub largest_turn: f64,
    /// Most boxes of poses that are looked at for one closure: some seconds.
    pub closure_work: usize,
    /// Walls that later logs feel elsewhere are told as moved by no more than this (m): twice as far as a whisker reaches, walls are others.
    pub largest_change: f64,
    /// And by no less, beside what errors explain (m): ends of traces are off by tenths of a millimetre.
    pub least_change: f64,
    /// How far from where the first log begins each later one does at most (m, rad); none where they may begin anywhere.
    pub same_start: Option<(f64, f64)>,
}

impl Default for MappingOptions {
    fn default() -> Self {
        Self {
            drift: 0.0,
            body_radius: 0.0,
            key_spacing: 0.1,
            key_turn: 0.5,
            cut: 0.3,
            turn_arm: 0.05,
            warm_up: 0.015,
            spacing: 0.5e-3,
            largest_slope: 1.45,
            largest_std: 0.5e-3,
            shortest: 15e-3,
            fewest: 15,
            trim_start: 8e-3,
            trim_end: 2e-3,
            free_tip: 10e-3,
            submap: 0.3,
            longest_submap: 1.2,
            closure_every: 0.15,
            submap_contacts: 20,
            contact_spacing: 4e-3,
            largest_gap: 5e-3,
            cell: 1e-3,
            stds_in_bound: 4.0,
            least_bound: 0.3e-3,
            closure_resolution: 1e-3,
            largest_place: 0.03,
            largest_turn: 0.15,
            closure_work: 400_000,
            largest_change: 40e-3,
            least_change: 1e-3,
            same_start: None,
        }
    }
}

impl MappingOptions {
    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        let (start, start_turn) = self.same_start.unwrap_or_default();
        for (name, value, lo, hi) in [
            ("drift", self.drift, 0.0, 10.0),
            ("body_radius", self.body_radius, 0.0, 1.0),
            ("key_spacing", self.key_spacing, 1e-3, 10.0),
            ("key_turn", self.key_turn, 1e-2, 10.0),
            ("cut", self.cut, 1e-2, 10.0),
            ("turn_arm", self.turn_arm, 0.0, 1.0),
            ("warm_up", self.warm_up, 0.0, 1.0),
            ("spacing", self.spacing, 0.0, 0.01),
            ("largest_slope", self.largest_slope, 0.1, 3.0),
            ("largest_std", self.largest_std, 1e-6, 1.0),
            ("shortest", self.shortest, 0.0, 1.0),
            ("trim_start", self.trim_start, 0.0, 1.0),
            ("trim_end", self.trim_end, 0.0, 1.0),
            ("free_tip", self.free_tip, 0.0, 1.0),
            ("submap", self.submap, 1e-2, 10.0),
            ("longest_submap", self.longest_submap, 1e-2, 10.0),
            ("closure_every", self.closure_every, 1e-2, 10.0),
            ("contact_spacing", self.contact_spacing, 1e-4, 0.1),
            ("largest_gap", self.largest_gap, 0.0, 0.1),
            ("cell", self.cell, 1e-4, 0.1),
            ("stds_in_bound", self.stds_in_bound, 1.0, 20.0),
            ("least_bound", self.least_bound, 0.0, 0.1),
            ("closure_resolution", self.closure_resolution, 1e-5, 0.1),
            ("largest_place", self.largest_place, 1e-4, 1.0),
            ("largest_turn", self.largest_turn, 1e-3, 1.0),
            ("largest_change", self.largest_change, 0.0, 1.0),
            ("least_change", self.least_change, 0.0, 1.0),
            ("same_start", start, 0.0, 100.0),
            ("same_start", start_turn, 0.0, core::f64::consts::PI),
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
