//! Meetings of contact sets: every component, crossings to rounding, degenerate cases.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;

use random::Random;
use vibrissa::beam::{Load, Whisker};
use vibrissa::flow::contact_set::{
    ContactModel, ContactRegion, ContactSet, MomentRegime, PlacedSet, Reading, Resolution, VirtualSensor, intersect,
    intersect_all,
};
use vibrissa::plane::{Pose2, Vec2};

const MOMENT: VirtualSensor = VirtualSensor::Moment(MomentRegime::LargeAngle);

fn paper() -> ContactModel {
    ContactModel::new(&Whisker::default(), Load::Normal).unwrap()
}

fn set(sensor: VirtualSensor, value: f64) -> ContactSet {
    ContactSet::new(&paper(), sensor, value, 200).unwrap()
}

#[test]
fn two_sensors_on_one_whisker_meet_at_the_contact() {
    let mut random = Random(5);
    let sensors = [VirtualSensor::Load, VirtualSensor::Strip, VirtualSensor::Slope, MOMENT];
    for trial in 0..300 {
        let Some(truth) = paper().contact(random.sign() * random.between(0.03, 0.15), random.between(0.03, 0.074))
        else {
            continue;
        };
        let (i, j) = (trial % 4, (trial + 1 + trial / 4 % 3) % 4);
        let sets = [i, j].map(|k| set(sensors[k], sensors[k].read(&truth)));
        let found = intersect(PlacedSet::at_home(&sets[0]), PlacedSet::at_home(&sets[1]), 1e-9);
        let hit = found.iter().find(|m| m.is_crossing && m.position.distance(truth.position) < 1e-9);
        assert!(hit.is_some_and(|m| m.is_one_shape()), "{i} {j} {truth:?}: {found:?}");
    }
}

#[test]
fn two_whiskers_at_known_mounts_meet_at_the_point_that_both_touch() {
    let mut random = Random(6);
    let mount = Pose2::new(0.0, 0.0042, 0.0);
    for _ in 0..100 {
        let point = Vec2::new(random.between(0.045, 0.06), random.between(0.012, 0.02));
        let touched = [point, mount.inverse_transform_point(point)]
            .map(|p| vibrissa::beam::point_mode(&Whisker::default(), p, Load::Normal).unwrap().remove(0));
        let sets = touched.map(|b| set(MOMENT, b.moment));
        let placed = [PlacedSet::at_home(&sets[0]), PlacedSet { set: &sets[1], frame_from_whisker: mount }];
        let found = intersect(placed[0], placed[1], 1e-9);
        assert!(
            found.iter().any(|m| m.position.distance(point) < 1e-6 || (m.position.distance(point) < m.extent + 1e-5)),
            "{point:?} {found:?}"
        );
    }
}

#[test]
fn an_intersection_need_not_be_connected() {
    // Against the second proposition: the base turns about itself while the contact stays. Both moments' curves start at
    // the base, which stays, too; they meet there and at the contact, and nowhere in between.
    let contact = Vec2::new(0.055, 0.012);
    let turn = Pose2::new(0.0, 0.0, -0.06);
    let moments = [contact, turn.inverse_transform_point(contact)]
        .map(|p| vibrissa::beam::point_mode(&Whisker::default(), p, Load::Normal).unwrap().remove(0).moment);
    let sets = moments.map(|m| set(MOMENT, m));
    let second = PlacedSet { set: &sets[1], frame_from_whisker: turn };
    let found = intersect(PlacedSet::at_home(&sets[0]), second, 2e-4);
    let at_base = found.iter().any(|m| m.stretch[0].norm() < 2e-3);
    let at_contact = found.iter().any(|m| m.position.distance(contact) < 1e-8);
    assert!(at_base && at_contact && found.len() >= 2, "{found:?}");
    // The regions say the same: cells around both, in separate components.
    let regions = [0, 1].map(|i| {
        ContactRegion::new(&paper(), &[Reading::exact(MOMENT, moments[i])], &Resolution::even(0.2e-3, 0.1)).unwrap()
    });
    let shared = regions[0].shared_with(&regions[1], turn);
    let components = shared.components();
    let holds =
        |p: Vec2| components.iter().position(|c| c.iter().any(|&i| shared.cells[i].cover.grown(1e-4).contains(p)));
    let (base, far) = (holds(Vec2::ZERO), holds(contact));
    assert!(base.is_some() && far.is_some() && base != far, "{base:?} {far:?}");
}

#[test]
fn same_curves_shared_pieces_and_nothing() {
    let one = set(VirtualSensor::Load, 0.1);
    let same = intersect(PlacedSet::at_home(&one), PlacedSet::at_home(&one), 0.0);
    assert_eq!(same.len(), 1);
    assert!((same[0].extent / one.curves[0].length() - 1.0).abs() < 1e-6, "{same:?}");
    // Two rays from one base at different angles share the base only, which the curves leave out.
    let rays = [0.5, 0.9].map(|phi| set(VirtualSensor::Slope, phi));
    assert!(intersect(PlacedSet::at_home(&rays[0]), PlacedSet::at_home(&rays[1]), 0.0).is_empty());
    // A ray and the same ray further out share a piece.
    let along = rays[0].curves[0].contacts()[199].position;
    let pushed = PlacedSet { set: &rays[0], frame_from_whisker: Pose2::new(0.5 * along.x, 0.5 * along.y, 0.0) };
    let shared = intersect(PlacedSet::at_home(&rays[0]), pushed, 1e-9);
    assert_eq!(shared.len(), 1, "{shared:?}");
    assert!((shared[0].extent - 0.5 * along.norm()).abs() < 2e-4, "{shared:?}");
    // Three sets: the third decides.
    let truth = paper().contact(0.1, 0.05).unwrap();
    let (strip, good, bad) =
        (set(VirtualSensor::Strip, 0.05), set(MOMENT, truth.moment), set(MOMENT, 1.3 * truth.moment));
    let [a, b, c, d] = [&one, &strip, &good, &bad].map(PlacedSet::at_home);
    assert_eq!(intersect_all(&[a, b, c], 1e-9).len(), 1);
    assert!(intersect_all(&[a, b, d], 1e-9).is_empty());
    assert!(intersect_all(&[a], 1e-9).is_empty());
    let none = set(VirtualSensor::Strip, 0.1);
    assert!(intersect(a, PlacedSet::at_home(&none), 1.0).is_empty());
}
