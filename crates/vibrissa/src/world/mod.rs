//! The known world: maps, robots, motion, and the readers of their files.

mod boundary;
pub mod calibration;
mod dxf;
mod geojson;
pub mod grid;
mod map;
mod motion;
mod robot;
mod robot_text;
mod robot_toml;
#[cfg(feature = "mcap")]
pub mod ros;
pub mod sensing;
mod svg;
mod text;
mod toml_section;
mod units;

pub use boundary::{Boundary, Role};
pub use map::{BoundarySample, ConcaveCorner, Map, MapPoint};
pub(crate) use map::{Foot, NearestPiece};
pub use motion::increments;
pub use robot::{MomentNoise, MountedWhisker, Odometry, ReadingNoise, Robot};
pub(crate) use robot_toml::{odometry as odometry_section, whiskers as whisker_entries};
pub(crate) use text::{cannot_open, did_you_mean, read_text};
pub(crate) use toml_section::{Allowed, FINITE, FRACTION, LENGTH, NOT_NEGATIVE, POSITIVE, Section, Source, show};
pub use units::{Dimension, parse_quantity};
