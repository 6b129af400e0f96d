//! The built-in arena and sweep: the main job without any file.

use crate::Result;
use crate::flow::pose::StampedPose;
use crate::plane::Pose2;
use crate::sim::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use crate::world::{Map, Robot};

/// The arena as a drawing (SVG, mm): 460 mm by 320 mm with curved and straight walls and two obstacles.
pub const ARENA_SVG: &str = include_str!("../../data/demo_arena.svg");

/// Waypoints of the robot, map frame (m, m, deg).
///
/// The whisker trails behind the robot. It meets the wall gently, drags through the bay, and ends on the bump.
const WAYPOINTS: [[f64; 3]; 6] = [
    [0.104, 0.236, 128.0],
    [0.166, 0.262, 128.0],
    [0.211, 0.273, 128.0],
    [0.256, 0.262, 126.0],
    [0.296, 0.250, 124.0],
    [0.350, 0.239, 124.0],
];
/// Speed (m/s), turning rate (rad/s) and rows a second: half a millimetre a row.
const PACE: Pace = Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 };

/// The arena.
///
/// # Errors
///
/// None as long as the built-in drawing is whole.
pub fn arena() -> Result<Map> {
    crate::io::map::from_svg(ARENA_SVG, "the built-in arena")
}

/// The robot's true path along the arena's upper wall, map frame.
///
/// # Errors
///
/// None as long as the built-in waypoints are whole.
pub fn path() -> Result<Vec<StampedPose>> {
    let waypoints = WAYPOINTS.map(|[x, y, degrees]| Pose2::new(x, y, degrees.to_radians()));
    path_through(&waypoints, &PACE)
}

/// The sweep of the paper's whisker along the path, with its declared moment noise from this seed and exact odometry.
///
/// # Errors
///
/// None as long as the built-in arena and path are whole.
pub fn sweep(seed: u64) -> Result<Sweep> {
    simulate_tip_sweep(&arena()?, &Robot::default(), &path()?, &SweepNoise::seeded(seed))
}

/// The same sweep at another speed (m/s), for a robot that is watched while it drives.
///
/// # Errors
///
/// A speed that is not above 0.
pub fn sweep_at(seed: u64, speed: f64) -> Result<Sweep> {
    let waypoints = WAYPOINTS.map(|[x, y, degrees]| Pose2::new(x, y, degrees.to_radians()));
    let path = path_through(&waypoints, &Pace { speed, turn_rate: PACE.turn_rate * speed / PACE.speed, ..PACE })?;
    simulate_tip_sweep(&arena()?, &Robot::default(), &path, &SweepNoise::seeded(seed))
}
