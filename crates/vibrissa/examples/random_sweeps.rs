//! How often the deterministic method keeps the truth: random sweeps along the walls of the built-in arena.
//!
//! `cargo run --release --example random_sweeps -- [TRIALS] [FIRST_SEED]`. Each trial presses the paper's whisker
//! against a random stretch of wall, sweeps along it with 5 % noise, and localizes without a prior. Trials that the
//! simulator refuses (contact with the whisker's side) are replaced.

#[path = "../tests/data/random.rs"]
mod random;

use random::Random;
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::plane::{Pose2, Vec2, wrap_angle};
use vibrissa::tasks::demo;
use vibrissa::tasks::simulate::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::world::{Map, Robot};
use vibrissa::{LocalizeOptions, Result, localize};

/// A sweep along a random stretch of wall, if it is one of tip contact all the way.
fn sweep(map: &Map, draw: &mut Random, seed: u64) -> Option<Sweep> {
    let samples = map.samples(1e-3);
    let start = samples[draw.between(0.0, samples.len() as f64) as usize];
    let (along, inward) = (Vec2::from_angle(start.tangent), Vec2::from_angle(start.tangent).perp());
    let forward = if draw.between(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 };
    // The whisker trails: it leans back from the direction of travel.
    let lean = draw.between(0.5, 1.1);
    let heading = (-inward).angle() - forward * lean;
    let reach = 0.075 * lean.cos();
    let length = draw.between(0.08, 0.16);
    let place = |s: f64, off: f64| {
        let p = start.position + along * (forward * s) + inward * off;
        Pose2::new(p.x, p.y, heading)
    };
    let press = |draw: &mut Random| reach - draw.between(0.004, 0.02);
    let way = [
        place(0.0, reach + 0.004),
        place(draw.between(0.005, 0.02), press(draw)),
        place(0.5 * length, press(draw)),
        place(length, press(draw)),
    ];
    if way.iter().any(|p| !map.is_free(p.position())) {
        return None;
    }
    let path = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).ok()?;
    let sweep = simulate_tip_sweep(map, &Robot::default(), &path, &SweepNoise::seeded(seed)).ok()?;
    (sweep.contacts.len() > 100).then_some(sweep)
}

/// Whether a place's extent holds the truth.
fn holds(answer: &Localization, truth: Pose2) -> bool {
    answer.hypotheses.iter().any(|h| {
        let middle = 0.5 * (h.extent.theta.lo() + h.extent.theta.hi());
        h.extent.x.contains(truth.x)
            && h.extent.y.contains(truth.y)
            && h.extent.theta.contains(middle + wrap_angle(truth.theta - middle))
    })
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (trials, first) = (arguments.next().unwrap_or(100), arguments.next().unwrap_or(1));
    let map = demo::arena()?;
    let (mut run, mut lost, mut localized, mut wrong) = (0, 0, Vec::new(), 0);
    let mut seed = first;
    while run < trials {
        seed += 1;
        let Some(sweep) = sweep(&map, &mut Random(seed.wrapping_mul(0x9e37_79b9)), seed) else { continue };
        run += 1;
        let answer = localize(&sweep.log, &map, &Robot::default(), &LocalizeOptions::default(), &mut |_| {})?;
        let truth = sweep.truth[sweep.truth.len() - 1].map_from_robot;
        let kept = holds(&answer, truth);
        lost += u64::from(!kept);
        let error = answer.estimate.map_or(f64::INFINITY, |e| e.position().distance(truth.position()));
        if answer.status == Status::Localized {
            localized.push(1e3 * error);
            wrong += u64::from(error > 5e-3);
        }
        if !kept {
            println!(
                "seed {seed}: {}, best place {:.1} mm off, {:?}",
                answer.status,
                1e3 * error,
                answer.events.last()
            );
        }
    }
    localized.sort_by(f64::total_cmp);
    let at = |share: f64| localized.get((share * localized.len() as f64) as usize).copied().unwrap_or(f64::NAN);
    println!(
        "{run} sweeps: truth outside every place in {lost}; localized {}, of these wrong {wrong}",
        localized.len()
    );
    println!("error where localized: median {:.2} mm, 95 % {:.2} mm", at(0.5), at(0.95));
    Ok(())
}
