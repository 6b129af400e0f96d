//! Rounding does not choose the probabilistic method's answer: readings that differ by their last digit leave the same places. All places along a
//! straight wall explain a contact alike, so that many costs are equal but for rounding.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/random.rs"]
mod random;
#[path = "data/random_arena.rs"]
mod random_arena;
#[path = "data/shared.rs"]
mod shared;

use random::Random;
use shared::shared;
use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::{Hypothesis, Localization};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::{Curve, Vec2};
use vibrissa::tasks::demo;
use vibrissa::world::{Boundary, Map, Robot, Role};
use vibrissa::{Method, localize};

/// The largest difference of two answers (m, rad).
const SAME: f64 = 1e-9;

/// The same readings but for their last digit.
fn rounded_otherwise(log: &SensorLog, seed: u64) -> SensorLog {
    let mut draw = Random(seed);
    let mut other = log.clone();
    for reading in other.rows.iter_mut().flat_map(|row| row.readings.iter_mut()) {
        *reading = if draw.unit() < 0.5 { reading.next_up() } else { reading.next_down() };
    }
    other
}

fn numbers(place: &Hypothesis) -> Vec<f64> {
    let of = &place.extent;
    let bounds = [of.x, of.y, of.theta].into_iter().flat_map(|range| [range.lo(), range.hi()]);
    [place.pose.x, place.pose.y, place.pose.theta].into_iter().chain(bounds).collect()
}

/// How far the places of two answers differ, each from the nearest of the other's: equal places may come in another order.
fn differ(one: &Localization, other: &Localization) -> f64 {
    assert_eq!((one.status, one.hypotheses.len()), (other.status, other.hypotheses.len()));
    let apart = |a: &Hypothesis, b: &Hypothesis| {
        let pairs = numbers(a).into_iter().zip(numbers(b));
        pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    let nearest = |a: &Hypothesis| other.hypotheses.iter().map(|b| apart(a, b)).fold(f64::INFINITY, f64::min);
    one.hypotheses.iter().map(nearest).fold(0.0, f64::max)
}

fn assert_same(name: &str, log: &SensorLog, map: &Map) {
    let options = Method::Probabilistic(ProbabilisticOptions::default());
    let answer = |log: &SensorLog| localize(log, map, &Robot::default(), &options, &mut |_| {}).unwrap();
    let first = answer(log);
    for seed in 0..2 {
        let off = differ(&first, &answer(&rounded_otherwise(log, seed)));
        println!("{name}: {}, {} places, {off:.1e}", first.status, first.hypotheses.len());
        assert!(off < SAME, "{name}: {off}");
    }
}

#[test]
fn the_last_digit_of_the_readings_changes_no_place() {
    let half = 0.15;
    let corner = |(x, y): (f64, f64)| Vec2::new(x * half, y * half);
    let points = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner);
    let wall = Boundary::new(Role::Arena, Curve::polyline(&points, true).unwrap(), None).unwrap();
    let room = Map::new(vec![wall]).unwrap();
    for (name, map) in [("square", room), ("arena", demo::arena().unwrap())] {
        for seed in 0..3 {
            let mut draw = Random(seed);
            let sweep = (0..1000).find_map(|_| random_arena::sweep(&map, &mut draw, seed)).unwrap();
            assert_same(name, &sweep.log, &map);
        }
    }
}

#[test]
fn the_last_digit_of_the_shared_sweeps_changes_no_place() {
    let Some(folder) = shared("sweeps") else { return };
    for (name, map) in [("square-00", "square"), ("square-02", "square"), ("obstacle-01", "obstacle")] {
        let log = vibrissa::read_log(folder.join(format!("{name}.csv"))).unwrap();
        assert_same(name, &log, &vibrissa::read_map(folder.join(format!("{map}.geojson"))).unwrap());
    }
}
