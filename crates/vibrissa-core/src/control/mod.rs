//! Controllers that run row by row beside a localizer: from readings to body twists. They know no map, no files and no clock.

mod feeler;
mod options;
mod trail;
mod wall_follower;

pub use options::{FollowOptions, Side};
pub use wall_follower::{FollowCommand, FollowState, WallFollower};
