//! What a calibration knows, and its file `cal.json`.

mod distance;

pub use distance::{Distance, DistanceModel, Motion};
