//! The table of all single contacts against the closed form: no equilibrium is left out, and little is added.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use core::f64::consts::{FRAC_PI_2, PI};
use random::Random;
use vibrissa::beam::elastica;
use vibrissa::beam::press::{PressEntry, PressSlice, PressTable};
use vibrissa::plane::Vec2;

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
    let trials = 15_000;
    let table = PressTable::new(columns, rows, friction, steepest);
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
    no_contact_is_left_out(96, 64, 0.3, 2.2, 2);
}

#[test]
fn coarse_tables_leave_out_nothing_either() {
    no_contact_is_left_out(16, 16, 0.0, 2.2, 3);
    no_contact_is_left_out(12, 12, 0.5, 1.5, 4);
}

#[test]
fn little_is_added() {
    let table = PressTable::new(96, 64, 0.0, 2.2);
    for (mu, most) in [(0.02, 2e-3), (0.2, 2e-3), (0.7, 2e-3), (1.4, 4e-3)] {
        let slice = table.slice(0.95 * mu, 1.05 * mu);
        let mut radii: Vec<f64> = slice.entries().iter().map(|e| e.radius).collect();
        radii.sort_by(f64::total_cmp);
        let at = |share: f64| radii[((radii.len() - 1) as f64 * share) as usize];
        println!("mu {mu}: {} entries, radius {:.1e} {:.1e} {:.1e}", radii.len(), at(0.5), at(0.9), at(1.0));
        assert!(at(0.5) < most, "{}", at(0.5));
    }
}
