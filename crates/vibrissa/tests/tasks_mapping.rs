//! Maps from logs alone: the outline, the way and closures of simulated laps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/lap.rs"]
mod lap;
#[path = "data/random.rs"]
mod random;

use lap::{Kind, Law, OdometryError, Room, record, robot, room, way};
use random::Random;
use vibrissa::Stop;
use vibrissa::config::MappingOptions;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::{Curve, Vec2};
use vibrissa::tasks::mapping::{ChangeKind, ClosureVerdict, Mapper, map_log, map_logs};
use vibrissa::world::{Boundary, Map, Role};

#[test]
fn a_lap_makes_a_room_with_its_corners() {
    let mut draw = Random(12);
    let room = room(&mut draw, Kind::Rectangle, (1.5, 1.6)).unwrap();
    let robot = robot(&mut draw);
    let path = way(&room, &mut draw, 0.3, 1.1 * room.map.total_length()).unwrap();
    let lap = record(&room.map, &robot, &path, Law::Even, OdometryError::default(), &mut draw).unwrap();
    let found = map_log(&lap.log, &robot, MappingOptions::default(), &Stop::default(), &mut |_, _| {}).unwrap();
    let first = path[0].map_from_robot;
    // What is known lies on the true walls, within its band.
    let map = &found.outline.map;
    let (mut known, mut within) = (0, 0);
    for sample in map.samples(2e-3) {
        let boundary = &map.boundaries()[sample.boundary];
        let piece = boundary.curve().segment_at(sample.arc_length);
        let Some(band) = boundary.piece_course(piece).unwrap().widest() else { continue };
        let distance = room.map.nearest(first.transform_point(sample.position)).unwrap().distance;
        known += 1;
        within += usize::from(distance <= band.bound);
        assert!(distance < 2e-3, "{distance} at {:?}", sample.position);
    }
    assert!(known > 500 && within as f64 > 0.99 * known as f64, "{within} of {known}");
    for corner in &found.outline.corners {
        let there = first.transform_point(corner.position);
        let off = room.corners.iter().map(|c| c.distance(there)).fold(f64::INFINITY, f64::min);
        assert!(off < 2e-3, "{off}");
    }
    assert_eq!((map.boundaries().len(), found.outline.corners.len()), (1, 4));
    let area = |map: &Map| map.boundaries()[0].curve().signed_area().abs();
    assert!((area(map) / area(&room.map) - 1.0).abs() < 2e-3, "{} {}", area(map), area(&room.map));
    // With exact odometry the way is that of the odometry, and the robot came back where it says.
    let (last, told) = (path[path.len() - 1].map_from_robot, found.trajectory().last().unwrap().map_from_robot);
    assert!(first.compose(told).position().distance(last.position()) < 1e-3);
    assert!(!found.closures.is_empty());
    assert!(found.closures.iter().all(|closure| closure.verdict == ClosureVerdict::Proved), "{:?}", found.closures);
}

#[test]
fn nothing_felt_is_an_error_that_says_what_to_do() {
    let mut draw = Random(3);
    let room = room(&mut draw, Kind::Rectangle, (1.5, 1.6)).unwrap();
    let robot = robot(&mut draw);
    let path = way(&room, &mut draw, 0.3, 0.3).unwrap();
    let lap = record(&room.map, &robot, &path[..20], Law::Even, OdometryError::default(), &mut draw).unwrap();
    let free = SensorLog { rows: lap.log.rows[..10].to_vec(), ..lap.log.clone() };
    let told = map_log(&free, &robot, MappingOptions::default(), &Stop::default(), &mut |_, _| {}).unwrap_err();
    assert!(told.to_string().contains("help: "), "{told}");
    let empty = SensorLog { rows: Vec::new(), ..lap.log.clone() };
    assert!(Mapper::new(&robot, &empty, MappingOptions::default()).unwrap().map().is_err());
    let bad = MappingOptions { drift: f64::NAN, ..MappingOptions::default() };
    assert!(Mapper::new(&robot, &empty, bad).is_err());
}

#[test]
fn a_second_log_from_anywhere_finds_its_place_and_tells_the_wall_that_has_moved() {
    let mut draw = Random(5);
    let before = room(&mut draw, Kind::LShape, (1.4, 1.5)).unwrap();
    let robot = robot(&mut draw);
    // The second of the walls comes 9 mm nearer.
    let mut corners = before.corners.clone();
    let inward = (corners[2] - corners[1]).perp() * (9e-3 / corners[1].distance(corners[2]));
    (corners[1], corners[2]) = (corners[1] + inward, corners[2] + inward);
    let boundary = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
    let map = Map::new(vec![boundary]).unwrap();
    // The second lap begins at the fourth wall.
    corners.rotate_left(3);
    let after = Room { corners, map };
    let first = way(&before, &mut draw, 0.3, 1.1 * before.map.total_length()).unwrap();
    let second = way(&after, &mut draw, 0.5, 1.0 * before.map.total_length()).unwrap();
    let logs = [(&before, &first), (&after, &second)].map(|(room, path)| {
        record(&room.map, &robot, path, Law::Even, OdometryError::default(), &mut draw).unwrap().log
    });
    // Between them one from another room, for which there is no place.
    let other = room(&mut draw, Kind::Polygon, (0.9, 0.95)).unwrap();
    let third = way(&other, &mut draw, 0.3, 0.9 * other.map.total_length()).unwrap();
    let third = record(&other.map, &robot, &third, Law::Even, OdometryError::default(), &mut draw).unwrap().log;
    let [before_log, after_log] = logs;
    let logs = [before_log, third, after_log];
    let found = map_logs(&logs, &robot, MappingOptions::default(), &Stop::default(), &mut |_, _| {}).unwrap();
    assert_ne!(found.visits[1].placed, ClosureVerdict::Proved);
    let map_from_truth = first[0].map_from_robot.inverse();
    let visit = &found.visits[2];
    assert_eq!((visit.placed, visit.places), (ClosureVerdict::Proved, 1));
    for (told, truth) in visit.trajectory.iter().zip(&second) {
        let truth = map_from_truth.compose(truth.map_from_robot);
        let off = told.map_from_robot.position().distance(truth.position());
        assert!(off < 0.5e-3, "{off} at {}", told.t);
    }
    assert!(!found.changes.is_empty());
    for change in &found.changes {
        assert_eq!(change.log, 2);
        let ChangeKind::Moved { by, std } = change.kind else { panic!("{change:?}") };
        assert!((by - 9e-3).abs() < 3.0 * std && std < 0.5e-3, "{by} {std}");
        assert!(change.points.iter().all(|p| on_wall(&after.map, map_from_truth.inverse().transform_point(*p))));
    }
    // What has moved is drawn where it is now, and nowhere else.
    for point in found.outline.known_points(2e-3) {
        assert!(on_wall(&after.map, map_from_truth.inverse().transform_point(point)), "{point:?}");
    }
    assert!(map_logs(&[], &robot, MappingOptions::default(), &Stop::default(), &mut |_, _| {}).is_err());
}

fn on_wall(map: &Map, place: Vec2) -> bool {
    map.nearest(place).unwrap().distance < 2e-3
}
