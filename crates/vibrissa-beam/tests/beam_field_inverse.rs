//! From a tip, or a direction and a moment, back to every equilibrium of the field: against the field, the modes and the curve of a moment.

// A test helper that fails fails its test.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "data/fields.rs"]
mod fields;
#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use fields::{FIELDS, plain, state, uniform};
use random::Random;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use vibrissa_beam::beam::field::TipState;
use vibrissa_beam::beam::{Whisker, tip_curve, tip_mode};
use vibrissa_beam::plane::Vec2;

/// A chart scanned finely finds what the index finds, and no more.
#[test]
fn no_branch_is_missed() {
    for (name, field) in FIELDS.iter() {
        let mut random = Random(7);
        let mut several = 0;
        for _ in 0..200 {
            let at = state(field, &mut random);
            let by_reading = field.by_direction_and_moment(at.direction() + TAU * 3.0, at.moment);
            several += usize::from(by_reading.len() > 1);
            let is_it =
                |s: &TipState| (s.energy - at.energy).abs() < 1e-5 * at.energy && (s.slope - at.slope).abs() < 1e-4;
            assert!(by_reading.iter().any(is_it), "{name}: reading of {at:?}");
            for found in &by_reading {
                let turned = (found.direction() - at.direction()) / TAU;
                assert!((turned - turned.round()).abs() < 1e-9);
                assert!((found.moment - at.moment).abs() < 1e-9 * field.rod().length() * at.force.abs());
            }
            // Near rest the tip says less about the tilt than the table's errors are.
            let told = at.by_tilt.position.cross(at.by_force.position).abs() / at.by_force.position.norm();
            if told < 2.0 * field.errors().position {
                continue;
            }
            let by_position = field.by_position(at.position);
            assert!(by_position.iter().any(is_it), "{name}: position of {at:?} among {by_position:?}");
            for found in &by_position {
                assert!(found.position.distance(at.position) < 1e-10 * field.length());
            }
        }
        assert!(several > 5, "{name}: {several}");
    }
}

#[test]
fn tip_mode_agrees() {
    let mut random = Random(8);
    for (index, name) in [(0, "uniform"), (1, "tapered"), (3, "elastic base")] {
        let field = &FIELDS[index].1;
        let whisker =
            [plain(), Whisker { tip_ratio: 0.05, ..plain() }, plain(), Whisker { base_stiffness: 0.03, ..plain() }]
                [index];
        for _ in 0..3 {
            let at = state(field, &mut random);
            let found = field.by_position(at.position);
            for bend in tip_mode(&whisker, at.position).unwrap() {
                let vector = bend.force_vector();
                let direction = vector.angle() - bend.phi_a - FRAC_PI_2;
                let tilt = direction - TAU * (direction / TAU).round();
                let (tilt, force) = if tilt.abs() <= FRAC_PI_2 {
                    (tilt, vector.norm())
                } else {
                    (tilt - PI * tilt.signum(), -vector.norm())
                };
                // At the very limits one may have it and the other not.
                if !field.holds(tilt * 1.001, force * 1.01) {
                    continue;
                }
                let near =
                    |s: &TipState| (s.slope - bend.phi_a).abs() < 1e-3 && (s.force - force).abs() < 1e-3 * force.abs();
                assert!(found.iter().any(near), "{name} at {:?}: {tilt} {force} {}", at.position, bend.phi_a);
            }
        }
    }
}

#[test]
fn the_curve_of_a_moment_lies_in_the_field() {
    let scale = plain().flexural_rigidity / plain().length;
    for mu in [0.05, 0.8, 2.0, 2.9] {
        for piece in tip_curve(mu) {
            for e in piece.iter().step_by(17) {
                if e.tilt().abs() > 1.44 || e.slope > 3.13 {
                    continue;
                }
                let found = uniform().by_direction_and_moment(e.direction, mu * scale);
                let tip = plain().length * Vec2::new(e.x, e.y);
                let near = |s: &TipState| s.position.distance(tip) < 1e-4 * plain().length;
                assert!(found.iter().any(near), "{mu} {e:?} {found:?}");
            }
        }
    }
}

#[test]
fn branches_are_followed_and_end() {
    let mut at = uniform().at(0.1, 0.01).unwrap();
    // Up the moment until the branch ends: just below the largest moment of that direction.
    let direction = at.direction();
    let mut last = at;
    for _ in 0..400 {
        match uniform().by_direction_and_moment_from(direction, at.moment * 1.02, &at) {
            Some(next) => (last, at) = (at, next),
            None => break,
        }
    }
    assert!(at.moment > last.moment);
    let beyond = uniform().by_direction_and_moment(direction, 1.03 * at.moment);
    let near = |s: &TipState| s.position.distance(at.position) < 2e-3;
    assert!(!beyond.iter().any(near), "{beyond:?}");
}
