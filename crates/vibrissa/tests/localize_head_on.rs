//! A whisker that meets a wall head-on buckles to one side or the other: such a contact is found like any other.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/nearest.rs"]
mod nearest;

use nearest::{RIGHT, nearest};
use vibrissa::sim::Scenario;

/// Towards the upper wall, and along it over two edges. The whisker stands by `MOUNT` and `HEADING` to the wall's normal.
const SWEEP: &str = r#"
seed = SEED
[map]
arena = [
    [0, 0], [0.11, 0], [0.11, -0.02], [0.3, -0.02], [0.34, -0.015], [0.53, -0.015], [0.53, 0.175], [0.39, 0.175], [0.26, 0.175],
    [0.22, 0.158], [0.08, 0.158], [0.08, 0.15], [0, 0.15],
]
[[whisker]]
mount = [0, "10 mm", "MOUNT deg"]
[path]
start = ["68 mm", "56 mm", "HEADING deg"]
[[path.leg]]
kind = "line"
to = ["252 mm", "88 mm"]
heading = "keep"
speed = "250 mm/s"
[noise]
law = "LAW"
[sensing]
columns = ["moment"]
"#;

/// How near the nearest place is to the truth (m).
fn error(mount: f64, heading: f64, law: &str, seed: u64) -> f64 {
    let told = [("SEED", seed.to_string()), ("MOUNT", mount.to_string()), ("HEADING", heading.to_string())];
    let text = told.iter().fold(SWEEP.replace("LAW", law), |text, (name, value)| text.replace(name, value));
    let scenario = Scenario::from_toml(&text, "head_on.toml", ".").unwrap();
    let made = scenario.simulate().unwrap();
    let truth = made.sweep.truth.last().unwrap().map_from_robot.position();
    nearest(&scenario, &made.recording.log, truth, &format!("{mount} + {heading} deg, {law}, seed {seed}"))
}

#[test]
fn a_whisker_that_meets_a_wall_head_on_is_localized() {
    let mut missed = Vec::new();
    for (k, off) in [-3.0, -1.2, -0.5, 0.5, 1.2, 3.0].into_iter().enumerate() {
        for law in ["uniform", "two_point"] {
            let found = error(80.0, 10.0 + off, law, 40 + k as u64);
            if found >= RIGHT {
                missed.push(format!("{off} deg from head-on, {law}: {found} m"));
            }
        }
    }
    // Along a wall only some modes are looked around from, and the place of one sweep in twelve may be told further along it.
    assert!(missed.len() <= 1, "{missed:?}");
}
