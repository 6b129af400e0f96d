//! What a calibration knows, and its file `cal.json`.

mod curve;
mod distance;
mod plane;

pub use curve::{MomentCurve, TipDeflection, WhiskerConstants};
pub use distance::{Distance, DistanceModel, Motion};
pub use plane::MomentPlane;

/// The version of the file that this library writes and reads.
pub const VERSION: u32 = 1;

/// A recording that a calibration rests on.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The file's name.
    pub file: String,
    /// Its rows.
    pub rows: usize,
    /// How many contacts of it were used.
    pub used: usize,
    /// The distance at which it was recorded (m), where it is one.
    pub distance: Option<f64>,
}

/// Everything that was calibrated of one whisker; what was not is not there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    /// The recordings behind it.
    pub data: Vec<Source>,
    /// Raw readings to moment.
    pub moment: Option<MomentCurve>,
    /// Raw readings to the moments about both transverse axes; where it is there, moments come from it.
    pub plane: Option<MomentPlane>,
    /// Moment to the retreat of the tip.
    pub tip_deflection: Option<TipDeflection>,
    /// Constants of the whisker.
    pub whisker: Option<WhiskerConstants>,
    /// The column whose slope tells the distance; empty without [`Calibration::distance`].
    pub channel: String,
    /// Slope of a reading to the distance of the contact.
    pub distance: Option<DistanceModel>,
}
