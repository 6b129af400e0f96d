//! A whisker that only grazes a wall explains noise no better than one that is free: short sweeps in rooms whose walls explain them alike
//! are ambiguous by the probabilistic method, whatever is sensed and however the errors hang together.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::Status;
use vibrissa::sim::Scenario;
use vibrissa::{Method, localize};

/// Pressed against a wall that is not the only one of its kind; along another one the tip would graze before it bends.
const STEPS: &str = r#"
[map]
arena = [[0, -0.02], [0.2, -0.02], [0.25, 0], [0.4, 0], [0.4, 0.13], [0.25, 0.13], [0.2, 0.15], [0, 0.15]]
[[whisker]]
mount = [0, "10 mm", "115 deg"]
[path]
start = ["140 mm", "65 mm"]
[[path.leg]]
kind = "line"
to = ["300 mm", "65 mm"]
speed = "250 mm/s"
"#;

/// Past the side of a wall that juts out, with an obstacle in the room.
const NICHE: &str = r#"
[map]
arena = [[0, 0], [0.4, 0], [0.4, 0.3], [0.22, 0.3], [0.18, 0.24], [0, 0.24]]
obstacle = [[[0.1, 0.08], [0.16, 0.06], [0.15, 0.12]]]
[[whisker]]
mount = [0, "8 mm", "110 deg"]
[path]
start = ["60 mm", "145 mm", 0]
[[path.leg]]
kind = "line"
to = ["150 mm", "175 mm"]
heading = "keep"
"#;

/// A place this near to the truth is the right one (m).
const RIGHT: f64 = 0.01;
/// Along an open wall a place is told by its middle, this far off at most (m).
const ALONG: f64 = 0.03;

/// Fails where another place than the truth is told as the only one, or none near it.
fn is_not_misled(room: &str, law: &str, columns: &str, seed: u64) {
    let text = format!("seed = {seed}\n{room}\n[noise]\nlaw = \"{law}\"\n[sensing]\ncolumns = {columns}\n");
    let scenario = Scenario::from_toml(&text, "grazing.toml", ".").unwrap();
    let made = scenario.simulate().unwrap();
    let truth = made.sweep.truth.last().unwrap().map_from_robot.position();
    let method = Method::Probabilistic(ProbabilisticOptions::default());
    let answer = localize(&made.recording.log, &scenario.map, &scenario.robot, &method, &mut |_| {}).unwrap();
    let off: Vec<f64> = answer.hypotheses.iter().map(|h| h.pose.position().distance(truth)).collect();
    let what = format!("{law}, {columns}, seed {seed}: {}, {off:.3?} m off", answer.status);
    println!("{what}");
    assert!(answer.status != Status::Localized || off[0] < RIGHT, "{what}");
    assert!(off.iter().any(|&far| far < ALONG), "{what}");
}

#[test]
fn moments_of_a_short_sweep_mislead_nobody() {
    for (law, seeds) in [("uniform", [3, 9, 11]), ("two_point", [2, 3, 7]), ("hysteresis", [1, 2, 3])] {
        seeds.into_iter().for_each(|seed| is_not_misled(STEPS, law, "[\"moment\"]", seed));
    }
    for (law, seed) in [("uniform", 1), ("two_point", 2), ("ar1", 3)] {
        is_not_misled(NICHE, law, "[\"moment\"]", seed);
    }
}

#[test]
fn force_and_slope_of_a_short_sweep_mislead_nobody() {
    for (room, seeds) in [(STEPS, [1, 5, 7]), (NICHE, [1, 2, 3])] {
        seeds.into_iter().for_each(|seed| is_not_misled(room, "uniform", "[\"force\", \"slope\"]", seed));
    }
}
