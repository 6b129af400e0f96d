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
    /// The same once more at the end of the log, at most: it ends when more work rules out little more.
    pub last_work: usize,
    /// Cells smaller than this are not halved (m; headings count by an arm of 0.1 m).
    pub resolution: f64,
    /// Largest slope of a whisker at its contact (rad): what is bent further is ruled out, not searched.
    pub largest_slope: f64,
    /// How many readings the true state may violate.
    pub tolerate: usize,
    /// Bound on the error of an absolute heading in the log (rad).
    pub heading_error: f64,
    /// Where the robot is at the first row, map frame, where that is known: least and largest x (m), y (m), heading (rad).
    pub prior: Option<Region>,
}

impl Default for PossibilisticOptions {
    fn default() -> Self {
        Self {
            most_cells: 2000,
            work: 130,
            last_work: 5_000_000,
            resolution: 0.4e-3,
            largest_slope: core::f64::consts::PI,
            tolerate: 0,
            heading_error: defaults::HEADING_ERROR,
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
        within("heading_error", self.heading_error, 0.0, core::f64::consts::PI, "rad")
    }
}
