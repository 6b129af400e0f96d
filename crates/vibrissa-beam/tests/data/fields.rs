//! Tip fields for tests: one of every kind of whisker.
#![allow(dead_code, reason = "not every test asks for all of it")]

use super::random::Random;
use std::sync::LazyLock;
use vibrissa_beam::beam::field::{TipField, TipState};
use vibrissa_beam::beam::{Rod, Segment, Whisker};

pub(crate) fn plain() -> Whisker {
    Whisker::default()
}

/// One whisker of every kind, built once.
pub(crate) static FIELDS: LazyLock<Vec<(&str, TipField)>> = LazyLock::new(|| {
    let wire = |length: f64, second_moment: f64| Segment { length, young_modulus: 52e9, second_moment };
    let joined = Rod::from_segments(&[wire(0.03, 5.555e-15), wire(0.045, 2e-15)]).unwrap();
    let poly = Rod::new(&plain()).unwrap().with_curvature(&[2.0, -80.0, 600.0]).unwrap();
    let of = |whisker: Whisker| TipField::new(&whisker).unwrap();
    vec![
        ("uniform", of(plain())),
        ("tapered to one twentieth", of(Whisker { tip_ratio: 0.05, ..plain() })),
        ("curved", of(Whisker { curvature: 6.0, ..plain() })),
        ("on an elastic base", of(Whisker { base_stiffness: 0.03, ..plain() })),
        ("all", of(Whisker { tip_ratio: 0.4, curvature: -6.0, base_stiffness: 0.3, ..plain() })),
        ("two wires", TipField::of_rod(&joined).unwrap()),
        ("curved by a polynomial", TipField::of_rod(&poly).unwrap()),
    ]
});

pub(crate) fn uniform() -> &'static TipField {
    &FIELDS[0].1
}

/// A load that the field holds, anywhere in it.
pub(crate) fn load(field: &TipField, random: &mut Random) -> (f64, f64) {
    let (tilt, sign) = (random.signed(1.45), random.sign());
    (tilt, sign * field.largest_force(tilt, sign) * random.unit())
}

pub(crate) fn state(field: &TipField, random: &mut Random) -> TipState {
    let (tilt, force) = load(field, random);
    field.at(tilt, force).unwrap()
}
