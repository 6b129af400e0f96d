//! A whisker that is pressed against a corner, slides off it and is let go: in one cell of the search it does so earlier or later than in
//! truth, and some of its readings are far off.

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
