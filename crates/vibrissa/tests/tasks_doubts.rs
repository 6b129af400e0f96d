//! What looks wrong where log, robot and map meet.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::io::log::from_csv;
use vibrissa::io::map::from_geojson;
use vibrissa::plane::Pose2;
use vibrissa::tasks::{demo, doubts};
use vibrissa::world::Robot;

fn square(role: &str, [x, y]: [f64; 2], side: f64) -> String {
    let corners = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side], [0.0, 0.0]].map(|[u, v]| [x + u, y + v]);
    format!(
        "{{\"type\": \"Feature\", \"properties\": {{\"role\": \"{role}\"}}, \"geometry\": {{\"type\": \"Polygon\", \
         \"coordinates\": [{corners:?}]}}}}"
    )
}

fn doubted(features: &[String]) -> Vec<String> {
    let text = format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", features.join(","));
    doubts(None, &Robot::default(), Some(&from_geojson(&text, "map.geojson").unwrap()))
}

#[test]
fn usual_inputs_raise_no_doubt() {
    let sweep = demo::sweep(1).unwrap();
    assert!(doubts(Some(&sweep.log), &Robot::default(), Some(&demo::arena().unwrap())).is_empty());
    assert!(doubted(&[square("arena", [0.0, 0.0], 2.0), square("obstacle", [0.5, 0.5], 0.2)]).is_empty());
}

#[test]
fn maps_of_a_stamp_of_the_globe_and_with_lost_obstacles_are_told() {
    let stamp = doubted(&[square("arena", [0.0, 0.0], 0.03)]);
    assert!(stamp.len() == 1 && stamp[0].contains("30.000 mm wide"), "{stamp:?}");
    let globe = doubted(&[square("arena", [8.55, 47.37], 0.2)]);
    assert!(globe.len() == 1 && globe[0].contains("longitude and latitude"), "{globe:?}");
    let lost = doubted(&[square("arena", [0.0, 0.0], 1.0), square("obstacle", [3.0, 0.5], 0.2)]);
    assert!(lost.len() == 1 && lost[0].contains("outside of the arena") && lost[0].contains("one at (3."), "{lost:?}");
}

#[test]
fn logs_of_the_globe_are_told() {
    let told = |x: f64, y: f64, step: f64| {
        let row = |k: i32| format!("{},{},{y},0,0\n", 0.01 * f64::from(k), x + step * f64::from(k));
        let rows: String = (0..50).map(row).collect();
        doubts(Some(&from_csv(&format!("t,x,y,theta,moment\n{rows}"), "log.csv").unwrap()), &Robot::default(), None)
    };
    let globe = told(8.55, 47.37, 1e-8);
    assert!(globe.len() == 1 && globe[0].contains("longitude and latitude"), "{globe:?}");
    // A robot in metres, one that stands, one near its origin, and coordinates that are no angles.
    for (x, y, step) in [(8.55, 47.37, 1e-3), (8.55, 47.37, 0.0), (0.1, 0.2, 1e-8), (5e5, 4e6, 1e-6)] {
        assert!(told(x, y, step).is_empty(), "{x} {y} {step}");
    }
}

#[test]
fn far_mounts_and_contact_from_the_first_row_are_told() {
    let mut robot = Robot::default();
    robot.whiskers[0].robot_from_whisker = Pose2::new(20.0, 0.0, 0.0);
    let far = doubts(None, &robot, None);
    assert!(far.len() == 1 && far[0].contains("w0") && far[0].contains("millimetres"), "{far:?}");
    let log = from_csv("t,x,y,theta,moment\n0,0,0,0,0.003\n0.01,0.001,0,0,0.003\n", "log.csv").unwrap();
    let first = doubts(Some(&log), &Robot::default(), None);
    assert!(first.len() == 1 && first[0].contains("first row (3.0000 mN m)"), "{first:?}");
}

#[test]
fn readings_that_are_the_same_while_the_robot_moves_are_told() {
    let told = |moment: &dyn Fn(i32) -> f64, step: f64, rows: i32| {
        let row = |k: i32| format!("{},{},0,0,{}\n", 0.01 * f64::from(k), step * f64::from(k), moment(k));
        let rows: String = (0..rows).map(row).collect();
        let log = from_csv(&format!("t,x,y,theta,moment\n{rows}"), "log.csv").unwrap();
        let all = doubts(Some(&log), &Robot::default(), None);
        all.into_iter().filter(|words| words.contains("stuck") || words.contains("saturated")).collect::<Vec<_>>()
    };
    let words = told(&|_| -0.002, 1e-3, 200);
    assert!(words.len() == 1 && words[0].contains("w0 reads the same in all 200 rows"), "{words:?}");
    // A free whisker, a robot that stands, few rows, and one reading that is other by a digit.
    assert!(told(&|_| 0.0, 1e-3, 200).is_empty() && told(&|_| 0.002, 1e-6, 200).is_empty());
    assert!(told(&|_| 0.002, 1e-3, 60).is_empty());
    assert!(told(&|k| if k == 150 { 0.002_000_1 } else { 0.002 }, 1e-3, 200).is_empty());
    // A limit at either side, in some rows and in a few.
    let clipped = |limit: f64| move |k: i32| (0.003 * (0.05 * f64::from(k)).sin()).clamp(-limit, limit);
    let words = told(&clipped(1e-3), 1e-3, 400);
    assert!(
        words.len() == 1 && words[0].contains("w0 reads 1.0000 mN m") && words[0].contains("of 400 rows"),
        "{words:?}"
    );
    assert!(told(&clipped(2.95e-3), 1e-3, 400).is_empty());
}

#[test]
fn milliseconds_and_millimetres_are_told() {
    let table = |time: f64, way: f64| {
        let rows: String = (0..50).map(|k| format!("{},{},0,0,0\n", f64::from(k) * time, f64::from(k) * way)).collect();
        from_csv(&format!("t,x,y,theta,moment\n{rows}"), "log.csv").unwrap().warnings
    };
    assert!(table(1.0 / 300.0, 1e-3).is_empty());
    let milliseconds = table(1e3 / 300.0, 1e-3);
    assert!(milliseconds.len() == 1 && milliseconds[0].contains("is t in milliseconds?"), "{milliseconds:?}");
    let millimetres = table(1.0 / 300.0, 0.09);
    assert!(millimetres.len() == 1 && millimetres[0].contains("in millimetres?"), "{millimetres:?}");
}
