//! A log that begins while the whisker is pressed: nothing says where the contact began.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::Status;
use vibrissa::sim::Scenario;
use vibrissa::{Method, localize};

/// Along a wall, over two edges and into a corner.
const SWEEP: &str = r#"
seed = SEED
[map]
arena = [[0, 0], [0.42, 0], [0.42, 0.28], [0.3, 0.31], [0.24, 0.27], [0.12, 0.27], [0, 0.22]]
[[whisker]]
mount = [0, "12 mm", "115 deg"]
[path]
start = ["130 mm", "170 mm", 0]
[[path.leg]]
kind = "line"
to = ["150 mm", "192 mm"]
heading = "keep"
[[path.leg]]
kind = "line"
to = ["330 mm", "215 mm"]
heading = "keep"
[noise]
law = "LAW"
[sensing]
columns = ["moment"]
"#;

/// A moment beyond what a free whisker reads with any zero that is not declared (N m).
const PRESSED: f64 = 5e-4;
/// A place this near to the truth is the right one (m).
const RIGHT: f64 = 0.01;

/// How near the nearest place is to the truth (m), of a log that begins so many rows after the whisker is pressed.
fn nearest(law: &str, seed: u64, after: usize) -> f64 {
    let text = SWEEP.replace("LAW", law).replace("SEED", &seed.to_string());
    let scenario = Scenario::from_toml(&text, "pressed.toml", ".").unwrap();
    let made = scenario.simulate().unwrap();
    let truth = made.sweep.truth.last().unwrap().map_from_robot.position();
    let mut log = made.recording.log;
    let first = log.rows.iter().position(|row| row.readings[0].abs() > PRESSED).unwrap();
    log.rows.drain(..first + after);
    let method = Method::Probabilistic(ProbabilisticOptions::default());
    let answer = localize(&log, &scenario.map, &scenario.robot, &method, &mut |_| {}).unwrap();
    let off = |pose: &vibrissa::plane::Pose2| pose.position().distance(truth);
    let each = answer.hypotheses.iter().map(|h| h.ridge.iter().map(off).fold(off(&h.pose), f64::min));
    let nearest = each.fold(f64::INFINITY, f64::min);
    println!("{law}, seed {seed}, {after} rows on: {}, {:.2} mm off", answer.status, 1e3 * nearest);
    assert!(answer.status != Status::Localized || off(&answer.hypotheses[0].pose) < RIGHT);
    nearest
}

#[test]
fn a_log_that_begins_in_contact_is_localized() {
    for (law, seed) in [("uniform", 1), ("ar1", 2), ("hysteresis", 3)] {
        for after in [0, 5, 40] {
            let found = nearest(law, seed, after);
            assert!(found < RIGHT, "{law}, seed {seed}, {after} rows on: {found} m");
        }
    }
}
