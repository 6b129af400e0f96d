//! What is told to try for logs that are spoiled on purpose.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Localization, Remedy, Status};
use vibrissa::flow::sensor_log::{LogRow, SensorLog};
use vibrissa::plane::Pose2;
use vibrissa::sim::recorder::{Recorder, TrueErrors};
use vibrissa::tasks::{advise, demo};
use vibrissa::world::Robot;
use vibrissa::{Method, localize};

fn spoiled(change: impl Fn(&mut LogRow)) -> (SensorLog, Robot) {
    let mut log = demo::sweep(1).unwrap().log;
    log.rows.iter_mut().for_each(change);
    (log, Robot::default())
}

fn placed(change: impl Fn(Pose2) -> Pose2) -> (SensorLog, Robot) {
    spoiled(|row| row.odom_from_robot = change(row.odom_from_robot))
}

/// The demo's sweep with a robot that is other than declared.
fn undeclared(truth: TrueErrors) -> (SensorLog, Robot) {
    let robot = Robot::default();
    let recorder = Recorder { truth, ..Recorder::default() };
    let log = recorder.record(&robot, &demo::sweep(1).unwrap()).unwrap().log;
    (log, truth.declared_robot(&robot).unwrap())
}

/// The answer with what is told to try.
fn advised(log: &SensorLog, robot: &Robot, method: &Method, go_on: &mut dyn FnMut() -> bool) -> Localization {
    let map = demo::arena().unwrap();
    let mut answer = localize(log, &map, robot, method, &mut |_| {}).unwrap();
    advise(&mut answer, log, &map, robot, method, go_on).unwrap();
    answer
}

fn told((log, robot): &(SensorLog, Robot), method: &Method) -> Vec<Remedy> {
    let answer = advised(log, robot, method, &mut || true);
    assert_eq!(answer.status, Status::Inconsistent);
    answer.consistency.expect("remedies").remedies
}

/// The remedy with these words comes first. Each case is a test of its own, since each tries two dozen changes.
fn comes_first(words: &str, case: &(SensorLog, Robot)) {
    // The guaranteed method contradicts the soonest.
    let found = told(case, &Method::named("possibilistic").unwrap());
    let best = &found.first().unwrap_or_else(|| panic!("{words}: nothing is told")).change;
    println!("{words}: {found:?}");
    assert!(best.contains(words), "{words}: {best}");
    assert!(found.iter().all(|remedy| remedy.status != Status::Inconsistent) && found.len() <= 5);
    assert!(found[0].statistic < 2.0, "the readings fit: {found:?}");
    assert!(found.iter().all(|remedy| remedy.statistic < 26.0), "what does not fit at all is no remedy: {found:?}");
}

#[test]
fn swapped_axes_are_told_first() {
    comes_first("x and y are swapped", &placed(|p| Pose2::new(p.y, p.x, p.theta)));
}

#[test]
fn millimetres_are_told_first() {
    comes_first("in millimetres", &placed(|p| Pose2::new(1e3 * p.x, 1e3 * p.y, p.theta)));
}

#[test]
fn degrees_are_told_first_where_they_leave_a_turn_of_radians() {
    // The demo turns by 4 degrees, which as radians are more than half a turn.
    comes_first("theta is in degrees", &placed(|p| Pose2::new(p.x, p.y, p.theta.to_degrees())));
}

#[test]
fn a_wrong_heading_is_told_first() {
    comes_first("heading is wrong", &spoiled(|row| row.heading = Some(0.35)));
}

#[test]
fn a_gain_is_told_first() {
    let truth = TrueErrors { gain: 0.2, ..TrueErrors::default() };
    comes_first("readings are 20 % too large", &undeclared(truth));
}

#[test]
fn a_length_is_told_first() {
    let length = Robot::default().whiskers[0].beam.length;
    let truth = TrueErrors { length: length - length / 1.1, ..TrueErrors::default() };
    comes_first("the whisker is 10 % longer", &undeclared(truth));
}

/// The methods by name, each with a test of its own.
fn has_remedies(name: &str) {
    let method = Method::named(name).unwrap();
    let found = told(&spoiled(|row| row.readings[0] = -row.readings[0]), &method);
    println!("{method}: {found:?}");
    assert!(found[0].change.contains("the sign of w0.moment"), "{method}: {found:?}");
}

#[test]
fn the_deterministic_method_has_remedies() {
    has_remedies("deterministic");
}

#[test]
fn the_possibilistic_method_has_remedies() {
    has_remedies("possibilistic");
}

#[test]
fn the_probabilistic_method_has_remedies() {
    has_remedies("probabilistic");
}

#[test]
fn no_method_is_without_a_test() {
    let names = Method::all().each_ref().map(Method::name);
    assert!(names.iter().all(|name| ["deterministic", "possibilistic", "probabilistic"].contains(name)), "{names:?}");
}

#[test]
fn errors_that_nobody_declared_are_left_out_first() {
    let ((log, robot), map) = (spoiled(|_| {}), demo::arena().unwrap());
    let mut answer = localize(&log, &map, &robot, &Method::default(), &mut |_| {}).unwrap();
    answer.status = Status::Inconsistent;
    let first = |method: &Method| {
        let mut answer = answer.clone();
        advise(&mut answer, &log, &map, &robot, method, &mut || true).unwrap();
        answer.consistency.unwrap().remedies.into_iter().next()
    };
    let best = first(&Method::default()).unwrap();
    assert!(best.change.contains("--undeclared none") && best.statistic < 2.0, "{best:?}");
    let exact = Method::Probabilistic(ProbabilisticOptions::exact());
    assert!(first(&exact).is_none_or(|remedy| !remedy.change.contains("--undeclared")));
}

#[test]
fn what_fits_needs_no_remedy_and_nobody_waits_longer_than_he_wants() {
    let (log, robot) = spoiled(|_| {});
    let answer = advised(&log, &robot, &Method::default(), &mut || panic!("nothing to try"));
    assert!(answer.status == Status::Localized && answer.consistency.is_none_or(|fit| fit.remedies.is_empty()));
    let (log, robot) = spoiled(|row| row.readings[0] = -row.readings[0]);
    let mut asked = 0;
    let mut impatient = || {
        asked += 1;
        asked < 10
    };
    let answer = advised(&log, &robot, &Method::default(), &mut impatient);
    assert_eq!(answer.consistency.unwrap().remedies, []);
    assert_eq!(asked, 10);
}
