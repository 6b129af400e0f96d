//! Work that pauses: whatever the slices, the answer is the same to the last bit, and what is told in between holds the truth
//! where the method guarantees that.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/random_arena.rs"]
mod random_arena;

use random::Random;
use vibrissa::config::PossibilisticOptions;
use vibrissa::flow::pose::Localization;
use vibrissa::plane::{Curve, Vec2};
use vibrissa::sim::Sweep;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Localizer, Method, WorkBudget};

fn room() -> Map {
    let corners = [(0.0, 0.0), (0.36, 0.03), (0.41, 0.27), (0.18, 0.33), (-0.04, 0.2)].map(|(x, y)| Vec2::new(x, y));
    Map::new(vec![Boundary::new(Role::Arena, Curve::polyline(&corners, true).unwrap(), None).unwrap()]).unwrap()
}

fn sweep(map: &Map, seed: u64) -> Sweep {
    let mut draw = Random(seed);
    (0..1000).find_map(|_| random_arena::sweep(map, &mut draw, seed)).unwrap()
}

/// All of an answer as words: floats as they are printed have one value.
fn words(answer: &Localization) -> String {
    format!("{answer:?}")
}

/// The answer by slices of so many units, with an estimate now and then, and the number of slices.
fn sliced(sweep: &Sweep, map: &Map, method: &Method, units: usize) -> (Localization, usize) {
    let robot = Robot::default();
    let mut localizer = Localizer::new(map, &robot, &sweep.log.channels, method).unwrap();
    let mut slices = 0;
    for row in &sweep.log.rows {
        localizer.begin(row).unwrap();
        while !localizer.advance(&mut WorkBudget::new(units)) {
            slices += 1;
            if slices % 17 == 0 {
                let (estimate, states) = (localizer.estimate(), localizer.states_now());
                assert!(states.iter().all(|state| state.x.is_finite() && state.theta.is_finite()));
                assert!(estimate.hypotheses.iter().all(|place| place.pose.x.is_finite()));
            }
        }
    }
    localizer.end();
    localizer.end();
    while !localizer.advance(&mut WorkBudget::new(units)) {
        slices += 1;
    }
    assert!(localizer.step(&sweep.log.rows[0]).unwrap_err().to_string().contains("after the end"));
    (localizer.finish(), slices)
}

fn slices_change_nothing(method: &Method, seeds: &[u64]) {
    let map = room();
    for &seed in seeds {
        let sweep = sweep(&map, seed);
        let robot = Robot::default();
        let mut whole = Localizer::new(&map, &robot, &sweep.log.channels, method).unwrap();
        sweep.log.rows.iter().for_each(|row| whole.step(row).unwrap());
        let whole = words(&whole.finish());
        for units in [1, 900] {
            let (answer, slices) = sliced(&sweep, &map, method, units);
            assert!(slices > 10, "{} has {slices} slices of {units} units", method.name());
            assert!(words(&answer) == whole, "{} in slices of {units} units answers otherwise", method.name());
        }
    }
}

#[test]
fn slices_change_no_answer_of_the_deterministic_method() {
    slices_change_nothing(&Method::named("deterministic").unwrap(), &[3, 8]);
}

#[test]
fn slices_change_no_answer_of_the_possibilistic_method() {
    slices_change_nothing(&Method::named("possibilistic").unwrap(), &[3, 8]);
}

#[test]
fn slices_change_no_answer_of_the_probabilistic_method() {
    slices_change_nothing(&Method::named("probabilistic").unwrap(), &[8]);
}

#[test]
fn slices_change_no_answer_where_a_reading_is_tolerated() {
    let options = PossibilisticOptions { tolerate: 1, ..PossibilisticOptions::default() };
    slices_change_nothing(&Method::Possibilistic(options), &[3, 8]);
}

#[test]
fn what_is_told_between_slices_holds_the_truth() {
    let map = room();
    let sweep = sweep(&map, 5);
    let robot = Robot::default();
    let method = Method::named("possibilistic").unwrap();
    let mut localizer = Localizer::new(&map, &robot, &sweep.log.channels, &method).unwrap();
    let mut told = 0;
    for (row, truth) in sweep.log.rows.iter().zip(&sweep.truth) {
        localizer.begin(row).unwrap();
        let mut is_done = false;
        while !is_done {
            is_done = localizer.advance(&mut WorkBudget::new(400));
            let places = localizer.estimate().hypotheses;
            let at = truth.map_from_robot;
            let holds = |place: &vibrissa::flow::pose::Hypothesis| {
                let off = place.extent.theta;
                let turned = [-1.0, 0.0, 1.0].map(|k| at.theta + k * core::f64::consts::TAU);
                place.extent.x.contains(at.x)
                    && place.extent.y.contains(at.y)
                    && turned.iter().any(|&theta| off.contains(theta))
            };
            told += usize::from(!places.is_empty());
            assert!(places.is_empty() || places.iter().any(holds), "the truth is lost at {} s", row.t);
        }
    }
    assert!(told > sweep.log.rows.len() / 4);
}
