//! The probabilistic method on sweeps of more rows than it keeps: what is summed up must neither be believed too much nor lost.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/region.rs"]
mod region;

use region::{CHI2_95, distance};
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::localizer::{Estimator, ProbabilisticEstimator};
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, SweepNoise, path_through, simulate_tip_sweep};
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, localize};

/// A square room of 400 mm.
fn room() -> Map {
    let corners = [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, 0.2)].map(|(x, y)| Vec2::new(x, y));
    Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
}

/// Waypoints (x, y in m, heading in rad) around three walls, with the whisker on them, in a slow wave.
fn waypoints(lines: &str) -> Vec<Pose2> {
    let numbers = |line: &str| line.split(',').map(|v| v.parse().unwrap()).collect::<Vec<f64>>();
    lines.lines().map(numbers).map(|v| Pose2::new(v[0], v[1], v[2])).collect()
}

/// The answer after a sweep with noise of this seed, as declared, and where the robot then is.
fn swept(lines: &str, seed: u64) -> (Localization, Pose2, usize) {
    let (map, robot) = (room(), Robot::default());
    let pace = Pace { speed: 0.3, turn_rate: 1.0, rate: 300.0 };
    let path = path_through(&waypoints(lines), &pace).unwrap();
    let sweep = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::seeded(seed)).unwrap();
    let options = Method::Probabilistic(Default::default());
    let answer = localize(&sweep.log, &map, &robot, &options, &mut |_| {}).unwrap();
    (answer, sweep.truth.last().unwrap().map_from_robot, sweep.log.rows.len())
}

/// The truth's least squared distance from a place, in the place's standard deviations; the room has four that are equal.
fn told_off(answer: &Localization, truth: Pose2) -> f64 {
    assert_eq!(answer.status, Status::Ambiguous, "{:?}", answer.events);
    assert_eq!(answer.hypotheses.len(), 4);
    answer.hypotheses.iter().map(|h| distance(h, truth)).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_second_wall_is_met_wherever_along_the_first_the_robot_is() {
    // Until then the place along the first wall is open, and the nearest hypothesis may stand 2 mm off.
    let (answer, truth, rows) = swept(include_str!("data/square_path_5.csv"), 5);
    let off = told_off(&answer, truth);
    println!("{rows} rows, chi² {off:.1}");
    assert!(answer.events.iter().all(|event| event.kind != "inconsistent"), "{:?}", answer.events);
    assert!(rows > 1200 && off < CHI2_95, "{rows} {off}");
}

#[test]
fn regions_after_many_rows_hold_the_truth() {
    // Three sweeps: that none is beyond the 95 % point by chance is likely, and that their mean is below twice the number
    // of freedoms, which is 3; what had been summed up too sharply gave 20 to 200.
    let all = [6, 7, 8].map(|seed| {
        let (answer, truth, _) = swept(include_str!("data/square_path_6.csv"), seed);
        told_off(&answer, truth)
    });
    println!("chi² {all:.1?}");
    assert!(all.iter().sum::<f64>() < 18.0, "{all:?}");
}

#[test]
fn nobody_goes_on_through_a_wall() {
    // A wrong hypothesis begins inside and may be carried through a wall. The room is 400 mm wide; by hand, what is dropped is
    // more than 8 mm outside, or 3 mm more where it is yet to move, and up to eight rows of 1 mm are taken before it is.
    let (map, robot) = (room(), Robot::default());
    let pace = Pace { speed: 0.3, turn_rate: 1.0, rate: 300.0 };
    let path = path_through(&waypoints(include_str!("data/square_path_6.csv")), &pace).unwrap();
    let sweep = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::seeded(6)).unwrap();
    let options = ProbabilisticOptions::default();
    let mut one = ProbabilisticEstimator::new(&map, &robot, &sweep.log.channels, options).unwrap();
    let (mut deepest, mut most) = (0.0_f64, 0);
    for row in &sweep.log.rows {
        one.step(row).unwrap();
        let states = one.states_now();
        most = most.max(states.len());
        deepest = states.iter().map(|s| s.x.abs().max(s.y.abs()) - 0.2).fold(deepest, f64::max);
    }
    println!("{:.1} mm outside of {most}", 1e3 * deepest);
    assert!(most > 100 && deepest < 0.02, "{most} {deepest}");
}

#[test]
fn a_compass_that_is_wrong_by_the_same_all_along_counts_once() {
    // Along one wall, at one heading, the readings say nothing of where along it and little of the heading.
    let (map, robot) = (room(), Robot::default());
    let way = [[0.1, -0.123], [0.1, -0.153], [-0.1, -0.151]].map(|[x, y]| Pose2::new(x, y, -0.834));
    let path = path_through(&way, &Pace { speed: 0.05, turn_rate: 1.0, rate: 300.0 }).unwrap();
    let mut sweep = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::seeded(3)).unwrap();
    for (row, truth) in sweep.log.rows.iter_mut().zip(&sweep.truth) {
        row.heading = Some(truth.map_from_robot.theta + 0.03);
    }
    let answers = [200, 4000].map(|window| {
        let options = ProbabilisticOptions { window, heading_error: 0.06, ..ProbabilisticOptions::default() };
        localize(&sweep.log, &map, &robot, &Method::Probabilistic(options), &mut |_| {}).unwrap()
    });
    let turn = answers.each_ref().map(|answer| {
        let told = answer.hypotheses.iter().filter_map(|h| h.covariance).map(|c| c[2][2].sqrt());
        told.fold(f64::INFINITY, f64::min)
    });
    println!("{} rows: {turn:.4?} rad", sweep.log.rows.len());
    assert!(turn[0] > 0.9 * turn[1] && turn[0].is_finite(), "{turn:?}");
}
