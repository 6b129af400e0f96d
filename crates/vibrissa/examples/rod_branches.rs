//! Counts the equilibria of random rods that the inverse modes miss. Usage: `cargo run --release --example rod_branches [-- CASES [SEED]]`
//!
//! Two oracles: shapes found forwards must be found again from their moment and from their contact; and the moments of a
//! dense scan over the force must cross a given one as often as moment mode has equilibria.

use std::f64::consts::{FRAC_PI_2, PI};
use vibrissa::beam::{Bend, Load, Rod, Whisker};
use vibrissa::tasks::batch::{all_cores, map};

/// Forces of the dense scan.
const SCAN: usize = 8000;

#[path = "../tests/data/random.rs"]
mod random;
use random::Random;

/// A rod, a load and a shape under it.
struct Case {
    whisker: Whisker,
    rod: Rod,
    load: Load,
    shape: Bend,
    unit: f64,
}

#[derive(Clone, Copy, Default)]
struct Outcome {
    of_moment: bool,
    of_point: bool,
    /// How many equilibria moment mode has less those of the dense scan, for loads that turn with the whisker.
    scan: Option<[usize; 2]>,
}

fn case(seed: u64) -> Option<Case> {
    let random = &mut Random(seed);
    let tip_ratio = if random.unit() < 0.25 { 1.0 } else { random.between(0.05, 1.0) };
    let mut whisker = Whisker { tip_ratio, ..Whisker::default() };
    if random.unit() < 0.7 {
        whisker.curvature = random.between(-12.0, 12.0);
    }
    if random.unit() < 0.3 {
        whisker.curvature_rise[0] = random.between(-200.0, 200.0);
    }
    if random.unit() < 0.7 {
        whisker.base_stiffness = 10f64.powf(random.between(-2.5, 1.0));
    }
    let rod = whisker.rod().ok()?;
    let s_a = random.between(0.005, whisker.length);
    let beta = random.between(-PI, PI);
    // The slope of a cantilever under a unit force, by its own quadrature, and the turning of its base.
    let narrowing = (1.0 - whisker.tip_ratio) / whisker.length;
    let lever = |i: i32| (f64::from(i) + 0.5) / 2000.0 * s_a;
    let soft = |s: f64| (s_a - s) / (whisker.flexural_rigidity * (1.0 - narrowing * s).powi(4));
    let softness: f64 = (0..2000).map(|i| soft(lever(i)) * s_a / 2000.0).sum();
    let unit = 1.0 / softness;
    let force = random.sign() * unit * random.between(0.05, 7.0);
    let shape = rod.force_mode(force, s_a, Load::Tilted(beta)).ok()?.pop()?;
    let psi = shape.phi_a + beta + FRAC_PI_2;
    let load = match seed % 3 {
        0 => Load::Normal,
        1 => Load::Tilted(beta),
        _ => Load::Directed(psi),
    };
    let shape = if seed.is_multiple_of(3) { rod.force_mode(force, s_a, load).ok()?.pop()? } else { shape };
    // By definition the inverse modes take the force that pushes to the side to which the moment bends.
    if matches!(load, Load::Directed(_)) && shape.force_vector().y * shape.moment < 0.0 {
        return None;
    }
    Some(Case { whisker, rod, load, shape, unit })
}

fn same(a: &Bend, b: &Bend) -> bool {
    let near = |x: f64, y: f64, scale: f64| (x - y).abs() < 1e-4 * scale;
    near(a.phi_a, b.phi_a, 1.0) && near(a.s_a, b.s_a, a.s_a) && near(a.moment, b.moment, a.moment.abs())
}

/// How often the moment crosses that of the shape, over a dense scan of forces.
fn crossings(case: &Case) -> usize {
    let Case { rod, load, shape, unit, .. } = case;
    let moment = |q: f64| {
        let bend = rod.force_mode(q * unit, shape.s_a, *load).ok().and_then(|mut bends| bends.pop());
        bend.map_or(f64::NAN, |bend| bend.moment - shape.moment)
    };
    let mut count = 0;
    let mut last = f64::NAN;
    for i in -(SCAN as i32)..=SCAN as i32 {
        // Dense near zero, and shifted so that no force is zero.
        let share = (f64::from(i) + 0.31) / SCAN as f64;
        let now = moment(share * (0.02 + 80.0 * share * share));
        count += usize::from(last * now < 0.0);
        last = now;
    }
    count
}

/// One case in so many is scanned, which takes ten times as long as all else.
const SCAN_EVERY: u64 = 8;

fn judge(seed: u64, case: &Case) -> Outcome {
    let (rod, load, shape) = (&case.rod, case.load, &case.shape);
    let of_moments = rod.moment_mode(shape.moment, shape.s_a, load).unwrap_or_default();
    let of_points = rod.point_mode(shape.contact, load).unwrap_or_default();
    let scanned = seed.is_multiple_of(SCAN_EVERY) && !matches!(load, Load::Directed(_));
    Outcome {
        of_moment: of_moments.iter().any(|b| same(b, shape)),
        of_point: of_points.iter().any(|b| same(b, shape)),
        scan: scanned.then(|| [of_moments.len(), crossings(case)]),
    }
}

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|text| text.parse::<u64>().ok());
    let (cases, seed) = (numbers.next().unwrap_or(300), numbers.next().unwrap_or(1));
    let seeds: Vec<u64> = (0..cases).map(|i| seed * 1_000_000 + i).collect();
    let outcomes = map(&seeds, all_cores(), |&seed| case(seed).map(|case| (judge(seed, &case), case)));
    let found: Vec<&(Outcome, Case)> = outcomes.iter().flatten().collect();
    let tell = |what: &str, (_, c): &&&(Outcome, Case)| {
        let Whisker { tip_ratio, curvature, curvature_rise, base_stiffness, .. } = c.whisker;
        println!(
            "{what}: {:?} F {:.4} s_a {:.4} phi_a {:.4} M0 {:.3e} | taper {tip_ratio:.3} curvature {curvature:.2} {:.1} base {base_stiffness:.4}",
            c.load, c.shape.force, c.shape.s_a, c.shape.phi_a, c.shape.moment, curvature_rise[0]
        );
    };
    let lost_moments: Vec<_> = found.iter().filter(|(o, _)| !o.of_moment).collect();
    let lost_points: Vec<_> = found.iter().filter(|(o, _)| !o.of_point).collect();
    let scanned = found.iter().filter_map(|(o, _)| o.scan);
    let fewer: Vec<_> = found.iter().filter(|(o, _)| o.scan.is_some_and(|[found, dense]| found < dense)).collect();
    let more = scanned.clone().filter(|[found, dense]| found > dense).count();
    lost_moments.iter().take(40).for_each(|c| tell("lost by moment", c));
    lost_points.iter().take(40).for_each(|c| tell("lost by point", c));
    fewer.iter().take(40).for_each(|c| tell("fewer than the scan", c));
    println!(
        "{} shapes: moment mode lost {}, point mode lost {}; of {} scans it had fewer {}, more {more}",
        found.len(),
        lost_moments.len(),
        lost_points.len(),
        scanned.count(),
        fewer.len(),
    );
}
