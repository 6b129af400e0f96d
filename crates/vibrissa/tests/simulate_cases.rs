//! Corners, ends of walls, both sides of walls, what is refused, noise within its bounds, paths and files.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

use core::f64::consts::{FRAC_PI_2, PI};
use vibrissa::flow::pose::StampedPose;
use vibrissa::io::log::to_csv;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, path_through};
use vibrissa::sim::{Sweep, SweepNoise, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, MomentNoise, MountedWhisker, Robot, Role};
use vibrissa::{Error, Result};

const PACE: Pace = Pace { speed: 0.15, turn_rate: 1.0, rate: 300.0 };

fn map(role: Role, points: &[[f64; 2]]) -> Map {
    let points: Vec<Vec2> = points.iter().map(|p| Vec2::new(p[0], p[1])).collect();
    let curve = Curve::polyline(&points, role != Role::Wall).unwrap();
    Map::new(vec![Boundary::new(role, curve, None).unwrap()]).unwrap()
}

fn path(waypoints: &[[f64; 3]]) -> Vec<StampedPose> {
    let poses: Vec<Pose2> = waypoints.iter().map(|w| Pose2::new(w[0], w[1], w[2])).collect();
    path_through(&poses, &PACE).unwrap()
}

fn run(map: &Map, waypoints: &[[f64; 3]]) -> Result<Sweep> {
    simulate_tip_sweep(map, &Robot::default(), &path(waypoints), &SweepNoise::none())
}

fn kinds(sweep: &Sweep) -> Vec<&str> {
    sweep.events.iter().map(|e| e.kind).collect()
}

#[test]
fn a_corner_catches_the_tip_and_lets_it_go() {
    // The whisker trails; beyond the corner the wall falls towards the robot or away from it.
    let corner = Vec2::new(0.0, 0.07);
    let fine = Pace { rate: 30000.0, ..PACE };
    for (end, last, catches) in [(-0.05, 0.024, true), (0.09, 0.032, false)] {
        let legs = [[0.045, 0.0, 2.1], [0.05, 0.032, 2.1], [0.08, last, 2.1]];
        let poses = legs.map(|[x, y, theta]| Pose2::new(x, y, theta));
        let path = path_through(&poses, &fine).unwrap();
        let points = [[-0.5, -0.5], [0.5, -0.5], [0.5, end], [corner.x, corner.y], [-0.5, corner.y]];
        let sweep =
            simulate_tip_sweep(&map(Role::Arena, &points), &Robot::default(), &path, &SweepNoise::none()).unwrap();
        let caught: Vec<_> = sweep.contacts.iter().filter(|c| c.position.distance(corner) < 1e-10).collect();
        println!("end {end}: caught for {} rows; {:?}", caught.len(), sweep.events);
        assert_eq!(caught.len() > 3, catches);
        assert!(sweep.contacts.iter().any(|c| c.position.x < -0.001));
        assert!(sweep.contacts.last().unwrap().position.x > 0.01, "it comes over the corner");
        // The force turns from one wall's normal to the other's while the tip stays.
        let (aslant, down) = (-FRAC_PI_2 + ((end - corner.y) / 0.5).atan(), -FRAC_PI_2);
        for pair in caught.windows(2) {
            let (before, after) = (pair[0].force.angle(), pair[1].force.angle());
            assert!(aslant - 1e-9 < after && after < before && before < down + 1e-9, "{before}, {after}");
        }
    }
}

#[test]
fn a_whisker_that_curls_along_a_wall_touches_once() {
    // Its bend shrinks into a small part of it next to the base, and the rest of it lies on the wall.
    let wall = map(Role::Wall, &[[-0.6, 0.0], [0.6, 0.0]]);
    let curl = |distance: f64| {
        let way = [[0.0, 0.09, -FRAC_PI_2], [0.0, distance, -2.2], [0.0, distance, -2.2 + 1.3]];
        run(&wall, &way).unwrap()
    };
    let turned = |sweep: &Sweep| sweep.truth.last().unwrap().map_from_robot.theta;
    let mut product = None;
    for distance in [0.02, 0.01, 0.005, 0.002] {
        let sweep = curl(distance);
        assert!(sweep.events.iter().all(|e| matches!(e.kind, "onset" | "side_contact")), "{:?}", sweep.events);
        let last = sweep.contacts.last().unwrap();
        assert!(last.row + 1 == sweep.truth.len() && last.position.y.abs() < 1e-9, "{last:?}");
        // Up to scale there is one side contact for each direction of the wall: moment and distance change inversely.
        let moment = sweep.exact_moments.last().unwrap()[0];
        let scaled = moment * distance;
        println!("{distance} m: {moment} N m at {} m, heading {}", last.s_a, turned(&sweep));
        let expected = *product.get_or_insert(scaled);
        assert!((scaled / expected - 1.0).abs() < 1e-8, "{scaled} instead of {expected}");
    }
}

#[test]
fn a_wall_is_felt_from_both_sides_and_ends() {
    let wall = map(Role::Wall, &[[-0.3, 0.0], [0.05, 0.0]]);
    let legs = [[0.0, -0.07, 2.2], [0.03, -0.05, 2.2], [0.13, -0.05, 2.2]];
    let below = run(&wall, &legs).unwrap();
    assert_eq!(kinds(&below), ["onset", "lift_off"], "{:?}", below.events);
    assert!(below.events[1].detail.contains("end of a wall"), "{:?}", below.events);
    let last = below.contacts.last().unwrap().position;
    assert!(last.x > 0.045 && last.x <= 0.05, "{last:?}");
    let above = run(&wall, &legs.map(|[x, y, theta]| [x, -y, -theta])).unwrap();
    assert_eq!(kinds(&above), kinds(&below));
    for (a, b) in below.exact_moments.iter().zip(&above.exact_moments) {
        assert!((a[0] + b[0]).abs() < 1e-12, "{} and {}", a[0], b[0]);
    }
    assert!(below.exact_moments.iter().any(|m| m[0] > 1e-4), "the wall above is to the right of a trailing whisker");
}

fn text(result: Result<Sweep>) -> String {
    result.err().map(|error: Error| error.to_string()).unwrap()
}

#[test]
fn what_makes_no_sense_is_refused_with_a_reason() {
    let post = map(Role::Obstacle, &[[0.03, 0.02], [0.05, 0.02], [0.05, 0.04], [0.03, 0.04]]);
    let inside = text(run(&post, &[[0.0, 0.03, 0.0], [0.0, 0.05, 0.0]]));
    assert!(inside.contains("does not start in free space") && inside.contains("at (0.03"), "{inside}");
    let buried = text(run(&post, &[[0.04, 0.03, 0.0], [0.0, 0.05, 0.0]]));
    assert!(buried.contains("does not start in free space"), "{buried}");

    let whisker = MountedWhisker { friction: -0.2, ..MountedWhisker::default() };
    let rough = Robot { whiskers: vec![whisker], ..Robot::default() };
    let legs = path(&[[0.0, -0.1, 0.0], [0.0, -0.05, 0.0]]);
    let refused = text(simulate_tip_sweep(&post, &rough, &legs, &SweepNoise::none()));
    assert!(refused.contains("friction") && refused.contains("-0.2"), "{refused}");
    let backwards = [legs[1], legs[0]];
    for bad in [&[][..], &backwards[..], &[StampedPose { t: f64::NAN, ..legs[0] }][..]] {
        assert!(simulate_tip_sweep(&post, &Robot::default(), bad, &SweepNoise::none()).is_err(), "{bad:?}");
    }
    let loud = SweepNoise { translation_relative: 1.0, ..SweepNoise::default() };
    let refused = text(simulate_tip_sweep(&post, &Robot::default(), &legs, &loud));
    assert!(refused.contains("translation_relative"), "{refused}");
}

#[test]
fn noise_keeps_its_bounds_and_its_seed() {
    let exact =
        simulate_tip_sweep(&demo::arena().unwrap(), &Robot::default(), &demo::path().unwrap(), &SweepNoise::none())
            .unwrap();
    let readings = |sweep: &Sweep| -> Vec<f64> { sweep.log.rows.iter().map(|r| r.readings[0]).collect() };
    assert_eq!(readings(&exact), exact.exact_moments.concat());
    let (one, again, other) = (demo::sweep(5).unwrap(), demo::sweep(5).unwrap(), demo::sweep(6).unwrap());
    assert_eq!(one, again);
    assert_ne!(one.log, other.log);
    assert_eq!(one.exact_moments, other.exact_moments);
    let MomentNoise { moment_relative, moment_absolute } = MomentNoise::default();
    let mut reach: (f64, f64) = (0.0, 0.0);
    for (z, h) in readings(&one).into_iter().zip(one.exact_moments.concat()) {
        let share = (h - z) / (moment_relative * z.abs() + moment_absolute);
        assert!(share.abs() <= 1.0 + 1e-9, "{h} read as {z}");
        reach = (reach.0.min(share), reach.1.max(share));
    }
    assert!(reach.0 < -0.95 && reach.1 > 0.95, "the noise fills its bounds: {reach:?}");
}

#[test]
fn odometry_starts_at_the_origin_and_keeps_its_bounds() {
    let noise = SweepNoise { translation_relative: 0.01, rotation_relative: 0.02, ..SweepNoise::none() };
    let wall = map(Role::Wall, &[[-1.0, 1.0], [1.0, 1.0]]);
    let legs = path(&[[0.1, 0.2, 0.3], [0.2, 0.2, 0.4], [0.2, 0.3, -0.4]]);
    let drift = simulate_tip_sweep(&wall, &Robot::default(), &legs, &noise).unwrap();
    let plain = simulate_tip_sweep(&wall, &Robot::default(), &legs, &SweepNoise::none()).unwrap();
    assert_eq!(plain.log.rows[0].odom_from_robot, Pose2::IDENTITY);
    let start = legs[0].map_from_robot;
    let mut strays = 0.0_f64;
    for (k, row) in plain.log.rows.iter().enumerate() {
        let there = start.compose(row.odom_from_robot);
        assert!(there.position().distance(legs[k].map_from_robot.position()) < 1e-12);
        strays = strays.max(drift.log.rows[k].odom_from_robot.position().distance(row.odom_from_robot.position()));
    }
    assert!(strays > 1e-5, "{strays}");
    for (a, b) in drift.log.rows.windows(2).zip(legs.windows(2)) {
        let felt = a[0].odom_from_robot.between(a[1].odom_from_robot);
        let real = b[0].map_from_robot.between(b[1].map_from_robot);
        let off = (felt.position() - real.position()).norm();
        assert!(off <= 0.01 * real.position().norm() + 1e-12);
        assert!((felt.theta - real.theta).abs() <= 0.02 * real.theta.abs() + 1e-12);
    }
}

#[test]
fn paths_keep_their_pace() {
    let legs = path(&[[0.0, 0.0, PI - 0.1], [0.15, 0.0, -PI + 0.1], [0.15, 0.0, -PI + 0.6]]);
    assert_eq!(legs.len(), 1 + 300 + 150, "one second of way and half a second of turn");
    assert!((legs[300].map_from_robot.x - 0.15).abs() < 1e-12);
    assert!((legs[150].map_from_robot.theta.abs() - PI).abs() < 1e-9, "the shorter way round");
    let step = |pair: &[StampedPose]| pair[0].map_from_robot.position().distance(pair[1].map_from_robot.position());
    assert!(legs.windows(2).all(|pair| step(pair) < 0.5e-3 + 1e-12));
    let poses = [Pose2::IDENTITY, Pose2::new(1.0, 0.0, 0.0)];
    for pace in [Pace { speed: 0.0, ..PACE }, Pace { rate: f64::NAN, ..PACE }, Pace { speed: 1e-9, ..PACE }] {
        assert!(path_through(&poses, &pace).unwrap_err().is_usage());
    }
    for waypoints in [&poses[..1], &[poses[0]; 3], &[poses[0], Pose2::new(f64::NAN, 0.0, 0.0)], &[]] {
        assert!(path_through(waypoints, &PACE).unwrap_err().is_usage(), "{waypoints:?}");
    }
}

#[test]
fn a_log_reads_back_as_it_was() {
    let log = demo::sweep(3).unwrap().log;
    let back = vibrissa::io::log::from_csv(&to_csv(&log), "log.csv").unwrap();
    assert_eq!(back.channels, log.channels);
    assert_eq!(back.warnings, Vec::<String>::new());
    assert_eq!(back.rows.len(), log.rows.len());
    for (a, b) in back.rows.iter().zip(&log.rows) {
        assert_eq!((a.t, a.odom_from_robot, &a.readings), (b.t, b.odom_from_robot, &b.readings));
    }
}
