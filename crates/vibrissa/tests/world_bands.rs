//! Maps with bands and unknown stretches: read, written, and what the methods make of them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/lap.rs"]
mod lap;
#[path = "data/random.rs"]
mod random;

use lap::{Kind, Law, OdometryError, record, robot, room, way};
use random::Random;
use vibrissa::config::{PossibilisticOptions, ProbabilisticOptions};
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::io::map::{from_geojson, to_geojson};
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::world::{Band, Boundary, Course, Map, PieceCourse, Role};
use vibrissa::{Method, localize};

fn feature(properties: &str) -> String {
    format!(
        "{{\"type\": \"Feature\",\n\"properties\": {{\"role\": \"arena\", {properties}}},\n\"geometry\": {{\"type\": \"Polygon\", \
         \"coordinates\": [[[0,0],[0.4,0],[0.4,0.3],[0,0.3],[0,0]]]}}}}"
    )
}

fn course_of(properties: &str) -> Course {
    let map = from_geojson(&feature(properties), "room.geojson").unwrap();
    map.boundaries()[0].course().unwrap().clone()
}

#[test]
fn properties_say_how_exactly_a_boundary_is_known() {
    let course = course_of("\"band\": 0.001");
    assert_eq!(course.pieces(), [PieceCourse::Band([Band::even(1e-3); 2]); 4]);
    assert!((course.correlation_length() - 0.05).abs() < 1e-12);
    let course =
        course_of("\"band_std\": [0.0001, 0.0002, 0.0003, 0.0004], \"band_length\": 0.02, \"unknown\": [[3, 1]]");
    let PieceCourse::Band([from, to]) = course.pieces()[1] else { panic!("{course:?}") };
    assert!((from.std - 2e-4).abs() < 1e-15 && (to.bound - 9e-4).abs() < 1e-15);
    // From the last point over the first to the second: 0.3 m and 0.4 m, which is how deep it is.
    for piece in [0, 3] {
        let PieceCourse::Unknown(depth) = course.pieces()[piece] else { panic!("{course:?}") };
        assert!((depth - 0.7).abs() < 1e-12);
    }
    let all = course_of("\"unknown\": true, \"unknown_depth\": 0.05");
    assert_eq!(all.pieces(), [PieceCourse::Unknown(0.05); 4]);
}

#[test]
fn a_map_is_written_as_it_is_read() {
    let text = feature("\"band\": [0.001, 0.002, 0.003, 0.004], \"unknown\": [[1, 2]], \"unknown_depth\": 0.03");
    let map = from_geojson(&text, "room.geojson").unwrap();
    let again = from_geojson(&to_geojson(&map), "again.geojson").unwrap();
    assert_eq!(map.boundaries()[0].curve(), again.boundaries()[0].curve());
    let course = again.boundaries()[0].course().unwrap();
    let PieceCourse::Band([from, to]) = course.pieces()[2] else { panic!("{course:?}") };
    assert!((from.bound - 3e-3).abs() < 1e-15 && (to.bound - 4e-3).abs() < 1e-15);
    assert_eq!(course.pieces()[1], PieceCourse::Unknown(0.03));
    // The other way round it is the same wall.
    let clockwise =
        text.replace("[[[0,0],[0.4,0],[0.4,0.3],[0,0.3],[0,0]]]", "[[[0,0],[0,0.3],[0.4,0.3],[0.4,0],[0,0]]]");
    let turned = from_geojson(&clockwise, "turned.geojson").unwrap();
    let pieces = turned.boundaries()[0].course().unwrap().pieces().to_vec();
    assert_eq!(pieces.iter().filter(|piece| matches!(piece, PieceCourse::Unknown(_))).count(), 1);
    let unknown = pieces.iter().position(|piece| matches!(piece, PieceCourse::Unknown(_))).unwrap();
    let segment = turned.boundaries()[0].curve().segments()[unknown];
    // Points 1 and 2 of the file: (0, 0.3) and (0.4, 0.3).
    assert!((segment.start().y - 0.3).abs() < 1e-12 && (segment.end().y - 0.3).abs() < 1e-12);
    let plain = Map::new(vec![
        Boundary::new(Role::Arena, Curve::circle(Vec2::ZERO, 0.1).unwrap(), Some("a \"ring\"".to_owned())).unwrap(),
    ]);
    let again = from_geojson(&to_geojson(&plain.unwrap()), "ring.geojson").unwrap();
    assert!(again.boundaries()[0].course().is_none());
    assert_eq!(again.boundaries()[0].name(), Some("a \"ring\""));
}

#[test]
fn faults_name_file_line_and_what_is_allowed() {
    for (properties, words) in [
        ("\"band\": \"wide\"", "list of numbers"),
        ("\"band\": [0.1]", "another number of entries"),
        ("\"band\": -1", "out of range"),
        ("\"band\": 0.001, \"band_std\": 0.002", "standard deviation"),
        ("\"band\": 0.001, \"band_length\": 0", "alike"),
        ("\"unknown\": 3", "pairs of points"),
        ("\"unknown\": [[0, 9]]", "none of the line's"),
        ("\"unknown\": true, \"unknown_depth\": \"deep\"", "not a number"),
    ] {
        let told = from_geojson(&feature(properties), "room.geojson").unwrap_err().to_string();
        assert!(
            told.contains("room.geojson:") && told.contains(words) && told.contains("help: "),
            "{properties}: {told}"
        );
    }
}

#[test]
fn what_other_commands_note_beside_a_map_is_passed_over() {
    let note = "{\"type\": \"Feature\", \"properties\": {\"role\": \"peg\"}, \"geometry\": {\"type\": \"Point\", \"coordinates\": [0, 0]}}";
    let text = format!("{{\"type\": \"FeatureCollection\", \"features\": [{}, {note}]}}", feature("\"band\": 0.001"));
    assert_eq!(from_geojson(&text, "felt.geojson").unwrap().boundaries().len(), 1);
}

/// A room that somebody drew who was off by a smooth error, and a sweep along the true walls.
fn drawn_off(seed: u64, bound: f64) -> Option<(Map, vibrissa::Robot, vibrissa::SensorLog, Pose2)> {
    let mut draw = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let room = room(&mut draw, Kind::Polygon, (1.2, 1.6))?;
    let robot = robot(&mut draw);
    let path = way(&room, &mut draw, 0.2, 0.5 * room.map.total_length())?;
    let lap = record(&room.map, &robot, &path, Law::Even, OdometryError::default(), &mut draw)?;
    let (length, phase) = (0.05, draw.signed(3.0));
    let mut points = Vec::new();
    for (k, corner) in room.corners.iter().enumerate() {
        let next = room.corners[(k + 1) % room.corners.len()];
        let parts = (corner.distance(next) / 5e-3).ceil();
        points.extend((0..parts as usize).map(|j| *corner + (next - *corner) * (j as f64 / parts)));
    }
    let mut along = 0.0;
    let drawn: Vec<Vec2> = (0..points.len())
        .map(|k| {
            along += points[k].distance(points[k.saturating_sub(1)]);
            points[k] + Vec2::from_angle(phase) * (0.9 * bound * (along / length + phase).sin())
        })
        .collect();
    let boundary = Boundary::new(Role::Arena, Curve::polyline(&drawn, true)?, None).ok()?;
    let band = PieceCourse::Band([Band { std: bound / 2.0, bound }; 2]);
    let course = Course::new(vec![band; drawn.len()], length).ok()?;
    let map = Map::new(vec![boundary.with_course(course).ok()?]).ok()?;
    Some((map, robot, lap.log, path[path.len() - 1].map_from_robot))
}

fn holds(answer: &Localization, truth: Pose2) -> bool {
    answer.hypotheses.iter().any(|h| {
        let middle = 0.5 * (h.extent.theta.lo() + h.extent.theta.hi());
        h.extent.x.contains(truth.x)
            && h.extent.y.contains(truth.y)
            && h.extent.theta.contains(middle + wrap_angle(truth.theta - middle))
    })
}

#[test]
fn a_wall_that_is_off_within_its_band_is_no_contradiction() {
    let (mut all, mut held, mut contradicted) = (0, 0, 0);
    for seed in 1..16 {
        let Some((map, robot, log, truth)) = drawn_off(seed, 1e-3) else { continue };
        all += 1;
        let method = Method::Probabilistic(ProbabilisticOptions::default());
        let answer = localize(&log, &map, &robot, &method, &mut |_| {}).unwrap();
        assert_ne!(answer.status, Status::Inconsistent, "seed {seed}: {:?}", answer.events.last());
        held += usize::from(holds(&answer, truth));
        let exact = Map::new(
            map.boundaries().iter().map(|b| Boundary::new(b.role(), b.curve().clone(), None).unwrap()).collect(),
        );
        let without = localize(&log, &exact.unwrap(), &robot, &method, &mut |_| {}).unwrap();
        println!("seed {seed}: {} with bands, {held} of {all} held; taken for exact {}", answer.status, without.status);
        contradicted += usize::from(without.status == Status::Inconsistent);
    }
    assert!(all >= 6 && 2 * held >= all, "{held} of {all}");
    assert!(contradicted > 0, "walls that are off contradict none of {all} maps that are taken for exact");
}

#[test]
fn the_guaranteed_set_holds_the_truth_and_the_deterministic_method_says_why_it_refuses() {
    let (map, robot, log, truth) = (1..9).find_map(|seed| drawn_off(seed, 5e-4)).unwrap();
    let options = PossibilisticOptions { two_contacts: Some(0.05), ..PossibilisticOptions::default() };
    let answer = localize(&log, &map, &robot, &Method::Possibilistic(options), &mut |_| {}).unwrap();
    assert!(holds(&answer, truth), "{}", answer.status);
    let boundary = map.boundaries()[0].clone();
    let count = boundary.curve().segments().len();
    let course = Course::new(vec![PieceCourse::Unknown(0.01); count], 0.05).unwrap();
    let unknown = Map::new(vec![boundary.with_course(course).unwrap()]).unwrap();
    let method = Method::Deterministic(vibrissa::config::DeterministicOptions::default());
    let told = localize(&log, &unknown, &robot, &method, &mut |_| {}).unwrap_err().to_string();
    assert!(told.contains("unknown stretches") && told.contains("--method"), "{told}");
    // Where nothing is known, nothing is ruled out.
    let answer = localize(&log, &unknown, &robot, &Method::Possibilistic(options), &mut |_| {}).unwrap();
    assert_ne!(answer.status, Status::Inconsistent);
}
