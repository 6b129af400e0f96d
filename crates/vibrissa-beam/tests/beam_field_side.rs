//! The side field against polynomials of the normal load, the integrated rod and 30-digit vectors.

// A test helper that fails fails its test.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../vibrissa/tests/data/random.rs"]
mod random;

use random::Random;
use std::sync::LazyLock;
use vibrissa_beam::beam::field::{SideField, SideState, TipField};
use vibrissa_beam::beam::normal::by_force;
use vibrissa_beam::beam::{Load, Rod, Segment, Whisker, force_mode, moment_mode, point_mode};
use vibrissa_beam::plane::Vec2;

fn plain() -> Whisker {
    Whisker::default()
}

fn mixed() -> Whisker {
    Whisker { tip_ratio: 0.4, curvature: 6.0, base_stiffness: 0.3, ..plain() }
}

static FIELDS: LazyLock<[(Whisker, SideField); 4]> = LazyLock::new(|| {
    [plain(), Whisker { tip_ratio: 0.1, ..plain() }, Whisker { base_stiffness: 0.03, ..plain() }, mixed()]
        .map(|whisker| (whisker, SideField::new(&whisker).unwrap()))
});

fn state(field: &SideField, length: f64, random: &mut Random) -> SideState {
    let (s_a, sign) = (length * random.between(0.1, 1.0), random.sign());
    field.at(s_a, sign * field.largest_force(s_a, sign) * random.unit()).unwrap()
}

#[test]
fn the_polynomials_of_the_normal_load_are_within_the_errors() {
    let (field, e) = (&FIELDS[0].1, FIELDS[0].1.errors());
    let mut random = Random(21);
    for _ in 0..20_000 {
        let at = state(field, plain().length, &mut random);
        let Some(want) = by_force(plain().flexural_rigidity, at.force, at.s_a) else { continue };
        let off = at.position - want.contact;
        assert!(off.x.abs() <= e.position && off.y.abs() <= e.position, "{at:?} {want:?}");
        assert!((at.slope - want.phi_a).abs() <= e.slope && (at.moment - want.moment).abs() <= e.moment);
    }
    assert!(e.position < 2e-6 * plain().length, "{e:?}");
}

#[test]
fn the_rod_is_within_the_errors() {
    for (whisker, field) in FIELDS.iter() {
        let (e, mut random) = (field.errors(), Random(22));
        for _ in 0..300 {
            let at = state(field, whisker.length, &mut random);
            let Some(want) = force_mode(whisker, at.force, at.s_a, Load::Normal).unwrap().pop() else { continue };
            let off = at.position - want.contact;
            assert!(off.x.abs() <= e.position && off.y.abs() <= e.position, "{whisker:?} {at:?} {want:?} {e:?}");
            assert!((at.slope - want.phi_a).abs() <= e.slope && (at.moment - want.moment).abs() <= e.moment);
            assert!((at.energy - want.energy()).abs() <= e.energy);
        }
        assert!(e.position < 1e-5 * whisker.length, "{e:?}");
    }
}

#[test]
fn derivatives_are_differences() {
    for (whisker, field) in FIELDS.iter() {
        let mut random = Random(23);
        for _ in 0..300 {
            let at = state(field, whisker.length, &mut random);
            let (ds, df) = (1e-6 * whisker.length, 1e-6 * field.largest_force(at.s_a, at.force));
            let pairs = [
                (field.at(at.s_a + ds, at.force), field.at(at.s_a - ds, at.force), ds, at.by_arc_length),
                (field.at(at.s_a, at.force + df), field.at(at.s_a, at.force - df), df, at.by_force),
            ];
            for (ahead, behind, h, rate) in pairs {
                let (Some(a), Some(b)) = (ahead, behind) else { continue };
                let off = (0.5 / h) * (a.position - b.position) - rate.position;
                assert!(off.norm() < 1e-4 * rate.position.norm() + 1e-9 / h * whisker.length, "{at:?}");
                let moment = (0.5 / h) * (a.moment - b.moment) - rate.moment;
                assert!(moment.abs() < 1e-4 * rate.moment.abs() + 1e-9 * at.moment.abs() / h, "{at:?}");
            }
        }
    }
}

#[test]
fn point_and_moment_mode_agree() {
    for (whisker, field) in FIELDS.iter() {
        let mut random = Random(24);
        for _ in 0..if whisker.is_uniform() { 300 } else { 4 } {
            let at = state(field, whisker.length, &mut random);
            let here = field.by_position(at.position);
            assert!(here.iter().any(|s| (s.slope - at.slope).abs() < 1e-6), "{whisker:?} {at:?}");
            for want in point_mode(whisker, at.position, Load::Normal).unwrap() {
                let inside = field.holds(want.s_a * 0.999, want.force * 1.001) && want.s_a > 0.101 * whisker.length;
                let near = |s: &SideState| (s.slope - want.phi_a).abs() < 1e-3;
                assert!(!inside || here.iter().any(near), "{whisker:?} {want:?} {here:?}");
            }
            let same = field.by_moment(at.s_a, at.moment);
            assert!(same.iter().any(|s| (s.slope - at.slope).abs() < 1e-6), "{whisker:?} {at:?}");
            for want in moment_mode(whisker, at.moment, at.s_a, Load::Normal).unwrap() {
                let inside = field.holds(at.s_a, want.force * 1.001);
                let near = |s: &SideState| (s.slope - want.phi_a).abs() < 1e-2;
                assert!(!inside || same.iter().any(near), "{whisker:?} {want:?} {same:?}");
            }
        }
    }
}

#[test]
fn a_neighbour_leads_to_the_same_branch() {
    for (whisker, field) in FIELDS.iter() {
        let (mut random, mut found) = (Random(26), 0);
        for _ in 0..300 {
            let at = state(field, whisker.length, &mut random);
            let (s_a, force) = (at.s_a * (1.0 + random.signed(0.03)), at.force * (1.0 + random.signed(0.03)));
            let Some(want) = field.at(s_a, force) else { continue };
            let Some(got) = field.by_position_from(want.position, &at) else { continue };
            found += 1;
            assert!(got.position.distance(want.position) < 1e-9 * whisker.length, "{at:?} {want:?} {got:?}");
            // Near a fold two states share a place.
            let same = (got.s_a - want.s_a).abs() < 1e-6 * whisker.length && (got.slope - want.slope).abs() < 1e-5;
            let listed = field.by_position(want.position).iter().any(|s| (s.slope - got.slope).abs() < 1e-6);
            assert!(same || listed, "{at:?} {want:?} {got:?}");
        }
        println!("taper {}, curvature {}: {found}", whisker.tip_ratio, whisker.curvature);
        assert!(found > 200, "{whisker:?}: {found}");
        let at = field.at(0.5 * whisker.length, 0.1 * field.largest_force(0.5 * whisker.length, 1.0)).unwrap();
        assert!(field.by_position_from(Vec2::new(-0.2, 0.3), &at).is_none());
        assert!(field.by_position_from(Vec2::new(f64::NAN, 0.0), &at).is_none());
    }
}

#[test]
fn a_stored_field_comes_back_bit_for_bit_and_damage_is_told() {
    for (whisker, field) in FIELDS.iter() {
        let bytes = field.to_bytes();
        let back = SideField::from_bytes(&bytes).unwrap();
        assert_eq!((back.to_bytes(), back.errors()), (bytes, field.errors()));
        let mut random = Random(27);
        for _ in 0..100 {
            let at = state(field, whisker.length, &mut random);
            assert_eq!(back.at(at.s_a, at.force), field.at(at.s_a, at.force));
            assert_eq!(back.by_position(at.position), field.by_position(at.position));
        }
    }
    let bytes = FIELDS[0].1.to_bytes();
    let mut flipped = bytes.clone();
    flipped[5_000] ^= 1;
    let tip = TipField::new(&plain()).unwrap().to_bytes();
    for (bytes, start) in [
        (&flipped[..], "a stored whisker field is damaged: its checksum does not match"),
        (&bytes[..1000], "a stored whisker field is damaged: its checksum does not match"),
        (&tip, "this is no stored whisker field"),
        (&[], "this is no stored whisker field"),
    ] {
        let error = SideField::from_bytes(bytes).err().unwrap();
        assert!(error.is_data() && error.to_string().starts_with(start), "{error}");
    }
}

#[test]
fn joints_cost_little() {
    let wire = |length: f64, second_moment: f64| Segment { length, young_modulus: 52e9, second_moment };
    let rod = Rod::from_segments(&[wire(0.03, 5.555e-15), wire(0.045, 2e-15)]).unwrap();
    let field = SideField::of_rod(&rod).unwrap();
    let mut random = Random(25);
    let mut worst = 0.0_f64;
    for _ in 0..500 {
        let at = state(&field, 0.075, &mut random);
        let Some(want) = rod.force_mode(at.force, at.s_a, Load::Normal).unwrap().pop() else { continue };
        worst = worst.max(at.position.distance(want.contact));
    }
    println!("worst {worst:e}, promised {:e}", field.errors().position);
    assert!(worst < field.errors().position && field.errors().position < 2e-5 * 0.075, "{worst} {:?}", field.errors());
}

#[test]
fn beyond_the_field_there_is_nothing() {
    let field = &FIELDS[0].1;
    for (s_a, force) in [(0.0, 0.1), (0.08, 0.1), (f64::NAN, 0.1), (0.05, f64::NAN), (0.05, 1e6)] {
        assert!(field.at(s_a, force).is_none());
    }
    assert!(field.by_position(Vec2::new(f64::NAN, 0.0)).is_empty());
    assert!(field.by_position(Vec2::new(0.2, 0.0)).is_empty());
    assert!(field.by_moment(0.05, 1.0).is_empty() && field.by_moment(0.2, 1e-3).is_empty());
    assert!(SideField::new(&Whisker { length: f64::NAN, ..plain() }).is_err());
}
