//! The tip field against the closed form, the integrated rod and 30-digit vectors.

// A test helper that fails fails its test.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "data/fields.rs"]
mod fields;
#[path = "../../vibrissa/tests/data/random.rs"]
mod random;
#[path = "../../vibrissa/tests/data/shared.rs"]
mod shared;

use fields::{FIELDS, load, plain, state, uniform};
use random::Random;
use shared::shared;
use vibrissa_beam::beam::Whisker;
use vibrissa_beam::beam::elastica::bend;
use vibrissa_beam::beam::field::{FieldErrors, TipField, TipState};
use vibrissa_beam::plane::Vec2;
use vibrissa_beam::sets::Interval;

/// The largest share of the promised errors that a state uses up.
fn share(errors: FieldErrors, state: &TipState, slope: f64, position: Vec2, moment: f64, energy: f64) -> f64 {
    let off = state.position - position;
    let shares = [
        (state.slope - slope) / errors.slope,
        off.x / errors.position,
        off.y / errors.position,
        (state.moment - moment) / errors.moment,
        (state.energy - energy) / errors.energy,
    ];
    shares.into_iter().fold(0.0, |a, b| a.max(b.abs()))
}

#[test]
fn the_closed_form_is_within_the_errors() {
    let (mut random, mut worst, mut seen) = (Random(1), 0.0_f64, 0);
    for _ in 0..130_000 {
        let (tilt, force) = load(uniform(), &mut random);
        let at = uniform().at(tilt, force).unwrap();
        let Some(b) = bend(plain().flexural_rigidity, force, plain().length, tilt) else { continue };
        worst = worst.max(share(uniform().errors(), &at, b.phi_a, b.contact, b.moment, b.energy()));
        seen += 1;
    }
    assert!(seen > 100_000, "{seen}");
    println!("{worst} of the promised errors, {seen} shapes");
    assert!(worst < 1.0 && worst > 0.1, "{worst}");
}

#[test]
fn the_beam_is_within_the_errors_for_every_kind_of_whisker() {
    for (name, field) in FIELDS.iter() {
        let (mut random, mut worst) = (Random(2), 0.0_f64);
        for _ in 0..700 {
            let (tilt, force) = load(field, &mut random);
            let exact = field.exact(tilt, force).unwrap();
            let at = field.at(tilt, force).unwrap();
            worst = worst.max(share(field.errors(), &at, exact.slope, exact.position, exact.moment, exact.energy));
        }
        println!("{name}: {worst} of the promised errors");
        assert!(worst < 1.0, "{name}: {worst}");
        assert!(field.errors().position < 2e-5 * field.length(), "{name}: {:?}", field.errors());
    }
}

#[test]
fn derivatives_are_those_of_the_beam() {
    for (name, field) in FIELDS.iter() {
        let mut random = Random(3);
        for _ in 0..100 {
            let (tilt, force) = load(field, &mut random);
            let at = field.at(tilt, force).unwrap();
            let h = 1e-4;
            let unit = field.largest_force(tilt, force);
            let (a, b) = (field.exact(tilt + h, force).unwrap(), field.exact(tilt - h, force).unwrap());
            let (c, d) = (field.exact(tilt, force + h * unit).unwrap(), field.exact(tilt, force - h * unit).unwrap());
            let scale = field.length() * (1.0 + (0.5 / h / field.length()) * (a.position - b.position).norm());
            let by_tilt = (0.5 / h) * (a.position - b.position) - at.by_tilt.position;
            let by_force = (0.5 / h) * (c.position - d.position) - unit * at.by_force.position;
            assert!(by_tilt.norm() < 3e-4 * scale, "{name} {tilt} {force}: {by_tilt:?}");
            assert!(by_force.norm() < 3e-4 * scale, "{name} {tilt} {force}: {by_force:?}");
            let slope = (0.5 / h) * (a.slope - b.slope) - at.by_tilt.slope;
            assert!(slope.abs() < 2e-3 * (1.0 + at.by_tilt.slope.abs()), "{name} {tilt} {force}: {slope}");
        }
    }
}

/// Against the beam's own differences, five points wide, whose error is estimated by halving their step.
#[test]
fn derivatives_are_within_their_errors() {
    for (name, field) in FIELDS.iter() {
        let (mut random, mut worst, mut seen) = (Random(12), [0.0_f64; 2], 0);
        let [by_tilt, by_force] = field.rate_errors();
        let most = (0..=20).map(|i| field.largest_force(0.1 * f64::from(i - 10), 1.0)).fold(0.0, f64::max);
        for _ in 0..150 {
            let (tilt, force) = load(field, &mut random);
            let at = field.at(tilt, force).unwrap();
            for (kind, (h, rate, promised)) in
                [(2e-3, at.by_tilt, by_tilt), (2e-3 * most, at.by_force, by_force)].into_iter().enumerate()
            {
                let go = |x: f64| {
                    let (tilt, force) = if kind == 0 { (tilt + x, force) } else { (tilt, force + x) };
                    let q = field.exact(tilt, force).unwrap();
                    [q.slope, q.position.x, q.position.y, q.moment, q.energy]
                };
                let slopes = |h: f64| {
                    let (a, b, c, d) = (go(2.0 * h), go(h), go(-h), go(-2.0 * h));
                    [0, 1, 2, 3, 4].map(|k: usize| (8.0 * (b[k] - c[k]) - (a[k] - d[k])) / (12.0 * h))
                };
                let (wide, narrow) = (slopes(h), slopes(0.5 * h));
                let got = [rate.slope, rate.position.x, rate.position.y, rate.moment, rate.energy];
                let p = promised;
                for (k, bound) in [p.slope, p.position, p.position, p.moment, p.energy].into_iter().enumerate() {
                    let unsure = (wide[k] - narrow[k]).abs();
                    if unsure > 0.2 * bound {
                        continue;
                    }
                    seen += 1;
                    worst[kind] = worst[kind].max(((got[k] - narrow[k]).abs() - unsure) / bound);
                }
            }
        }
        println!("{name}: {worst:?} of the promised errors, {seen} derivatives");
        assert!(worst[0] < 1.0 && worst[1] < 1.0, "{name}: {worst:?}");
        assert!(worst[0] > 0.02 && worst[1] > 0.02 && seen > 500, "{name}: {worst:?} {seen}");
    }
}

/// The work of the force is the change of the energy: no derivative of the table knows that.
#[test]
fn the_force_is_the_gradient_of_the_energy() {
    for (name, field) in FIELDS.iter() {
        let mut random = Random(4);
        for _ in 0..2_000 {
            let at = state(field, &mut random);
            let force = at.force_vector();
            for by in [at.by_tilt, at.by_force] {
                let work = force.dot(by.position);
                let scale = force.norm() * by.position.norm();
                assert!((by.energy - work).abs() < 2e-3 * scale + 1e-12, "{name} {at:?}: {work}");
            }
            let moment = at.position.cross(force);
            assert!((at.moment - moment).abs() <= field.errors().moment + field.errors().position * 2.0 * force.norm());
        }
    }
}

#[test]
fn the_stiffness_is_symmetric_and_moves_as_it_says() {
    let mut random = Random(5);
    for (name, field) in FIELDS.iter() {
        let mut seen = 0;
        for _ in 0..300 {
            let at = state(field, &mut random);
            let (Some(rates), Some(reading)) = (at.by_position(), at.by_reading()) else { continue };
            let [x, y] = rates.force;
            let size = x.norm().max(y.norm());
            // Near rest a straight whisker cannot be stretched: the stiffness is without bound there.
            if size * field.length() > 1e3 * at.force.abs() {
                continue;
            }
            seen += 1;
            assert!((x.y - y.x).abs() < 2e-2 * size, "{name} {rates:?} {at:?}");
            let step = 1e-6 * field.length();
            let Some(moved) = field.by_position_from(at.position + Vec2::new(step, 0.5 * step), &at) else { continue };
            let want = at.moment + step * (rates.moment.x + 0.5 * rates.moment.y);
            let change = (moved.moment - at.moment).abs();
            assert!((moved.moment - want).abs() < 0.05 * change + 1e-9 * at.moment.abs(), "{name} {at:?}");
            let (turn, more) = (1e-6, 1e-6 * at.moment);
            let Some(read) = field.by_direction_and_moment_from(at.direction() + turn, at.moment + more, &at) else {
                continue;
            };
            let predicted = turn * reading.by_direction + more * reading.by_moment;
            let real = read.position - at.position;
            assert!((real - predicted).norm() < 0.05 * predicted.norm() + 1e-12, "{name} {real:?} {predicted:?}");
        }
        assert!(seen > 100, "{name}: {seen}");
    }
}

#[test]
fn a_straight_whisker_mirrors_and_a_curved_one_does_not() {
    let mut random = Random(6);
    for (tilt, force) in (0..300).map(|_| load(uniform(), &mut random)).collect::<Vec<_>>() {
        let (a, b) = (uniform().at(tilt, force).unwrap(), uniform().at(-tilt, -force).unwrap());
        assert!((a.position.x - b.position.x).abs() + (a.position.y + b.position.y).abs() < 1e-15);
        assert!((a.moment + b.moment).abs() < 1e-18 && (a.direction() + b.direction()).abs() < 1e-14);
        assert!((a.by_force.moment - b.by_force.moment).abs() < 1e-12);
        assert!((a.by_tilt.position.x + b.by_tilt.position.x).abs() < 1e-14);
    }
    let curved = &FIELDS[2].1;
    let (a, b) = (curved.at(0.1, 0.02).unwrap(), curved.at(-0.1, -0.02).unwrap());
    assert!((a.position.x - b.position.x).abs() > 1e-4);
}

#[test]
fn every_vector_with_its_contact_at_the_tip() {
    let Some(path) = shared("vectors/elastica.csv") else { return };
    let text = std::fs::read_to_string(path).unwrap();
    let mut seen = 0;
    for line in text.lines().skip(1) {
        let f: Vec<&str> = line.split(',').collect();
        let n = |i: usize| f[i].parse::<f64>().unwrap();
        // A whisker that ends at the contact: nothing beyond it carries a load.
        let (s_a, length) = (n(8), n(7));
        let tip_ratio = 1.0 - (1.0 - n(3)) * s_a / length;
        let whisker = Whisker {
            length: s_a,
            flexural_rigidity: n(6),
            tip_ratio,
            curvature: n(4),
            base_stiffness: n(5),
            ..Whisker::default()
        };
        let (beta, force) = (n(2), n(9));
        let field = TipField::new(&whisker).unwrap();
        let Some(at) = field.at(beta, force) else { continue };
        seen += 1;
        let e = field.errors();
        let off = at.position - Vec2::new(n(11), n(12));
        assert!((at.slope - n(10)).abs() <= e.slope && (at.moment - n(13)).abs() <= e.moment, "{line}");
        assert!(off.x.abs() <= e.position && off.y.abs() <= e.position, "{line}");
        if seen == 12 {
            break;
        }
    }
    assert!(seen == 12, "{seen}");
}

#[test]
fn enclosures_hold_what_they_promise() {
    for (name, field) in FIELDS.iter() {
        let mut random = Random(9);
        for _ in 0..60 {
            let at = state(field, &mut random);
            let (turn, more) = (random.between(1e-4, 0.1), at.force.abs() * random.between(1e-4, 0.1));
            let around = |x: f64, r: f64| Interval::new(x - r, x + r);
            let hull = field.enclosure(around(at.tilt, turn), around(at.force, more)).unwrap();
            let readings =
                field.enclosures_of_reading(around(at.direction(), turn), around(at.moment, 0.05 * at.moment.abs()));
            assert!(readings.iter().any(|b| b.x.contains(at.position.x) && b.y.contains(at.position.y)), "{name}");
            for _ in 0..5 {
                let (tilt, force) = (at.tilt + random.signed(turn), at.force + random.signed(more));
                if !field.holds(tilt, force) {
                    continue;
                }
                let exact = field.exact(tilt, force).unwrap();
                let inside = hull.x.contains(exact.position.x)
                    && hull.y.contains(exact.position.y)
                    && hull.moment.contains(exact.moment)
                    && hull.slope.contains(exact.slope)
                    && hull.energy.contains(exact.energy);
                assert!(inside, "{name} {hull:?} {exact:?}");
                let s = field.at(tilt, force).unwrap();
                let explained = (s.direction() - at.direction()).abs() <= turn
                    && (s.moment - at.moment).abs() <= 0.05 * at.moment.abs();
                let held = |b: &vibrissa_beam::beam::field::TipBox| {
                    b.x.contains(exact.position.x) && b.y.contains(exact.position.y)
                };
                assert!(!explained || readings.iter().any(held), "{name}");
            }
        }
        // A small box of loads stays small.
        let tight = field.enclosure(Interval::new(0.1, 0.1001), Interval::new(1e-4, 1.0001e-4)).unwrap();
        assert!(tight.x.width() < 1e-4 * field.length(), "{name} {tight:?}");
    }
}

#[test]
fn a_stored_field_comes_back_bit_for_bit_and_damage_is_told() {
    for (name, field) in [&FIELDS[0], &FIELDS[4], &FIELDS[5]] {
        let bytes = field.to_bytes();
        assert!(bytes.len() < 2_000_000, "{name}: {}", bytes.len());
        let back = TipField::from_bytes(&bytes).unwrap();
        assert_eq!(back.to_bytes(), bytes);
        let mut random = Random(10);
        for _ in 0..200 {
            let (tilt, force) = load(field, &mut random);
            assert_eq!(back.at(tilt, force), field.at(tilt, force));
            let position = field.at(tilt, force).unwrap().position;
            assert_eq!(back.by_position(position), field.by_position(position));
        }
        assert_eq!(back.errors(), field.errors());
    }
    let bytes = uniform().to_bytes();
    let mut flipped = bytes.clone();
    flipped[5_000] ^= 1;
    let mut other = bytes.clone();
    other[15] = 9;
    let messages = [
        (TipField::from_bytes(&flipped), "a stored whisker field is damaged: its checksum does not match"),
        (TipField::from_bytes(&bytes[..1000]), "a stored whisker field is damaged: its checksum does not match"),
        (TipField::from_bytes(&other), "version of a stored whisker field: 9 (allowed: 2)"),
        (TipField::from_bytes(b"PK"), "this is no stored whisker field"),
        (TipField::from_bytes(&[]), "this is no stored whisker field"),
    ];
    for (result, start) in messages {
        let error = result.err().unwrap();
        assert!(error.is_data() && error.to_string().starts_with(start), "{error}");
        assert!(error.to_string().contains("help: "));
    }
}

#[test]
fn beyond_the_field_there_is_nothing() {
    let f = uniform();
    for (tilt, force) in [(1.6, 0.1), (f64::NAN, 0.1), (0.1, f64::NAN), (0.1, 1e9), (0.0, f64::INFINITY)] {
        assert!(f.at(tilt, force).is_none());
    }
    for position in [(0.2, 0.0), (f64::NAN, 0.0), (f64::INFINITY, 1.0), (-0.07, -0.02)] {
        assert!(f.by_position(Vec2::new(position.0, position.1)).is_empty());
    }
    for (direction, moment) in [(1.0, 1e3), (f64::NAN, 1e-3), (1.0, f64::NAN), (f64::INFINITY, 1e-3)] {
        assert!(f.by_direction_and_moment(direction, moment).is_empty());
    }
    // Answers end where the field says, on both sides, also where limits have corners.
    let mut random = Random(23);
    for _ in 0..20_000 {
        let (tilt, sign) = (random.signed(1.46), random.sign());
        let force = sign * f.largest_force(tilt, sign) * (1.0 + random.signed(1.0).powi(9));
        assert_eq!(f.at(tilt, force).is_some(), f.holds(tilt, force), "{tilt} {force}");
    }
    assert!(TipField::new(&Whisker { length: -1.0, ..plain() }).is_err());
    let rest = f.at(0.3, 0.0).unwrap();
    assert!(rest.position.distance(Vec2::new(0.075, 0.0)) < 1e-9 && rest.moment.abs() < 1e-9 && rest.is_stable());
    assert!(rest.by_position().is_none());
}
