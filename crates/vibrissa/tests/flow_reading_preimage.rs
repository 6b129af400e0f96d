//! Preimages of readings: no true state is left out, and areas are what geometry says.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/whiskers.rs"]
mod whiskers;

use core::f64::consts::{FRAC_PI_2, PI};
use random::Random;
use vibrissa::beam::{Load, Whisker};
use vibrissa::flow::contact_set::{Contact, ContactModel, ContactRegion, Parts, Reading, VirtualSensor};
use vibrissa::flow::preimage::{Construction, PreimageOptions, fused_preimage, reading_preimage};
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sets::Interval;
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Role};
use whiskers::{SENSORS, kinds, random_contact};

fn paper() -> ContactModel {
    ContactModel::new(&Whisker::default(), Load::Normal).unwrap()
}

fn map(role: Role, points: &[(f64, f64)]) -> Map {
    let points: Vec<Vec2> = points.iter().map(|p| Vec2::new(p.0, p.1)).collect();
    let curve = Curve::polyline(&points, role != Role::Wall).unwrap();
    Map::new(vec![Boundary::new(role, curve, None).unwrap()]).unwrap()
}

fn coarse(construction: Construction) -> PreimageOptions {
    PreimageOptions { cell: 2e-3, headings: 180, construction, contacts: Parts::Side, collision_free: false }
}

/// The whisker of `contact` with its side against the boundary: normals agree.
fn laid(contact: &Contact, position: Vec2, tangent: f64) -> Pose2 {
    let side = if contact.force >= 0.0 { 0.0 } else { PI };
    let theta = tangent + side - contact.phi_a;
    let base = position - contact.position.rotated(theta);
    Pose2::new(base.x, base.y, theta)
}

/// Whether the whisker is out of everything solid, but for a hair at the contact.
fn is_clear(map: &Map, model: &ContactModel, contact: &Contact, map_from_whisker: Pose2) -> bool {
    let inside = |p: &Vec2| {
        let place = map_from_whisker.transform_point(*p);
        !map.is_free(place) && map.nearest(place).unwrap().distance > 1e-6
    };
    !model.shape(contact, 60).iter().any(inside)
}

#[test]
fn true_states_are_in_their_preimage() {
    let arena = demo::arena().unwrap();
    let mut random = Random(11);
    let mount = Pose2::new(0.03, -0.01, 0.5);
    let (mut tried, mut collision_free) = (0, 0);
    for (index, (name, model, _)) in kinds().into_iter().enumerate().filter(|(i, _)| [0, 3, 4, 5].contains(i)) {
        for trial in 0..if index == 0 { 6 } else { 1 } {
            let mut contact = random_contact(&mut random, &model);
            while contact.phi_a.abs() > 1.2 {
                contact = random_contact(&mut random, &model);
            }
            let sensor = SENSORS[(trial + index) % 4];
            let value = sensor.read(&contact);
            let reading =
                Reading { sensor, value: Interval::new(value - 0.02 * value.abs(), value + 0.01 * value.abs()) };
            let any = coarse(Construction::Alignment);
            let options = PreimageOptions { collision_free: true, ..any };
            let found = [any, options].map(|o| reading_preimage(&arena, &model, mount, &[reading], &o).unwrap());
            for _ in 0..80 {
                let boundary = &arena.boundaries()[(random.unit() * 3.0) as usize];
                let at = boundary.curve().at(random.unit() * boundary.curve().length());
                let whisker = laid(&contact, at.position, at.tangent);
                let state = whisker.compose(mount.inverse());
                assert!(found[0].states.contains(state), "{name} {reading:?} {state:?}");
                tried += 1;
                if is_clear(&arena, &model, &contact, whisker) {
                    assert!(found[1].states.contains(state), "{name} {reading:?} {state:?}: lost to collisions");
                    collision_free += 1;
                }
            }
            assert!(found[1].states.volume() < found[0].states.volume());
        }
    }
    assert!(tried > 500 && collision_free > 50, "{tried} {collision_free}");
}

#[test]
fn any_angle_is_in_the_distance_preimage_and_it_holds_the_aligned_one() {
    let block = map(Role::Obstacle, &[(0.0, 0.0), (0.2, 0.0), (0.2, 0.1), (0.0, 0.1)]);
    let mut random = Random(12);
    let reading = Reading::exact(VirtualSensor::Load, 0.1);
    let solve = |c| reading_preimage(&block, &paper(), Pose2::IDENTITY, &[reading], &coarse(c)).unwrap();
    let (aligned, distance) = (solve(Construction::Alignment), solve(Construction::Distance));
    for _ in 0..500 {
        let contact = paper().contact(0.1, random.between(0.001, 0.075)).unwrap();
        let at = block.boundaries()[0].curve().at(random.between(0.0, 0.6));
        let theta = random.signed(PI);
        let base = at.position - contact.position.rotated(theta);
        assert!(distance.states.contains(Pose2::new(base.x, base.y, theta)));
    }
    let both = aligned.states.intersection(&distance.states).unwrap();
    // Covers are grown each by its own tolerance, so that a rim of cells may differ.
    assert!(both.volume() > 0.97 * aligned.states.volume(), "{} {}", both.volume(), aligned.states.volume());
    assert!(distance.states.volume() > 3.0 * aligned.states.volume());
}

#[test]
fn the_strip_of_distances_has_the_area_of_a_grown_wall() {
    let wall = map(Role::Wall, &[(0.0, 0.0), (0.5, 0.0)]);
    for (sensor, value, shortest) in [(VirtualSensor::Load, 0.1, 0.0), (VirtualSensor::Slope, 0.8, 0.0)] {
        let options = PreimageOptions {
            cell: 1e-3,
            headings: 180,
            construction: Construction::Distance,
            contacts: Parts::Side,
            collision_free: false,
        };
        let found =
            reading_preimage(&wall, &paper(), Pose2::IDENTITY, &[Reading::exact(sensor, value)], &options).unwrap();
        let reach = match sensor {
            VirtualSensor::Load => paper().contact(value, 0.075).unwrap().position.norm(),
            _ => {
                // The ray's end: the polar angle's sine law is not needed, the set itself tells its last contact.
                let set = vibrissa::flow::contact_set::ContactSet::new(&paper(), sensor, value, 50).unwrap();
                set.curves[0].contacts().last().unwrap().position.norm()
            }
        };
        assert!(shortest == 0.0 && reach < 0.075);
        let expected = 2.0 * reach * 0.5 + PI * reach * reach;
        let rim = (1.0 + 2.0 * PI * reach) * (found.deviation + 2e-3);
        assert!(
            found.states.area() >= expected && found.states.area() < expected + rim,
            "{sensor:?} {} {expected}",
            found.states.area()
        );
        assert!(found.sampled_area > expected - rim && found.sampled_area < expected + rim);
    }
}

#[test]
fn a_straight_wall_has_the_aligned_preimage_that_geometry_gives() {
    // Along a wall the base's distance from it, seen from the contact's tangent, is a function of the contact alone.
    let wall = map(Role::Arena, &[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
    let options = PreimageOptions { cell: 2e-3, contacts: Parts::Side, ..PreimageOptions::default() };
    let reading = Reading::exact(VirtualSensor::Load, 0.1);
    let found = reading_preimage(&wall, &paper(), Pose2::IDENTITY, &[reading], &options).unwrap();
    let height = |s_a: f64| {
        let c = paper().contact(0.1, s_a).unwrap();
        c.position.rotated(-c.phi_a).y.abs()
    };
    let farthest = (1..=300).map(|i| height(0.075 * f64::from(i) / 300.0)).fold(0.0, f64::max);
    // Away from the corners a column over the lower wall is filled from the wall to the farthest base.
    let filled = (0..found.states.raster().rows)
        .filter(|&row| {
            let column = found.states.raster().columns / 2;
            let y = found.states.raster().corner(column, row).y;
            y < 0.5 && found.states.holds(column, row)
        })
        .count() as f64
        * 2e-3;
    assert!(filled >= farthest - 2e-3 && filled < farthest + 4.0 * 2e-3 + found.deviation, "{filled} {farthest}");
    // One heading for each contact: pushed towards +y, the whisker at the tip's contact heads along the wall less its slope.
    let tip = paper().contact(0.1, 0.0749).unwrap();
    let state = laid(&tip, Vec2::new(0.5, 0.0), 0.0);
    assert!(found.states.contains(state) && state.y > 0.0);
    assert!(!found.states.contains(Pose2::new(state.x, state.y, state.theta + 0.3)));
    assert!(!found.states.contains(Pose2::new(state.x, state.y, state.theta + FRAC_PI_2)));
}

#[test]
fn fused_readings_leave_a_smaller_preimage() {
    let arena = demo::arena().unwrap();
    let truth = paper().contact(0.08, 0.06).unwrap();
    let options = coarse(Construction::Alignment);
    let solve = |readings: &[Reading]| reading_preimage(&arena, &paper(), Pose2::IDENTITY, readings, &options).unwrap();
    let (load, strip) =
        (Reading::exact(VirtualSensor::Load, truth.force), Reading::exact(VirtualSensor::Strip, truth.s_a));
    let (one, other, both) = (solve(&[load]), solve(&[strip]), solve(&[load, strip]));
    assert!(both.states.volume() < 0.3 * one.states.volume().min(other.states.volume()));
    let apart = one.states.intersection(&other.states).unwrap();
    assert!(apart.volume() >= both.states.intersection(&apart).unwrap().volume());
    // Every state of the fused set explains each reading by itself.
    assert!(both.states.intersection(&apart).unwrap().volume() > 0.9 * both.states.volume());
    // Readings that contradict each other leave nothing.
    let none = solve(&[load, Reading::exact(VirtualSensor::Moment(Default::default()), -1e-3)]);
    assert!(none.states.is_empty() && none.states.area() == 0.0 && none.states.volume() == 0.0);
}

#[test]
fn a_whisker_through_a_thin_wall_is_left_out_and_one_past_its_end_stays() {
    let walls = |points: [[(f64, f64); 2]; 2]| {
        let of = |p: [(f64, f64); 2]| Curve::polyline(&p.map(|p| Vec2::new(p.0, p.1)), false).unwrap();
        Map::new(points.map(|p| Boundary::new(Role::Wall, of(p), None).unwrap()).to_vec()).unwrap()
    };
    // The whisker lies against the upper wall from below, its base at x = 0; the other wall stands across its way.
    let contact = paper().contact(-0.1, 0.07).unwrap();
    let state = laid(&contact, Vec2::new(0.065, 0.1), 0.0 + PI);
    let readings = [Reading::exact(VirtualSensor::Load, -0.1), Reading::exact(VirtualSensor::Strip, 0.07)];
    let holds = |across: [(f64, f64); 2], collision_free: bool| {
        let options = PreimageOptions { collision_free, ..coarse(Construction::Alignment) };
        let map = walls([[(-0.1, 0.1), (0.3, 0.1)], across]);
        reading_preimage(&map, &paper(), Pose2::IDENTITY, &readings, &options).unwrap().states.contains(state)
    };
    let middle = paper().shape(&contact, 31)[15];
    let place = state.transform_point(middle);
    assert!(place.y < 0.099 && state.y < 0.1, "{state:?} {place:?}");
    let across = |from: f64, to: f64| [(place.x, place.y + from), (place.x, place.y + to)];
    assert!(holds(across(-0.05, 0.05), false) && !holds(across(-0.05, 0.05), true));
    // Beside it, past its end, and so near to its end that the grid cannot tell.
    assert!(holds(across(0.03, 0.05), true) && holds(across(-0.05, -0.02), true) && holds(across(-0.05, 1e-3), true));
}

#[test]
fn the_body_of_every_fused_whisker_is_checked() {
    // Two whiskers touch one point of a wall from both sides; a second wall stands in the way of one or the other.
    let (point, readings) = (Vec2::new(0.0, 0.1), [-0.2, 0.2]);
    let contacts = readings.map(|force| paper().contact(force, 0.07).unwrap());
    let [first, second] = contacts.map(|contact| laid(&contact, point, PI));
    let mounts = [Pose2::IDENTITY, first.between(second)];
    let options = PreimageOptions { cell: 1e-3, collision_free: true, ..coarse(Construction::Alignment) };
    let regions = [0, 1].map(|i| {
        let own = [Reading::exact(VirtualSensor::Load, readings[i]), Reading::exact(VirtualSensor::Strip, 0.07)];
        (ContactRegion::new(&paper(), &own, &options.resolution(0.2)).unwrap(), mounts[i])
    });
    let holds = |x: f64| {
        let of = |points: &[Vec2]| Boundary::new(Role::Wall, Curve::polyline(points, false).unwrap(), None).unwrap();
        let wall = of(&[Vec2::new(-0.2, 0.1), Vec2::new(0.2, 0.1)]);
        let across = of(&[Vec2::new(x, -0.1), Vec2::new(x, 0.098)]);
        let map = Map::new(vec![wall, across]).unwrap();
        fused_preimage(&map, &regions, &options).unwrap().states.contains(first)
    };
    let middles = [0, 1].map(|i| [first, second][i].transform_point(paper().shape(&contacts[i], 31)[7]));
    assert!(middles[0].x * middles[1].x < 0.0, "{middles:?}");
    assert!(!holds(middles[0].x) && !holds(middles[1].x));
    assert!(holds(0.15));
}

#[test]
fn sampled_places_are_never_more_than_the_cover() {
    let map = map(Role::Arena, &[(0.0, 0.0), (0.3, 0.02), (0.28, 0.2), (0.12, 0.15), (0.02, 0.22)]);
    let options = PreimageOptions { contacts: Parts::All, collision_free: true, ..coarse(Construction::Alignment) };
    for force in [-0.3, -0.05, 0.02, 0.1, 0.4] {
        let reading = Reading::exact(VirtualSensor::Load, force);
        let found = reading_preimage(&map, &paper(), Pose2::IDENTITY, &[reading], &options).unwrap();
        let (sampled, cover) = (found.sampled_area, found.states.area());
        assert!(sampled > 0.5 * cover && sampled <= cover, "{force} N: {sampled} of {cover} m²");
    }
}

#[test]
fn options_out_of_range_are_refused() {
    let wall = map(Role::Wall, &[(0.0, 0.0), (500.0, 400.0)]);
    let reading = Reading::exact(VirtualSensor::Load, 0.1);
    for options in [
        PreimageOptions::default(),
        PreimageOptions { cell: f64::NAN, ..PreimageOptions::default() },
        PreimageOptions { headings: 0, ..PreimageOptions::default() },
    ] {
        let error = reading_preimage(&wall, &paper(), Pose2::IDENTITY, &[reading], &options).unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("allowed"), "{error}");
    }
}
