//! What the possibilistic method can be told.

use super::{Region, Setting, Slot, check_region, defaults, heading_setting, region_setting, within};
use crate::Result;

/// The knobs of the possibilistic method \[routray, section "Possibilistic Method"\]: they trade time for tightness,
/// never for soundness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PossibilisticOptions {
    /// Most cells that are halved into; the first reading may take more.
    pub most_cells: usize,
    /// How often a cell meets a reading in one update, at most, over all cells.
    pub work: usize,
    /// The same once more at the end of the log, at most, less some for each cell: it ends when more work rules out little more. The default
    /// takes a second at most; five million may leave a large map's set a single place where it leaves several.
    pub last_work: usize,
    /// Cells smaller than this are not halved (m; headings count by an arm of 0.1 m).
    pub resolution: f64,
    /// Largest slope of a whisker at its contact (rad): what is bent further is ruled out, not searched.
    pub largest_slope: f64,
    /// How many readings the true state may violate.
    pub tolerate: usize,
    /// Bound on the error of an absolute heading in the log (rad).
    pub heading_error: f64,
    /// From which way of the robot after the first contact on (m, turns by an arm of 0.1 m) the whisker may touch in two places at
    /// once; none where it never does. With 0 the first contact may be two.
    pub two_contacts: Option<f64>,
    /// Where the robot is at the first row, map frame, where that is known: least and largest x (m), y (m), heading (rad).
    pub prior: Option<Region>,
}

impl Default for PossibilisticOptions {
    fn default() -> Self {
        Self {
            most_cells: 2000,
            work: 130,
            last_work: 1_400_000,
            resolution: 0.4e-3,
            largest_slope: core::f64::consts::PI,
            tolerate: 0,
            heading_error: defaults::HEADING_ERROR,
            two_contacts: None,
            prior: None,
        }
    }
}

impl PossibilisticOptions {
    /// The options that shells offer.
    pub fn settings(&mut self) -> Vec<Setting<'_>> {
        let setting = |name, value_name, help, field| Setting { name, value_name, help, field };
        vec![
            setting("tolerate", "K", "How many readings may break their bounds", Slot::Count(&mut self.tolerate)),
            setting(
                "largest_slope",
                "RAD",
                "Largest slope of the whisker at its contact, in rad",
                Slot::Number(&mut self.largest_slope),
            ),
            setting(
                "work",
                "N",
                "Meetings of cells and readings in one row: more is tighter and slower, never less sound",
                Slot::Count(&mut self.work),
            ),
            setting("last_work", "N", "The same once more at the end of the log", Slot::Count(&mut self.last_work)),
            setting(
                "two_contacts",
                "M",
                "From so far after the first contact on the whisker may touch in two places, as in corners",
                Slot::OptionalNumber(&mut self.two_contacts, "never"),
            ),
            heading_setting(&mut self.heading_error),
            region_setting(&mut self.prior),
        ]
    }

    /// Checks that every knob is in its range.
    ///
    /// # Errors
    ///
    /// Usage: names the knob, its value and the allowed range.
    pub fn check(&self) -> Result<()> {
        check_region(self.prior)?;
        within("most_cells", self.most_cells as f64, 1.0, 1e6, "cells")?;
        within("work", self.work as f64, 1.0, 1e7, "meetings a row")?;
        within("last_work", self.last_work as f64, 0.0, 1e9, "meetings")?;
        within("resolution", self.resolution, 1e-5, 0.1, "m")?;
        within("largest_slope", self.largest_slope, 0.1, core::f64::consts::PI, "rad")?;
        within("tolerate", self.tolerate as f64, 0.0, 100.0, "readings")?;
        within("two_contacts", self.two_contacts.unwrap_or(0.0), 0.0, 1e6, "m")?;
        within("heading_error", self.heading_error, 0.0, core::f64::consts::PI, "rad")
    }
}

/// When two contacts at once are thought possible.
pub(crate) mod two_contacts {
    /// A contact is seen from the base at no less than this share of the slope there, where all of the whisker before it bends one
    /// way: a third for small slopes, 0.297 for half a turn (curvature that grows from nothing in proportion to the arc length).
    pub(crate) const ANGLE_SHARE: f64 = 0.29;
    /// And at no more than this: two thirds for small slopes, with room for large ones.
    pub(crate) const UPPER_SHARE: f64 = 0.8;
    /// And at no less than this where the curvature falls from the base on: half for an arc of a circle, with room.
    pub(crate) const RELAXED_SHARE: f64 = 0.47;
    /// The whisker goes on behind a contact within this angle (rad) of its direction there: a right angle, and a sixth of a turn
    /// for its bending.
    pub(crate) const SWEPT_BACK: f64 = 2.1;
    /// Boundary is looked at in stretches no longer than this (m): shorter ones tell more, and take longer.
    pub(crate) const LONGEST_STRETCH: f64 = 0.01;
    /// What stands less proud of a wall than this (m) is rounding, or the readers' tolerance for arcs.
    pub(crate) const LOWEST_CORNER: f64 = 1e-7;
    /// Stretches of boundary whose normals differ by less than this (rad) are one place: a whisker that lies along a smooth wall, or a
    /// rough one, reads what one contact on it explains.
    pub(crate) const SMOOTH: f64 = 0.35;
    /// Cells that are wider than this (rad, m) are too wide to be told that a corner is out of play: near corners they are left alone.
    pub(crate) const WIDE_TURN: f64 = 0.05;
    pub(crate) const WIDE_REACH: f64 = 8e-3;
    /// A wall that turns by less than this (rad) is straight.
    pub(crate) const STRAIGHT: f64 = 1e-5;
    /// Cells of first readings that two contacts may explain are no larger than this (m, rad): wider ones would be bisected at once.
    pub(crate) const COVER_PLACE: f64 = 0.02;
    pub(crate) const COVER_TURN: f64 = 0.25;
}
