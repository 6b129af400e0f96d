//! Planar geometry: vectors, rigid motions, curves, and fast look-up among many of them.

mod pose2;
mod vec2;

pub use pose2::{Pose2, Twist2, wrap_angle};
pub use vec2::Vec2;
