//! The known world: maps, robots, motion, and the readers of their files.

mod boundary;
pub mod calibration;
mod geojson;
mod map;
mod motion;
mod robot;
mod robot_toml;
mod svg;
mod text;
mod units;

pub use boundary::{Boundary, Role};
pub use map::{BoundarySample, ConcaveCorner, Map, MapPoint};
pub use motion::increments;
pub use robot::{MomentNoise, MountedWhisker, Odometry, Robot};
pub(crate) use text::{cannot_open, did_you_mean};
pub use units::{Dimension, parse_quantity};
