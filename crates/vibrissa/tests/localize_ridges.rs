//! Places that the readings leave open along a curve: the truth lies on it, what feels the same lies on it, and nothing else.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/random_arena.rs"]
mod random_arena;
#[path = "data/ridge.rs"]
mod ridge;
#[path = "data/shared.rs"]
mod shared;

use core::f64::consts::FRAC_PI_2;
use random::Random;
use ridge::off_ridge;
use shared::shared;
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::io::read_tum;
use vibrissa::plane::{Curve, Pose2, Vec2, wrap_angle};
use vibrissa::sim::{Pace, Sweep, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, localize};

fn localized(log: &SensorLog, map: &Map, robot: &Robot, window: usize) -> Localization {
    let options = Method::Probabilistic(ProbabilisticOptions { window, ..ProbabilisticOptions::exact() });
    localize(log, map, robot, &options, &mut |_| {}).unwrap()
}

/// Distance (m) and turn (rad) of a state from the nearest ridge.
fn off(answer: &Localization, state: Pose2) -> (f64, f64) {
    let all = answer.hypotheses.iter().filter_map(|h| off_ridge(&h.ridge, state));
    all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, f64::INFINITY))
}

/// How far the state is from the nearest place (m).
fn off_middle(answer: &Localization, state: Pose2) -> f64 {
    answer.hypotheses.iter().map(|h| h.pose.position().distance(state.position())).fold(f64::INFINITY, f64::min)
}

/// All vertices stand in free space, and none is further from the next than a step of the walk.
fn check_vertices(answer: &Localization, map: &Map) {
    for ridge in answer.hypotheses.iter().map(|h| &h.ridge) {
        assert!(ridge.iter().all(|pose| map.is_free(pose.position())), "{ridge:?}");
        assert!(ridge.windows(2).all(|w| w[0].position().distance(w[1].position()) < 0.03), "{ridge:?}");
    }
}

#[test]
fn the_truth_of_sweeps_along_straight_walls_lies_on_a_ridge() {
    let Some(folder) = shared("sweeps") else { return };
    for sweep in ["square-00", "square-01", "square-02", "obstacle-01"] {
        let map = vibrissa::read_map(folder.join(format!("{}.geojson", sweep.split('-').next().unwrap()))).unwrap();
        for (suffix, bound) in [("", 1e-3), ("-bias", 2e-3)] {
            let mut robot = Robot::default();
            if !suffix.is_empty() {
                robot.whiskers[0].noise.moment_relative = 0.055;
                robot.odometry.translation_relative = 0.0101;
                robot.odometry.rotation_relative = 0.0101;
            }
            let log = vibrissa::read_log(folder.join(format!("{sweep}{suffix}.csv"))).unwrap();
            let truth = read_tum(folder.join(format!("{sweep}{suffix}.truth.tum"))).unwrap();
            let truth = truth.last().unwrap().map_from_robot;
            let answer = localized(&log, &map, &robot, 1000);
            let (distance, turn) = off(&answer, truth);
            println!("{sweep}{suffix}: {:.3} mm, {:.3} deg", 1e3 * distance, turn.to_degrees());
            assert!(distance < bound && turn < 0.5_f64.to_radians(), "{sweep}{suffix}: {distance} {turn}");
            assert!(answer.hypotheses.iter().all(|h| h.ridge.len() > 5), "{sweep}{suffix}: {:?}", answer.hypotheses);
            check_vertices(&answer, &map);
        }
    }
}

const SIDE: f64 = 0.25;

fn square_room() -> Map {
    let corners = [(-SIDE, -SIDE), (SIDE, -SIDE), (SIDE, SIDE), (-SIDE, SIDE)].map(|(x, y)| Vec2::new(x, y));
    Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
}

/// Along the upper wall, moved along it by this much; none where the robot cannot go there.
fn along_the_wall(shift: f64, noise: &SweepNoise) -> Option<Sweep> {
    let way = [(-0.05, 0.18), (-0.05, 0.2), (0.1, 0.2)].map(|(x, y)| Pose2::new(x + shift, y, 2.2));
    if way.iter().any(|pose| pose.x.abs() > SIDE) {
        return None;
    }
    let path = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).unwrap();
    simulate_tip_sweep(&square_room(), &Robot::default(), &path, noise).ok()
}

fn end(sweep: &Sweep) -> Pose2 {
    sweep.truth.last().unwrap().map_from_robot
}

#[test]
fn what_feels_the_same_lies_on_the_ridge_and_what_does_not_lies_off_it() {
    let exact = along_the_wall(0.0, &SweepNoise::none()).unwrap();
    let noise = Robot::default().whiskers[0].noise;
    let mut told = 0;
    for seed in 1..10 {
        let sweep = along_the_wall(0.0, &SweepNoise::seeded(seed)).unwrap();
        let answer = localized(&sweep.log, &square_room(), &Robot::default(), 1000);
        // A middle that happens to be the truth says nothing.
        if off_middle(&answer, end(&sweep)) < 2e-3 || told == 2 {
            continue;
        }
        told += 1;
        check_vertices(&answer, &square_room());
        let (mut alike, mut unlike) = (0, 0);
        for step in -200..=200 {
            let Some(there) = along_the_wall(1e-3 * f64::from(step), &SweepNoise::none()) else { continue };
            let pairs = || there.log.rows.iter().zip(&exact.log.rows).map(|(a, b)| (a.readings[0], b.readings[0]));
            let (distance, turn) = off(&answer, end(&there));
            let beyond = pairs()
                .filter(|(a, b)| (a - b).abs() > 3.0 * (noise.moment_relative * b.abs() + noise.moment_absolute));
            if pairs().all(|(a, b)| (a - b).abs() < 1e-8) {
                alike += 1;
                assert!(distance < 1e-3 && turn < 0.5_f64.to_radians(), "{step}: {distance} {turn}");
            } else if beyond.count() > 10 {
                unlike += 1;
                assert!(distance > 1e-3, "{step}: {distance} {turn}");
            }
        }
        println!("seed {seed}: {alike} on the ridge, {unlike} off it");
        assert!(alike > 250 && unlike > 5, "{alike} {unlike}");
    }
    assert_eq!(told, 2);
}

#[test]
fn every_vertex_explains_the_readings() {
    let noise = Robot::default().whiskers[0].noise;
    let mut shares: Vec<f64> = Vec::new();
    for seed in 1..9 {
        let sweep = along_the_wall(0.0, &SweepNoise::seeded(seed)).unwrap();
        let answer = localized(&sweep.log, &square_room(), &Robot::default(), 1000);
        // Its images are turned ones.
        for pose in &answer.hypotheses[0].ridge {
            // The whole way, moved so that it ends here, felt anew by the simulator.
            let motion = pose.compose(end(&sweep).inverse());
            let mut path = sweep.truth.clone();
            path.iter_mut().for_each(|row| row.map_from_robot = motion.compose(row.map_from_robot));
            let felt = simulate_tip_sweep(&square_room(), &Robot::default(), &path, &SweepNoise::none()).unwrap();
            let pairs = felt.log.rows.iter().zip(&sweep.log.rows).map(|(h, z)| (h.readings[0], z.readings[0]));
            let broken = pairs.filter(|(h, z)| (h - z).abs() > noise.moment_relative * z.abs() + noise.moment_absolute);
            shares.push(broken.count() as f64 / sweep.log.rows.len() as f64);
        }
    }
    shares.sort_by(f64::total_cmp);
    let (median, worst) = (shares[shares.len() / 2], shares[shares.len() - 1]);
    println!("{} vertices, share of readings beyond their bound: median {median:.3}, most {worst:.3}", shares.len());
    assert!(shares.len() >= 80 && median < 0.03 && worst < 0.1, "{} {median} {worst}", shares.len());
}

#[test]
fn ridges_of_images_are_each_others_turns() {
    let sweep = along_the_wall(0.0, &SweepNoise::seeded(6)).unwrap();
    // All that is known at the end, and most of it summed up before.
    for window in [1000, 200] {
        let answer = localized(&sweep.log, &square_room(), &Robot::default(), window);
        assert_eq!((answer.status, answer.hypotheses.len()), (Status::Ambiguous, 4));
        let first = &answer.hypotheses[0];
        assert!(first.ridge.len() > 5, "{first:?}");
        for other in &answer.hypotheses {
            let quarters = (wrap_angle(other.pose.theta - first.pose.theta) / FRAC_PI_2).round();
            let turn = Pose2::new(0.0, 0.0, quarters * FRAC_PI_2);
            assert_eq!(other.ridge.len(), first.ridge.len());
            for (a, b) in first.ridge.iter().zip(&other.ridge) {
                let image = turn.compose(*a);
                assert!(image.position().distance(b.position()) < 1e-9, "{image:?} {b:?}");
                assert!(wrap_angle(image.theta - b.theta).abs() < 1e-9, "{image:?} {b:?}");
            }
        }
        let (distance, turn) = off(&answer, end(&sweep));
        println!("window {window}: {:.3} mm, {:.3} deg", 1e3 * distance, turn.to_degrees());
        assert!(distance < 1e-3 && turn < 0.5_f64.to_radians(), "window {window}: {distance} {turn}");
    }
}

#[test]
fn ridges_along_bends_hold_the_truth_where_the_middle_does_not() {
    let draws = random_arena::Draws {
        first_half: -1.0,
        lean: [0.5, 1.0],
        off: 0.006,
        pressed: [0.01, 0.01],
        press: [0.006, 0.02],
        length: [0.02, 0.05],
        fewest: 20,
    };
    for seed in [5001_u64, 5019, 5050, 5054] {
        let mut draw = Random(seed * 0x9e37_79b9);
        let map = random_arena::arena(&mut draw).unwrap();
        let sweep = random_arena::sweep_of(&map, &mut draw, seed, &draws).unwrap();
        let answer = localized(&sweep.log, &map, &Robot::default(), 1000);
        let (distance, turn) = off(&answer, end(&sweep));
        let middle = off_middle(&answer, end(&sweep));
        println!(
            "seed {seed}: {:.2} mm, {:.2} deg, the middle {:.1} mm",
            1e3 * distance,
            turn.to_degrees(),
            1e3 * middle
        );
        assert!(distance < 1e-3 && turn < 0.5_f64.to_radians() && middle > 3e-3, "{seed}: {distance} {turn} {middle}");
        assert!(answer.hypotheses.iter().all(|h| h.ridge.iter().all(|pose| map.is_free(pose.position()))));
    }
}

#[test]
fn a_round_room_closes_the_ridge() {
    let points: Vec<Vec2> = (0..720).map(|i| 0.2 * Vec2::from_angle(f64::from(i).to_radians() / 2.0)).collect();
    let room = Boundary::new(Role::Arena, Curve::polyline(&points, true).unwrap(), None).unwrap();
    let map = Map::new(vec![room]).unwrap();
    let way = [(-0.02, 0.12), (-0.02, 0.136), (0.03, 0.145)].map(|(x, y)| Pose2::new(x, y, 2.2));
    let path = path_through(&way, &Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 }).unwrap();
    let sweep = simulate_tip_sweep(&map, &Robot::default(), &path, &SweepNoise::seeded(3)).unwrap();
    let answer = localized(&sweep.log, &map, &Robot::default(), 1000);
    let truth = end(&sweep);
    // Every turn of the truth about the middle feels the same.
    for degrees in (0..360).step_by(5) {
        let image = Pose2::new(0.0, 0.0, f64::from(degrees).to_radians()).compose(truth);
        let (distance, turn) = off(&answer, image);
        assert!(distance < 1e-3 && turn < 0.5_f64.to_radians(), "{degrees}: {distance} {turn}");
    }
    let ridge = &answer.hypotheses[0].ridge;
    let circumference = core::f64::consts::TAU * truth.position().norm();
    let length = answer.hypotheses[0].ridge_length().unwrap();
    println!("{} vertices, {length:.4} m of {circumference:.4} m, {} places", ridge.len(), answer.hypotheses.len());
    assert!(ridge.first() == ridge.last() && (length / circumference - 1.0).abs() < 0.01);
}

#[test]
fn a_sharp_place_has_no_ridge() {
    let sweep = demo::sweep(1).unwrap();
    let answer = localized(&sweep.log, &demo::arena().unwrap(), &Robot::default(), 1000);
    assert_eq!(answer.status, Status::Localized);
    assert!(answer.hypotheses.iter().all(|h| h.ridge.is_empty()), "{:?}", answer.hypotheses);
    // Neither has any place of the other methods.
    let answer = localize(
        &sweep.log,
        &demo::arena().unwrap(),
        &Robot::default(),
        &Method::Deterministic(Default::default()),
        &mut |_| {},
    );
    assert!(answer.unwrap().hypotheses.iter().all(|h| h.ridge.is_empty()));
}
