//! The probabilistic method: sharp where the answer is unique, honest where it is not.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/shared.rs"]
mod shared;

use random::Random;
use shared::shared;
use std::path::{Path, PathBuf};
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::io::read_tum;
use vibrissa::localizer::{Estimator, ProbabilisticEstimator};
use vibrissa::plane::{Pose2, wrap_angle};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, localize};

fn options() -> Method {
    Method::Probabilistic(ProbabilisticOptions::exact())
}

fn sweeps() -> Option<PathBuf> {
    shared("sweeps")
}

fn run(folder: &Path, name: &str, map: &str) -> (Localization, Pose2) {
    let map = vibrissa::read_map(folder.join(format!("{map}.geojson"))).unwrap();
    let log = vibrissa::read_log(folder.join(format!("{name}.csv"))).unwrap();
    let truth = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
    let mut robot = Robot::default();
    if name.ends_with("bias") {
        robot.whiskers[0].noise.moment_relative = 0.055;
    }
    (localize(&log, &map, &robot, &options(), &mut |_| {}).unwrap(), truth.last().unwrap().map_from_robot)
}

/// Distance (m) and turn (rad).
fn off(a: Pose2, b: Pose2) -> (f64, f64) {
    (a.position().distance(b.position()), wrap_angle(a.theta - b.theta).abs())
}

#[test]
fn unique_places_are_found_within_half_a_millimetre() {
    let Some(folder) = sweeps() else { return };
    for (name, map) in
        [("rough0-02", "rough0"), ("rough0-03", "rough0"), ("rough0-03-bias", "rough0"), ("bays-00", "bays")]
    {
        let (answer, truth) = run(&folder, name, map);
        assert_eq!(answer.status, Status::Localized, "{name}");
        let (distance, turn) = off(answer.estimate.unwrap(), truth);
        println!("{name}: {:.3} mm, {:.3} deg", 1e3 * distance, turn.to_degrees());
        assert!(distance < 0.6e-3 && turn < 0.3_f64.to_radians(), "{name}: {distance} {turn}");
        let (bound, heading) = answer.hypotheses[0].bound().unwrap();
        // The odometry of a biased log is off and not declared so: residuals stay alike, and the region says so.
        let wide = if name.ends_with("bias") { 3.5 } else { 1.0 };
        assert!(
            bound > 1e-5 && bound < wide * 1e-3 && heading > 1e-4 && heading < wide * 1e-2,
            "{name}: {bound} {heading}"
        );
    }
}

/// Rows in between, so that the window is full before the robot has gone far.
fn slowed(log: &SensorLog, times: usize) -> SensorLog {
    let mut slow = SensorLog { rows: Vec::new(), ..log.clone() };
    for pair in log.rows.windows(2) {
        let [from, to] = pair else { continue };
        for k in 0..times {
            let share = k as f64 / times as f64;
            let mut row = from.clone();
            let step = from.odom_from_robot.between(to.odom_from_robot);
            let part = Pose2::new(share * step.x, share * step.y, share * step.theta);
            row.t = (from.t + share * (to.t - from.t)) * times as f64;
            row.odom_from_robot = from.odom_from_robot.compose(part);
            row.readings[0] = from.readings[0] + share * (to.readings[0] - from.readings[0]);
            slow.rows.push(row);
        }
    }
    slow
}

#[test]
fn a_contact_is_followed_until_few_cells_are_left_however_slow_the_robot() {
    let Some(folder) = sweeps() else { return };
    let (answer, truth) = run(&folder, "rough0-02", "rough0");
    println!("{} first states", answer.first_states.len());
    assert!((1..1000).contains(&answer.first_states.len()), "{}", answer.first_states.len());
    let map = vibrissa::read_map(folder.join("rough0.geojson")).unwrap();
    let log = slowed(&vibrissa::read_log(folder.join("rough0-02.csv")).unwrap(), 20);
    let slow = localize(&log, &map, &Robot::default(), &Method::default(), &mut |_| {}).unwrap();
    println!("{}, {} rows", slow.status, log.rows.len());
    assert_ne!(slow.status, Status::Inconsistent);
    let holds = |h: &vibrissa::flow::pose::Hypothesis| h.extent.x.contains(truth.x) && h.extent.y.contains(truth.y);
    assert!(slow.hypotheses.iter().any(holds), "{:?} {truth:?}", slow.hypotheses);
}

#[test]
fn a_square_has_four_equal_places() {
    let Some(folder) = sweeps() else { return };
    let (answer, truth) = run(&folder, "square-01", "square");
    assert_eq!(answer.status, Status::Ambiguous);
    assert_eq!(answer.hypotheses.len(), 4);
    assert!(answer.hypotheses.iter().all(|h| (h.weight - 0.25).abs() < 0.1), "{:?}", answer.hypotheses);
    let holds = answer.hypotheses.iter().any(|h| {
        let middle = 0.5 * (h.extent.theta.lo() + h.extent.theta.hi());
        h.extent.x.contains(truth.x)
            && h.extent.y.contains(truth.y)
            && h.extent.theta.contains(middle + wrap_angle(truth.theta - middle))
    });
    assert!(holds);
}

#[test]
fn a_wrong_map_is_not_believed() {
    let Some(folder) = sweeps() else { return };
    let (answer, _) = run(&folder, "rough0-02", "bays");
    // The declared bounds may leave a place on this map, too: it is told as what it is.
    let is_enclosed = answer.status == Status::Ambiguous && answer.events.iter().any(|e| e.kind == "enclosed");
    assert!(answer.status == Status::Inconsistent || is_enclosed, "{:?}", answer.events);
    assert!((answer.estimate.is_none() || is_enclosed) && answer.events.iter().any(|e| e.kind == "inconsistent"));
}

#[test]
fn the_same_log_gives_the_same_answer_and_false_readings_do_not_move_it() {
    let (map, sweep) = (demo::arena().unwrap(), demo::sweep(1).unwrap());
    let truth = sweep.truth.last().unwrap().map_from_robot;
    let mut log = sweep.log;
    let plain = localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap();
    let again = localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap();
    assert_eq!(plain, again);
    // Every twentieth reading is false: gone, doubled, or beyond what any whisker feels.
    for (index, row) in log.rows.iter_mut().enumerate().skip(7).step_by(20) {
        row.readings[0] *= [0.0, 2.0, -1.0, 1e3][index / 20 % 4];
    }
    let noisy = localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap();
    for answer in [&plain, &noisy] {
        let (distance, turn) = off(answer.estimate.unwrap(), truth);
        println!("{} {:.3} mm, {:.3} deg", answer.status, 1e3 * distance, turn.to_degrees());
        assert!(answer.status == Status::Localized && distance < 1e-3 && turn < 0.01, "{distance} {turn}");
    }
}

#[test]
fn a_log_without_contact_says_so() {
    let (map, mut log) = (demo::arena().unwrap(), demo::sweep(1).unwrap().log);
    log.rows.iter_mut().for_each(|row| row.readings[0] = 0.0);
    let answer = localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap();
    assert_eq!(answer.status, Status::NoContact);
    log.rows.truncate(0);
    assert_eq!(localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap().status, Status::NoContact);
}

#[test]
fn a_region_or_a_compass_tells_the_places_of_a_square_apart() {
    let Some(folder) = sweeps() else { return };
    let map = vibrissa::read_map(folder.join("square.geojson")).unwrap();
    let mut log = vibrissa::read_log(folder.join("square-01.csv")).unwrap();
    let truth = read_tum(folder.join("square-01.truth.tum")).unwrap();
    let (first, last) = (truth.first().unwrap().map_from_robot, truth.last().unwrap().map_from_robot);
    let around = |v: f64, half: f64| [v - half, v + half];
    let prior = Some([around(first.x, 0.03), around(first.y, 0.03), around(first.theta, 0.3)]);
    let within = Method::Probabilistic(ProbabilisticOptions { prior, ..ProbabilisticOptions::exact() });
    let region = localize(&log, &map, &Robot::default(), &within, &mut |_| {}).unwrap();
    // A compass that is off by the same angle all the time, as they are.
    for (row, true_row) in log.rows.iter_mut().zip(&truth) {
        row.heading = Some(true_row.map_from_robot.theta + 0.03);
    }
    let compass = localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap();
    // A straight wall leaves the place along it open; which wall it is, is known.
    for (answer, farthest) in [(region, 0.06), (compass, 0.2)] {
        assert_eq!(answer.hypotheses.len(), 1, "{:?}", answer.hypotheses);
        let (distance, turn) = off(answer.estimate.unwrap(), last);
        println!("{:.3} mm, {:.3} deg", 1e3 * distance, turn.to_degrees());
        assert!(distance < farthest && turn < 0.02, "{distance} {turn}");
    }
}

#[test]
fn declared_odometry_errors_widen_the_place() {
    let Some(folder) = sweeps() else { return };
    let map = vibrissa::read_map(folder.join("bays.geojson")).unwrap();
    let log = vibrissa::read_log(folder.join("bays-00-bias.csv")).unwrap();
    let truth = read_tum(folder.join("bays-00-bias.truth.tum")).unwrap().last().unwrap().map_from_robot;
    let answer = |share: f64| {
        let mut robot = Robot::default();
        robot.whiskers[0].noise.moment_relative = 0.055;
        robot.odometry.translation_relative = share;
        robot.odometry.rotation_relative = share;
        localize(&log, &map, &robot, &options(), &mut |_| {}).unwrap()
    };
    let (exact, rough) = (answer(0.0), answer(0.0101));
    let (narrow, wide) = (exact.hypotheses[0].bound().unwrap(), rough.hypotheses[0].bound().unwrap());
    assert!(wide.0 > 1.2 * narrow.0 && wide.0 < 3e-3, "{narrow:?} {wide:?}");
    let extent = rough.hypotheses[0].extent;
    assert!(extent.x.contains(truth.x) && extent.y.contains(truth.y), "{extent:?}");
    assert!(off(rough.estimate.unwrap(), truth).0 < 2e-3);
}

#[test]
fn nonsense_ends_in_a_verdict() {
    let (map, mut log) = (demo::arena().unwrap(), demo::sweep(1).unwrap().log);
    log.rows.truncate(120);
    let mut seed = 7_u64;
    for row in &mut log.rows {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        row.readings[0] = 0.01 * ((seed >> 40) as f64 / 16_777_216.0 - 0.5);
    }
    let answer = localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap();
    assert!(matches!(answer.status, Status::Inconsistent | Status::Ambiguous), "{:?}", answer.status);
}

/// The demo's sweep up to a row, and then the same sweep from another row on, as if the robot had been carried there
/// without its odometry noticing; with the truth at the end and the row of the change.
fn carried(until: usize, from: usize) -> (SensorLog, Pose2, usize) {
    let (first, second) = (demo::sweep(1).unwrap(), demo::sweep(2).unwrap());
    let mut log = first.log;
    log.rows.truncate(until);
    let last = log.rows.last().unwrap().clone();
    let start = second.log.rows[from].odom_from_robot;
    for row in &second.log.rows[from + 1..] {
        let mut row = row.clone();
        row.odom_from_robot = last.odom_from_robot.compose(start.between(row.odom_from_robot));
        row.t += last.t - second.log.rows[from].t;
        log.rows.push(row);
    }
    (log, second.truth.last().unwrap().map_from_robot, until)
}

#[test]
fn a_robot_that_was_carried_away_is_found_again() {
    let map = demo::arena().unwrap();
    let rows = demo::sweep(1).unwrap().log.rows.len();
    for (until, from) in [(rows, 0), (2 * rows / 3, rows / 6)] {
        let (log, truth, change) = carried(until, from);
        let answer = localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap();
        let kinds: Vec<&str> = answer.events.iter().map(|e| e.kind).collect();
        println!("{until} {from}: {} {kinds:?}", answer.status);
        assert_eq!(answer.status, Status::Localized, "{:?}", answer.events);
        assert!(kinds.contains(&"inconsistent") && kinds.contains(&"recovered"), "{kinds:?}");
        let (distance, turn) = off(answer.estimate.unwrap(), truth);
        assert!(distance < 1e-3 && turn < 0.01, "{distance} {turn}");
        // The way before was another one, and stays so.
        let there = demo::sweep(1).unwrap().truth[until - 1].map_from_robot;
        let at = |t: f64| answer.trajectory.iter().find(|p| (p.t - t).abs() < 1e-9).unwrap().map_from_robot;
        assert!(off(at(log.rows[change - 1].t), there).0 < 5e-3);
    }
}

#[test]
fn memory_does_not_grow_and_the_place_stays_known() {
    // Forth and back along the demo's sweep, with new noise each time.
    let (map, sweep) = (demo::arena().unwrap(), demo::sweep(1).unwrap());
    let rows = &sweep.log.rows;
    let small = ProbabilisticOptions { window: 400, ..ProbabilisticOptions::exact() };
    let robot = Robot::default();
    let mut localizer = ProbabilisticEstimator::new(&map, &robot, &sweep.log.channels, small).unwrap().without_record();
    let mut draw = Random(11);
    let (mut worst, mut most, mut last): (f64, usize, usize) = (0.0, 0, 0);
    for step in 0..12_000_usize {
        let (way, at) = (step / (rows.len() - 1), step % (rows.len() - 1));
        let k = if way.is_multiple_of(2) { at } else { rows.len() - 1 - at };
        let mut row = rows[k].clone();
        row.t = step as f64 / 300.0;
        let exact = sweep.exact_moments[k][0];
        row.readings[0] = exact + draw.signed(1.0) * (0.045 * exact.abs() + 1.9e-5);
        localizer.step(&row).unwrap();
        most = most.max(localizer.rows_kept());
        if step > 2000 {
            let truth = sweep.truth[k].map_from_robot;
            worst = worst.max(localizer.estimate().pose().map_or(1.0, |e| off(e, truth).0));
        }
        last = k;
    }
    println!("{most} rows kept, worst {:.3} mm", 1e3 * worst);
    assert!(most <= 401, "{most}");
    assert!(worst < 0.3e-3, "{worst}");
    let answer = Box::new(localizer).finish();
    assert!(answer.trajectory.is_empty() && answer.steps.is_empty() && answer.events.len() < 200);
    assert_eq!(answer.status, Status::Localized, "{:?}", answer.events);
    assert!(off(answer.estimate.unwrap(), sweep.truth[last].map_from_robot).0 < 0.2e-3);
}

#[test]
fn a_whisker_that_feels_something_else_for_a_while_is_no_contradiction() {
    let (map, sweep) = (demo::arena().unwrap(), demo::sweep(3).unwrap());
    let truth = sweep.truth.last().unwrap().map_from_robot;
    let mut log = sweep.log;
    // As after a snap: for a sixth of the rows on end the moment is that of no equilibrium near.
    let from = log.rows.len() * 3 / 5;
    let until = from + log.rows.len() / 6;
    log.rows[from..until].iter_mut().for_each(|row| row.readings[0] *= 1.5);
    let tolerating = |tolerated_share| {
        Method::Probabilistic(ProbabilisticOptions { tolerated_share, ..ProbabilisticOptions::exact() })
    };
    let tolerant = tolerating(0.15);
    let answer = localize(&log, &map, &Robot::default(), &tolerant, &mut |_| {}).unwrap();
    assert_ne!(answer.status, Status::Inconsistent, "{:?}", answer.events);
    let nearest = answer.hypotheses.iter().map(|h| off(h.pose, truth).0).fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-3, "{nearest} {}", answer.status);
    let strict = tolerating(0.0);
    let answer = localize(&log, &map, &Robot::default(), &strict, &mut |_| {}).unwrap();
    assert_eq!(answer.status, Status::Inconsistent, "{:?}", answer.events);
}

#[test]
fn a_whisker_that_is_wedged_for_a_while_ends_nothing() {
    let (map, sweep) = (demo::arena().unwrap(), demo::sweep(3).unwrap());
    let truth = sweep.truth.last().unwrap().map_from_robot;
    let mut log = sweep.log;
    // More than any one contact makes, for a while; from the start on it is a wrong unit or whisker.
    let from = log.rows.len() * 3 / 5;
    log.rows[from..from + 20].iter_mut().for_each(|row| row.readings[0] *= 1e4);
    let answer = localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).unwrap();
    assert_ne!(answer.status, Status::Inconsistent, "{:?}", answer.events);
    assert!(off(answer.estimate.unwrap(), truth).0 < 1e-3);
    log.rows.iter_mut().for_each(|row| row.readings[0] *= 1e4);
    assert!(localize(&log, &map, &Robot::default(), &options(), &mut |_| {}).is_err());
}
