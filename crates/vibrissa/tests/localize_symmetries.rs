//! Symmetries of the world that change no answer, for the methods that work in continuous states: what moves, mirrors,
//! scales, reverses or renumbers the world does so to the answer. `localize_laws.rs` has the deterministic method's.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use std::sync::LazyLock;
use vibrissa::config::{PossibilisticOptions, ProbabilisticOptions};
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Curve, Pose2, Segment, Vec2, wrap_angle};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Robot};
use vibrissa::{Method, localize};

/// One localization: a world, what was recorded in it, and where the robot was at the end.
#[derive(Clone)]
struct World {
    map: Map,
    robot: Robot,
    log: SensorLog,
    truth: Pose2,
}

/// Every third row of the demo from where the whisker touches, without the first approach: enough to be unique.
static DEMO: LazyLock<World> = LazyLock::new(|| {
    let sweep = demo::sweep(2).unwrap();
    let rows: Vec<LogRow> = sweep.log.rows.iter().step_by(3).cloned().collect();
    let truth = sweep.truth.iter().step_by(3).next_back().unwrap().map_from_robot;
    World { map: demo::arena().unwrap(), robot: Robot::default(), log: SensorLog { rows, ..sweep.log }, truth }
});

static PLAIN: LazyLock<[Localization; 2]> =
    LazyLock::new(|| METHODS.map(|method| answer(&DEMO, &options(method, 1.0))));

const METHODS: [&str; 2] = [POSSIBILISTIC, "probabilistic"];
const POSSIBILISTIC: &str = "possibilistic";

/// Little work, for speed, in a world whose lengths are `k` times the demo's.
fn options(method: &str, k: f64) -> Method {
    let possibilistic = PossibilisticOptions::default();
    let probabilistic = ProbabilisticOptions::exact();
    if method == POSSIBILISTIC {
        Method::Possibilistic(PossibilisticOptions {
            work: 30,
            last_work: 0,
            resolution: k * possibilistic.resolution,
            ..possibilistic
        })
    } else {
        Method::Probabilistic(ProbabilisticOptions {
            seed_turn: 0.1,
            seed_spacing: 2e-3 * k,
            seed_travel: k * probabilistic.seed_travel,
            seed_step: k * probabilistic.seed_step,
            ..probabilistic
        })
    }
}

fn answer(world: &World, options: &Method) -> Localization {
    localize(&world.log, &world.map, &world.robot, options, &mut |_| {}).unwrap()
}

/// The map with every point moved by `place`.
fn moved(map: &Map, place: impl Fn(Vec2) -> Vec2) -> Map {
    let segment = |s: &Segment| match *s {
        Segment::Line(p) => Segment::Line(p.map(&place)),
        Segment::Quadratic(p) => Segment::Quadratic(p.map(&place)),
        Segment::Cubic(p) => Segment::Cubic(p.map(&place)),
    };
    let boundary = |b: &Boundary| {
        let segments = b.curve().segments().iter().map(segment).collect();
        Boundary::new(b.role(), Curve::from_segments(segments, b.curve().is_closed()).unwrap(), None).unwrap()
    };
    Map::new(map.boundaries().iter().map(boundary).collect()).unwrap()
}

/// The world with map and truth moved by `place`, odometry by `odom` and readings by `reading`.
fn changed(
    place: impl Fn(Vec2) -> Vec2,
    truth: Pose2,
    odom: impl Fn(Pose2) -> Pose2,
    reading: impl Fn(f64) -> f64,
) -> World {
    let mut world = World { map: moved(&DEMO.map, place), truth, ..DEMO.clone() };
    for row in &mut world.log.rows {
        row.odom_from_robot = odom(row.odom_from_robot);
        row.readings.iter_mut().for_each(|r| *r = reading(*r));
    }
    world
}

fn holds(found: &Localization, truth: Pose2) -> bool {
    found.states.iter().any(|b| {
        let middle = 0.5 * (b.theta.lo() + b.theta.hi());
        b.x.contains(truth.x) && b.y.contains(truth.y) && b.theta.contains(middle + wrap_angle(truth.theta - middle))
    })
}

/// Whether both say the same, where `image` takes a pose of the plain world to one of the other, `k` times as large.
fn same(what: &str, world: &World, image: impl Fn(Pose2) -> Pose2, k: f64) {
    for (method, plain) in METHODS.into_iter().zip(PLAIN.iter()) {
        let other = answer(world, &options(method, k));
        let volume = |found: &Localization, k: f64| found.steps.last().unwrap().volume / (k * k);
        let (was, is) = (volume(plain, 1.0), volume(&other, k));
        let (a, b) = (image(plain.estimate.unwrap()), other.estimate.unwrap());
        let (distance, turn) = (a.position().distance(b.position()) / k, wrap_angle(a.theta - b.theta).abs());
        println!(
            "{what}, {method}: {} {}, {:.4} mm, {:.4} deg, volumes {was:.2e} {is:.2e}",
            plain.status,
            other.status,
            1e3 * distance,
            turn.to_degrees()
        );
        if method == POSSIBILISTIC {
            assert!(holds(&other, world.truth), "{what}: the truth is lost");
            // Boxes are halved along the axes, so that a turned world is covered by other boxes, but not by many more.
            assert!(is < 4.0 * was && was < 4.0 * is, "{what}: {was} {is}");
        } else {
            assert!(distance < 0.1e-3 && turn < 2e-3, "{what}: {distance} m, {turn} rad");
        }
        if (k - 1.0).abs() < 0.5 {
            assert_eq!(plain.status, other.status, "{what}, {method}");
        }
    }
}

#[test]
fn the_plain_world_is_localized() {
    let [possibilistic, probabilistic] = &*PLAIN;
    assert!(holds(possibilistic, DEMO.truth), "{:?}", possibilistic.status);
    assert_eq!(probabilistic.status, Status::Localized);
    assert!(probabilistic.estimate.unwrap().position().distance(DEMO.truth.position()) < 0.5e-3);
}

#[test]
fn a_moved_world_moves_the_answer() {
    let motion = Pose2::new(-5.0, 1.0, -2.9);
    let world = changed(|p| motion.transform_point(p), motion.compose(DEMO.truth), |p| p, |m| m);
    same("moved", &world, |p| motion.compose(p), 1.0);
}

#[test]
fn the_odometry_frame_does_not_matter() {
    let elsewhere = Pose2::new(-130.0, 45.0, 2.6);
    same("odometry", &changed(|p| p, DEMO.truth, |p| elsewhere.compose(p), |m| m), |p| p, 1.0);
}

#[test]
fn a_mirrored_world_mirrors_the_answer() {
    let mirror = |p: Pose2| Pose2::new(p.x, -p.y, -p.theta);
    same("mirrored", &changed(|p| Vec2::new(p.x, -p.y), mirror(DEMO.truth), mirror, |m| -m), mirror, 1.0);
}

#[test]
fn ten_times_the_lengths_give_ten_times_the_answer() {
    // Moments are EI over length: with EI a hundred times as large they are ten times as large.
    let k = 10.0;
    let larger = |p: Pose2| Pose2::new(k * p.x, k * p.y, p.theta);
    let mut world = changed(|p| p * k, larger(DEMO.truth), larger, |m| k * m);
    let whisker = &mut world.robot.whiskers[0];
    whisker.beam.length *= k;
    whisker.beam.flexural_rigidity *= k * k;
    whisker.noise.moment_absolute *= k;
    same("scaled", &world, larger, k);
}

#[test]
fn where_an_outline_starts_and_which_way_it_is_drawn_does_not_matter() {
    let mut boundaries: Vec<Boundary> = DEMO.map.boundaries().iter().rev().cloned().collect();
    for (index, boundary) in boundaries.iter_mut().enumerate() {
        let mut segments = boundary.curve().segments().to_vec();
        if boundary.curve().is_closed() {
            let third = segments.len() / 3;
            segments.rotate_left(third);
        }
        if index % 2 == 0 {
            segments = segments.iter().rev().map(Segment::reversed).collect();
        }
        let curve = Curve::from_segments(segments, boundary.curve().is_closed()).unwrap();
        *boundary = Boundary::new(boundary.role(), curve, None).unwrap();
    }
    same("renumbered", &World { map: Map::new(boundaries).unwrap(), ..DEMO.clone() }, |p| p, 1.0);
}

#[test]
fn the_order_of_whiskers_and_columns_does_not_matter() {
    let mut plain = DEMO.clone();
    let mut idle = plain.robot.whiskers[0].clone();
    plain.robot.whiskers[0].name = "feels".into();
    idle.name = "idle".into();
    // A stub behind the robot that stays in the air.
    idle.beam.length = 0.01;
    idle.robot_from_whisker = Pose2::new(0.0, 0.0, 3.0);
    let stub = |p: Pose2| p.compose(idle.robot_from_whisker).transform_point(Vec2::new(idle.beam.length, 0.0));
    let path = demo::path().unwrap();
    assert!(path.iter().all(|p| !DEMO.map.crosses(p.map_from_robot.position(), stub(p.map_from_robot))));
    plain.robot.whiskers.push(idle);
    let with = |names: [&str; 2], robot: &Robot| {
        let mut world = World { robot: robot.clone(), ..plain.clone() };
        world.log.channels = names.map(|name| Channel { whisker: name.into(), quantity: Quantity::Moment }).to_vec();
        for row in &mut world.log.rows {
            let moment = row.readings[0];
            row.readings = names.map(|name| if name == "feels" { moment } else { 0.0 }).to_vec();
        }
        world
    };
    let mut other_way = plain.robot.clone();
    other_way.whiskers.reverse();
    for method in METHODS {
        let of = |names, robot: &Robot| answer(&with(names, robot), &options(method, 1.0));
        let first = of(["feels", "idle"], &plain.robot);
        assert_eq!(first, of(["idle", "feels"], &plain.robot), "{method}: columns");
        let reversed = of(["feels", "idle"], &other_way);
        assert_eq!(first.status, reversed.status, "{method}: whiskers");
        assert!(first.estimate.is_some(), "{method}: {} {:?}", first.status, first.events);
        let (a, b) = (first.estimate.unwrap(), reversed.estimate.unwrap());
        println!("{method}: {:.4} mm", 1e3 * a.position().distance(b.position()));
        if method == POSSIBILISTIC {
            assert!(holds(&first, DEMO.truth) && holds(&reversed, DEMO.truth));
        } else {
            assert!(a.position().distance(b.position()) < 0.1e-3, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_log_played_backwards_ends_where_it_began() {
    // Nothing rubs and nothing slips, so that readings depend on places alone, whichever way time runs.
    let mut world = DEMO.clone();
    let (first, last) = (world.log.rows[0].odom_from_robot, world.log.rows[world.log.rows.len() - 1].odom_from_robot);
    let end = world.log.rows[world.log.rows.len() - 1].t;
    world.log.rows.reverse();
    world.log.rows.iter_mut().for_each(|row| row.t = end - row.t);
    let back = last.between(first);
    world.truth = DEMO.truth.compose(back);
    for method in METHODS {
        let found = answer(&world, &options(method, 1.0));
        let off = found.estimate.map(|p| p.position().distance(world.truth.position()));
        println!("backwards, {method}: {}, {off:?} m", found.status);
        match method {
            POSSIBILISTIC => assert!(holds(&found, world.truth), "the truth is lost: {:?}", found.events),
            _ => assert!(found.status == Status::Localized && off.unwrap() < 1e-3, "{:?} {off:?}", found.status),
        }
    }
}
