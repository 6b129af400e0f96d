//! The table of all single contacts against the closed form: no equilibrium is left out, and little is added.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use core::f64::consts::{FRAC_PI_2, PI};
use random::Random;
use vibrissa_beam::beam::elastica;
use vibrissa_beam::beam::press::{PressEntry, PressSlice, PressTable};
use vibrissa_beam::plane::Vec2;

/// Whether an entry holds a contact: over the share of the moments there is nothing to search, it is linear.
fn holds(entry: &PressEntry, psi: f64, p: Vec2) -> bool {
    let rest = p - entry.center - entry.by_direction * (psi - entry.middle);
    let square = entry.by_moment.norm_squared();
    let share = if square > 0.0 { (rest.dot(entry.by_moment) / square).clamp(-1.0, 1.0) } else { 0.0 };
    (psi - entry.middle).abs() <= entry.half + 1e-12 && (rest - entry.by_moment * share).norm() <= entry.radius
}

fn known(slice: &PressSlice, psi: f64, p: Vec2) -> bool {
    slice.between(psi, psi).iter().any(|entry| holds(entry, psi, p))
}

/// An interval of a few percent around a moment, sometimes with the moment at its very end.
fn around(draw: &mut Random, mu: f64) -> (f64, f64) {
    let (below, above) = (draw.between(0.0, 0.06), draw.between(0.0, 0.06));
    let floor = draw.between(0.0, 1.0) * 0.01;
    match draw.between(0.0, 3.0) as u32 {
        0 => (mu, mu * (1.0 + above) + floor),
        1 => ((mu * (1.0 - below) - floor).max(0.0), mu),
        _ => ((mu * (1.0 - below) - floor).max(0.0), mu * (1.0 + above) + floor),
    }
}

fn no_contact_is_left_out(columns: usize, rows: usize, friction: f64, steepest: f64, seed: u64) {
    no_contact_is_left_out_of(&PressTable::new(columns, rows, friction, steepest), friction, steepest, seed);
}

fn no_contact_is_left_out_of(table: &PressTable, friction: f64, steepest: f64, seed: u64) {
    let trials = 15_000;
    let mut draw = Random(seed);
    let (mut tips, mut sides) = (0, 0);
    for _ in 0..trials {
        let tip = draw.unit() < 0.5;
        // Towards the ends of the range, too.
        let skew = |draw: &mut Random| if draw.unit() < 0.3 { draw.unit().powi(4) } else { draw.unit() };
        let (beta, s_a) = if tip {
            let share = skew(&mut draw);
            let share = if draw.unit() < 0.5 { share } else { 1.0 - share };
            (-friction + (FRAC_PI_2 + friction) * share, 1.0)
        } else {
            (draw.signed(friction), skew(&mut draw).max(1e-6))
        };
        let t = draw.between(0.0, 6.0);
        let Some(bend) = elastica::bend(1.0, (t / s_a).powi(2), s_a, beta) else { continue };
        if bend.moment <= 0.0 || bend.phi_a > steepest {
            continue;
        }
        let (lo, hi) = around(&mut draw, bend.moment);
        let slice = table.slice(lo, hi);
        // Tips are known by the direction of the force, sides by the whisker's normal.
        let psi = bend.phi_a + FRAC_PI_2 + if tip { beta } else { 0.0 };
        assert!(
            known(&slice, psi, bend.contact),
            "{} psi {psi} beta {beta} s_a {s_a} t {t} moment {} in {lo}..{hi}: {:?}; {:?}",
            if tip { "tip" } else { "side" },
            bend.moment,
            bend.contact,
            slice.between(psi, psi)
        );
        if tip { tips += 1 } else { sides += 1 }
    }
    assert!(tips > trials / 8 && sides > trials / 8, "{tips} {sides}");
}

#[test]
fn no_contact_is_left_out_without_friction() {
    no_contact_is_left_out(96, 64, 0.0, PI, 1);
}

#[test]
fn no_contact_is_left_out_with_friction() {
    no_contact_is_left_out(96, 64, 0.3, PI, 2);
}

#[test]
fn coarse_tables_leave_out_nothing_either() {
    no_contact_is_left_out(16, 16, 0.0, PI, 3);
    no_contact_is_left_out(12, 12, 0.5, 1.5, 4);
}

#[test]
fn tables_made_of_finer_ones_leave_out_nothing_either() {
    let fine = PressTable::new(64, 64, 0.2, PI);
    let [half, quarter, eighth] = {
        let half = fine.coarser();
        let quarter = half.coarser();
        [half, quarter.clone(), quarter.coarser()]
    };
    for (table, seed) in [(&half, 13), (&quarter, 14), (&eighth, 15)] {
        no_contact_is_left_out_of(table, 0.2, PI, seed);
        no_inflection_is_left_out_of(table, 0.2, PI, seed);
    }
    // The coarsest that localization uses.
    for (friction, steepest, seed) in [(0.0, PI, 16), (0.5, PI, 17), (0.0, 2.2, 18), (0.98, PI, 19)] {
        let table = PressTable::new(16, 32, friction, steepest);
        for table in [&table.coarser(), &table] {
            no_contact_is_left_out_of(table, friction, steepest, seed);
            no_inflection_is_left_out_of(table, friction, steepest, seed);
        }
    }
    // They are indeed coarser, and one with an odd number of rows stays as it is.
    let entries = |table: &PressTable| table.slice(0.5, 0.55).entries().len();
    assert!(entries(&half) > entries(&quarter) && entries(&quarter) > entries(&eighth));
    let odd = PressTable::new(16, 15, 0.0, 2.2);
    assert_eq!(odd.slice(0.5, 0.55), odd.coarser().slice(0.5, 0.55));
}

/// A whisker of unit length and stiffness as a pendulum that starts from rest `amplitude` before its balance, after the
/// time `t`: how far from the balance it is, its speed, how often it came to rest, and the tip in the base's frame.
fn swung(amplitude: f64, t: f64) -> (f64, f64, usize, Vec2) {
    let steps = 1500;
    let h = t / f64::from(steps);
    let rate = |[w, v, ..]: [f64; 4]| [v, -w.sin(), w.cos(), w.sin()];
    let step = |y: [f64; 4], d: [f64; 4], by: f64| [0, 1, 2, 3].map(|i| y[i] + by * d[i]);
    let mut y = [-amplitude, 0.0, 0.0, 0.0];
    let mut rests = 0;
    for _ in 0..steps {
        let a = rate(y);
        let b = rate(step(y, a, 0.5 * h));
        let c = rate(step(y, b, 0.5 * h));
        let d = rate(step(y, c, h));
        let next = step(y, [0, 1, 2, 3].map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0), h);
        rests += usize::from(y[1] * next[1] < 0.0);
        y = next;
    }
    // The slope is the base's angle less the one on the way; the integrals turn with the base.
    let (sin, cos) = y[0].sin_cos();
    (y[0], y[1], rests, Vec2::new(cos * y[2] + sin * y[3], sin * y[2] - cos * y[3]) * (1.0 / t))
}

#[test]
fn the_pendulum_of_these_tests_is_the_closed_form() {
    let bend = elastica::bend(1.0, 4.0, 1.0, 0.3).unwrap();
    let (w, v, rests, tip) = swung(FRAC_PI_2 - 0.3, 2.0);
    assert!((2.0 * v - bend.moment).abs() < 1e-9 && rests == 0, "{} {}", 2.0 * v, bend.moment);
    assert!((w + FRAC_PI_2 - 0.3 - bend.phi_a).abs() < 1e-9 && tip.distance(bend.contact) < 1e-9);
}

/// Shapes with one inflection, tip or held by friction on the side: by integration, which knows no elliptic function.
fn no_inflection_is_left_out(columns: usize, rows: usize, friction: f64, steepest: f64, seed: u64) {
    no_inflection_is_left_out_of(&PressTable::new(columns, rows, friction, steepest), friction, steepest, seed);
}

fn no_inflection_is_left_out_of(table: &PressTable, friction: f64, steepest: f64, seed: u64) {
    let mut draw = Random(seed);
    let (mut tips, mut sides) = (0, 0);
    while tips < 800 {
        let tip = friction == 0.0 || draw.unit() < 0.6;
        let beta = if tip { draw.between(-friction, FRAC_PI_2) } else { draw.signed(friction) };
        let s_a = if tip { 1.0 } else { draw.between(0.01, 1.0) };
        let amplitude = FRAC_PI_2 - beta;
        let t = draw.between(3.0, 9.0);
        let (w, speed, rests, contact) = swung(amplitude, t);
        let slope = w + amplitude;
        if rests != 1 || slope > steepest || speed >= 0.0 {
            continue;
        }
        let (lo, hi) = around(&mut draw, -speed * t / s_a);
        let slice = table.slice(-hi, -lo);
        let psi = slope + FRAC_PI_2 + if tip { beta } else { 0.0 };
        let contact = contact * s_a;
        let held = slice.between(psi, psi).iter().any(|entry| entry.inflected && holds(entry, psi, contact));
        assert!(held, "psi {psi} beta {beta} s_a {s_a} t {t} moment {}: {contact:?}", speed * t / s_a);
        if tip { tips += 1 } else { sides += 1 }
    }
    assert!(friction == 0.0 || sides > 150, "{sides}");
}

#[test]
fn no_inflection_is_left_out_of_any_table() {
    no_inflection_is_left_out(64, 48, 0.0, PI, 5);
    no_inflection_is_left_out(64, 48, 0.5, PI, 6);
    no_inflection_is_left_out(8, 16, 0.0, 2.2, 7);
    no_inflection_is_left_out(24, 24, 0.2, PI, 8);
}

#[test]
fn little_is_added() {
    let table = PressTable::new(96, 64, 0.0, PI);
    for (mu, most) in [(0.02, 2e-3), (0.2, 2e-3), (0.7, 2e-3), (1.4, 4e-3)] {
        let slice = table.slice(0.95 * mu, 1.05 * mu);
        let mut radii: Vec<f64> = slice.entries().iter().map(|e| e.radius).collect();
        radii.sort_by(f64::total_cmp);
        let at = |share: f64| radii[((radii.len() - 1) as f64 * share) as usize];
        println!("mu {mu}: {} entries, radius {:.1e} {:.1e} {:.1e}", radii.len(), at(0.5), at(0.9), at(1.0));
        assert!(at(0.5) < most, "{}", at(0.5));
    }
}
