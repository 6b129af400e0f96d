//! Maps from logs alone: the outline, the way and closures of simulated laps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/lap.rs"]
mod lap;
#[path = "data/random.rs"]
mod random;

use lap::{Kind, Law, OdometryError, record, robot, room, way};
use random::Random;
use vibrissa::Stop;
use vibrissa::config::MappingOptions;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::tasks::mapping::{ClosureVerdict, Mapper, map_log};

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
    let area = |map: &vibrissa::world::Map| map.boundaries()[0].curve().signed_area().abs();
    assert!((area(map) / area(&room.map) - 1.0).abs() < 2e-3, "{} {}", area(map), area(&room.map));
    // With exact odometry the way is that of the odometry, and the robot came back where it says.
    let (last, told) = (path[path.len() - 1].map_from_robot, found.trajectory.last().unwrap().map_from_robot);
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
