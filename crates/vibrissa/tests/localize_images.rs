//! A room that is its own image turned by half a turn: the probabilistic method keeps both images along a straight wall.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::Status;
use vibrissa::plane::wrap_angle;
use vibrissa::sim::Scenario;
use vibrissa::{Method, localize};

/// Pressed into the upper wall first, so that shapes are far from where the first rows put them when the whisker begins to trail.
const SWEEP: &str = r#"
seed = 1
[map]
arena = [[0, 0], [0.6, 0], [0.6, 0.4], [0, 0.4]]
[[whisker]]
mount = [0, 0.02, "128 deg"]
[path]
waypoints = [[0.1, 0.25, 0], [0.15, 0.328, 0], [0.50, 0.328, 0]]
"#;

/// Weights of the true place and of its image by half a turn.
fn weights(seed: u64, window: usize) -> [Option<f64>; 2] {
    let text = SWEEP.replace("seed = 1", &format!("seed = {seed}"));
    let scenario = Scenario::from_toml(&text, "images.toml", ".").unwrap();
    let made = scenario.simulate().unwrap();
    let truth = made.sweep.truth.last().unwrap().map_from_robot;
    let probabilistic = ProbabilisticOptions { window, ..ProbabilisticOptions::default() };
    let options = Method::Probabilistic(probabilistic);
    let answer = localize(&made.recording.log, &scenario.map, &scenario.robot, &options, &mut |_| {}).unwrap();
    assert_eq!(answer.status, Status::Ambiguous);
    let images = [(truth.x, truth.y, truth.theta), (0.6 - truth.x, 0.4 - truth.y, truth.theta + core::f64::consts::PI)];
    images.map(|(x, y, theta)| {
        let held = answer.hypotheses.iter().find(|h| {
            let turned = wrap_angle(h.pose.theta - theta).abs();
            h.extent.x.contains(x) && (h.pose.y - y).abs() < 1e-3 && turned < 0.01
        });
        println!("seed {seed}, window {window}: image at {x:.3}, {y:.3}: weight {:?}", held.map(|h| h.weight));
        held.map(|h| h.weight)
    })
}

#[test]
fn both_images_of_a_rectangle_are_kept() {
    for seed in [1, 2, 5] {
        let found = weights(seed, 1000);
        assert!(found.iter().all(|w| w.is_some_and(|w| w > 0.35)), "seed {seed}: {found:?}");
    }
}

#[test]
fn both_images_are_kept_when_rows_are_summed_up() {
    let found = weights(3, 400);
    assert!(found.iter().all(|w| w.is_some_and(|w| w > 0.2)), "{found:?}");
}
