//! Whether the probabilistic method's regions and weights mean what they say: random sweeps on random maps.
//!
//! `cargo run --release --example calibration_runs -- [TRIALS] [FIRST_SEED] [TOLERATED_SHARE] [ODOMETRY]`. Each trial draws an arena with bays and
//! bumps, presses the paper's whisker against a random stretch of wall, sweeps along it with the declared noise, and
//! localizes without a prior. It counts how often the 95 % region of a place holds the truth, how often the heaviest
//! place is the true one against how often its weight says so, and the errors where the verdict was `localized`. With ODOMETRY,
//! a bound that is declared for it, the odometry of each log is wrong by shares drawn evenly within it.

#[path = "../tests/data/mistaken.rs"]
mod mistaken;
#[path = "../tests/data/random.rs"]
mod random;
#[path = "../tests/data/random_arena.rs"]
mod random_arena;
#[path = "../tests/data/region.rs"]
mod region;

use mistaken::mistaken;
use random::Random;
use random_arena::{arena, sweep};
use region::{CHI2_95, distance};
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Hypothesis, Status};
use vibrissa::plane::wrap_angle;
use vibrissa::world::Robot;
use vibrissa::{Method, Result, localize};

/// The value below which `share` of the sorted values lie.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(f64::NAN)
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (trials, first) = (arguments.next().unwrap_or(200), arguments.next().unwrap_or(1));
    let mut options = ProbabilisticOptions::exact();
    if let Some(share) = std::env::args().nth(3).and_then(|a| a.parse().ok()) {
        options.tolerated_share = share;
    }
    let method = Method::Probabilistic(options);
    let mut robot = Robot::default();
    if let Some(bound) = std::env::args().nth(4).and_then(|a| a.parse().ok()) {
        (robot.odometry.translation_relative, robot.odometry.rotation_relative) = (bound, bound);
    }
    let (mut run, mut held, mut near, mut verdicts) = (0, 0, 0, [0; 4]);
    let (mut errors, mut turns, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
    let (mut promised, mut kept, mut wrong) = (0.0, 0, 0);
    let mut seed = first;
    while run < trials {
        seed += 1;
        let mut draw = Random(seed.wrapping_mul(0x9e37_79b9));
        let map = arena(&mut draw)?;
        let Some(sweep) = sweep(&map, &mut draw, seed) else { continue };
        let (place, turn) = (robot.odometry.translation_relative, robot.odometry.rotation_relative);
        let log = if place > 0.0 {
            // Within a disc, and between two bounds.
            let (off, way) = (place * draw.between(0.0, 1.0).sqrt(), draw.between(0.0, core::f64::consts::TAU));
            mistaken(&sweep.log, [off * way.cos(), off * way.sin(), draw.between(-turn, turn)])
        } else {
            sweep.log.clone()
        };
        let answer = match localize(&log, &map, &robot, &method, &mut |_| {}) {
            Ok(answer) => answer,
            // The simulated whisker was bent further than its tip can be held: no sweep to judge by.
            Err(error) => {
                println!("seed {seed}: left out: {error}");
                continue;
            }
        };
        run += 1;
        let truth = sweep.truth[sweep.truth.len() - 1].map_from_robot;
        let nearest = answer.hypotheses.iter().map(|h| distance(h, truth)).fold(f64::INFINITY, f64::min);
        held += u64::from(nearest <= CHI2_95);
        if run.is_multiple_of(50) {
            println!("{run} sweeps so far, up to seed {seed}: truth in a region {held}");
        }
        let off = |h: &Hypothesis| h.pose.position().distance(truth.position());
        near += u64::from(answer.hypotheses.iter().any(|h| off(h) < 5e-3));
        verdicts[answer.status as usize] += 1;
        let Some(best) = answer.hypotheses.first() else {
            println!("seed {seed}: {} {:?}", answer.status, answer.events.last());
            continue;
        };
        promised += best.weight;
        kept += u64::from(off(best) < 5e-3);
        if answer.status == Status::Localized {
            errors.push(1e3 * off(best));
            turns.push(wrap_angle(best.pose.theta - truth.theta).abs().to_degrees());
            bounds.extend(best.bound().map(|b| 1e3 * b.0));
            wrong += u64::from(off(best) > 5e-3);
        }
        if nearest > CHI2_95 {
            println!("seed {seed}: {}, best {:.2} mm off, chi² {nearest:.1}", answer.status, 1e3 * off(best));
        }
    }
    let count = run as f64;
    println!("{run} sweeps: localized {}, ambiguous {}, inconsistent {}", verdicts[0], verdicts[1], verdicts[2]);
    println!(
        "truth in a place's 95 % region: {:.1} %; within 5 mm of a place: {:.1} %",
        100.0 * held as f64 / count,
        100.0 * near as f64 / count
    );
    println!(
        "heaviest place true: {:.1} %, by its weight {:.1} %",
        100.0 * kept as f64 / count,
        100.0 * promised / count
    );
    [&mut errors, &mut turns, &mut bounds].into_iter().for_each(|values| values.sort_by(f64::total_cmp));
    println!(
        "localized, {wrong} of them wrong: median {:.3} mm, 95 % {:.3} mm; heading {:.3} deg, 95 % {:.3} deg; median bound {:.3} mm",
        quantile(&errors, 0.5),
        quantile(&errors, 0.95),
        quantile(&turns, 0.5),
        quantile(&turns, 0.95),
        quantile(&bounds, 0.5)
    );
    Ok(())
}
