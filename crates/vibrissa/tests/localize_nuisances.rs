//! The probabilistic method where readings err in other ways than independently, and where what nobody knows exactly is declared: it is
//! estimated along, and the truth is in what is told.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/region.rs"]
mod region;

use region::{CHI2_95, distance};
use vibrissa::config::{NoiseAssumption, ProbabilisticOptions};
use vibrissa::flow::pose::{Localization, NuisanceQuantity, Status};
use vibrissa::plane::Pose2;
use vibrissa::sim::recorder::{NoiseLaw, Recorder, TrueErrors};
use vibrissa::sim::{SweepNoise, simulate_tip_sweep};
use vibrissa::tasks::demo;
use vibrissa::world::Robot;
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
