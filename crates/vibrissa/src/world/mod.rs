//! The known world: maps, robots, motion.

mod robot;

pub use robot::{MomentNoise, MountedWhisker, Odometry, Robot};
