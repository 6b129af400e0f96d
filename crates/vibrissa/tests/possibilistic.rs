//! The possibilistic method never loses the truth: random sweeps at the edge of the declared bounds, and sweeps of an
//! independent simulator.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/random_sweep.rs"]
mod random_sweep;
#[path = "data/shared.rs"]
mod shared;

use random_sweep::{Trial, contains, random_sweep, random_sweep_of};
use shared::shared;
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::{Localization, Status};
use vibrissa::flow::sensor_log::{Channel, Quantity};
use vibrissa::io::read_tum;
use vibrissa::plane::{Curve, Pose2, Vec2};
use vibrissa::sim::{Pace, SimulateOptions, SweepNoise, path_through, simulate};
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, localize};

/// Little work, for speed: soundness does not depend on it.
fn quick() -> PossibilisticOptions {
    PossibilisticOptions { work: 30, last_work: 0, ..PossibilisticOptions::default() }
}

fn run(trial: &Trial, possibilistic: PossibilisticOptions) -> Localization {
    let options = Method::Possibilistic(possibilistic);
    localize(&trial.log, &trial.map, &trial.robot, &options, &mut |_| {}).unwrap()
}

/// The first trials from a seed on.
fn trials(first: u64, count: usize) -> impl Iterator<Item = (u64, Trial)> {
    (first..).filter_map(|seed| Some((seed, random_sweep(seed)?))).take(count)
}

#[test]
fn the_truth_is_never_lost() {
    for (seed, trial) in trials(1, 24) {
        let answer = run(&trial, quick());
        assert!(contains(&answer, trial.truth), "seed {seed}: {} {:?}", answer.status, answer.events);
    }
}

/// Tapered, curved and of several wires, some with declared errors; the simulator marches rods step by step.
#[test]
fn the_truth_is_never_lost_with_whiskers_of_any_kind() {
    let trials = (1..).filter_map(|seed| Some((seed, random_sweep_of(seed, true)?))).take(10);
    for (seed, trial) in trials {
        assert!(!trial.robot.whiskers[0].beam.is_uniform());
        let answer = run(&trial, quick());
        assert!(contains(&answer, trial.truth), "seed {seed}: {} {:?}", answer.status, answer.events);
    }
}

#[test]
fn headings_and_a_prior_only_help() {
    for (seed, mut trial) in trials(500, 6) {
        let plain = run(&trial, quick());
        // The truth along the log is not kept, but its odometry differs from it by one motion at the last row.
        let last = trial.log.rows[trial.log.rows.len() - 1].odom_from_robot;
        let exact = trial.robot.odometry.translation_relative == 0.0;
        for row in &mut trial.log.rows {
            row.heading = Some(trial.truth.theta + (row.odom_from_robot.theta - last.theta) + 0.05);
        }
        let heading_error = if exact { 0.051 } else { 0.2 };
        let helped = run(&trial, PossibilisticOptions { heading_error, ..quick() });
        assert!(contains(&helped, trial.truth), "seed {seed}: {:?}", helped.events);
        assert!(helped.steps[0].volume < 0.5 * plain.steps[0].volume, "seed {seed}");
        if exact {
            let first = trial.truth.compose(last.between(trial.log.rows[0].odom_from_robot));
            let around = |v: f64, by: f64| [v - by, v + 0.1 * by];
            let prior = Some([around(first.x, 0.05), around(first.y, 0.05), around(first.theta, 0.5)]);
            trial.log.rows.iter_mut().for_each(|row| row.heading = None);
            let helped = run(&trial, PossibilisticOptions { prior, ..quick() });
            assert!(contains(&helped, trial.truth), "seed {seed}: {:?}", helped.events);
            assert!(helped.steps[0].volume < 0.5 * plain.steps[0].volume, "seed {seed}");
        }
    }
}

#[test]
fn a_wrong_reading_can_be_tolerated() {
    // Enough work that what is left at the end of these trials does without the states that the wrong reading rules out.
    let patient = PossibilisticOptions { work: 60, last_work: 100_000, ..PossibilisticOptions::default() };
    let mut ruled_out = 0;
    for (seed, mut trial) in trials(709, 2) {
        // The first reading that is a contact for certain is a strong one to the other side.
        let noise = trial.robot.whiskers[0].noise;
        let certain = |z: f64| z.abs() * (1.0 - noise.moment_relative) > noise.moment_absolute;
        let touching = trial.log.rows.iter().position(|row| certain(row.readings[0]));
        let Some(index) = touching else { continue };
        let beam = &trial.robot.whiskers[0].beam;
        let strong = 1.2 * beam.flexural_rigidity / beam.length;
        trial.log.rows[index].readings[0] = -strong.copysign(trial.log.rows[index].readings[0]);
        let strict = run(&trial, patient);
        ruled_out += usize::from(!contains(&strict, trial.truth));
        let tolerant = run(&trial, PossibilisticOptions { tolerate: 1, ..patient });
        assert!(contains(&tolerant, trial.truth), "seed {seed}: {:?}", tolerant.events);
    }
    assert!(ruled_out > 0, "the wrong reading rules out nothing");
}

#[test]
fn each_whisker_is_one_more_constraint() {
    for (seed, mut trial) in trials(900, 4) {
        let alone = run(&trial, quick());
        let mut second = trial.robot.whiskers[0].clone();
        second.name = "w1".into();
        trial.robot.whiskers.push(second);
        let channel = |name: &str| Channel { whisker: name.into(), quantity: Quantity::Moment };
        trial.log.channels = vec![channel("w0"), channel("w1")];
        trial.log.rows.iter_mut().for_each(|row| row.readings = vec![row.readings[0]; 2]);
        let both = run(&trial, quick());
        assert!(contains(&both, trial.truth), "seed {seed}: {:?}", both.events);
        let volume = |answer: &Localization| answer.steps.last().unwrap().volume;
        assert!(volume(&both) < 3.0 * volume(&alone), "{} {}", volume(&both), volume(&alone));
    }
}

#[test]
fn same_input_same_answer() {
    let (_, trial) = trials(40, 1).next().unwrap();
    assert_eq!(run(&trial, quick()), run(&trial, quick()));
}

/// Another physics code, 5 % noise or gain and odometry errors.
fn check_sweeps(names: &[&str], last_work: usize) {
    let Some(folder) = shared("sweeps") else { return };
    for name in names {
        let map = vibrissa::read_map(folder.join(format!("{}.geojson", name.split('-').next().unwrap()))).unwrap();
        let log = vibrissa::read_log(folder.join(format!("{name}.csv"))).unwrap();
        let truth = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap().last().unwrap().map_from_robot;
        let mut robot = Robot::default();
        if name.ends_with("bias") {
            robot.whiskers[0].noise.moment_relative = 0.055;
            robot.odometry.translation_relative = 0.0101;
            robot.odometry.rotation_relative = 0.0101;
        }
        let options = PossibilisticOptions { last_work, ..PossibilisticOptions::default() };
        let answer =
            run(&Trial { map, robot, log, truth, kinds: [0; 5], path: Vec::new(), touches: Vec::new() }, options);
        let (first, last) = (answer.steps[0], answer.steps[answer.steps.len() - 1]);
        println!("{name}: {}, {:.1e} to {:.1e} m2 rad", answer.status, first.volume, last.volume);
        assert!(contains(&answer, truth), "{name}: {} {:?}", answer.status, answer.events);
        assert!(last.volume < 0.8 * first.volume, "{name}: {first:?} {last:?}");
        assert_ne!(answer.status, Status::NoContact);
    }
}

#[test]
fn sweeps_of_another_simulator_are_kept() {
    check_sweeps(&["rough0-02", "bays-01", "square-01"], 20_000);
}

#[test]
fn biased_sweeps_of_another_simulator_are_kept() {
    // With a drifting odometry the rows alone tighten little.
    check_sweeps(&["rough0-03-bias", "obstacle-00-bias"], 200_000);
}

#[test]
fn a_unique_place_beside_concave_boundary_is_found() {
    let Some(folder) = shared("sweeps") else { return };
    let (map, log) = (
        vibrissa::read_map(folder.join("obstacle.geojson")).unwrap(),
        vibrissa::read_log(folder.join("obstacle-00.csv")).unwrap(),
    );
    let truth = read_tum(folder.join("obstacle-00.truth.tum")).unwrap().last().unwrap().map_from_robot;
    let trial =
        Trial { map, robot: Robot::default(), log, truth, kinds: [0; 5], path: Vec::new(), touches: Vec::new() };
    let answer = run(&trial, PossibilisticOptions::default());
    let last = answer.steps.last().unwrap();
    println!("{}: {} places, {:.1} mm2", answer.status, answer.hypotheses.len(), 1e6 * last.area_m2);
    // Its bays could hold a whisker with an inflection in many places; the readings do not fit there.
    assert!(contains(&answer, truth));
    assert!(answer.status == Status::Localized && last.area_m2 < 30e-6, "{}: {} m2", answer.status, last.area_m2);
}

#[test]
fn a_refinement_without_work_enough_is_told() {
    let (_, trial) = trials(48, 1).next().unwrap();
    let ends = |last_work: usize| run(&trial, PossibilisticOptions { last_work, ..quick() });
    let is_told = |answer: &Localization| answer.events.iter().any(|event| event.kind == "cut_short");
    // Less than one meeting for each cell, and little more.
    for work in [1, 3000] {
        let answer = ends(work);
        assert!(contains(&answer, trial.truth) && answer.status == Status::Ambiguous, "{work}: {}", answer.status);
        let told = answer.events.last().unwrap();
        assert!(told.kind == "cut_short" && told.detail.contains(&format!("(last_work {work})")), "{work}: {told:?}");
        // What it proposes leaves less.
        let proposed = told.detail.rsplit("last_work ").next().unwrap().split(' ').next().unwrap().parse().unwrap();
        let volume = |answer: &Localization| answer.steps.last().unwrap().volume;
        assert!(volume(&ends(proposed)) < volume(&answer), "{work}: {proposed}");
    }
    // Without any it is as was asked for, and with enough nothing is to be told.
    let enough = ends(5_000_000);
    assert!(!is_told(&ends(0)) && enough.status == Status::Ambiguous && !is_told(&enough));
}

#[test]
fn a_set_that_is_empty_only_after_the_last_row_is_told() {
    let (_, trial) = trials(709, 1).next().unwrap();
    // The moments of another whisker, three times as stiff: nothing on the map explains all of them.
    let mut log = trial.log.clone();
    log.rows.iter_mut().for_each(|row| row.readings[0] *= 3.0);
    let trial = Trial { log, ..trial };
    let options = PossibilisticOptions { work: 1, last_work: 300_000, ..PossibilisticOptions::default() };
    let answer = run(&trial, options);
    assert_eq!(answer.status, Status::Inconsistent);
    assert!(answer.events.last().unwrap().detail.starts_with("all readings together"), "{:?}", answer.events.last());
}

#[test]
fn no_way_leads_through_a_wall() {
    // Along the lower wall, far to the right through the air and back, and on along the wall: no reading tells where along it, but the way to the
    // right needs room.
    let outline = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.3), (0.0, 0.3)].map(|(x, y)| Vec2::new(x, y));
    let map = Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&outline, true).unwrap(), None).unwrap()]);
    let (map, mut robot) = (map.unwrap(), Robot::default());
    robot.whiskers[0].beam.length = 0.08;
    robot.whiskers[0].robot_from_whisker = Pose2::new(0.0, 0.0, -1.2);
    let way = [
        (0.1, 0.09),
        (0.105, 0.066),
        (0.16, 0.066),
        (0.17, 0.15),
        (0.42, 0.15),
        (0.17, 0.15),
        (0.18, 0.066),
        (0.2, 0.066),
    ];
    let way = way.map(|(x, y)| Pose2::new(x, y, 0.0));
    let path = path_through(&way, &Pace { speed: 0.1, turn_rate: 1.0, rate: 50.0 }).unwrap();
    let sweep = simulate(&map, &robot, &path, &SweepNoise::seeded(3), &SimulateOptions::default()).unwrap();
    let truth = path.last().unwrap().map_from_robot;
    // In the air a row for every 110 mm: no whisker is seen to go through the wall, but the base is behind it.
    let mut log = sweep.log.clone();
    let is_in_air = |y: f64| y > truth.y + 0.083;
    let mut air = 0;
    log.rows.retain(|row| {
        air += 1;
        !is_in_air(row.odom_from_robot.y + path[0].map_from_robot.y) || air % 55 == 0
    });
    let options = PossibilisticOptions {
        heading_error: 0.01,
        work: 1,
        prior: Some([[0.0, 0.5], [0.0, 0.3], [-0.02, 0.02]]),
        ..PossibilisticOptions::default()
    };
    let answer = localize(&log, &map, &robot, &Method::Possibilistic(options), &mut |_| {}).unwrap();
    assert!(contains(&answer, truth));
    // At the right end of its way, 0.22 m further than at the end, the base was at 0.5 m at most; the row there may be 25 mm before it.
    let right = answer.hypotheses.iter().map(|place| place.extent.x.hi()).fold(f64::NEG_INFINITY, f64::max);
    assert!(right < 0.31, "{right}");
}
