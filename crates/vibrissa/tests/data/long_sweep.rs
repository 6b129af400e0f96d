//! Long sweeps of the paper's whisker along the walls of a map, around its corners.

use super::random::Random;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sim::{Pace, Part, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::world::{Map, Robot};

/// The whisker's length (m).
const LENGTH: f64 = 0.075;
/// How far apart lean and pressure are drawn anew (m).
const STRIDE: f64 = 0.04;
/// Spacing of the boundary's points (m).
const SPACING: f64 = 1e-3;
/// A sweep has at least this many rows in contact, and at least this share of them at the tip.
const FEWEST: usize = 800;
const TIP_SHARE: f64 = 0.6;
/// No contact is nearer to the base than this share of the whisker: a robot does not go that near to a wall.
const NEAREST: f64 = 0.05;

/// The sweep of a seed along a random stretch of wall, if the robot can go there and touches for long.
pub(crate) fn long_sweep(map: &Map, seed: u64) -> Option<Sweep> {
    let mut draw = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let samples = map.samples(SPACING);
    let start = (draw.unit() * samples.len() as f64) as usize;
    let boundary = samples[start].boundary;
    let forward = draw.sign();
    let strides = draw.between(8.0, 30.0) as usize;
    let step = (STRIDE / SPACING) as i64;
    let mut way = Vec::with_capacity(strides + 1);
    for k in 0..=strides {
        let at = (start as i64 + forward as i64 * step * k as i64).rem_euclid(samples.len() as i64) as usize;
        let here = samples[at];
        if here.boundary != boundary {
            return None;
        }
        let inward = Vec2::from_angle(here.tangent).perp();
        let lean = draw.between(0.4, 1.0);
        // The first place is clear of the wall.
        let press = if k == 0 { -0.005 } else { draw.between(0.004, 0.018) };
        let heading = (-inward).angle() - forward * lean;
        let base = here.position + inward * (LENGTH * lean.cos() - press);
        way.push(Pose2::new(base.x, base.y, heading));
    }
    let path = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).ok()?;
    if path.iter().any(|pose| !map.is_free(pose.map_from_robot.position())) {
        return None;
    }
    let sweep = simulate_tip_sweep(map, &Robot::default(), &path, &SweepNoise::seeded(seed)).ok()?;
    let tips = sweep.contacts.iter().filter(|touch| touch.part == Part::Tip).count();
    let stopped = sweep.events.iter().any(|event| event.kind == "lost");
    let too_near = sweep.contacts.iter().any(|touch| touch.s_a < NEAREST * LENGTH);
    (!stopped && !too_near && tips >= FEWEST && tips as f64 >= TIP_SHARE * sweep.truth.len() as f64).then_some(sweep)
}
