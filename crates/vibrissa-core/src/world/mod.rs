//! The world: maps, robots, how they move, and what their sensors are calibrated to.

mod band;
mod boundary;
pub mod calibration;
mod cost;
mod map;
mod motion;
mod robot;
mod unknown;

pub use band::{Band, Course, PieceCourse};
pub use boundary::{Boundary, CurveFault, Role, beyond_maps, out_of_range};
pub use cost::MapCost;
pub use map::{BoundarySample, ConcaveCorner, Foot, Map, MapPoint, NearestPiece};
pub use motion::increments;
pub use robot::{Lean, MomentNoise, MountedWhisker, Odometry, ReadingNoise, Robot, WhiskerErrors};
pub use unknown::UnknownZones;
