//! The polynomial shapes against the closed form in elliptic functions, which shares nothing with them, over the whole
//! first mode.

// Exact equality is what these tests promise: inputs repeated bit for bit, mirrors, exact zeros.
#![allow(clippy::float_cmp, clippy::unwrap_used)]

use vibrissa_beam::beam::elastica::bend;
use vibrissa_beam::beam::normal::{
    Branch, NormalBend, by_force, by_force_batch, by_moment, by_moment_batch, by_point, by_point_batch, largest_angle,
    largest_moment,
};
use vibrissa_beam::beam::{Load, Whisker, moment_mode, point_mode};
use vibrissa_beam::plane::Vec2;

const EI: f64 = 2.8886e-4;
const S_A: f64 = 0.06;
/// `2 K(1/2)²`.
const LAST_Q: f64 = 6.875_185_818_020_372;

fn force(q: f64) -> f64 {
    2.0 * EI * q / (S_A * S_A)
}

/// Errors of slope, x, y, moment and energy: relative while the whisker is little bent, then of its size.
fn errors(a: &NormalBend, phi_a: f64, contact: Vec2, moment: f64, energy: f64) -> [f64; 5] {
    let small = phi_a.abs().min(1.0);
    [
        (a.phi_a - phi_a) / phi_a.abs(),
        (a.contact.x - contact.x) / a.s_a,
        (a.contact.y - contact.y) / (a.s_a * small),
        (a.moment - moment) / (EI / a.s_a * small),
        (a.energy() - energy) / (EI / a.s_a * small * small),
    ]
    .map(f64::abs)
}

fn grow(worst: &mut [f64; 5], errors: [f64; 5]) {
    for (w, e) in worst.iter_mut().zip(errors) {
        *w = if e.is_nan() { f64::INFINITY } else { w.max(e) };
    }
}

#[test]
fn force_mode_over_the_whole_range() {
    let (mut worst, mut turned) = ([0.0; 5], 0.0_f64);
    let linear = (1..=200_000).map(|i| LAST_Q * f64::from(i) / 200_001.0);
    let tiny = (0..300).map(|i| 10f64.powf(-f64::from(i)));
    for q in linear.chain(tiny) {
        for sign in [1.0, -1.0] {
            let a = by_force(EI, sign * force(q), S_A).unwrap();
            let b = bend(EI, sign * force(q), S_A, 0.0).unwrap();
            assert!(a.force == b.force && a.s_a == S_A);
            if q > 1e-140 {
                grow(&mut worst, errors(&a, b.phi_a, b.contact, b.moment, b.energy()));
            }
            turned = turned.max(a.tangent.distance(Vec2::from_angle(b.phi_a)));
            turned = turned.max(a.tip(0.075).distance(b.tip(0.075)) / 0.075);
        }
    }
    println!("force mode: worst of slope, x, y, moment, energy {:?}", worst.map(|e| format!("{e:.1e}")));
    println!("direction and tip {turned:.1e}");
    assert!(turned < 2e-13);
    assert!(worst.iter().all(|e| *e < 2e-13));
}

#[test]
fn moment_mode_on_both_branches() {
    let whisker = Whisker::default();
    let (mut worst, mut force_error) = ([0.0; 5], 0.0_f64);
    // Conditioning: near the fold a relative error e of the moment moves the slope by sqrt(e).
    for i in 1..4000 {
        let share = f64::from(i) / 4000.0;
        let moment = share * largest_moment() * EI / S_A;
        let reference = moment_mode(&whisker, -moment, S_A, Load::Normal).unwrap();
        assert_eq!(reference.len(), 2);
        for (branch, b) in [Branch::Least, Branch::Curled].into_iter().zip(&reference) {
            let Some(a) = by_moment(EI, -moment, S_A, branch) else { panic!("{share} {branch:?}") };
            let ill = (1.0 - share).sqrt();
            grow(&mut worst, errors(&a, b.phi_a, b.contact, b.moment, b.energy()).map(|e| e * ill));
            force_error = force_error.max((a.force / b.force - 1.0).abs() * ill);
        }
    }
    for k in 3..150 {
        let moment = 10f64.powi(-k);
        let a = by_moment(EI, moment, S_A, Branch::Least).unwrap();
        let b = bend(EI, a.force, S_A, 0.0).unwrap();
        assert!((b.moment / moment - 1.0).abs() < 1e-13 && (a.phi_a / b.phi_a - 1.0).abs() < 1e-13, "{k}");
    }
    println!("force of moment mode {force_error:.1e}");
    println!("moment mode: worst of slope, x, y, moment, energy {:?}", worst.map(|e| format!("{e:.1e}")));
    assert!(force_error < 1e-12 && worst.iter().all(|e| *e < 1e-12));
    assert!(by_moment(EI, 1.000_001 * largest_moment() * EI / S_A, S_A, Branch::Least).is_none());
}

#[test]
fn point_mode_on_both_branches() {
    let whisker = Whisker { length: 10.0, ..Whisker::default() };
    let (mut worst, mut force_error) = ([0.0; 5], 0.0_f64);
    for i in 1..4000 {
        let angle = largest_angle() * f64::from(i) / 4000.0;
        let point = 0.03 * Vec2::from_angle(-angle);
        let reference = point_mode(&whisker, point, Load::Normal).unwrap();
        assert_eq!(reference.len(), 1 + usize::from(angle > std::f64::consts::FRAC_PI_2), "{angle}");
        assert_eq!(by_point(EI, 10.0, point, Branch::Curled).is_some(), reference.len() == 2);
        for (branch, b) in [Branch::Least, Branch::Curled].into_iter().zip(&reference) {
            let a = by_point(EI, 10.0, point, branch).unwrap();
            let ill = (1.0 - angle / largest_angle()).sqrt();
            grow(&mut worst, errors(&a, b.phi_a, b.contact, b.moment, b.energy()).map(|e| e * ill));
            force_error = force_error.max((a.force / b.force - 1.0).abs().max((a.s_a / b.s_a - 1.0).abs()) * ill);
            assert!(a.contact == point);
        }
    }
    for k in 3..150 {
        let point = Vec2::new(0.03, 10f64.powi(-k));
        let a = by_point(EI, 0.075, point, Branch::Least).unwrap();
        let b = bend(EI, a.force, a.s_a, 0.0).unwrap();
        assert!((b.contact.y / point.y - 1.0).abs() < 1e-12, "{k}");
    }
    println!("force of point mode {force_error:.1e}");
    println!("point mode: worst of slope, x, y, moment, energy {:?}", worst.map(|e| format!("{e:.1e}")));
    assert!(force_error < 1e-12 && worst.iter().all(|e| *e < 1e-12));
}

#[test]
fn the_curled_shape_without_a_moment_is_the_end_of_the_first_mode() {
    let end = by_force(EI, force(LAST_Q), S_A).unwrap();
    for moment in [0.0, 5e-324, 1e-310, 1e-301] {
        let curled = by_moment(EI, moment, S_A, Branch::Curled).unwrap();
        let off = curled.contact.distance(end.contact) / S_A;
        assert!(off < 1e-12 && curled.contact.norm() <= S_A, "{moment}: {curled:?}, {end:?}");
        let least = by_moment(EI, moment, S_A, Branch::Least).unwrap();
        assert!(least.contact.distance(Vec2::new(S_A, 0.0)) / S_A < 1e-12, "{moment}: {least:?}");
    }
}

#[test]
fn what_is_beyond_the_range_of_numbers_has_no_shape() {
    assert!(by_moment(f64::MAX, 2e-3, S_A, Branch::Least).is_none());
    assert!(by_moment(EI, 2e-3, 5e-324, Branch::Least).is_none());
    assert!(by_moment(EI, 2e-3, 5e-324, Branch::Curled).is_none());
    assert!(by_moment(EI, 0.0, f64::MAX, Branch::Curled).is_none());
    assert!(by_point(f64::MAX, 0.075, Vec2::new(0.06, -0.01), Branch::Least).is_none());
    assert!(by_point(EI, 0.075, Vec2::new(0.0, 5e-324), Branch::Least).is_none());
}

#[test]
fn what_has_no_shape_has_none() {
    assert!(by_force(EI, force(1.000_001 * LAST_Q), S_A).is_none());
    assert!(by_force(EI, force(LAST_Q), S_A).is_some());
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300];
    for b in bad {
        assert!(by_force(EI, b, S_A).is_none() && by_moment(EI, b, S_A, Branch::Least).is_none());
        assert!(by_point(EI, 0.075, Vec2::new(b, 0.01), Branch::Least).is_none());
        assert!(by_point(EI, 0.075, Vec2::new(0.01, b), Branch::Curled).is_none());
    }
    for s_a in [0.0, -1.0, f64::NAN] {
        assert!(by_force(EI, 0.1, s_a).is_none() && by_moment(EI, 1e-3, s_a, Branch::Curled).is_none());
    }
    for ei in [0.0, -1.0, f64::NAN] {
        assert!(by_force(ei, 0.1, S_A).is_none() && by_moment(ei, 1e-3, S_A, Branch::Least).is_none());
        assert!(by_point(ei, 0.075, Vec2::new(0.03, 0.01), Branch::Least).is_none());
    }
    assert!(by_point(EI, 0.075, Vec2::ZERO, Branch::Least).is_none());
    assert!(by_point(EI, 0.075, Vec2::new(-0.01, 0.0), Branch::Least).is_none());
    assert!(by_point(EI, 0.075, Vec2::new(0.08, 0.0), Branch::Least).is_none());
    let straight = by_point(EI, 0.075, Vec2::new(0.075, 0.0), Branch::Least).unwrap();
    assert!(straight.force == 0.0 && straight.s_a == 0.075 && straight.phi_a == 0.0);
    for tiny in [0.0, 1e-310] {
        let a = by_moment(EI, tiny, 0.05, Branch::Least).unwrap();
        assert!(a.contact.distance(Vec2::new(0.05, 0.0)) < 1e-14 && a.phi_a.abs() < 1e-300, "{a:?}");
    }
    let unloaded = by_force(EI, 0.0, 0.05).unwrap();
    assert!(
        unloaded.contact.distance(Vec2::new(0.05, 0.0)) < 3e-15
            && unloaded.contact.y == 0.0
            && unloaded.moment == 0.0
            && unloaded.energy() == 0.0
    );
}

#[test]
fn batches_give_the_same_bits() {
    let n = 1000;
    let forces: Vec<f64> = (0..n).map(|i| force(8.0 * f64::from(i - 500) / 500.0)).collect();
    let lengths = vec![S_A; n as usize];
    let mut out = vec![NormalBend::default(); n as usize];
    by_force_batch(EI, &forces, &lengths, &mut out);
    for (a, &f) in out.iter().zip(&forces) {
        assert_eq!(by_force(EI, f, S_A), if a.phi_a.is_nan() { None } else { Some(*a) });
    }
    let moments: Vec<f64> = out.iter().map(|a| a.moment).collect();
    let points: Vec<Vec2> = out.iter().map(|a| a.contact).collect();
    for branch in [Branch::Least, Branch::Curled] {
        by_moment_batch(EI, &moments, &lengths, branch, &mut out);
        for (a, &m) in out.iter().zip(&moments) {
            assert_eq!(by_moment(EI, m, S_A, branch), if a.phi_a.is_nan() { None } else { Some(*a) });
        }
        by_point_batch(EI, 0.075, &points, branch, &mut out);
        for (a, &p) in out.iter().zip(&points) {
            assert_eq!(by_point(EI, 0.075, p, branch), if a.phi_a.is_nan() { None } else { Some(*a) });
        }
    }
}
