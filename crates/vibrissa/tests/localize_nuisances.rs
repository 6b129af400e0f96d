//! The probabilistic method where readings err in other ways than independently, and where what nobody knows exactly is declared: it is
//! estimated along, and the truth is in what is told.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/region.rs"]
mod region;

use region::{CHI2_95, distance};
use vibrissa::config::{NoiseAssumption, ProbabilisticOptions};
use vibrissa::flow::pose::{Localization, NuisanceQuantity, Status};
use vibrissa::plane::{Curve, Pose2, Segment, Vec2};
use vibrissa::sim::recorder::{NoiseLaw, Recorder, TrueErrors};
use vibrissa::sim::{Pace, SimulateOptions, SweepNoise, path_through, simulate, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, localize};

/// The answer to the demo's sweep of a robot that is not quite what it declares, and where the declared robot is at the end.
fn answer(
    declared: &Robot,
    truth: TrueErrors,
    law: NoiseLaw,
    seed: u64,
    noise_model: NoiseAssumption,
) -> (Localization, Pose2) {
    let map = demo::arena().unwrap();
    let robot = truth.true_robot(declared).unwrap();
    let path = demo::path().unwrap();
    let sweep = simulate_tip_sweep(&map, &robot, &path, &SweepNoise::none()).unwrap();
    let noise = SweepNoise::seeded(seed);
    let recorder = Recorder { noise, law, truth, ..Recorder::default() };
    let log = recorder.record(&robot, &sweep).unwrap().log;
    let method = Method::Probabilistic(ProbabilisticOptions { noise_model, ..ProbabilisticOptions::default() });
    let told = localize(&log, &map, declared, &method, &mut |_| {}).unwrap();
    (told, truth.on_declared_map(sweep.truth.last().unwrap().map_from_robot))
}

#[test]
fn errors_that_stay_alike_leave_the_truth_in_the_region() {
    let robot = Robot::default();
    let laws = ["two_point", "ar1", "sine", "hysteresis", "drift"];
    let mut refused = 0;
    for word in laws {
        let law = NoiseLaw::from_word(word).unwrap_or_else(|| panic!("{word}"));
        let (told, truth) = answer(&robot, TrueErrors::default(), law, 4, NoiseAssumption::Correlated);
        assert_ne!(told.status, Status::Inconsistent, "{word}: {:?}", told.events);
        let near = told.hypotheses.iter().map(|h| distance(h, truth)).fold(f64::INFINITY, f64::min);
        println!("{word}: {}, chi² {near:.1}", told.status);
        assert!(near < 2.0 * CHI2_95, "{word}: {near}");
        let (plain, _) = answer(&robot, TrueErrors::default(), law, 4, NoiseAssumption::Independent);
        let near = plain.hypotheses.iter().map(|h| distance(h, truth)).fold(f64::INFINITY, f64::min);
        refused += usize::from(plain.status == Status::Inconsistent || near > 2.0 * CHI2_95);
    }
    // Taken for independent, most of these errors contradict what is declared, or move the answer out of its region.
    assert!(refused >= 3, "{refused}");
}

#[test]
fn what_is_declared_as_not_known_is_estimated() {
    let mut declared = Robot::default();
    let errors = &mut declared.whiskers[0].errors;
    (errors.zero, errors.gain, errors.mount) = (3e-4, 0.08, [0.0, 0.0, 0.035]);
    declared.odometry.delay = 0.02;
    let none = TrueErrors::default();
    let cases = [
        (TrueErrors { zero: 2e-4, ..none }, NuisanceQuantity::Zero, 2e-4),
        (TrueErrors { gain: 0.07, ..none }, NuisanceQuantity::Gain, 0.07),
        (TrueErrors { mount: [0.0, 0.0, 0.03], ..none }, NuisanceQuantity::MountHeading, 0.03),
        (TrueErrors { delay: -0.012, ..none }, NuisanceQuantity::Delay, -0.012),
    ];
    for (truth, quantity, value) in cases {
        let (told, pose) = answer(&declared, truth, NoiseLaw::Uniform, 11, NoiseAssumption::Independent);
        assert!(matches!(told.status, Status::Localized | Status::Ambiguous), "{quantity:?}: {:?}", told.events);
        let near = told.hypotheses.iter().map(|h| distance(h, pose)).fold(f64::INFINITY, f64::min);
        let own = told.nuisances.iter().find(|n| n.quantity == quantity).unwrap();
        println!("{quantity:?}: {:.5} +- {:.5}, not {value}; chi² {near:.1}", own.estimate, own.std);
        assert!((own.estimate - value).abs() < 4.0 * own.std + 0.02 * value.abs(), "{quantity:?}: {own:?}");
        assert!(own.std < 0.7 * own.bound, "{quantity:?} is not told any better than it was declared: {own:?}");
        assert!(near < 2.0 * CHI2_95, "{quantity:?}: {near}");
    }
}

/// The demo's arena, moved.
fn arena_at(place: Vec2) -> Map {
    let boundary = |b: &Boundary| {
        let segment = |s: &Segment| match *s {
            Segment::Line(p) => Segment::Line(p.map(|p| p + place)),
            Segment::Quadratic(p) => Segment::Quadratic(p.map(|p| p + place)),
            Segment::Cubic(p) => Segment::Cubic(p.map(|p| p + place)),
        };
        let segments = b.curve().segments().iter().map(segment).collect();
        Boundary::new(b.role(), Curve::from_segments(segments, b.curve().is_closed()).unwrap(), None).unwrap()
    };
    Map::new(demo::arena().unwrap().boundaries().iter().map(boundary).collect()).unwrap()
}

#[test]
fn places_are_told_on_the_map_as_it_is_drawn_though_its_scale_is_wrong() {
    let mut declared = Robot { map_scale: 0.02, ..Robot::default() };
    declared.odometry.translation_relative = 0.005;
    // Far from the origin an error of the scale is a long way.
    let world = arena_at(Vec2::new(1.5, -2.0));
    for (seed, map_scale) in [(3, 0.02), (4, -0.015)] {
        let truth = TrueErrors { map_scale, ..TrueErrors::default() };
        let map = truth.declared_map(&world).unwrap();
        let mut path = demo::path().unwrap();
        path.iter_mut().for_each(|p| {
            (p.map_from_robot.x, p.map_from_robot.y) = (p.map_from_robot.x + 1.5, p.map_from_robot.y - 2.0)
        });
        let robot = truth.true_robot(&declared).unwrap();
        let mut sweep = simulate_tip_sweep(&world, &robot, &path, &SweepNoise::none()).unwrap();
        let recorder = Recorder { noise: SweepNoise::seeded(seed), truth, ..Recorder::default() };
        let log = recorder.record(&robot, &sweep).unwrap().log;
        sweep.truth.iter_mut().for_each(|pose| pose.map_from_robot = truth.on_declared_map(pose.map_from_robot));
        let method = Method::Probabilistic(ProbabilisticOptions::default());
        let told = localize(&log, &map, &declared, &method, &mut |_| {}).unwrap();
        let pose = sweep.truth.last().unwrap().map_from_robot;
        let near = told.hypotheses.iter().map(|h| distance(h, pose)).fold(f64::INFINITY, f64::min);
        assert!(near < 2.0 * CHI2_95, "{map_scale}: {near}");
        let own = told.nuisances.iter().find(|n| n.quantity == NuisanceQuantity::MapScale).unwrap();
        assert!((own.estimate - map_scale).abs() < 4.0 * own.std, "{own:?}");
        assert_eq!(told.status, Status::Localized, "{map_scale}");
        // The way back from the last row is as long as it is drawn.
        for (row, exact) in told.trajectory.iter().rev().zip(sweep.truth.iter().rev()).step_by(40) {
            let off = row.map_from_robot.position().distance(exact.map_from_robot.position());
            assert!(off < 2e-3, "{map_scale}: {off} at {}", row.t);
        }
    }
}

#[test]
fn a_contact_is_found_beside_a_zero_that_has_drifted_to_the_other_side() {
    // Along a wall and over a bay. The first readings of the contact have the sign of the zero, not that of the moment.
    let outline =
        [(0.0, 0.0), (0.25, 0.0), (0.25, -0.05), (0.32, -0.05), (0.32, 0.0), (0.45, 0.0), (0.45, 0.3), (0.0, 0.3)];
    let outline = outline.map(|(x, y)| Vec2::new(x, y));
    let map = Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&outline, true).unwrap(), None).unwrap()]);
    let (map, mut robot) = (map.unwrap(), Robot::default());
    robot.whiskers[0].beam.length = 0.08;
    robot.whiskers[0].robot_from_whisker = Pose2::new(0.0, 0.0, -1.2);
    robot.whiskers[0].noise.moment_absolute = 5e-6;
    robot.whiskers[0].errors.zero_drift = 1e-5;
    let way = [(0.1, 0.2), (0.15, 0.066), (0.4, 0.066)].map(|(x, y)| Pose2::new(x, y, 0.0));
    let path = path_through(&way, &Pace { speed: 0.02, turn_rate: 1.0, rate: 50.0 }).unwrap();
    let sweep = simulate(&map, &robot, &path, &SweepNoise::none(), &SimulateOptions::default()).unwrap();
    let pose = sweep.truth.last().unwrap().map_from_robot;
    for zero_drift in [-9.5e-6, 9.5e-6] {
        let truth = TrueErrors { zero_drift, ..TrueErrors::default() };
        let recorder = Recorder { noise: SweepNoise::seeded(5), truth, ..Recorder::default() };
        let log = recorder.record(&robot, &sweep).unwrap().log;
        let method = Method::Probabilistic(ProbabilisticOptions::default());
        let told = localize(&log, &map, &robot, &method, &mut |_| {}).unwrap();
        let near = told.hypotheses.iter().map(|h| distance(h, pose)).fold(f64::INFINITY, f64::min);
        println!("{zero_drift}: {}, chi² {near:.1}, {:?}", told.status, told.events);
        assert!(near < 2.0 * CHI2_95, "{zero_drift}: {}, {near}", told.status);
        let drift = told.nuisances.iter().find(|n| n.quantity == NuisanceQuantity::ZeroDrift).unwrap();
        assert!((drift.estimate - zero_drift).abs() < 1e-6, "{drift:?}");
    }
}
