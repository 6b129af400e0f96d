//! Each place where the paper is wrong or loose, shown by a number: docs/theory-beam.md has the derivations.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/shared.rs"]
mod shared;

use shared::shared;
use std::f64::consts::PI;
use vibrissa::beam::normal::{NormalBend, by_force, largest_moment};
use vibrissa::beam::{Load, SmallAngle, Whisker, force_mode};
use vibrissa::config::defaults;

/// The shape under the `i`-th of `n` normal forces up to the end of the first mode, where rigidity and arc length are 1.
fn unit_shape(i: usize, n: usize) -> NormalBend {
    by_force(1.0, 6.87 * 2.0 * i as f64 / n as f64, 1.0).unwrap()
}

/// 1: with the paper's order of the sines the root is imaginary for every shape; with ours it is the moment.
#[test]
fn the_sines_under_the_root() {
    let whisker = Whisker::default();
    for force in [0.01, 0.1, 0.3, -0.2] {
        for load in [Load::Normal, Load::Vertical, Load::Tilted(0.4)] {
            let b = force_mode(&whisker, force, 0.05, load).unwrap().remove(0);
            // Seen from the side to which it bends; the lever is the oracle.
            let (phi, beta) = (b.phi_a.abs(), b.beta * b.phi_a.signum());
            let root = (phi + beta).sin() - beta.sin();
            assert!(root > 0.0, "the paper's difference is the negative of this");
            let moment = (2.0 * whisker.flexural_rigidity * force.abs() * root).sqrt();
            let lever = b.contact.cross(b.force_vector());
            assert!((moment / lever.abs() - 1.0).abs() < 1e-11);
        }
    }
}

/// 2: what the direction of the load is worth at 0.1 N on the paper's wire.
#[test]
fn eight_millimetres_between_two_loads() {
    let contact = |load| force_mode(&Whisker::default(), 0.1, 0.075, load).unwrap()[0].contact;
    let apart = 1e3 * contact(Load::Normal).distance(contact(Load::Vertical));
    assert!((apart - 7.65).abs() < 0.01, "{apart} mm");
    // Far below a gram the two agree.
    let weak = |load| force_mode(&Whisker::default(), 1e-4, 0.075, load).unwrap()[0].contact;
    assert!(weak(Load::Normal).distance(weak(Load::Vertical)) < 1e-9);
}

/// 3: the contact sets of a moment and of half of it after a turn about the base meet at the base and at one other point.
#[test]
fn an_intersection_of_contact_sets_in_two_pieces() {
    let turn = 0.3;
    // By the contact's polar angle, while that rises: the distance from the base at a moment of one, E I = 1.
    let curve: Vec<(f64, f64)> = (1..20_000)
        .map(|i| unit_shape(i, 20_000))
        .map(|b| (b.contact.y.atan2(b.contact.x), b.contact.norm() * b.moment))
        .take_while(|(angle, _)| *angle < 1.5)
        .collect();
    assert!(curve.windows(2).all(|w| w[0].0 < w[1].0));
    let distance = |angle: f64| {
        let i = curve.partition_point(|(a, _)| *a < angle).clamp(1, curve.len() - 1);
        let ((a0, r0), (a1, r1)) = (curve[i - 1], curve[i]);
        r0 + (r1 - r0) * (angle - a0) / (a1 - a0)
    };
    // Both begin at the base: the distance goes to zero with the angle.
    assert!(curve[0].1 < 1e-2 && (curve[20].1 / curve[20].0 / (curve[0].1 / curve[0].0) - 1.0).abs() < 1e-3);
    let gap = |angle: f64| distance(angle) - 2.0 * distance(angle - turn);
    let angles: Vec<f64> = (1..1000).map(|i| turn + (1.45 - turn) * f64::from(i) / 1000.0).collect();
    let crossings: Vec<f64> = angles.windows(2).filter(|w| gap(w[0]) * gap(w[1]) < 0.0).map(|w| w[0]).collect();
    assert_eq!(crossings.len(), 1, "{crossings:?}");
    // Between base and crossing the curves are apart: no path leads from one common point to the other.
    assert!(crossings[0] > turn + 0.1 && distance(crossings[0]) > 0.5);
    assert!(angles.iter().filter(|a| **a < crossings[0]).all(|a| gap(*a) > 0.0));
}

/// 4: what the abstract promises and what the table shows.
#[test]
fn seven_millimetres_are_seven_point_three() {
    let Some(folder) = shared("paper") else { return };
    let file = std::fs::read_dir(folder).unwrap().next().unwrap().unwrap();
    let text = std::fs::read_to_string(file.path()).unwrap();
    let row = text.lines().find(|line| line.starts_with("Average Error")).unwrap();
    let largest =
        row.split('&').filter_map(|cell| cell.trim_matches([' ', '\\']).parse::<f64>().ok()).fold(0.0, f64::max);
    assert!((largest - 7.30).abs() < 1e-9);
    assert!(text.contains("errors under \\SI{7}{\\milli\\meter}"), "the abstract's number");
}

/// 5: the earlier method is the small-angle formula. The column itself is computed in `paper_tables`.
#[test]
fn the_earlier_method_follows_from_two_small_angle_formulas() {
    let (ei, force, s_a): (f64, f64, f64) = (2.8886e-4, 0.003, 0.05);
    let (moment, deflection) = (force * s_a, force * s_a * s_a * s_a / (3.0 * ei));
    assert!(((3.0 * ei * deflection / moment).sqrt() / s_a - 1.0).abs() < 1e-14);
    let bent = SmallAngle::from_moment_and_deflection(ei, moment, deflection).unwrap();
    assert!((bent.s_a / s_a - 1.0).abs() < 1e-14);
}

/// 6: the largest moment of a normal load, by scanning all forces of the first mode.
#[test]
fn moments_that_no_shape_has() {
    let most = (1..100_000).map(|i| unit_shape(i, 100_000).moment).fold(0.0, f64::max);
    assert!((most - 2.944).abs() < 1e-3 && (most / largest_moment() - 1.0).abs() < 1e-8, "{most}");
    let reach = |moment: f64| 1e3 * most * defaults::FLEXURAL_RIGIDITY / moment;
    assert!((reach(0.017) - 50.0).abs() < 0.05 && (reach(0.025) - 34.0).abs() < 0.05);
    // The table's moments, 25 to 130 times smaller, are possible anywhere on the whisker.
    assert!(reach(0.63e-3) > 75.0);
}

/// 7 and 8: the heading follows from slope and wall, `theta = phi_E - phi_a`; the paper's angle counts both clockwise.
#[test]
fn the_heading_of_a_whisker_that_touches_a_wall() {
    let bend = force_mode(&Whisker::default(), 0.05, 0.06, Load::Normal).unwrap().remove(0);
    let along = |theta: f64, wall: f64| (theta + bend.point_at(bend.s_a).slope - wall).sin().abs() < 1e-12;
    for wall in [0.3, -1.1, 2.0] {
        let theta = wall - bend.phi_a;
        assert!(along(theta, wall));
        // Read literally, with counter-clockwise slopes, it is right for no such wall.
        assert!(!along(PI - (bend.phi_a + wall), wall));
        // With the whisker's slope clockwise, and the turn the other way, it is ours.
        assert!(along(-(PI - (-bend.phi_a + wall)), wall));
    }
}

/// 9: two readings that share a place but not a heading.
#[test]
fn one_place_two_headings() {
    let above = 0.03;
    // A normal load's whisker lies along the wall where it touches: at heading -phi_a its base is so far above.
    let state = |i: usize| {
        let shape = unit_shape(i, 1000);
        let depth = -shape.contact.rotated(-shape.phi_a).y;
        let s_a = above / depth;
        (depth * s_a, -shape.phi_a, shape.moment * defaults::FLEXURAL_RIGIDITY / s_a, s_a)
    };
    let (first, second) = (state(300), state(500));
    assert!([first, second].iter().all(|state| state.3 > 0.0 && state.3 < 0.075), "{first:?} {second:?}");
    assert!((first.0 - second.0).abs() < 1e-15, "both bases are 30 mm above the wall");
    assert!((first.1 - second.1).abs() > 0.1 && (first.2 / second.2 - 1.0).abs() > 0.05);
}

/// 10: the constants.
#[test]
fn the_papers_wire() {
    let second_moment = PI * defaults::DIAMETER.powi(4) / 64.0;
    assert!((second_moment / 5.555e-15 - 1.0).abs() < 1e-4);
    assert!((defaults::YOUNG_MODULUS * second_moment / defaults::FLEXURAL_RIGIDITY - 1.0).abs() < 1e-4);
    assert!((defaults::LENGTH - 0.075).abs() < 1e-15);
}
