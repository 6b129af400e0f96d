//! Random arenas and sweeps along their walls.

use super::random::Random;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Error, Result};

/// A closed arena whose radius is a random sum of waves.
#[allow(dead_code, reason = "each program takes what it needs")]
pub(crate) fn arena(draw: &mut Random) -> Result<Map> {
    let waves: Vec<(f64, f64, f64)> =
        (2..9).map(|k| (f64::from(k), draw.signed(0.018) / (f64::from(k) * 0.4).max(1.0), draw.signed(3.2))).collect();
    let radius = draw.between(0.18, 0.28);
    let point = |i: usize| {
        let angle = i as f64 / 1200.0 * core::f64::consts::TAU;
        let r = radius + waves.iter().map(|(k, a, phase)| a * (k * angle + phase).sin()).sum::<f64>();
        r * Vec2::from_angle(angle)
    };
    let points: Vec<Vec2> = (0..1200).map(point).collect();
    let curve = Curve::polyline(&points, true).ok_or_else(|| Error::data("a degenerate arena"))?;
    Map::new(vec![Boundary::new(Role::Arena, curve, None)?])
}

/// What sweeps are drawn from.
pub(crate) struct Draws {
    /// 1 or -1: which way the first half of the draws goes.
    pub(crate) first_half: f64,
    /// How far the whisker leans back from its way (rad).
    pub(crate) lean: [f64; 2],
    /// How far off the wall the sweep begins (m).
    pub(crate) off: f64,
    /// Where along the wall it is pressed first (m); drawn only where it is a range.
    pub(crate) pressed: [f64; 2],
    /// By how much it is pressed (m).
    pub(crate) press: [f64; 2],
    /// How long it is (m).
    pub(crate) length: [f64; 2],
    /// Fewest rows in contact.
    pub(crate) fewest: usize,
}

/// Sweeps that touch for long.
const LONG: Draws = Draws {
    first_half: -1.0,
    lean: [0.5, 1.0],
    off: 0.006,
    pressed: [0.01, 0.01],
    press: [0.006, 0.02],
    length: [0.10, 0.20],
    fewest: 150,
};

/// A sweep along a random stretch of wall, if the robot can go there and touches for long.
#[allow(dead_code, reason = "each program takes what it needs")]
pub(crate) fn sweep(map: &Map, draw: &mut Random, seed: u64) -> Option<Sweep> {
    sweep_of(map, draw, seed, &LONG)
}

/// The same from other draws; the whisker trails.
pub(crate) fn sweep_of(map: &Map, draw: &mut Random, seed: u64, draws: &Draws) -> Option<Sweep> {
    let samples = map.samples(1e-3);
    let start = samples[draw.between(0.0, samples.len() as f64) as usize];
    let (along, inward) = (Vec2::from_angle(start.tangent), Vec2::from_angle(start.tangent).perp());
    let forward = -draws.first_half * draw.sign();
    let range = |draw: &mut Random, [lo, hi]: [f64; 2]| if lo < hi { draw.between(lo, hi) } else { lo };
    let lean = range(draw, draws.lean);
    let heading = (-inward).angle() - forward * lean;
    let reach = 0.075 * lean.cos();
    let length = range(draw, draws.length);
    let place = |s: f64, off: f64| {
        let p = start.position + along * (forward * s) + inward * off;
        Pose2::new(p.x, p.y, heading)
    };
    let press = |draw: &mut Random| reach - range(draw, draws.press);
    let way = [
        place(0.0, reach + draws.off),
        place(range(draw, draws.pressed), press(draw)),
        place(0.5 * length, press(draw)),
        place(length, press(draw)),
    ];
    if way.iter().any(|p| !map.is_free(p.position())) {
        return None;
    }
    let path = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).ok()?;
    let sweep = simulate_tip_sweep(map, &Robot::default(), &path, &SweepNoise::seeded(seed)).ok()?;
    (sweep.contacts.len() > draws.fewest).then_some(sweep)
}
