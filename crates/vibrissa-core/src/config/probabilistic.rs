//! What the probabilistic method can be told.

use super::{Choice, Region, Setting, Slot, check_region, defaults, heading_setting, region_setting, within};
use crate::Result;

/// Sensors that are fitted to all rows of the window at once; with more of them rows leave it earlier, so that no more readings are run again and again.
/// With all rows the end of a log of sixteen whiskers takes four times as long.
pub const WHISKERS_OF_WHOLE_WINDOW: usize = 3;

/// How the errors of a sensor's readings hang together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoiseAssumption {
    /// Each is new, evenly within its bound, but for a gain that all share.
    Independent,
    /// They may stay alike for a while, as hysteresis, drift and calibration curves make them; how long is estimated.
    #[default]
    Correlated,
}

impl Choice for NoiseAssumption {
    fn words(&self) -> &'static [(&'static str, &'static str)] {
        &[
            ("independent", "Each error is new, but for a gain that all readings share"),
            (
                "correlated",
                "Errors stay alike for a while, as hysteresis and drift make them; variance and time constant are estimated",
            ),
        ]
    }

    fn word(&self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Correlated => "correlated",
        }
    }

    fn take(&mut self, word: &str) -> bool {
        let found = [Self::Independent, Self::Correlated].into_iter().find(|model| model.word() == word);
        *self = found.unwrap_or(*self);
        found.is_some()
    }
}

/// What is taken for errors that the robot does not bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UndeclaredErrors {
    /// They may be as large as those of a typical robot, and are estimated along.
    #[default]
    Typical,
    /// There are none.
    None,
}

impl Choice for UndeclaredErrors {
    fn words(&self) -> &'static [(&'static str, &'static str)] {
        &[
            (
                "typical",
                "Zero, mount, length, gain, odometry and delay may be off as those of a typical robot, and are estimated along",
            ),
            ("none", "What the robot file does not bound is exact"),
        ]
    }

    fn word(&self) -> &'static str {
        match self {
            Self::Typical => "typical",
            Self::None => "none",
        }
    }

    fn take(&mut self, word: &str) -> bool {
        let found = [Self::Typical, Self::None].into_iter().find(|errors| errors.word() == word);
        *self = found.unwrap_or(*self);
        found.is_some()
    }
}

/// The knobs of the probabilistic method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbabilisticOptions {
    /// Spacing along the boundary of the first hypotheses (m): a few of them lie within the reach of one linearisation.
    pub seed_spacing: f64,
    /// Spacing of their headings (rad).
    pub seed_turn: f64,
    /// Base travel after the first touch before hypotheses start (m): enough to tell most headings apart.
    pub seed_travel: f64,
    /// Base travel between the readings that judge them first (m).
    pub seed_step: f64,
    /// Standard deviation of a relative error that all readings share (gain, stiffness), estimated along; 0 for none.
    ///
    /// None takes a quarter of the declared relative bound: a bound is seldom noise alone, and readings enough show how
    /// large the shared part is.
    pub shared_gain: Option<f64>,
    /// Bound on the error of the log's absolute headings (rad), taken as one error of the whole log.
    pub heading_error: f64,
    /// Where the robot is at the first row, map frame, where that is known: least and largest x (m), y (m), heading (rad).
    pub prior: Option<Region>,
    /// Rows that are kept and fitted again, twice as many where errors of the odometry are declared, fewer on robots of more than three sensors; what older
    /// ones say is summed up as a Gaussian for each mode.
    pub window: usize,
    /// Share of the rows that no equilibrium needs to explain, 0 to 0.5: while the whisker has snapped or touches at three
    /// places, even the true place explains nothing.
    pub tolerated_share: f64,
    /// How the readings' errors hang together.
    pub noise_model: NoiseAssumption,
    /// What is taken for errors that the robot does not bound.
    pub undeclared: UndeclaredErrors,
}

impl Default for ProbabilisticOptions {
    fn default() -> Self {
        Self {
            seed_spacing: 4e-3,
            seed_turn: 0.11,
            seed_travel: 12e-3,
            seed_step: 2e-3,
            shared_gain: None,
            heading_error: defaults::HEADING_ERROR,
            prior: None,
            window: 1000,
            tolerated_share: 0.05,
            noise_model: NoiseAssumption::default(),
            undeclared: UndeclaredErrors::default(),
        }
    }
}

impl ProbabilisticOptions {
    /// The options for a robot that is exactly what it declares, as simulated ones are.
    #[must_use]
    pub fn exact() -> Self {
        Self { undeclared: UndeclaredErrors::None, ..Self::default() }
    }

    /// The options that shells offer.
    pub fn settings(&mut self) -> Vec<Setting<'_>> {
        let setting = |name, value_name, help, field| Setting { name, value_name, help, field };
        vec![
            setting(
                "seed_spacing",
                "M",
                "Spacing along the boundary of the first hypotheses, in m",
                Slot::Number(&mut self.seed_spacing),
            ),
            setting("seed_turn", "RAD", "Spacing of their headings, in rad", Slot::Number(&mut self.seed_turn)),
            setting(
                "seed_travel",
                "M",
                "Travel of the whisker base in contact before the first hypotheses, in m",
                Slot::Number(&mut self.seed_travel),
            ),
            setting(
                "shared_gain",
                "SHARE",
                "Standard deviation of a relative error that all readings share",
                Slot::OptionalNumber(&mut self.shared_gain, "a quarter of the noise bound"),
            ),
            setting(
                "tolerated_share",
                "SHARE",
                "Share of the rows that no contact needs to explain, since the whisker has snapped or touches at three places",
                Slot::Number(&mut self.tolerated_share),
            ),
            setting(
                "noise_model",
                "NOISE",
                "How the readings' errors hang together",
                Slot::Choice(&mut self.noise_model),
            ),
            setting(
                "undeclared",
                "ERRORS",
                "What is taken for errors that the robot file does not bound",
                Slot::Choice(&mut self.undeclared),
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
        within("window", self.window as f64, 200.0, 1e6, "rows")?;
        within("tolerated_share", self.tolerated_share, 0.0, 0.5, "(share of the rows)")?;
        within("heading_error", self.heading_error, 1e-4, core::f64::consts::PI, "rad")?;
        within("seed_spacing", self.seed_spacing, 5e-4, 2e-2, "m")?;
        within("seed_turn", self.seed_turn, 5e-3, 0.2, "rad")?;
        within("seed_travel", self.seed_travel, 2e-3, 1.0, "m")?;
        within("shared_gain", self.shared_gain.unwrap_or(0.0), 0.0, 0.5, "(relative)")?;
        within("seed_step", self.seed_step, 2e-4, self.seed_travel, "m, up to seed_travel")
    }
}
