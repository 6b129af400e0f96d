//! The general rod against the closed form where that holds, and elsewhere against the physics: each answer is integrated
//! from its base by an extrapolation method that shares nothing with the Taylor series.

// Exact equality is what these tests promise: inputs repeated bit for bit, mirrors, exact zeros.
#![allow(clippy::float_cmp, clippy::unwrap_used)]

use std::f64::consts::PI;
use vibrissa_beam::beam::rod::{Followed, Status};
use vibrissa_beam::beam::{Bend, Load, Rod, Segment, Whisker, force_mode, moment_mode, point_mode};
use vibrissa_beam::plane::Vec2;

#[path = "data/extrapolation.rs"]
mod extrapolation;
#[allow(dead_code)]
#[path = "../../vibrissa/tests/data/random.rs"]
mod random;
#[path = "data/wire.rs"]
mod wire;
use random::Random;
use wire::{EI, Wire, balanced, random_load, random_whisker, softness};

#[test]
fn a_uniform_rod_is_the_closed_form_in_every_mode_and_branch() {
    let mut random = Random(5);
    let whisker = Whisker::default();
    let rod = Rod::new(&whisker).unwrap();
    let (mut worst, mut count, mut missing, mut extra) = (0.0_f64, [0; 3], Vec::new(), Vec::new());
    for i in 0..400 {
        let load = random_load(&mut random, i);
        let s_a = random.between(0.01, 0.075);
        let t = random.between(0.01, 4.5);
        let force = random.sign() * EI * (t / s_a).powi(2);
        let moment = random.sign() * random.between(0.0, 3.2) * EI / s_a;
        let contact = random.between(0.02, 0.074) * Vec2::from_angle(random.between(-1.9, 1.9));
        let pairs = [
            (force_mode(&whisker, force, s_a, load), rod.force_mode(force, s_a, load)),
            (moment_mode(&whisker, moment, s_a, load), rod.moment_mode(moment, s_a, load)),
            (point_mode(&whisker, contact, load), rod.point_mode(contact, load)),
        ];
        for (mode, (closed, found)) in pairs.into_iter().enumerate() {
            let (closed, found) = (closed.unwrap(), found.unwrap());
            let gap = |a: &Bend, b: &Bend| {
                (a.phi_a - b.phi_a).abs() + (a.contact.distance(b.contact) + (a.s_a - b.s_a).abs()) / a.s_a
            };
            // What is said of a mode: strong loads beyond the rod's range are not compared.
            for a in closed.iter().filter(|a| a.s_a * (a.force.abs() / EI).sqrt() < 5.2) {
                count[mode] += 1;
                match found.iter().map(|b| gap(a, b)).min_by(f64::total_cmp) {
                    Some(g) if g < 1e-6 => worst = worst.max(g),
                    _ => missing.push(format!("{mode} {load:?} {a:?}")),
                }
            }
            for b in &found {
                if !closed.iter().any(|a| gap(a, b) < 1e-6) {
                    extra.push(format!("{mode} {load:?} {:?} {:?}", b.phi_a, b.contact));
                }
            }
        }
    }
    println!("{count:?} shapes, worst difference {worst:.1e}; missing {}, extra {}", missing.len(), extra.len());
    missing.iter().take(5).for_each(|m| println!("missing {m}"));
    extra.iter().take(5).for_each(|m| println!("extra {m}"));
    assert!(worst < 1e-9 && count.iter().all(|&n| n > 200));
    assert!(missing.is_empty() && extra.is_empty());
}

#[test]
fn force_mode_is_in_equilibrium_for_random_whiskers() {
    let mut random = Random(17);
    let (mut worst, mut count, mut tiny) = (0.0_f64, 0, 0);
    for i in 0..600 {
        let whisker = random_whisker(&mut random);
        let wire = Wire::whisker(&whisker);
        let s_a = random.between(0.005, 0.075);
        let q = if random.unit() < 0.7 { random.between(0.0, 6.0) } else { 10f64.powf(random.between(-10.0, 0.0)) };
        let force = random.sign() * q / softness(&whisker, s_a);
        let load = random_load(&mut random, i);
        for b in force_mode(&whisker, force, s_a, load).unwrap() {
            assert!(b.force == force && b.s_a == s_a && balanced(&b));
            let miss = wire.miss(&b);
            assert!(miss < 1e-8, "{miss:e} {whisker:?} {load:?} {b:?}");
            worst = worst.max(miss);
            count += 1;
            tiny += usize::from(q < 1e-6);
        }
    }
    println!("{count} shapes, {tiny} all but straight, worst miss {worst:.1e}");
    assert!(count > 500 && tiny > 50);
}

fn three_wires() -> (Rod, Wire) {
    let diameters = [0.8e-3, 0.5e-3, 0.3e-3];
    let second_moment = |d: f64| PI * d * d * d * d / 64.0;
    let segments = diameters.map(|d| Segment { length: 0.02, young_modulus: 52e9, second_moment: second_moment(d) });
    let curvature = vec![3.0, -200.0, 1500.0, 2e4];
    let rod = Rod::from_segments(&segments).unwrap().with_curvature(&curvature).unwrap();
    let rod = rod.with_base_stiffness(0.2).unwrap();
    let stretch = |(i, d): (usize, &f64)| (0.02 * (i + 1) as f64, 52e9 * second_moment(*d), 0.0);
    let stretches = diameters.iter().enumerate().map(stretch).collect();
    (rod, Wire { length: 0.06, stretches, curvature, base_compliance: 5.0 })
}

#[test]
fn wires_joined_and_curved_by_a_polynomial() {
    let (rod, wire) = three_wires();
    assert!((rod.length() - wire.length).abs() < 1e-15);
    let (mut worst, mut count) = (0.0_f64, 0);
    for load in [Load::Normal, Load::Vertical, Load::Tilted(0.4), Load::Directed(-1.0)] {
        for s_a in [0.01, 0.02, 0.033, 0.04, 0.05, 0.06 - 1e-12] {
            for force in [1e-6, 1e-3, 0.01, 0.1, -0.02] {
                for b in rod.force_mode(force, s_a, load).unwrap() {
                    worst = worst.max(wire.miss(&b));
                    count += 1;
                    let again = rod.point_mode(b.contact, load).unwrap();
                    worst = again.iter().map(|c| wire.miss(c)).fold(worst, f64::max);
                }
            }
        }
    }
    println!("{count} shapes, worst miss {worst:.1e}");
    assert!(count > 80 && worst < 1e-8);
}

#[test]
fn shapes_have_unit_speed_and_their_own_curvature() {
    let (rod, _) = three_wires();
    let tapered = Whisker { tip_ratio: 0.1, curvature: -8.0, base_stiffness: 0.1, ..Whisker::default() };
    let bends =
        [rod.force_mode(0.02, 0.05, Load::Normal).unwrap(), force_mode(&tapered, 0.003, 0.06, Load::Normal).unwrap()];
    for (b, length) in bends.iter().zip([0.06, 0.075]) {
        let b = &b[0];
        let points = b.shape_points(length, 4001);
        assert!(points[0].1.position.norm() < 1e-12 && (points[0].1.slope - b.base_angle()).abs() < 1e-10);
        assert!(points[4000].1.position.distance(b.tip(length)) < 1e-15);
        assert!(b.point_at(b.s_a).position.distance(b.contact) < 1e-15);
        let mut energy = 0.0;
        for w in points.windows(2) {
            let ((s0, p), (s1, q)) = (w[0], w[1]);
            assert!(((q.position - p.position).norm() / (s1 - s0) - 1.0).abs() < 1e-6);
            // Curvature jumps where the wire changes.
            let mean = 0.5 * (p.curvature + q.curvature);
            let jump = (p.curvature - q.curvature).abs();
            assert!((q.slope - p.slope - (s1 - s0) * mean).abs() <= (s1 - s0) * (0.5 * jump + 1e-4));
            energy += q.slope - p.slope;
        }
        assert!((energy - (b.point_at(length).slope - b.base_angle())).abs() < 1e-12);
    }
}

#[test]
fn energy_is_the_work_done() {
    let mut random = Random(3);
    for _ in 0..60 {
        let whisker = random_whisker(&mut random);
        let s_a = random.between(0.01, 0.075);
        let q = random.sign() * random.between(0.1, 3.0);
        let at = |q: f64| force_mode(&whisker, q / softness(&whisker, s_a), s_a, Load::Normal).unwrap().pop();
        let (Some(before), Some(b), Some(after)) = (at(0.9999 * q), at(q), at(1.0001 * q)) else { continue };
        let work = b.force_vector().dot(after.contact - before.contact);
        assert!((work / (after.energy() - before.energy()) - 1.0).abs() < 1e-4, "{whisker:?} {q}");
    }
}

#[test]
fn mirrored_rods_mirror_their_answers() {
    let mut random = Random(41);
    for _ in 0..50 {
        let whisker = random_whisker(&mut random);
        let mirrored = Whisker { curvature: -whisker.curvature, ..whisker };
        let s_a = random.between(0.01, 0.075);
        let force = random.between(0.1, 3.0) / softness(&whisker, s_a);
        let beta = random.between(-1.0, 1.0);
        let a = force_mode(&whisker, force, s_a, Load::Tilted(beta)).unwrap();
        let b = force_mode(&mirrored, -force, s_a, Load::Tilted(-beta)).unwrap();
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!((a.phi_a + b.phi_a).abs() < 1e-12 && (a.moment + b.moment).abs() < 1e-12 * a.moment.abs());
        }
    }
}

#[test]
fn branches_are_followed_with_a_status() {
    let whisker = Whisker { tip_ratio: 0.4, curvature: 5.0, base_stiffness: 0.3, ..Whisker::default() };
    let rod = Rod::new(&whisker).unwrap();
    for load in [Load::Normal, Load::Vertical, Load::Tilted(-0.3)] {
        let mut bend = rod.force_mode(1e-4, 0.06, load).unwrap().remove(0);
        let mut steps = 0;
        for i in 1..=60 {
            let moment = 2e-5 * f64::from(i);
            let Followed { bend: next, status, iterations } = rod.moment_from(moment, 0.06, load, &bend).unwrap();
            assert_eq!(status, Status::Converged, "{load:?} {moment}");
            bend = next.unwrap();
            steps += iterations;
            let cold = rod.moment_mode(moment, 0.06, load).unwrap();
            assert!((cold[0].phi_a - bend.phi_a).abs() < 1e-9, "{load:?} {moment}");
            let back = rod.point_from(bend.contact + Vec2::new(1e-6, 0.0), load, &bend).unwrap();
            assert_eq!(back.status, Status::Converged);
            let forced = rod.force_from(bend.force, 0.06, load, &bend).unwrap();
            assert!((forced.bend.unwrap().phi_a - bend.phi_a).abs() < 1e-10);
        }
        println!("{load:?}: {steps} Newton steps for 60 moments");
        assert!(steps <= 60 * 6);
        // A moment that no shape has, and a contact out of reach: no pretence.
        let lost = rod.moment_from(1.0, 0.06, load, &bend).unwrap();
        assert!(lost.status != Status::Converged || matches!(load, Load::Vertical), "{:?}", lost.status);
        assert_ne!(rod.point_from(Vec2::new(0.09, 0.0), load, &bend).unwrap().status, Status::Converged);
    }
}

/// What is followed to a contact beside is one of all shapes there, and the nearest of them to where it began.
#[test]
fn a_contact_that_is_followed_is_one_of_all_shapes() {
    let mut random = Random(41);
    let (mut followed, mut ended) = (0, 0);
    for _ in 0..60 {
        let whisker = random_whisker(&mut random);
        let rod = Rod::new(&whisker).unwrap();
        let contact = Vec2::from_angle(random.signed(0.9)) * (whisker.length * random.between(0.3, 0.9));
        for bend in rod.point_mode(contact, Load::Normal).unwrap() {
            let beside = contact + Vec2::from_angle(random.signed(PI)) * (0.01 * whisker.length);
            let Followed { bend: found, status, .. } = rod.point_from(beside, Load::Normal, &bend).unwrap();
            let Some(found) = found.filter(|_| status == Status::Converged) else {
                ended += 1;
                continue;
            };
            followed += 1;
            assert!(found.contact.distance(beside) < 1e-8, "{whisker:?} {contact:?}: {found:?}");
            let all = rod.point_mode(beside, Load::Normal).unwrap();
            let gap = |b: &Bend| (b.phi_a - found.phi_a).abs() + (b.s_a - found.s_a).abs() / found.s_a;
            let nearest = all.iter().map(gap).min_by(f64::total_cmp);
            assert!(nearest.is_some_and(|gap| gap < 1e-6), "{whisker:?} {contact:?} {nearest:?}: {found:?}");
            let from = |b: &Bend| (b.phi_a - bend.phi_a).abs() + (b.s_a - bend.s_a).abs() / bend.s_a;
            assert!(all.iter().all(|other| from(&found) <= from(other) + 1e-6), "{whisker:?} {bend:?} {found:?}");
        }
    }
    println!("{followed} followed, {ended} ended");
    assert!(followed > 60 && ended * 5 < followed, "{followed} {ended}");
}

#[test]
fn faults_are_named_and_nothing_panics() {
    let base = Whisker::default();
    let wrong = [
        (Whisker { tip_ratio: 0.0, ..base }, "tip_ratio"),
        (Whisker { tip_ratio: 1.5, ..base }, "tip_ratio"),
        (Whisker { tip_ratio: f64::NAN, ..base }, "tip_ratio"),
        (Whisker { curvature: f64::NAN, ..base }, "curvature"),
        (Whisker { curvature: 1e3, ..base }, "curvature"),
        (Whisker { base_stiffness: 0.0, ..base }, "base_stiffness"),
        (Whisker { base_stiffness: f64::NAN, ..base }, "base_stiffness"),
        (Whisker { length: -1.0, curvature: 1.0, ..base }, "length"),
        (Whisker { flexural_rigidity: 0.0, curvature: 1.0, ..base }, "flexural_rigidity"),
    ];
    for (whisker, name) in wrong {
        let error = force_mode(&whisker, 0.1, 0.05, Load::Normal).unwrap_err();
        assert!(error.is_data() && error.to_string().contains(name), "{error}");
        assert!(moment_mode(&whisker, 1e-3, 0.05, Load::Normal).is_err());
        assert!(point_mode(&whisker, Vec2::new(0.05, 0.01), Load::Normal).is_err());
    }
    assert!(Rod::from_segments(&[]).is_err());
    let bad = Segment { length: 0.01, young_modulus: -1.0, second_moment: 1e-15 };
    assert!(Rod::from_segments(&[bad]).unwrap_err().to_string().contains("segment 0: young_modulus"));
    let whisker = Whisker { tip_ratio: 0.05, curvature: -20.0, base_stiffness: 1e-3, ..base };
    for extreme in [0.0, 1e-300, 1e-150, 1e-30, 1e-3, 1.0, 1e30, 1e300] {
        for load in [Load::Normal, Load::Vertical, Load::Tilted(-2.0), Load::Directed(PI)] {
            for sign in [1.0, -1.0] {
                let _ = force_mode(&whisker, sign * extreme, 0.05, load);
                let _ = moment_mode(&whisker, sign * extreme, 0.05, load);
                let _ = point_mode(&whisker, Vec2::new(0.05, sign * extreme), load);
            }
        }
    }
}

#[test]
fn a_sharp_tip_bends_a_little_as_the_integrals_say() {
    // Small angles: slope and travel are integrals of (s_a - s) / EI and (s_a - s)² / EI, here by Simpson's rule.
    for tip_ratio in [0.05, 0.1, 0.4, 0.9, 1.0] {
        let whisker = Whisker { tip_ratio, flexural_rigidity: EI, ..Whisker::default() };
        let rod = Rod::new(&whisker).unwrap();
        for share in [0.3, 0.8, 0.99, 1.0] {
            let s_a = share * whisker.length;
            let at = |s: f64, power: i32| {
                (s_a - s).powi(power) / (EI * (1.0 - (1.0 - tip_ratio) * s / whisker.length).powi(4))
            };
            let n = 20_000;
            let simpson = |power: i32| {
                let node = |i: i32| at(s_a * f64::from(i) / f64::from(n), power);
                let inner: f64 = (1..n).map(|i| f64::from(2 + 2 * (i % 2)) * node(i)).sum();
                (inner + node(0) + node(n)) * s_a / f64::from(3 * n)
            };
            let (softness, travel) = (simpson(1), simpson(2));
            let force = -1e-8 / softness;
            let bend = rod.force_mode(force, s_a, Load::Normal).unwrap().remove(0);
            let (slope, across) = (bend.phi_a / (force * softness) - 1.0, bend.contact.y / (force * travel) - 1.0);
            assert!(slope.abs() < 1e-9 && across.abs() < 1e-9, "taper {tip_ratio} at {share}: {slope:e} {across:e}");
        }
    }
}
