//! The equilibria against the physics itself: each whisker is integrated from its base as an ordinary differential equation
//! `phi' = (p_a - p) x F / EI`, `p' = (cos phi, sin phi)`, which knows no elliptic function, and must arrive at its contact.

// Exact equality is what these tests promise: inputs repeated bit for bit, mirrors, exact zeros.
#![allow(clippy::float_cmp)]

#[path = "data/extrapolation.rs"]
mod extrapolation;
#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use extrapolation::integrate;
use random::Random;
use std::f64::consts::{FRAC_PI_2, PI};
use vibrissa_beam::beam::elastica::bend;
use vibrissa_beam::beam::{Bend, Load, Whisker, force_mode, moment_mode, point_mode};
use vibrissa_beam::plane::Vec2;

const EI: f64 = 2.8886e-4;

/// State (phi, x, y) of the whisker at arc length `s`, integrated from its base.
fn march(b: &Bend, s: f64, steps: usize) -> [f64; 3] {
    let force = b.force_vector();
    let f = |_: f64, v: [f64; 3]| {
        let lever = b.contact - Vec2::new(v[1], v[2]);
        [lever.cross(force) / EI, v[0].cos(), v[0].sin()]
    };
    integrate(&f, [0.0; 3], 0.0, s, steps)
}

/// How far the whisker misses its contact, relative to slope and deflection.
fn miss(b: &Bend) -> f64 {
    let [phi, x, y] = march(b, b.s_a, 24);
    let scale = b.phi_a.abs().min(1.0);
    let error = (phi - b.phi_a).abs().max((y - b.contact.y).abs() / b.s_a).max((x - b.contact.x).abs() / b.s_a * scale);
    if scale > 0.0 { error / scale } else { error }
}

/// The miss where the integration can tell: its errors grow like exp(t), so long whiskers (`t > 9`) pass unseen.
fn bounded_miss(b: &Bend) -> f64 {
    let t = b.s_a * (b.force.abs() / EI).sqrt();
    if t > 9.0 { 0.0 } else { miss(b) }
}

/// The moment about the base is the force times its lever.
fn check_balance(b: &Bend) {
    assert!((b.moment - b.contact.cross(b.force_vector())).abs() <= 1e-12 * b.force.abs() * b.s_a);
}

#[test]
fn the_oracle_itself_is_right() {
    // A weak load: phi_a = F s_a²/(2 EI) to first order, exact in the limit.
    let b = bend(EI, 1e-9, 0.05, 0.0).unwrap();
    let [phi, _, y] = march(&b, 0.05, 4);
    assert!((phi / (1e-9 * 0.0025 / (2.0 * EI)) - 1.0).abs() < 1e-9);
    assert!((y / (1e-9 * 0.05f64.powi(3) / (3.0 * EI)) - 1.0).abs() < 1e-9);
    // It must notice a whisker that is slightly wrong.
    let mut wrong = bend(EI, 0.1, 0.05, 0.3).unwrap();
    assert!(miss(&wrong) < 1e-12);
    wrong.phi_a *= 1.0 + 1e-9;
    assert!(miss(&wrong) > 1e-10);
}

#[test]
fn random_tilts_signs_and_sizes() {
    let mut random = Random(7);
    let (mut worst, mut count, mut tiny) = (0.0_f64, 0, 0);
    for _ in 0..4000 {
        let s_a = random.between(1e-3, 0.2);
        let t = if random.unit() < 0.5 { random.between(0.0, 6.0) } else { 10f64.powf(random.between(-6.0, 0.5)) };
        let force = random.sign() * EI * (t / s_a).powi(2);
        let beta = random.between(-PI, PI);
        let Some(b) = bend(EI, force, s_a, beta) else { continue };
        assert!(b.force == force && b.s_a == s_a && b.beta == beta);
        assert!(b.phi_a * force * beta.cos() >= 0.0, "a push bends the whisker its way");
        let error = miss(&b);
        check_balance(&b);
        worst = worst.max(error);
        count += 1;
        tiny += usize::from(b.phi_a.abs() < 1e-8);
    }
    println!("{count} whiskers, {tiny} below 1e-8 rad, worst miss {worst:.1e}");
    assert!(count > 3000 && tiny > 100);
    // Errors of the integration from the base grow like exp(t), t up to 6.
    assert!(worst < 1e-10);
}

#[test]
fn across_the_series_threshold_and_down_to_1e_minus_12() {
    let mut worst = 0.0_f64;
    for beta in [-1.57, -1.0, -0.3, 0.0, 0.5, 1.2, 1.57, 2.5, -2.0] {
        for t in [1e-6, 1e-4, 0.01, 0.2, 0.2499, 0.25, 0.2501, 0.3, 0.5, 1.0, 2.0, 3.0] {
            for sign in [1.0, -1.0] {
                let Some(b) = bend(EI, sign * EI * (t / 0.05_f64).powi(2), 0.05, beta) else { continue };
                worst = worst.max(miss(&b));
            }
        }
    }
    println!("worst miss {worst:.1e}");
    assert!(worst < 1e-12);
}

#[test]
fn fixed_directions_all_branches() {
    let mut random = Random(11);
    let whisker = Whisker::default();
    let (mut worst, mut count, mut many) = (0.0_f64, 0, 0);
    for i in 0..1500 {
        let psi = random.between(-2.0 * PI, 2.0 * PI);
        let (load, psi) = if i % 3 == 0 { (Load::Vertical, FRAC_PI_2) } else { (Load::Directed(psi), psi) };
        let s_a = random.between(0.005, 0.075);
        let t = random.between(0.01, 6.0);
        let force = random.sign() * EI * (t / s_a).powi(2);
        let bends = force_mode(&whisker, force, s_a, load).unwrap();
        assert!(!bends.is_empty(), "a fixed direction always has an equilibrium: {psi} {t}");
        many += usize::from(bends.len() > 1);
        for b in &bends {
            let direction = b.force_vector() - force * Vec2::from_angle(psi);
            assert!(direction.norm() < 1e-13 * force.abs());
            check_balance(b);
            worst = worst.max(miss(b));
            count += 1;
        }
    }
    println!("{count} whiskers, {many} loads with several, worst miss {worst:.1e}");
    assert!(many > 50);
    assert!(worst < 1e-9);
}

#[test]
fn every_answer_of_the_inverse_modes_is_an_equilibrium() {
    let mut random = Random(23);
    let whisker = Whisker::default();
    let (mut worst, mut moments, mut points) = (0.0_f64, 0, 0);
    for i in 0..1500 {
        let load = match i % 4 {
            0 => Load::Normal,
            1 => Load::Vertical,
            2 => Load::Tilted(random.between(-PI, PI)),
            _ => Load::Directed(random.between(-PI, PI)),
        };
        let s_a = random.between(0.005, 0.075);
        let moment = random.sign() * random.between(0.0, 3.5) * EI / s_a;
        for b in &moment_mode(&whisker, moment, s_a, load).unwrap() {
            assert!(b.moment == moment && b.s_a == s_a);
            check_balance(b);
            worst = worst.max(bounded_miss(b));
            moments += 1;
        }
        let contact = random.between(0.01, 0.07) * Vec2::from_angle(random.between(-PI, PI));
        for b in &point_mode(&whisker, contact, load).unwrap() {
            assert!(b.contact == contact && b.s_a <= whisker.length);
            worst = worst.max(bounded_miss(b));
            check_balance(b);
            points += 1;
        }
    }
    println!("{moments} from moments, {points} from points, worst miss {worst:.1e}");
    assert!(moments > 1000 && points > 300);
    assert!(worst < 1e-9);
}
