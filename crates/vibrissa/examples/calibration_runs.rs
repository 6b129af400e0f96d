//! Whether the probabilistic method's regions and weights mean what they say: random sweeps on random maps.
//!
//! `cargo run --release --example calibration_runs -- [TRIALS] [FIRST_SEED]`. Each trial draws an arena with bays and
//! bumps, presses the paper's whisker against a random stretch of wall, sweeps along it with the declared noise, and
//! localizes without a prior. It counts how often the 95 % region of a place holds the truth, how often the heaviest
//! place is the true one against how often its weight says so, and the errors where the verdict was `localized`.

#[path = "../tests/data/random.rs"]
mod random;

use random::Random;
use vibrissa::flow::pose::{Hypothesis, Method, Status};
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::tasks::simulate::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Error, LocalizeOptions, Result, localize};

/// The 95 % point of chi² for three degrees of freedom.
const CHI2_95: f64 = 7.815;

/// A closed arena whose radius is a random sum of waves.
fn arena(draw: &mut Random) -> Result<Map> {
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

/// A sweep along a random stretch of wall, if it is one of tip contact all the way.
fn sweep(map: &Map, draw: &mut Random, seed: u64) -> Option<Sweep> {
    let samples = map.samples(1e-3);
    let start = samples[draw.between(0.0, samples.len() as f64) as usize];
    let (along, inward) = (Vec2::from_angle(start.tangent), Vec2::from_angle(start.tangent).perp());
    let forward = draw.sign();
    let lean = draw.between(0.5, 1.0);
    let heading = (-inward).angle() - forward * lean;
    let reach = 0.075 * lean.cos();
    let length = draw.between(0.10, 0.20);
    let place = |s: f64, off: f64| {
        let p = start.position + along * (forward * s) + inward * off;
        Pose2::new(p.x, p.y, heading)
    };
    let press = |draw: &mut Random| reach - draw.between(0.006, 0.02);
    let way = [
        place(0.0, reach + 0.006),
        place(0.01, press(draw)),
        place(0.5 * length, press(draw)),
        place(length, press(draw)),
    ];
    if way.iter().any(|p| !map.is_free(p.position())) {
        return None;
    }
    let path = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).ok()?;
    let sweep = simulate_tip_sweep(map, &Robot::default(), &path, &SweepNoise::seeded(seed)).ok()?;
    (sweep.contacts.len() > 150).then_some(sweep)
}

/// The squared distance of the truth from a place in its own standard deviations; infinite without a covariance.
fn distance(place: &Hypothesis, truth: Pose2) -> f64 {
    let Some(c) = place.covariance else { return f64::INFINITY };
    let d = [truth.x - place.pose.x, truth.y - place.pose.y, wrap_angle(truth.theta - place.pose.theta)];
    let det = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let solved = |k: usize| {
        let mut replaced = c;
        (0..3).for_each(|i| replaced[i][k] = d[i]);
        det(replaced) / det(c)
    };
    (0..3).map(|k| d[k] * solved(k)).sum()
}

/// The value below which `share` of the sorted values lie.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(f64::NAN)
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map_while(|a| a.parse::<u64>().ok());
    let (trials, first) = (arguments.next().unwrap_or(200), arguments.next().unwrap_or(1));
    let options = LocalizeOptions { method: Method::Probabilistic, ..LocalizeOptions::default() };
    let (mut run, mut held, mut near, mut verdicts) = (0, 0, 0, [0; 4]);
    let (mut errors, mut turns, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
    let (mut promised, mut kept, mut wrong) = (0.0, 0, 0);
    let mut seed = first;
    while run < trials {
        seed += 1;
        let mut draw = Random(seed.wrapping_mul(0x9e37_79b9));
        let map = arena(&mut draw)?;
        let Some(sweep) = sweep(&map, &mut draw, seed) else { continue };
        let answer = match localize(&sweep.log, &map, &Robot::default(), &options, &mut |_| {}) {
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
