//! Drives whose motion tells the delay between readings and odometry.

use vibrissa::flow::pose::StampedPose;
use vibrissa::plane::Pose2;
use vibrissa::sim::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;

/// Readings a second (Hz).
const RATE: f64 = 300.0;
/// Speeds of the legs (m/s).
const SPEEDS: [f64; 5] = [0.1, 0.03, 0.12, 0.05, 0.15];

/// A drive of 13 s along the demo's wall, to and a part of the way fro, with a rest after each leg; `first` is the first leg's speed among
/// [`SPEEDS`].
pub(crate) fn uneven(seed: u64, first: usize) -> Sweep {
    let corners = [
        [0.104, 0.236, 128.0],
        [0.166, 0.262, 128.0],
        [0.211, 0.273, 128.0],
        [0.256, 0.262, 126.0],
        [0.296, 0.25, 124.0],
        [0.35, 0.239, 124.0],
    ];
    let legs: Vec<[f64; 3]> = corners.into_iter().chain(corners.into_iter().rev().skip(1).take(3)).collect();
    let mut path: Vec<StampedPose> = Vec::new();
    for (index, leg) in legs.windows(2).enumerate() {
        let ends = [leg[0], leg[1]].map(|[x, y, degrees]| Pose2::new(x, y, f64::to_radians(degrees)));
        let pace = Pace { speed: SPEEDS[(index + first) % SPEEDS.len()], turn_rate: 1.0, rate: RATE };
        let start = path.last().map_or(0.0, |last| last.t + 1.0 / RATE);
        path.extend(path_through(&ends, &pace).unwrap().iter().map(|pose| StampedPose { t: start + pose.t, ..*pose }));
        let last = *path.last().unwrap();
        path.extend((1..=90).map(|i| StampedPose { t: last.t + f64::from(i) / RATE, ..last }));
    }
    simulate_tip_sweep(&demo::arena().unwrap(), &Robot::default(), &path, &SweepNoise::seeded(seed)).unwrap()
}
