//! Whiskers of every kind, and random contacts of them.

use super::random::Random;
use vibrissa::beam::{Load, Rod, Segment, Whisker};
use vibrissa::flow::contact_set::{Contact, ContactModel, MomentRegime, VirtualSensor};

pub(crate) const SENSORS: [VirtualSensor; 4] =
    [VirtualSensor::Load, VirtualSensor::Strip, VirtualSensor::Slope, VirtualSensor::Moment(MomentRegime::LargeAngle)];

/// A name, the model, and how many trials it is worth.
pub(crate) fn kinds() -> Vec<(&'static str, ContactModel, usize)> {
    let plain = Whisker::default();
    let normal = |whisker: Whisker| ContactModel::new(&whisker, Load::Normal).unwrap();
    let loaded = |load: Load| ContactModel::new(&plain, load).unwrap();
    let wire = |length: f64, second_moment: f64| Segment { length, young_modulus: 52e9, second_moment };
    let jointed = Rod::from_segments(&[wire(0.03, 9e-15), wire(0.04, 2e-15)]).unwrap();
    vec![
        ("uniform", normal(plain), 2000),
        ("uniform, tilted load", loaded(Load::Tilted(0.3)), 400),
        ("uniform, vertical load", loaded(Load::Vertical), 24),
        ("tapered", normal(Whisker { tip_ratio: 0.4, ..plain }), 400),
        ("curved", normal(Whisker { curvature: 6.0, ..plain }), 400),
        ("elastic base", normal(Whisker { base_stiffness: 0.1, ..plain }), 400),
        ("all three", normal(Whisker { tip_ratio: 0.5, curvature: -5.0, base_stiffness: 0.3, ..plain }), 400),
        ("jointed", ContactModel::of_rod(jointed, Load::Normal).unwrap(), 400),
    ]
}

/// A contact anywhere on the whisker, bent to either side up to about 120 degrees.
pub(crate) fn random_contact(random: &mut Random, model: &ContactModel) -> Contact {
    loop {
        let s_a = model.length() * random.between(0.02, 1.0);
        let slope = random.sign() * 10f64.powf(random.between(-3.0, 0.35));
        // The force that small-angle theory would need.
        let Some(gentle) = model.contact(1e-7, s_a) else { continue };
        let rest = model.contact(0.0, s_a).map_or(0.0, |c| c.phi_a);
        let force = slope / (gentle.phi_a - rest) * 1e-7;
        if let Some(contact) = model.contact(force, s_a).filter(|c| c.phi_a.abs() < 2.2) {
            return contact;
        }
    }
}
