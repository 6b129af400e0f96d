//! Bending in a turned plane against a rod that is marched in space.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::f64::consts::{FRAC_PI_2, PI};
use vibrissa_beam::beam::{BendingPlane, Load, Whisker, moment_mode_in_space};

type Vec3 = [f64; 3];

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn plus(a: Vec3, b: Vec3, by: f64) -> Vec3 {
    [0, 1, 2].map(|k| a[k] + by * b[k])
}

/// Where a rod that leaves the origin along x ends and points after an arc length, under a force at `held`: `r' = t`, `E I t' = m × t`,
/// `m = (held - r) × force` (Kirchhoff's rod without twist), by the classical Runge-Kutta method.
fn marched(rigidity: f64, arc_length: f64, held: Vec3, force: Vec3) -> (Vec3, Vec3) {
    const STEPS: usize = 2000;
    let h = arc_length / STEPS as f64;
    let rate = |(r, t): (Vec3, Vec3)| {
        let moment = cross(plus(held, r, -1.0), force);
        (t, cross(moment, t).map(|v| v / rigidity))
    };
    let add = |a: (Vec3, Vec3), b: (Vec3, Vec3), by: f64| (plus(a.0, b.0, by), plus(a.1, b.1, by));
    let mut state = ([0.0; 3], [1.0, 0.0, 0.0]);
    for _ in 0..STEPS {
        let a = rate(state);
        let b = rate(add(state, a, 0.5 * h));
        let c = rate(add(state, b, 0.5 * h));
        let d = rate(add(state, c, h));
        for (slope, weight) in [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)] {
            state = add(state, slope, weight * h / 6.0);
        }
    }
    state
}

#[test]
fn a_rod_in_space_under_the_found_force_ends_at_the_found_contact() {
    let whisker = Whisker::default();
    let mut tried = 0;
    for k in 0..24 {
        let angle = -PI + 0.02 + f64::from(k) * PI / 12.0;
        for (moment, s_a) in [(1e-4, 0.075), (4e-3, 0.06), (9e-3, 0.075), (1.5e-2, 0.03)] {
            let moments = [moment * angle.cos(), moment * angle.sin()];
            let contacts = moment_mode_in_space(&whisker, moments, s_a, Load::Normal).unwrap();
            for contact in &contacts {
                let (point, force) = (contact.point(), contact.force());
                let (end, tangent) = marched(whisker.flexural_rigidity, s_a, point, force);
                let gap = plus(end, point, -1.0).iter().map(|v| v * v).sum::<f64>().sqrt();
                assert!(gap < 1e-9, "{angle} {moment} {s_a}: {gap} m from {point:?}");
                // Without friction the force is across the whisker.
                let along: f64 = (0..3).map(|axis| tangent[axis] * force[axis]).sum();
                assert!(along.abs() < 1e-7, "{along} N along the whisker");
                // The base feels what the sensor says: about z, and about -y.
                let felt = cross(point, force);
                assert!((felt[2] - moments[0]).abs() < 1e-12 && (-felt[1] - moments[1]).abs() < 1e-12, "{felt:?}");
                assert!((point[1].hypot(point[2]) - contact.r).abs() < 1e-12 && (point[0] - contact.x).abs() < 1e-15);
                tried += 1;
            }
            assert!(!contacts.is_empty());
        }
    }
    assert!(tried > 150, "{tried}");
}

#[test]
fn bands_hold_all_moments_within_the_errors() {
    let mut state = 1_u64;
    let mut dice = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 2f64.powi(52) - 1.0
    };
    for _ in 0..20_000 {
        let (told, errors) = ([5e-3 * dice(), 5e-3 * dice()], [1e-3 * dice().abs(), 1e-3 * dice().abs()]);
        let truth = BendingPlane::of([told[0] + errors[0] * dice(), told[1] + errors[1] * dice()]);
        let found = BendingPlane::of(told);
        let [moment, angle] = found.bands(errors);
        let turned = (truth.angle - found.angle).rem_euclid(2.0 * PI);
        let turned = turned.min(2.0 * PI - turned);
        assert!(
            (truth.moment - found.moment).abs() <= moment + 1e-15 && turned <= angle + 1e-12,
            "{told:?} {errors:?}"
        );
    }
}

#[test]
fn planes_are_named_by_their_angle_and_curved_whiskers_are_refused() {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(near(BendingPlane::of([1e-3, 0.0]).angle, 0.0) && near(BendingPlane::of([-1e-3, 0.0]).out_of_plane(), 0.0));
    let up = BendingPlane::of([0.0, 2e-3]);
    assert!(near(up.angle, FRAC_PI_2) && near(up.out_of_plane(), FRAC_PI_2) && near(up.moment, 2e-3));
    assert!(near(BendingPlane::of([0.0; 2]).bands([1e-6, 0.0])[1], PI));
    let curved = Whisker { curvature: 5.0, ..Whisker::default() };
    let error = moment_mode_in_space(&curved, [1e-3, 0.0], 0.075, Load::Normal).unwrap_err().to_string();
    assert!(error.contains("curved") && error.contains("straighten"), "{error}");
    assert!(moment_mode_in_space(&Whisker::default(), [1.0, 0.0], 0.075, Load::Normal).unwrap().is_empty());
}
