//! The probabilistic method in rooms that look alike after a turn: images weigh the same, whatever has been summed up, and
//! what stands where the robot would be tells them apart.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/random_arena.rs"]
mod random_arena;

use core::f64::consts::{PI, TAU};
use random::Random;
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::sim::Sweep;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, localize};

/// A room whose wall looks the same after a half turn about its middle, and nothing else does.
fn room(middle: Vec2) -> Boundary {
    let wave = |angle: f64| {
        0.012 * (2.0 * angle + 0.4).sin() + 0.007 * (4.0 * angle - 1.0).sin() + 0.004 * (8.0 * angle).cos()
    };
    let point = |i: u32| {
        let angle = f64::from(i) / 800.0 * TAU;
        middle + (0.2 + wave(angle)) * Vec2::from_angle(angle)
    };
    let points: Vec<Vec2> = (0..800).map(point).collect();
    Boundary::new(Role::Arena, Curve::polyline(&points, true).unwrap(), None).unwrap()
}

fn sweep(map: &Map, seed: u64) -> Sweep {
    let mut draw = Random(seed);
    (0..1000).find_map(|_| random_arena::sweep(map, &mut draw, seed)).unwrap()
}

fn localized(log: &SensorLog, map: &Map, robot: &Robot, window: usize) -> Localization {
    let options = Method::Probabilistic(ProbabilisticOptions { window, ..ProbabilisticOptions::exact() });
    localize(log, map, robot, &options, &mut |_| {}).unwrap()
}

fn off(a: Pose2, b: Pose2) -> (f64, f64) {
    (a.position().distance(b.position()), wrap_angle(a.theta - b.theta).abs())
}

#[test]
fn images_weigh_the_same_from_the_first_contact_on_and_after_rows_were_summed_up() {
    let middle = Vec2::new(0.1, -0.3);
    let map = Map::new(vec![room(middle)]).unwrap();
    let image = |pose: Pose2| {
        let place = middle + (pose.position() - middle).rotated(PI);
        Pose2::new(place.x, place.y, pose.theta + PI)
    };
    for seed in [3, 8] {
        let sweep = sweep(&map, seed);
        let truth = sweep.truth.last().unwrap().map_from_robot;
        // All of it, the same with little kept, and what is left when the log begins in contact.
        let touched = sweep.log.rows.iter().position(|row| row.readings[0].abs() > 3e-4).unwrap();
        let late = SensorLog { rows: sweep.log.rows[touched + 5..].to_vec(), ..sweep.log.clone() };
        for (log, window) in [(&sweep.log, 1000), (&sweep.log, 200), (&late, 1000), (&late, 200)] {
            let answer = localized(log, &map, &Robot::default(), window);
            let told: Vec<(f64, f64)> =
                answer.hypotheses.iter().map(|h| (h.weight, 1e3 * off(h.pose, truth).0)).collect();
            println!("seed {seed}, {} rows, window {window}: {} {told:?}", log.rows.len(), answer.status);
            assert_eq!(answer.status, Status::Ambiguous);
            assert!(told.iter().any(|t| t.1 < 4.0), "{told:?}");
            // Each place has its image, with the same weight.
            for place in &answer.hypotheses {
                let same = answer.hypotheses.iter().filter(|other| {
                    let (distance, turn) = off(image(place.pose), other.pose);
                    distance < 1e-9 && turn < 1e-9 && (place.weight - other.weight).abs() < 1e-12
                });
                assert_eq!(same.count(), 1, "{told:?}");
            }
        }
    }
}

#[test]
fn the_robot_stands_in_free_space() {
    // The robot's origin lies behind the whisker's base. Where it would be at the image of the truth stands a pillar that the
    // whisker never meets: a robot that is its whisker's base may be at either place, this one only at the true one.
    let map = Map::new(vec![room(Vec2::ZERO)]).unwrap();
    let sweep = sweep(&map, 5);
    let mut behind = Robot::default();
    behind.whiskers[0].robot_from_whisker = Pose2::new(0.06, 0.0, 0.0);
    let robot_from_base = behind.whiskers[0].robot_from_whisker;
    let turned = Pose2::new(0.0, 0.0, PI);
    let origin = |base: Pose2| base.compose(robot_from_base.inverse());
    let last = sweep.truth.last().unwrap().map_from_robot;
    let at = turned.compose(origin(last)).position();
    // Neither the whisker of the image nor the true robot comes near it.
    for pose in &sweep.truth {
        let base = pose.map_from_robot;
        assert!(origin(base).position().distance(at) > 0.05);
        let image = turned.compose(base);
        (0..=10).for_each(|k| {
            let place = image.transform_point(Vec2::new(0.0075 * f64::from(k), 0.0));
            assert!(place.distance(at) > 0.03, "{}", place.distance(at));
        });
    }
    let corner = |x: f64, y: f64| at + Vec2::new(x, y);
    let pillar = [corner(-0.012, -0.012), corner(0.012, -0.012), corner(0.012, 0.012), corner(-0.012, 0.012)];
    let pillar = Boundary::new(Role::Obstacle, Curve::polyline(&pillar, true).unwrap(), None).unwrap();
    let map = Map::new(vec![room(Vec2::ZERO), pillar]).unwrap();
    let mut log = sweep.log.clone();
    let as_base = localized(&log, &map, &Robot::default(), 1000);
    for row in &mut log.rows {
        row.odom_from_robot = origin(row.odom_from_robot);
    }
    let as_robot = localized(&log, &map, &behind, 1000);
    let near = |found: &Localization, place: Pose2| found.hypotheses.iter().any(|h| off(h.pose, place).0 < 4e-3);
    println!("{} {}, {} {}", as_base.status, as_base.hypotheses.len(), as_robot.status, as_robot.hypotheses.len());
    assert!(near(&as_base, last) && near(&as_base, turned.compose(last)));
    assert!(near(&as_robot, origin(last)) && !near(&as_robot, turned.compose(origin(last))));
}
