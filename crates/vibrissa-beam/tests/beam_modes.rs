//! The modes against each other and against brute force.

// Exact equality is what these tests promise: inputs repeated bit for bit, mirrors, exact zeros.
#![allow(clippy::float_cmp)]

use std::f64::consts::{FRAC_PI_2, PI};
use vibrissa_beam::beam::elastica::bend;
use vibrissa_beam::beam::{Bend, Load, Whisker, force_mode, moment_mode, point_mode, tip_mode};
use vibrissa_beam::plane::Vec2;

const EI: f64 = 2.8886e-4;
const LOADS: [Load; 6] =
    [Load::Normal, Load::Vertical, Load::Tilted(0.4), Load::Tilted(-0.9), Load::Tilted(2.8), Load::Directed(2.2)];

fn close(a: &Bend, b: &Bend, tolerance: f64) -> bool {
    (a.phi_a - b.phi_a).abs() <= tolerance * b.phi_a.abs()
        && (a.force - b.force).abs() <= tolerance * b.force.abs()
        && a.contact.distance(b.contact) <= tolerance * b.s_a
        && (a.moment - b.moment).abs() <= tolerance * b.moment.abs()
        && (a.s_a - b.s_a).abs() <= tolerance * b.s_a
}

#[test]
fn modes_find_each_others_equilibria() {
    let whisker = Whisker::default();
    for load in LOADS {
        for t in [1e-8, 1e-5, 1e-3, 0.1, 0.24, 0.26, 0.7, 1.3, 1.9, 2.4, 2.9] {
            for sign in [1.0, -1.0] {
                let force = sign * EI * (t / 0.06_f64).powi(2);
                let Some(b) = force_mode(&whisker, force, 0.06, load).unwrap().into_iter().next() else { continue };
                // Inverse modes take pushes only; this force pulls for that load.
                if matches!(load, Load::Directed(psi) if b.phi_a * force * psi.sin() < 0.0) {
                    continue;
                }
                let name = format!("{load:?} t = {t} F = {force:e}");
                let moments = moment_mode(&whisker, b.moment, 0.06, load).unwrap();
                assert!(moments.iter().any(|m| close(m, &b, 1e-10)), "moment mode, {name}");
                let points = point_mode(&whisker, b.contact, load).unwrap();
                assert!(points.iter().any(|p| close(p, &b, 1e-10)), "point mode, {name}");
            }
        }
    }
}

#[test]
fn inverse_modes_agree_with_force_mode_recomputed() {
    let whisker = Whisker::default();
    for beta in [-1.2, -0.5, 0.0, 0.3, 1.1] {
        for moment in [1e-9, -1e-4, 2e-3, 5e-3, -8e-3] {
            for m in moment_mode(&whisker, moment, 0.06, Load::Tilted(beta)).unwrap() {
                let again = bend(EI, m.force, 0.06, beta).unwrap();
                assert!((again.moment - moment).abs() < 1e-12 * m.force.abs() * 0.06);
            }
        }
        for angle in [1e-9, 0.2, -0.6, 0.9, 1.6, 1.7] {
            let contact = 0.03 * Vec2::from_angle(angle);
            for p in point_mode(&whisker, contact, Load::Tilted(beta)).unwrap() {
                let again = bend(EI, p.force, p.s_a, beta).unwrap();
                assert!(again.contact.distance(contact) < 1e-14);
                assert!((again.contact.y / contact.y - 1.0).abs() < 1e-11);
            }
        }
    }
}

/// Sign changes of `f` over a fine grid.
fn crossings(f: impl Fn(f64) -> f64, lo: f64, hi: f64) -> usize {
    let values: Vec<f64> = (0..=40_000).map(|i| f(lo + (hi - lo) * f64::from(i) / 40_000.0)).collect();
    values.windows(2).filter(|w| w[0].is_finite() && w[1].is_finite() && (w[0] > 0.0) != (w[1] > 0.0)).count()
}

#[test]
fn branch_counts_against_a_brute_force_scan() {
    let whisker = Whisker::default();
    for beta in [-1.3, -0.8, -0.7, -0.2, 0.0, 0.6] {
        let at = |t: f64| bend(EI, EI * (t / 0.05).powi(2), 0.05, beta);
        for scaled in [0.3, 1.0, 2.0, 2.5, 2.9, 2.94, 2.95, 3.5, 6.0] {
            let moment = scaled * EI / 0.05;
            let expected = crossings(|t| at(t).map_or(-moment, |b| b.moment - moment), 1e-9, 9.0);
            let found = moment_mode(&whisker, moment, 0.05, Load::Tilted(beta)).unwrap().len();
            assert_eq!(found, expected, "moment {scaled} beta {beta}");
        }
        for angle in [0.1, 0.9, 1.5, 1.6, 1.72, 1.75, 2.2, 3.0] {
            // No limit from the whisker's length: a contact near the base.
            let contact = 1e-4 * Vec2::from_angle(angle);
            let target = Vec2::from_angle(angle);
            let f = |t: f64| {
                at(t).map_or(f64::NAN, |b| if b.contact.dot(target) > 0.0 { target.cross(b.contact) } else { f64::NAN })
            };
            let up = point_mode(&whisker, contact, Load::Tilted(beta)).unwrap();
            let found = up.iter().filter(|b| b.phi_a > 0.0).count();
            assert_eq!(found, crossings(f, 1e-6, 9.0), "point {angle} beta {beta}");
        }
    }
}

#[test]
fn fixed_directions_against_a_brute_force_scan_over_the_tilt() {
    let whisker = Whisker::default();
    for psi in [0.3, 1.0, FRAC_PI_2, 2.5, 3.0, 3.3, 4.0, FRAC_PI_2 * 3.0, 5.5] {
        for t in [0.5, 1.2, 1.8, 2.5, 3.1, 3.3, 3.6, 4.5] {
            let force = EI * (t / 0.05_f64).powi(2);
            // The direction reached with tilt beta, less the one wanted, modulo a turn.
            let off = |beta: f64| {
                bend(EI, force, 0.05, beta).map_or(f64::NAN, |b| {
                    let d = (b.phi_a + beta + FRAC_PI_2 - psi).rem_euclid(2.0 * PI);
                    let d = if d > PI { d - 2.0 * PI } else { d };
                    if d.abs() < 1.0 { d } else { f64::NAN }
                })
            };
            let expected = crossings(off, -PI, PI);
            let found = force_mode(&whisker, force, 0.05, Load::Directed(psi)).unwrap().len();
            assert_eq!(found, expected, "psi {psi} t {t}");
        }
    }
}

#[test]
fn the_normal_load_has_two_branches_below_its_largest_moment() {
    let whisker = Whisker::default();
    let count = |scaled: f64| moment_mode(&whisker, scaled * EI / 0.05, 0.05, Load::Normal).unwrap().len();
    let (mut lo, mut hi) = (2.5, 3.2);
    for _ in 0..60 {
        let middle = 0.5 * (lo + hi);
        if count(middle) == 2 { lo = middle } else { hi = middle }
    }
    println!("largest M0 s_a / EI under a normal load: {lo}");
    assert!((lo - 2.9).abs() < 0.05);
    assert_eq!((count(lo - 1e-9), count(hi + 1e-9)), (2, 0));
}

#[test]
fn mirror_and_scaling() {
    for beta in [-1.4, -0.3, 0.0, 0.8, 2.0, -2.9] {
        for t in [1e-3, 0.4, 1.5, 2.7] {
            let force = EI * (t / 0.05_f64).powi(2);
            let (a, b) = (bend(EI, force, 0.05, beta), bend(EI, -force, 0.05, -beta));
            assert_eq!(a.is_none(), b.is_none());
            let (Some(a), Some(b)) = (a, b) else {
                continue;
            };
            assert!(a.phi_a == -b.phi_a && a.moment == -b.moment && a.contact == Vec2::new(b.contact.x, -b.contact.y));
            let big = bend(8.0 * EI, 2.0 * force, 0.1, beta).unwrap();
            assert!((big.phi_a - a.phi_a).abs() < 1e-14 && big.contact.distance(2.0 * a.contact) < 1e-16);
        }
    }
}

#[test]
fn energy_is_the_work_done() {
    for beta in [-1.2, -0.4, 0.0, 0.7, 1.4] {
        for t in [0.01, 0.2, 0.3, 1.0, 2.0, 2.9] {
            for sign in [1.0, -1.0] {
                let at = |t: f64| bend(EI, sign * EI * (t / 0.05).powi(2), 0.05, beta).unwrap();
                let h = 1e-4 * t;
                let (before, b, after) = (at(t - h), at(t), at(t + h));
                assert!(b.energy() > 0.0);
                let work = b.force_vector().dot(after.contact - before.contact);
                let stored = after.energy() - before.energy();
                assert!((work / stored - 1.0).abs() < 1e-5, "{beta} {t}: {work:e} {stored:e}");
                // And it is the integral of the squared curvature.
                let n = 2001;
                let sum: f64 = b.shape_points(0.05, n).iter().map(|(_, p)| p.curvature * p.curvature).sum();
                let ends = 0.5 * (b.moment / EI).powi(2);
                let integral = 0.5 * EI * (sum - ends) * 0.05 / (n - 1) as f64;
                assert!((integral / b.energy() - 1.0).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn the_shape_is_a_curve_of_unit_speed_from_base_to_tip() {
    let b = bend(EI, -0.4, 0.05, 0.2).unwrap();
    let points = b.shape_points(0.075, 3001);
    assert!(points[0].1.position.norm() < 1e-16 && points[0].1.slope.abs() < 1e-15);
    assert!(points[3000].1.position.distance(b.tip(0.075)) < 1e-16);
    assert!(b.tip_displacement(0.075).y < 0.0);
    for w in points.windows(2) {
        let (d, h) = (w[1].1.position - w[0].1.position, w[1].0 - w[0].0);
        assert!((d.norm() / h - 1.0).abs() < 1e-6);
        assert!((w[1].1.slope - w[0].1.slope - 0.5 * h * (w[0].1.curvature + w[1].1.curvature)).abs() < 1e-7);
        let middle = 0.5 * (w[0].1.slope + w[1].1.slope);
        assert!((d.angle() - middle).abs() < 1e-6);
    }
}

#[test]
fn no_load_is_a_straight_whisker() {
    let whisker = Whisker::default();
    for load in LOADS {
        let bends = [
            force_mode(&whisker, 0.0, 0.05, load).unwrap(),
            moment_mode(&whisker, -0.0, 0.05, load).unwrap(),
            point_mode(&whisker, Vec2::new(0.05, 0.0), load).unwrap(),
        ];
        for list in bends {
            let b = &list[0];
            assert!(b.phi_a == 0.0 && b.force == 0.0 && b.moment == 0.0 && b.contact == Vec2::new(0.05, 0.0));
            assert!(b.energy() == 0.0 && b.shape(0.075, 4)[3] == Vec2::new(0.075, 0.0));
        }
    }
}

#[test]
fn axial_forces() {
    let whisker = Whisker::default();
    let force = |t: f64| EI * (t / 0.05_f64).powi(2);
    // Compression: straight up to half the first mode, buckled to either side above Euler's load t = pi/2.
    let count = |t: f64| force_mode(&whisker, force(t), 0.05, Load::Directed(PI)).unwrap().len();
    assert_eq!([count(1.0), count(1.57), count(1.58), count(3.0)], [1, 1, 3, 3]);
    // Tension: always straight.
    let pulled = force_mode(&whisker, force(3.0), 0.05, Load::Directed(0.0)).unwrap();
    assert!(pulled.len() == 1 && pulled[0].phi_a == 0.0 && pulled[0].force > 0.0);
    // Nearly so: the whisker all but follows a strong force.
    let b = force_mode(&whisker, force(200.0), 0.05, Load::Vertical).unwrap().remove(0);
    assert!((b.phi_a - FRAC_PI_2).abs() < 1e-15 && (b.moment - b.contact.x * b.force).abs() < 1e-12 * b.moment);
}

#[test]
fn faults_are_named_and_nothing_panics() {
    let whisker = Whisker::default();
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0, 0.0751] {
        assert!(force_mode(&whisker, 0.1, bad, Load::Normal).unwrap_err().is_usage());
        assert!(moment_mode(&whisker, 1e-3, bad, Load::Vertical).unwrap_err().is_usage());
    }
    assert!(force_mode(&whisker, f64::NAN, 0.05, Load::Normal).is_err());
    assert!(force_mode(&whisker, 1e9, 0.05, Load::Vertical).unwrap_err().to_string().contains("allowed"));
    assert!(moment_mode(&whisker, f64::INFINITY, 0.05, Load::Normal).is_err());
    assert!(point_mode(&whisker, Vec2::ZERO, Load::Normal).is_err());
    assert!(point_mode(&whisker, Vec2::new(f64::NAN, 0.0), Load::Normal).is_err());
    assert!(force_mode(&whisker, 0.1, 0.05, Load::Tilted(f64::NAN)).is_err());
    // Beyond the first mode, and beyond the whisker's length: empty.
    assert!(force_mode(&whisker, EI * (3.8 / 0.05_f64).powi(2), 0.05, Load::Normal).unwrap().is_empty());
    assert!(point_mode(&whisker, Vec2::new(0.08, 0.01), Load::Normal).unwrap().is_empty());
    for extreme in [1e-300, 1e-150, 1e-30, 1e30, 1e150, 1e300] {
        for load in LOADS {
            for sign in [1.0, -1.0] {
                let _ = force_mode(&whisker, sign * extreme, 0.05, load);
                let _ = moment_mode(&whisker, sign * extreme, 0.05, load);
                let _ = point_mode(&whisker, Vec2::new(0.05, sign * extreme), load);
                let _ = point_mode(&whisker, Vec2::new(sign * extreme, 0.05), load);
            }
        }
    }
}

#[test]
fn whiskers_of_any_size_give_shapes_of_finite_numbers_or_a_refusal() {
    let (mut shapes, mut refused) = (0, 0);
    for length in [1e-300, 1e-200, 1e-150, 1e-12, 1.0, 1e12, 1e150, 1e300] {
        for flexural_rigidity in [1e-300, 1e-12, 1.0, 1e12, 1e300] {
            let whisker = Whisker { length, flexural_rigidity, ..Whisker::default() };
            let unit = flexural_rigidity / length;
            let within = Vec2::new(0.7 * length, 0.3 * length);
            let by_load = LOADS.into_iter().flat_map(|load| {
                [
                    force_mode(&whisker, unit / length, 0.8 * length, load),
                    moment_mode(&whisker, 0.7 * unit, 0.8 * length, load),
                    point_mode(&whisker, within, load),
                ]
            });
            for answer in by_load.chain([tip_mode(&whisker, within)]) {
                let Ok(bends) = answer else {
                    refused += 1;
                    continue;
                };
                for bend in bends {
                    let numbers = [bend.force, bend.s_a, bend.phi_a, bend.beta, bend.moment, bend.energy()];
                    let outline = bend.shape(length, 8);
                    assert!(
                        numbers.into_iter().all(f64::is_finite) && outline.iter().all(|p| p.is_finite()),
                        "{length:e} m, {flexural_rigidity:e} N m2: {bend:?}"
                    );
                    shapes += 1;
                }
            }
        }
    }
    assert!(shapes > 400 && refused > 100, "{shapes} shapes, {refused} refused");
}

#[test]
fn a_moment_at_the_very_base_is_refused_where_no_finite_force_causes_it() {
    for load in [Load::Normal, Load::Vertical, Load::Tilted(0.3)] {
        let error = moment_mode(&Whisker::default(), 1e8, 1e-301, load).unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("s_a"), "{error}");
        let near = moment_mode(&Whisker::default(), 1e-3, 1e-12, load).unwrap();
        // The lever arm is the arc length there, and the force's share across it the cosine of the tilt.
        assert!(
            near.iter().any(|bend| (bend.contact.cross(bend.force_vector()) / 1e-3 - 1.0).abs() < 1e-6),
            "{near:?}"
        );
    }
}
