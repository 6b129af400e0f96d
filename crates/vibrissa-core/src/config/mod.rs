//! Every default of the product, once, with its unit and its reason.

pub mod band;
pub mod budgets;
mod calibration;
mod contact;
pub mod defaults;
mod deterministic;
mod grid;
pub mod limits;
mod mapping;
mod possibilistic;
mod probabilistic;
mod setting;
pub mod wall_following;

pub use calibration::{CurveOptions, StaircaseOptions, TapOptions};
pub use contact::{ContactOptions, MapAssemblyOptions, ProfileOptions};
pub use deterministic::{DeterministicOptions, TipLoad};
pub use grid::GridOptions;
pub use mapping::MappingOptions;
pub use possibilistic::PossibilisticOptions;
pub(crate) use possibilistic::two_contacts;
pub use probabilistic::{NoiseAssumption, ProbabilisticOptions, UndeclaredErrors, WHISKERS_OF_WHOLE_WINDOW};
pub use setting::{Choice, Region, Setting, SettingValue, Slot};
pub use vibrissa_beam::config::sensing;

use crate::{Error, Result};

/// The shafts whose distances are calibrated, where a call does not describe them.
pub mod shaft {
    /// Length of the rat-like whisker whose taps are public (m).
    pub const TAPPED_LENGTH: f64 = 0.18;
    /// Its tip radius over its base radius.
    pub const TAPPED_TIP_RATIO: f64 = 1.0 / 3.0;
    /// Length of the shaft whose staircase of contacts is public (m); its taper is fitted.
    pub const STAIRCASE_LENGTH: f64 = 0.15;
}

/// How finely the contacts that explain a reading are told.
pub mod contact_set {
    /// Contacts on each branch of an exact reading's curve: smooth on any screen.
    pub const NODES: usize = 200;
    /// How close curves must come to meet (m), beyond what their chords leave out: rounding.
    pub const MEETING: f64 = 1e-9;
}

/// What a scenario leaves out, and its limits.
pub mod scenario {
    /// Speed of the robot (m/s): half a millimetre a row.
    pub const SPEED: f64 = 0.15;
    /// Largest turning rate (rad/s).
    pub const TURN_RATE: f64 = 1.0;
    /// Rows a second (Hz): the paper's sampling rate.
    pub const RATE: f64 = 300.0;
    /// Most rows: an hour and a half at 300 Hz, and about a GB of memory.
    pub const MOST_ROWS: f64 = 2e6;
    /// Curved legs are followed by chords of this length (m); the sagitta on a 10 mm radius is a micrometre.
    pub const CHORD: f64 = 0.25e-3;
    /// Most chords of one leg: 100 m of wall.
    pub const MOST_CHORDS: f64 = 4e5;
    /// How far outside the robot's outline a whisker's mount may lie (m): drawn outlines are rounded.
    pub const MOUNT_SLACK: f64 = 1e-3;
}

/// Refuses an option out of its range.
///
/// # Errors
///
/// Usage: names the option, its value and the allowed range with its unit.
pub fn within(name: &str, value: f64, lo: f64, hi: f64, unit: &str) -> Result<()> {
    if value >= lo && value <= hi {
        return Ok(());
    }
    Err(Error::usage(format!("the option {name} is out of range")).value(value).allowed(format!("{lo} to {hi} {unit}")))
}

/// Checks a prior region.
fn check_region(region: Option<Region>) -> Result<()> {
    let wrong = |[lo, hi]: &&[f64; 2]| !(lo <= hi && lo.is_finite() && hi.is_finite());
    match region.as_ref().and_then(|bounds| bounds.iter().find(wrong)) {
        Some([lo, hi]) => Err(Error::usage("the prior region is empty")
            .value(format!("{lo} to {hi}"))
            .allowed("a finite least value, and a largest that is no smaller")),
        None => Ok(()),
    }
}

/// The bound on absolute headings, which several methods have.
fn heading_setting(at: &mut f64) -> Setting<'_> {
    Setting {
        name: "heading_error",
        value_name: "RAD",
        help: "Bound on the error of the log's absolute headings, in rad",
        field: Slot::Number(at),
    }
}

/// The region of the first pose, which every method has.
fn region_setting(at: &mut Option<Region>) -> Setting<'_> {
    Setting {
        name: "within",
        value_name: "BOX",
        help: "Where the robot is at the first row, in m and rad: least and largest x, y and heading, six numbers with \
               commas or spaces between them. Large maps need it",
        field: Slot::Region(at),
    }
}
