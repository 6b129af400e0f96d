//! What the deterministic method can be told.

use super::{Choice, Region, Setting, Slot, check_region, limits, region_setting, within};
use crate::Result;

/// Which way the contact force acts at a whisker's tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TipLoad {
    /// Normal to the boundary, as frictionless contact of a tip with a smooth wall is.
    #[default]
    BoundaryNormal,
    /// Normal to the whisker, as the paper has it; millimetres off where the whisker meets the wall aslant.
    WhiskerNormal,
}

/// The knobs of the deterministic method \[routray, section "Localization: Deterministic Method"\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeterministicOptions {
    /// Spacing of the points along the boundary at which the whisker is aligned (m).
    ///
    /// The paper's is 1 mm. A candidate moves to where it explains the readings best, and ends no further from the truth
    /// when its neighbours are three times as far away.
    pub boundary_spacing: f64,
    /// How many whisker shapes estimate the boundary's slope; the paper's 2 to 5.
    pub history_shapes: usize,
    /// How far the whisker base travels from the first to the last of these shapes (m).
    ///
    /// A reading off by 5 % moves the tip by a millimetre or two. Over 10 mm the slope is good to a few degrees, and
    /// walls are still all but straight.
    pub history_travel: f64,
    /// How far the whisker base travels between two updates (m).
    pub update_travel: f64,
    /// Where on the boundary and at which heading a candidate may miss an observation, in standard deviations.
    pub tolerance: f64,
    /// Heading tolerance that stays when readings are exact (rad): the wall bends within the history.
    pub heading_floor: f64,
    /// Position tolerance that stays when readings are exact (m): shapes and walls are interpolated.
    pub position_floor: f64,
    /// Share of the observations that a candidate may miss: 0 is the paper's plain intersection.
    ///
    /// At corners the slope of the history is nobody's slope; a few bad observations must not empty the set.
    pub missed_share: f64,
    /// Which way the force acts at the tip.
    pub tip_load: TipLoad,
    /// Where the robot is at the first row, map frame, where that is known: least and largest x (m), y (m), heading (rad).
    pub prior: Option<Region>,
}

impl Default for DeterministicOptions {
    fn default() -> Self {
        Self {
            boundary_spacing: 3e-3,
            history_shapes: 5,
            history_travel: 10e-3,
            update_travel: 2e-3,
            tolerance: 4.0,
            heading_floor: 0.05,
            position_floor: 0.7e-3,
            missed_share: 0.25,
            tip_load: TipLoad::default(),
            prior: None,
        }
    }
}

impl Choice for TipLoad {
    fn words(&self) -> &'static [(&'static str, &'static str)] {
        &[
            ("boundary-normal", "Normal to the wall, as frictionless contact is"),
            ("whisker-normal", "Normal to the whisker, as in the paper"),
        ]
    }

    fn word(&self) -> &'static str {
        match self {
            Self::BoundaryNormal => "boundary-normal",
            Self::WhiskerNormal => "whisker-normal",
        }
    }

    fn take(&mut self, word: &str) -> bool {
        let found = [Self::BoundaryNormal, Self::WhiskerNormal].into_iter().find(|load| load.word() == word);
        *self = found.unwrap_or(*self);
        found.is_some()
    }
}

impl DeterministicOptions {
    /// The options that shells offer.
    pub fn settings(&mut self) -> Vec<Setting<'_>> {
        let setting = |name, value_name, help, field| Setting { name, value_name, help, field };
        vec![
            setting("tip_load", "LOAD", "Which way the force acts at the tip", Slot::Choice(&mut self.tip_load)),
            setting(
                "boundary_spacing",
                "M",
                "Spacing of the points along the boundary at which the whisker is aligned, in m",
                Slot::Number(&mut self.boundary_spacing),
            ),
            setting(
                "history_shapes",
                "N",
                "Whisker shapes that estimate the boundary's slope, 2 to 5",
                Slot::Count(&mut self.history_shapes),
            ),
            setting(
                "history_travel",
                "M",
                "Travel of the whisker base from the first to the last of these shapes, in m",
                Slot::Number(&mut self.history_travel),
            ),
            setting(
                "update_travel",
                "M",
                "Travel of the whisker base between two updates, in m",
                Slot::Number(&mut self.update_travel),
            ),
            setting(
                "tolerance",
                "SIGMA",
                "How far a candidate may lie from an observation, in standard deviations",
                Slot::Number(&mut self.tolerance),
            ),
            setting(
                "missed_share",
                "SHARE",
                "Share of the observations that a candidate may miss; 0 is the paper's plain intersection",
                Slot::Number(&mut self.missed_share),
            ),
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
        within("boundary_spacing", self.boundary_spacing, 1e-5, limits::COARSEST_SPACING, "m")?;
        within("history_shapes", self.history_shapes as f64, 2.0, 5.0, "shapes")?;
        within("history_travel", self.history_travel, 1e-5, 1.0, "m")?;
        // Shorter updates share all but a hundredth of their readings: time is spent, nothing is learned.
        let least = 0.01 * self.history_travel;
        within(
            "update_travel",
            self.update_travel,
            least,
            self.history_travel,
            "m, a hundredth to all of history_travel",
        )?;
        within("tolerance", self.tolerance, 0.1, 10.0, "standard deviations")?;
        within("heading_floor", self.heading_floor, 0.0, 1.0, "rad")?;
        within("position_floor", self.position_floor, 0.0, 0.1, "m")?;
        within("missed_share", self.missed_share, 0.0, 0.9, "of the observations")
    }
}
