//! Contact sets of the virtual sensors: nothing true is left out, and nothing is in that should not be.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/whiskers.rs"]
mod whiskers;

use random::Random;
use vibrissa::beam::{Load, Rod, SmallAngle, Whisker, force_mode, point_mode};
use vibrissa::flow::contact_set::{
    Contact, ContactModel, ContactRegion, ContactSet, Limits, MomentRegime, Reading, Resolution, VirtualSensor,
};
use vibrissa::plane::Vec2;
use vibrissa::sets::Interval;
use whiskers::{SENSORS, kinds, random_contact};

const EI: f64 = 2.8886e-4;
const LENGTH: f64 = 0.075;

fn paper() -> ContactModel {
    ContactModel::new(&Whisker::default(), Load::Normal).unwrap()
}

/// The contacts of all curves of an exact reading.
fn set(model: &ContactModel, sensor: VirtualSensor, value: f64) -> ContactSet {
    ContactSet::new(model, sensor, value, 200).unwrap()
}

#[test]
fn the_forward_map_is_the_beams() {
    let mut random = Random(1);
    for _ in 0..200 {
        let (force, s_a) = (random.signed(0.5), random.between(0.01, LENGTH));
        let bends = force_mode(&Whisker::default(), force, s_a, Load::Normal).unwrap();
        let Some(bend) = bends.first() else { continue };
        let contact = paper().contact(force, s_a).unwrap();
        for (sensor, value) in SENSORS.into_iter().zip([bend.force, bend.s_a, bend.phi_a, bend.moment]) {
            assert!((sensor.read(&contact) - value).abs() <= 1e-11 * value.abs(), "{sensor:?}");
        }
        assert!(contact.position.distance(bend.contact) < 1e-14);
    }
}

#[test]
fn true_contacts_are_on_the_curves_of_their_readings() {
    let mut random = Random(2);
    for (name, model, trials) in kinds() {
        for trial in 0..trials {
            let contact = random_contact(&mut random, &model);
            let sensor = SENSORS[trial % 4];
            let set = set(&model, sensor, sensor.read(&contact));
            let gap = set.distance(contact.position);
            assert!(gap <= set.tolerance + 1e-9, "{name} {sensor:?} {contact:?}: {gap} beyond {}", set.tolerance);
            // Traced curves follow the grid's nodes, which are further apart where a curve turns sharply.
            let most = if model.has_closed_family() { 4e-3 } else { 2e-2 } * model.length();
            assert!(set.tolerance < most, "{name} {sensor:?}: {}", set.tolerance);
        }
    }
}

#[test]
fn every_node_of_a_curve_has_the_reading_by_the_beams_own_inverse() {
    // Point mode knows nothing of readings: it must find the shape of each node from its place alone.
    let whisker = Whisker::default();
    for (sensor, value) in SENSORS.into_iter().zip([-0.12, 0.06, 0.9, -5e-3]) {
        let set = set(&paper(), sensor, value);
        assert!(!set.is_empty());
        for contact in set.curves.iter().flat_map(|c| c.contacts()).filter(|c| c.phi_a.abs() < 2.5).step_by(7) {
            let bends = point_mode(&whisker, contact.position, Load::Normal).unwrap();
            let readings = bends.iter().map(|b| {
                sensor.read(&Contact {
                    force: b.force,
                    s_a: b.s_a,
                    phi_a: b.phi_a,
                    position: b.contact,
                    moment: b.moment,
                    tilt: 0.0,
                })
            });
            let off = readings.map(|r| (r - value).abs()).fold(f64::INFINITY, f64::min);
            assert!(off <= 1e-6 * value.abs(), "{sensor:?} {contact:?}: {off}");
            assert!(contact.s_a <= LENGTH * (1.0 + 1e-9));
        }
    }
}

#[test]
fn traced_curves_agree_with_the_closed_families() {
    // The same whisker once in closed form and once as a rod that is integrated and tabulated.
    let rod = ContactModel::of_rod(Rod::new(&Whisker::default()).unwrap(), Load::Normal).unwrap();
    for (sensor, value) in SENSORS.into_iter().zip([0.1, 0.05, -0.7, 4e-3]) {
        let sensor = if let VirtualSensor::Moment(_) = sensor {
            VirtualSensor::Moment(MomentRegime::LargeAngle)
        } else {
            sensor
        };
        let (closed, traced) = (set(&paper(), sensor, value), set(&rod, sensor, value));
        assert!(!closed.is_empty() && !traced.is_empty(), "{sensor:?}");
        for contact in traced.curves.iter().flat_map(|c| c.contacts()) {
            // A node is as far from the beam's curve as the table says, which is what a caller is promised. To bring it there to rounding
            // takes a step on the beam itself for each node, some hundred times as long as the whole set.
            let known = closed.tolerance + traced.tolerance.min(1e-6);
            assert!(closed.distance(contact.position) <= known, "{sensor:?} {contact:?}");
        }
        // A rod's first mode is cut where the grid ends; away from there the curves are as long.
        for contact in closed.curves.iter().flat_map(|c| c.contacts()).filter(|c| c.phi_a.abs() < 2.8) {
            let gap = traced.distance(contact.position);
            assert!(gap <= traced.tolerance + 1e-4, "{sensor:?} {contact:?}: {gap}");
        }
    }
}

#[test]
fn a_moment_has_both_branches_and_one_loop_when_the_whisker_is_long() {
    let large = VirtualSensor::Moment(MomentRegime::LargeAngle);
    // 4 mN m: the fold lies at 2.944 EI / M0 = 212 mm, beyond the tip, so that the branches are apart.
    let apart = set(&paper(), large, 4e-3);
    assert_eq!(apart.curves.len(), 2);
    let tips = apart.curves.iter().map(|c| c.contacts().iter().map(|n| n.s_a).fold(0.0, f64::max));
    assert!(tips.into_iter().all(|s| (s / LENGTH - 1.0).abs() < 1e-9));
    // 17 mN m: the fold lies at 50 mm; one loop from the base to the base.
    let whole = set(&paper(), large, 17e-3);
    assert_eq!(whole.curves.len(), 1);
    let furthest = whole.curves[0].contacts().iter().map(|n| n.s_a).fold(0.0, f64::max);
    assert!((furthest / (vibrissa::beam::normal::largest_moment() * EI / 17e-3) - 1.0).abs() < 1e-3, "{furthest}");
    // An end slope is a straight ray from the base.
    let ray = set(&paper(), VirtualSensor::Slope, 1.0);
    let far = ray.curves[0].contacts().last().unwrap().position;
    assert!(ray.curves[0].contacts().iter().all(|n| n.position.cross(far).abs() < 1e-15));
}

#[test]
fn the_moment_regime_changes_at_a_tenth_of_the_length() {
    let moment = VirtualSensor::Moment(MomentRegime::Auto);
    let threshold = 0.3 * EI / LENGTH;
    for sign in [1.0, -1.0] {
        let small = set(&paper(), moment, sign * 0.999 * threshold);
        assert!(small.model().is_small_angle());
        assert!(!set(&paper(), moment, sign * 1.001 * threshold).model().is_small_angle());
        for contact in small.curves.iter().flat_map(|c| c.contacts()) {
            let closed = SmallAngle::from_moment(EI, contact.moment, contact.s_a);
            assert!(contact.position.distance(closed.contact()) < 1e-15);
            assert!((contact.phi_a - closed.phi_a()).abs() < 1e-14);
        }
        // The elastica's contacts are within what the set says about its own error, and that is not much.
        assert!(small.tolerance < 2e-3, "{}", small.tolerance);
        let large = set(&paper(), VirtualSensor::Moment(MomentRegime::LargeAngle), small.value);
        let least = large.curves.iter().flat_map(|c| c.contacts()).filter(|c| c.phi_a.abs() < 1.0);
        for contact in least {
            assert!(small.distance(contact.position) <= small.tolerance, "{contact:?}");
        }
    }
    let curved = ContactModel::new(&Whisker { curvature: 5.0, ..Whisker::default() }, Load::Normal).unwrap();
    assert!(ContactSet::new(&curved, VirtualSensor::Moment(MomentRegime::SmallAngle), 1e-4, 50).is_err());
}

#[test]
fn small_angle_beams_agree_with_gently_loaded_rods() {
    // Taper and an elastic base, straight at rest: the integrated rod under a force that hardly bends it.
    let whisker = Whisker { tip_ratio: 0.3, base_stiffness: 0.2, ..Whisker::default() };
    let rod = ContactModel::new(&whisker, Load::Normal).unwrap();
    let small = rod.in_regime(MomentRegime::SmallAngle, 0.0).unwrap();
    for s_a in [0.02, 0.05, 0.075] {
        let (exact, linear) = (rod.contact(1e-6, s_a).unwrap(), small.contact(1e-6, s_a).unwrap());
        assert!((linear.phi_a / exact.phi_a - 1.0).abs() < 1e-6, "{s_a}");
        assert!((linear.position.y / exact.position.y - 1.0).abs() < 1e-6, "{s_a}");
        let (a, b) = (small.shape(&linear, 301), rod.shape(&exact, 301));
        assert!(a.iter().zip(&b).all(|(p, q)| p.distance(*q) < 1e-5 * b[300].y.abs() + 1e-9), "{s_a}");
    }
}

#[test]
fn limits_and_impossible_readings_cut_the_sets() {
    let limited = paper().with_limits(Limits { force: 0.2, moment: 8e-3, slope: 1.2 }).unwrap();
    for (sensor, value) in SENSORS.into_iter().zip([0.15, 0.06, 1.0, 7e-3]) {
        let (all, cut) = (set(&paper(), sensor, value), set(&limited, sensor, value));
        let length = |set: &ContactSet| set.curves.iter().map(|c| c.length()).sum::<f64>();
        assert!(length(&cut) < length(&all) && !cut.is_empty(), "{sensor:?}");
        let nodes = cut.curves.iter().flat_map(|c| c.contacts());
        assert!(
            nodes
                .clone()
                .all(|c| c.force.abs() <= 0.2 + 1e-9 && c.moment.abs() <= 8e-3 + 1e-9 && c.phi_a.abs() <= 1.2 + 1e-9)
        );
    }
    for (sensor, value) in SENSORS.into_iter().zip([0.25, 0.08, 1.3, 9e-3]) {
        assert!(set(&limited, sensor, value).is_empty(), "{sensor:?}");
        let region = ContactRegion::new(&limited, &[Reading::exact(sensor, value)], &Resolution::default()).unwrap();
        assert!(region.is_empty() && region.area() <= 0.0, "{sensor:?}");
        assert!(ContactSet::new(&limited, sensor, f64::NAN, 50).is_err());
        assert!(ContactSet::new(&limited, sensor, f64::INFINITY, 50).is_err());
    }
    assert!(
        set(&paper(), VirtualSensor::Strip, 0.0).is_empty() && set(&paper(), VirtualSensor::Strip, -0.01).is_empty()
    );
    assert!(set(&paper(), VirtualSensor::Slope, 3.3).is_empty());
    assert!(ContactModel::new(&Whisker::default(), Load::Directed(0.3)).is_err());
    assert!(paper().with_limits(Limits { force: -1.0, ..Limits::default() }).is_err());
}

#[test]
fn readings_of_nothing_are_the_whisker_at_rest() {
    for sensor in [VirtualSensor::Load, VirtualSensor::Slope, VirtualSensor::Moment(MomentRegime::LargeAngle)] {
        let set = set(&paper(), sensor, 0.0);
        assert_eq!(set.curves.len(), 1, "{sensor:?}");
        assert!(set.curves[0].contacts().iter().all(|c| c.position.y == 0.0 && c.force == 0.0));
    }
    let curved = ContactModel::new(&Whisker { curvature: 6.0, ..Whisker::default() }, Load::Normal).unwrap();
    let rest = set(&curved, VirtualSensor::Moment(MomentRegime::Auto), 0.0);
    let arc = |s: f64| Vec2::new((6.0 * s).sin() / 6.0, (1.0 - (6.0 * s).cos()) / 6.0);
    for s in [0.01, 0.04, 0.07] {
        assert!(rest.distance(arc(s)) <= rest.tolerance + 1e-7, "{s}: {}", rest.distance(arc(s)));
    }
}

#[test]
fn mirrored_readings_give_mirrored_sets() {
    for (sensor, value) in SENSORS.into_iter().zip([0.1, 0.06, 0.8, 6e-3]) {
        if sensor == VirtualSensor::Strip {
            let both = set(&paper(), sensor, value);
            assert!(both.curves[0].contacts().iter().any(|c| c.position.y > 0.01));
            assert!(both.curves[0].contacts().iter().any(|c| c.position.y < -0.01));
            continue;
        }
        let (up, down) = (set(&paper(), sensor, value), set(&paper(), sensor, -value));
        for contact in up.curves.iter().flat_map(|c| c.contacts()) {
            let mirrored = Vec2::new(contact.position.x, -contact.position.y);
            assert!(contact.position.y > 0.0 && down.distance(mirrored) <= down.tolerance + 1e-12, "{sensor:?}");
        }
    }
}

#[test]
fn contact_sets_are_compact_and_each_branch_is_connected() {
    // The first proposition: each branch is a continuous image of a closed interval, so it is bounded and in one piece.
    let mut random = Random(7);
    for (name, model, trials) in kinds() {
        for trial in 0..trials / 4 {
            let contact = random_contact(&mut random, &model);
            let sensor = SENSORS[trial % 4];
            let set = set(&model, sensor, sensor.read(&contact));
            for curve in &set.curves {
                let points = curve.points();
                assert!(points.iter().all(|p| p.norm() <= model.length() * (1.0 + 1e-9)), "{name}");
                let largest = points.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f64::max);
                assert!(largest < 0.12 * model.length(), "{name} {sensor:?}: a gap of {largest} m at {contact:?}");
            }
        }
    }
}

#[test]
fn regions_hold_every_contact_whose_reading_is_in_the_interval() {
    let mut random = Random(3);
    for (name, model, trials) in kinds() {
        // A vertical load takes a search for each contact; `examples/random_readings.rs` has the patience.
        if name.contains("vertical") {
            continue;
        }
        for trial in 0..trials.min(4) {
            let contact = random_contact(&mut random, &model);
            let sensor = SENSORS[trial % 4];
            let value = sensor.read(&contact);
            let (below, above) = (random.unit() * 0.05 * value.abs(), random.unit() * 0.05 * value.abs());
            let reading = Reading { sensor, value: Interval::new(value - below, value + above) };
            let region = ContactRegion::new(&model, &[reading], &Resolution::even(3e-3, 0.5)).unwrap();
            assert!(region.explains(&contact), "{name} {reading:?} {contact:?}");
        }
    }
}

#[test]
fn areas_agree_with_a_brute_force_grid() {
    let whisker = Whisker::default();
    let readings = [
        Reading { sensor: VirtualSensor::Load, value: Interval::new(0.09, 0.11) },
        Reading { sensor: VirtualSensor::Strip, value: Interval::new(0.05, 0.055) },
        Reading { sensor: VirtualSensor::Slope, value: Interval::new(-0.9, -0.8) },
        Reading { sensor: VirtualSensor::Moment(MomentRegime::LargeAngle), value: Interval::new(5e-3, 5.5e-3) },
    ];
    let limits = Limits { force: 0.5, moment: 0.02, slope: 1.5 };
    let model = paper().with_limits(limits).unwrap();
    for reading in readings {
        let region = ContactRegion::new(&model, &[reading], &Resolution::default()).unwrap();
        // Every cell of a grid is asked by point mode whether some shape there has the reading.
        let step = 0.5e-3;
        let (mut truth, mut rim, mut missed) = (0usize, 0usize, 0usize);
        let explained = |p: Vec2| {
            point_mode(&whisker, p, Load::Normal).unwrap().iter().any(|b| {
                let c = Contact {
                    force: b.force,
                    s_a: b.s_a,
                    phi_a: b.phi_a,
                    position: b.contact,
                    moment: b.moment,
                    tilt: 0.0,
                };
                reading.value.contains(reading.sensor.read(&c)) && limits.admit(&c)
            })
        };
        for i in 0..160 {
            let mut last = false;
            for j in -150..150 {
                let p = Vec2::new((f64::from(i) + 0.5) * step, (f64::from(j) + 0.5) * step);
                let inside = explained(p);
                truth += usize::from(inside);
                rim += usize::from(inside != last);
                last = inside;
                missed += usize::from(inside && !region.contains(p));
            }
        }
        let (expected, error) = (truth as f64 * step * step, rim as f64 * step * step);
        assert_eq!(missed, 0, "{reading:?}");
        assert!(
            (region.area() - expected).abs() < 0.06 * expected + 0.5 * error,
            "{reading:?}: {} {expected} {error}",
            region.area()
        );
        assert!(region.area() > 0.97 * expected - 0.2 * error, "{reading:?}");
    }
}

#[test]
fn readings_are_fused_on_the_contact_itself() {
    let model = paper();
    let truth = model.contact(0.11, 0.062).unwrap();
    let all: Vec<Reading> = SENSORS.into_iter().map(|s| Reading::exact(s, s.read(&truth))).collect();
    let fused = ContactRegion::new(&model, &all, &Resolution::default()).unwrap();
    assert!(fused.explains(&truth) && fused.area() < 1e-6, "{}", fused.area());
    assert_eq!(fused.components().len(), 1);
    // A contradiction leaves nothing: this moment needs a larger force at this place.
    let wrong = [all[0], all[1], Reading::exact(VirtualSensor::Moment(MomentRegime::Auto), 1.2 * truth.moment)];
    assert!(ContactRegion::new(&model, &wrong, &Resolution::default()).unwrap().is_empty());
}
