//! Tapered, jointed and elastically mounted whiskers through the corridor, on sweeps of the simulator.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::beam::{Stretch, Whisker};
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::Status;
use vibrissa::plane::wrap_angle;
use vibrissa::sets::StateBox;
use vibrissa::sim::{SimulateOptions, SweepNoise, simulate, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
use vibrissa::{Method, localize};

fn whiskers() -> Vec<(&'static str, Whisker)> {
    let paper = Whisker::default();
    let wire =
        |length, flexural_rigidity, tip_ratio| Stretch { length, flexural_rigidity, tip_ratio, ..Stretch::default() };
    vec![
        ("tapered", Whisker { tip_ratio: 0.4, ..paper }),
        ("on an elastic base", Whisker { base_stiffness: 0.03, ..paper }),
        ("of two wires", Whisker::of_stretches(&[wire(0.04, 3e-4, 1.0), wire(0.035, 1.5e-4, 0.7)]).unwrap()),
    ]
}

#[test]
fn a_straight_whisker_of_any_make_finds_its_place() {
    let (map, path) = (demo::arena().unwrap(), demo::path().unwrap());
    for (name, beam) in whiskers() {
        let mut robot = Robot::default();
        robot.whiskers[0].beam = beam;
        let noise = SweepNoise { seed: 3, ..SweepNoise::default() };
        let sweep = simulate_tip_sweep(&map, &robot, &path, &noise).unwrap();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        for (method, most) in [("probabilistic", 0.6e-3), ("deterministic", 2e-3)] {
            let answer = localize(&sweep.log, &map, &robot, &Method::named(method).unwrap(), &mut |_| {}).unwrap();
            let found = answer.estimate.unwrap();
            let (off, turn) =
                (found.position().distance(truth.position()), wrap_angle(found.theta - truth.theta).abs());
            println!("{name}, {method:?}: {:.3} mm, {:.3} deg", 1e3 * off, turn.to_degrees());
            assert_eq!(answer.status, Status::Localized, "{name}, {method:?}");
            assert!(off < most && turn < 0.01, "{name}, {method:?}: {off} m, {turn} rad");
        }
    }
}

#[test]
fn a_curved_whisker_is_refused_by_name_where_no_guarantee_is_asked_for() {
    let (map, mut robot) = (demo::arena().unwrap(), Robot::default());
    let log = demo::sweep(1).unwrap().log;
    robot.whiskers[0].beam.curvature = 4.0;
    for method in ["deterministic", "probabilistic"] {
        let method = Method::named(method).unwrap();
        let error = localize(&log, &map, &robot, &method, &mut |_| {}).unwrap_err().to_string();
        assert!(error.contains("curvature: 4") && error.contains("--method possibilistic"), "{method:?}: {error}");
    }
}

#[test]
fn the_guaranteed_set_holds_whiskers_of_any_make() {
    let (map, path) = (demo::arena().unwrap(), demo::path().unwrap());
    let curved = Whisker { curvature: 4.0, ..Whisker::default() };
    for (name, beam) in whiskers().into_iter().chain([("curved", curved)]) {
        let mut robot = Robot::default();
        robot.whiskers[0].beam = beam;
        let noise = SweepNoise { seed: 3, ..SweepNoise::default() };
        let sweep = simulate(&map, &robot, &path, &noise, &SimulateOptions::default()).unwrap();
        let truth = sweep.truth.last().unwrap().map_from_robot;
        // Curved ones tell little at first: by default the end of the log has not work enough for them.
        let options = PossibilisticOptions { last_work: 5_000_000, ..PossibilisticOptions::default() };
        let answer = localize(&sweep.log, &map, &robot, &Method::Possibilistic(options), &mut |_| {}).unwrap();
        let holds = |state: &StateBox| {
            let (theta, [x, y]) = (state.theta, [state.x, state.y]);
            let middle = 0.5 * (theta.lo() + theta.hi());
            x.contains(truth.x) && y.contains(truth.y) && theta.contains(middle + wrap_angle(truth.theta - middle))
        };
        let area: f64 = answer.states.iter().map(|state| state.x.width() * state.y.width()).sum();
        println!("{name}: {}, {} boxes of {:.3} mm² in all", answer.status, answer.states.len(), 1e6 * area);
        assert!(answer.states.iter().any(holds), "{name}: {} {:?}", answer.status, answer.events.last());
        assert_eq!(answer.status, Status::Localized, "{name}");
    }
}
