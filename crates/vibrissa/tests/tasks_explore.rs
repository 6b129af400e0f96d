//! A robot that localizes itself by its own motion.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/ridge.rs"]
mod ridge;

use ridge::off_ridge;
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::Status;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{SimulateOptions, Stage, SweepNoise};
use vibrissa::tasks::explore::{
    Ended, Exploration, ExploreOptions, Order, Pilot, Strategy, explore, explore_by, way_back,
};
use vibrissa::tasks::plan::{Past, PlanOptions};
use vibrissa::world::{Boundary, Map, MountedWhisker, Robot, Role};
use vibrissa::{Method, localize};

fn stage(corners: &[(f64, f64)]) -> Stage {
    let corners: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    let arena = Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap();
    let whisker = MountedWhisker { robot_from_whisker: Pose2::new(0.0, 0.0, -0.8), ..MountedWhisker::default() };
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let options = SimulateOptions { links: 30, ..SimulateOptions::default() };
    Stage::new(Map::new(vec![arena]).unwrap(), robot, options).unwrap()
}

/// Along the lower wall, from where the whisker is free.
fn begin() -> [Pose2; 2] {
    let off = 0.075 * 0.8_f64.sin();
    [Pose2::new(0.06, off + 0.003, 0.0), Pose2::new(0.13, off - 0.008, 0.0)]
}

fn options() -> ExploreOptions {
    let plan = PlanOptions { footprint: 0.015, ..PlanOptions::default() };
    ExploreOptions { plan, ..ExploreOptions::default() }
}

fn explored(stage: &Stage) -> Exploration {
    explore(stage, &begin(), &Method::default(), &SweepNoise::seeded(1), &options()).unwrap()
}

#[test]
fn a_robot_finds_out_where_it_is_and_stops() {
    let bay =
        [(0.0, 0.0), (0.25, 0.0), (0.25, -0.05), (0.32, -0.05), (0.32, 0.0), (0.45, 0.0), (0.45, 0.3), (0.0, 0.3)];
    let stage = stage(&bay);
    let found = explored(&stage);
    assert_eq!((found.ended, found.answer.status), (Ended::Localized, Status::Localized));
    let truth = found.truth.last().unwrap().map_from_robot;
    let off = found.answer.estimate.unwrap().position().distance(truth.position());
    assert!(off < 5e-3, "{off} m");
    // It had to move, and told before which places it would part.
    assert!(!found.motions.is_empty() && found.motions[0].places.len() > 1 && found.way > 0.0);
    assert!(found.motions.iter().any(|made| made.plan.as_ref().is_some_and(|plan| plan.words().contains("parts"))));
    assert!(!found.collided && found.hardest < 1.1, "{}", found.hardest);
    assert_eq!(found.truth.len(), found.log.rows.len());
    // Nothing in it is by chance.
    let again = explored(&stage);
    assert_eq!((again.log.rows, again.truth), (found.log.rows, found.truth));
}

#[test]
fn a_place_is_tested_before_the_robot_stops() {
    let bay =
        [(0.0, 0.0), (0.25, 0.0), (0.25, -0.05), (0.32, -0.05), (0.32, 0.0), (0.45, 0.0), (0.45, 0.3), (0.0, 0.3)];
    let stage = stage(&bay);
    let found = |is_tested| {
        let options = ExploreOptions { is_tested, ..options() };
        explore(&stage, &begin(), &Method::default(), &SweepNoise::seeded(3), &options).unwrap()
    };
    let (tested, untested) = (found(true), found(false));
    assert_eq!((tested.ended, untested.ended), (Ended::Localized, Ended::Localized));
    let truth = tested.truth.last().unwrap().map_from_robot;
    assert!(tested.answer.estimate.unwrap().position().distance(truth.position()) < 5e-3);
    // The way up to it is the same, and no more is needed than a short test where the set leaves nothing else open.
    assert_eq!(tested.log.rows[..untested.log.rows.len()], untested.log.rows[..]);
    assert!(tested.way < untested.way + 0.0601, "{} {}", tested.way, untested.way);
}

#[test]
fn the_first_motion_ends_where_a_whisker_feels_as_much_as_is_gentle() {
    let stage = stage(&[(0.0, 0.0), (0.25, 0.0), (0.25, -0.05), (0.45, -0.05), (0.45, 0.3), (0.0, 0.3)]);
    // Down onto the lower wall, as far as the base of the whisker would reach it.
    let [from, _] = begin();
    let down = [from, Pose2::new(0.06, 0.02, 0.0)];
    let options = ExploreOptions { most_motions: 2, ..options() };
    let found = explore(&stage, &down, &Method::default(), &SweepNoise::seeded(1), &options).unwrap();
    let stop_at = options.plan.stop_at(stage.robot())[0];
    let sizes: Vec<f64> = found.log.rows.iter().map(|row| row.readings[0].abs()).collect();
    let first = sizes.iter().position(|size| *size >= stop_at).expect("it is pressed");
    assert_eq!(found.motions[0].row, first + 1);
    assert!(found.truth[first].map_from_robot.y > 0.025, "it goes on to press");
}

#[test]
fn a_log_that_nothing_explains_is_begun_anew() {
    let bay =
        [(0.0, 0.0), (0.25, 0.0), (0.25, -0.05), (0.32, -0.05), (0.32, 0.0), (0.45, 0.0), (0.45, 0.3), (0.0, 0.3)];
    let stage = stage(&bay);
    let robot = stage.robot().clone();
    // It is told to be where no wall is within reach.
    let prior = Some([[0.2, 0.22], [0.14, 0.16], [-0.1, 0.1]]);
    let method = Method::Possibilistic(PossibilisticOptions { prior, ..PossibilisticOptions::default() });
    let found = explore(&stage, &begin(), &method, &SweepNoise::seeded(1), &options()).unwrap();
    let anew: Vec<usize> =
        found.motions.iter().filter(|made| made.name == "back, to begin anew").map(|made| made.row).collect();
    assert_eq!((found.ended, anew.len()), (Ended::Inconsistent, 2), "{:?}", found.answer.status);
    // It is free there, and touches again, more gently than the first time.
    let size = |row: usize| found.log.rows[row].readings[0].abs();
    let noise = robot.whiskers[0].noise;
    let nothing = noise.readings(0.0)[1];
    assert!(found.since > anew[1] && size(found.since) <= nothing, "{} {}", found.since, size(found.since));
    let hardest = (found.since..found.log.rows.len()).map(size).fold(0.0, f64::max);
    assert!(hardest > 1e-4 && hardest < 0.7 * options().plan.stop_at(&robot)[0], "{hardest}");
    // The answer is that of the log from there on.
    let rest = SensorLog { rows: found.log.rows[found.since..].to_vec(), ..found.log.clone() };
    let answer = localize(&rest, stage.map(), &robot, &method, &mut |_| {}).unwrap();
    assert_eq!((answer.status, answer.hypotheses), (found.answer.status, found.answer.hypotheses));
}

#[test]
fn a_symmetric_room_ends_with_that_word() {
    let stage = stage(&[(0.0, 0.0), (0.4, 0.0), (0.4, 0.25), (0.0, 0.25)]);
    let found = explored(&stage);
    assert_eq!((found.ended, found.answer.status), (Ended::Symmetric, Status::Ambiguous));
    // The truth is one of the places.
    let truth = found.truth.last().unwrap().map_from_robot;
    let off = |h: &vibrissa::flow::pose::Hypothesis| {
        let off = h.pose.position().distance(truth.position());
        off_ridge(&h.ridge, truth).map_or(off, |(ridge, _)| ridge.min(off))
    };
    assert!(found.answer.hypotheses.iter().any(|h| off(h) < 3e-3));
    assert!(!found.collided);
}

#[test]
fn other_choices_are_obeyed_and_limits_end_them() {
    let stage = stage(&[(0.0, 0.0), (0.4, 0.0), (0.4, 0.25), (0.0, 0.25)]);
    let mut asked = 0;
    let mut first = |all: &[vibrissa::tasks::plan::Motion], _: f64| {
        asked += 1;
        all.first().map(|motion| motion.share(0.5))
    };
    let options = ExploreOptions { most_motions: 3, ..options() };
    let found = explore_by(
        &stage,
        &begin(),
        &Method::default(),
        &SweepNoise::seeded(1),
        &options,
        Strategy::Chosen(&mut first),
    )
    .unwrap();
    assert_eq!((found.ended, found.motions.len(), asked), (Ended::GaveUp, 3, 3));
    assert!(found.motions.iter().all(|made| made.plan.is_none() && made.name == "along the wall"));
}

#[test]
fn a_pilot_lets_a_pressed_whisker_go_and_says_when_there_is_no_way() {
    let stage = stage(&[(0.0, 0.0), (0.4, 0.0), (0.4, 0.25), (0.1, 0.25), (0.0, 0.2)]);
    let (map, robot) = (stage.map(), stage.robot());
    let found = explored(&stage);
    let places = &found.answer.hypotheses;
    let plan = options().plan;
    let most = plan.most(&robot.whiskers[0]);
    let next = |pilot: &mut Pilot, reading: f64| {
        pilot.next(map, robot, places, &Past { history: &[], readings: &[reading] }).unwrap()
    };
    // Back three times, whatever the plan, and then by a plan again.
    let mut pilot = Pilot::new(plan).unwrap();
    for _ in 0..3 {
        assert!(matches!(next(&mut pilot, -0.95 * most), (Order::Back, None)));
    }
    assert!(!matches!(next(&mut pilot, -0.95 * most).0, Order::Back));
    // Nothing is admissible for a robot that is too large for the room.
    let mut pilot = Pilot::new(PlanOptions { footprint: 0.2, ..plan }).unwrap();
    for _ in 0..3 {
        assert_eq!(next(&mut pilot, 0.0).0, Order::Back);
    }
    assert_eq!(next(&mut pilot, 0.0).0, Order::End(Ended::Confined));
    assert!(Pilot::new(PlanOptions { longest: -1.0, ..plan }).is_err());
    // The way back ends after 50 mm, where a turn counts, too.
    let end = |way: Vec<Pose2>| *way.last().unwrap();
    let straight = (0..200).map(|k| Pose2::new(-1e-3 * f64::from(k), 0.0, 0.0));
    let turning = (0..200).map(|k| Pose2::new(0.0, 0.0, 0.02 * f64::from(k)));
    let (back, turned) = (end(way_back(straight)), end(way_back(turning)));
    assert!((-0.0501..-0.046).contains(&back.x) && (0.92..1.001).contains(&turned.theta), "{back:?} {turned:?}");
    // One that went back before goes on from there, by poses that are not those that it came by.
    let came = (0..100).map(|k| 1.9e-3 * f64::from(k)).chain((0..33).map(|k| 0.19 - 1.5e-3 * f64::from(k)));
    let poses: Vec<Pose2> = came.map(|x| Pose2::new(x, 0.0, 0.0)).collect();
    let (here, back) = (poses[poses.len() - 1].x, end(way_back(poses.iter().rev().copied())));
    assert!((0.044..0.0501).contains(&(here - back.x)), "{here} {back:?}");
    assert!(way_back(core::iter::empty()).is_empty());
    // One that is back at its beginning goes once more where it went.
    let there_and_back = (0..=30).chain((0..30).rev()).map(|k| Pose2::new(2e-3 * f64::from(k), 0.0, 0.0));
    let again = end(way_back(there_and_back));
    assert!((0.046..0.0501).contains(&again.x), "{again:?}");
}

/// Two places in a long room as wide as the robot, at its two ends: what goes on at one of them runs into the wall at the other.
#[test]
fn a_robot_that_may_only_turn_turns_once_and_then_leaves() {
    let long = stage(&[(0.0, 0.0), (0.5, 0.0), (0.5, 0.21), (0.0, 0.215)]);
    let small = explored(&stage(&[(0.0, 0.0), (0.4, 0.0), (0.4, 0.25), (0.1, 0.25), (0.0, 0.2)]));
    let mut robot = long.robot().clone();
    robot.whiskers[0].beam.length = 0.02;
    let at = |x: f64| {
        let mut place = small.answer.hypotheses[0].clone();
        (place.pose, place.weight, place.covariance) = (Pose2::new(x, 0.106, 0.0), 0.5, None);
        place.ridge.clear();
        place
    };
    let places = [at(0.105), at(0.395)];
    let mut pilot = Pilot::new(PlanOptions { footprint: 0.1, sideways: false, ..options().plan }).unwrap();
    let mut orders = Vec::new();
    for _ in 0..6 {
        let (order, plan) = pilot.next(long.map(), &robot, &places, &Past { history: &[], readings: &[0.0] }).unwrap();
        if let Order::Go { motion, .. } = &order {
            assert!(motion.way() < 2e-3 && motion.turn() > 0.1, "{motion:?} {}", plan.unwrap().words());
        }
        orders.push(order);
    }
    assert!(matches!(orders[0], Order::Go { .. }), "{orders:?}");
    assert_eq!(
        orders[1..],
        [Order::Back, Order::Back, Order::Back, Order::End(Ended::Confined), Order::End(Ended::Confined)]
    );
}
