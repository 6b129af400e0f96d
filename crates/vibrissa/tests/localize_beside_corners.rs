//! A whisker that slides off a corner: in a cell of the search it does so earlier or later than in truth, and beside the true place along a
//! wall, too. Some readings are far off there, and no derivative tells why.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "data/nearest.rs"]
mod nearest;

use nearest::{RIGHT, nearest};
use vibrissa::sim::Scenario;

const ROOM: &str = r#"
seed = 2
[map]
arena = [[0, 0], [1.045, 0], [1.045, 0.511], [0.56, 0.511], [0.56, 1.048], [0, 1.048]]
obstacle = [[0.191, 0.143], [0.261, 0.283], [0.311, 0.183]]
[noise]
law = "LAW"
[sensing]
columns = ["moment"]
[path]
"#;

/// Four presses against one corner of the triangle (mm, mm, degrees).
const WAY: [[f64; 3]; 13] = [
    [383.0, 229.0, -117.69],
    [365.0, 219.5, -117.69],
    [351.0, 216.5, -117.69],
    [335.7, 249.0, -117.69],
    [345.4, 258.3, -117.69],
    [350.0, 260.7, -124.9],
    [334.5, 257.5, -124.9],
    [320.0, 268.0, -124.9],
    [339.2, 282.0, -124.9],
    [329.2, 277.0, -110.15],
    [315.0, 274.4, -110.15],
    [303.4, 303.5, -110.15],
    [311.7, 312.0, -110.15],
];

/// Readings of that, so many millimetres to the side.
fn presses(law: &str, aside: f64) -> String {
    let pose = |[x, y, heading]: [f64; 3]| (x + aside, y, heading);
    let (x, y, heading) = pose(WAY[0]);
    let mut text = ROOM.replace("LAW", law) + &format!("start = [\"{x} mm\", \"{y} mm\", \"{heading} deg\"]\n");
    for next in &WAY[1..] {
        let (x, y, heading) = pose(*next);
        text += &format!("[[path.leg]]\nkind = \"line\"\nto = [\"{x} mm\", \"{y} mm\"]\nheading = \"{heading} deg\"\n");
    }
    text
}

#[test]
fn readings_beside_a_corner_do_not_lose_the_true_place() {
    for law in ["none", "uniform"] {
        for aside in [-2.0, -1.0, 0.0, 2.0] {
            let scenario = Scenario::from_toml(&presses(law, aside), "presses.toml", ".").unwrap();
            let made = scenario.simulate().unwrap();
            let truth = made.sweep.truth.last().unwrap().map_from_robot.position();
            let what = format!("{law}, {aside} mm aside");
            let found = nearest(&scenario, &made.recording.log, truth, &what);
            assert!(found < RIGHT, "{what}: {found} m");
        }
    }
}

/// A whisker that leans is dragged along a block and off its corner.
const DRAG: &str = r#"
seed = SEED
[map]
arena = [[0, 0], [0.9, 0], [0.9, 0.5], [0.55, 0.5], [0.55, 0.85], [0, 0.85]]
obstacle = [[0.25, 0.3], [0.4, 0.3], [0.4, 0.4], [0.25, 0.4]]
[noise]
law = "LAW"
[sensing]
columns = ["moment"]
[path]
start = ["330 mm", "222 mm", "115 deg"]
[[path.leg]]
kind = "line"
to = ["340 mm", "240 mm"]
heading = "keep"
[[path.leg]]
kind = "line"
to = ["460 mm", "240 mm"]
heading = "keep"
"#;

#[test]
fn the_place_along_a_wall_is_where_the_whisker_slides_off_its_end() {
    for (law, seed) in [("none", 1), ("uniform", 2), ("ar1", 3)] {
        let text = DRAG.replace("LAW", law).replace("SEED", &seed.to_string());
        let scenario = Scenario::from_toml(&text, "drag.toml", ".").unwrap();
        let made = scenario.simulate().unwrap();
        let truth = made.sweep.truth.last().unwrap().map_from_robot.position();
        let found = nearest(&scenario, &made.recording.log, truth, law);
        assert!(found < RIGHT, "{law}: {found} m");
    }
}
