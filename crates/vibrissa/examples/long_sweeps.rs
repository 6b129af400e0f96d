//! Long sweeps along the walls of given maps, for the other programs of this folder.
//!
//! `cargo run --release --example long_sweeps -- MAPS OUT [COUNT] [FIRST_SEED]` writes COUNT sweeps for every `MAP.geojson` of
//! the folder MAPS into the folder OUT: `MAP-sSEED.csv` and `MAP-sSEED.truth.tum`, beside a copy of the map. In each the
//! paper's whisker is pressed against a random stretch of wall and follows it for 0.3 to 1.2 m, at 300 Hz and 0.15 m/s, with
//! the lean and the pressure drawn anew every 40 mm and 5 % noise on readings. Sweeps in which one contact of the tip does
//! not explain most readings, or in which a wall stops the base, are replaced by those of the next seed.

#[path = "../tests/data/random.rs"]
mod random;

use random::Random;
use std::path::Path;
use vibrissa::flow::trajectory::format_tum;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::simulate::{Pace, Part, Sweep, SweepNoise, log_csv, path_through, simulate_tip_sweep};
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Result};

/// The whisker's length (m).
const LENGTH: f64 = 0.075;
/// How far apart lean and pressure are drawn anew (m).
const STRIDE: f64 = 0.04;
/// Spacing of the boundary's points (m).
const SPACING: f64 = 1e-3;
/// A sweep has at least this many rows in contact, and at least this share of them at the tip.
const FEWEST: usize = 800;
const TIP_SHARE: f64 = 0.6;

/// The sweep of a seed, if the robot can go there and touches for long.
fn sweep(map: &Map, seed: u64) -> Option<Sweep> {
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
    (!stopped && tips >= FEWEST && tips as f64 >= TIP_SHARE * sweep.truth.len() as f64).then_some(sweep)
}

fn written(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).map_err(|error| Error::data(format!("{}: {error}", path.display())))
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let mut folder = |name: &str| arguments.next().ok_or_else(|| Error::usage(format!("the folder {name} is missing")));
    let (maps, out) = (folder("MAPS")?, folder("OUT")?);
    let mut number = || arguments.next().and_then(|word| word.parse::<u64>().ok());
    let (count, first) = (number().unwrap_or(8), number().unwrap_or(1));
    std::fs::create_dir_all(&out).map_err(|error| Error::data(error.to_string()))?;
    let files = std::fs::read_dir(&maps).map_err(|error| Error::data(error.to_string()))?;
    let mut paths: Vec<_> = files.filter_map(|file| Some(file.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "geojson"));
    paths.sort();
    for path in paths {
        let map = Map::read(&path)?;
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        std::fs::copy(&path, Path::new(&out).join(format!("{name}.geojson")))
            .map_err(|error| Error::data(error.to_string()))?;
        let found = (first..first + 100 * count).filter_map(|seed| Some((seed, sweep(&map, seed)?)));
        for (seed, sweep) in found.take(count as usize) {
            let beside = |ending: &str| Path::new(&out).join(format!("{name}-s{seed}.{ending}"));
            written(&beside("csv"), &log_csv(&sweep.log))?;
            written(&beside("truth.tum"), &format_tum(&sweep.truth))?;
            println!("{name}-s{seed}: {} rows, {} touches", sweep.truth.len(), sweep.contacts.len());
        }
    }
    Ok(())
}
