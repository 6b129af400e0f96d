//! A log that begins while the whisker is pressed: nothing says where the contact began.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/nearest.rs"]
mod nearest;

use nearest::{RIGHT, nearest};
use vibrissa::sim::Scenario;

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
/// How near the nearest place is to the truth (m), of a log that begins so many rows after the whisker is pressed.
fn error(law: &str, seed: u64, after: usize) -> f64 {
    let text = SWEEP.replace("LAW", law).replace("SEED", &seed.to_string());
    let scenario = Scenario::from_toml(&text, "pressed.toml", ".").unwrap();
    let made = scenario.simulate().unwrap();
    let truth = made.sweep.truth.last().unwrap().map_from_robot.position();
    let mut log = made.recording.log;
    let first = log.rows.iter().position(|row| row.readings[0].abs() > PRESSED).unwrap();
    log.rows.drain(..first + after);
    nearest(&scenario, &log, truth, &format!("{law}, seed {seed}, {after} rows on"))
}

#[test]
fn a_log_that_begins_in_contact_is_localized() {
    for (law, seed) in [("uniform", 1), ("ar1", 2), ("hysteresis", 3)] {
        for after in [0, 5, 40] {
            let found = error(law, seed, after);
            assert!(found < RIGHT, "{law}, seed {seed}, {after} rows on: {found} m");
        }
    }
}
