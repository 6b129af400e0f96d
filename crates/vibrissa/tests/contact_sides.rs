//! Sides that slide: a whisker that rolls on an obstacle before its tip comes round, against the simulator's contacts.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::path::Path;
use vibrissa::config::ContactOptions;
use vibrissa::sim::Part;
use vibrissa::sim::Scenario;
use vibrissa::tasks::contact::{ContactKind, contacts};

#[test]
fn a_side_that_rolls_on_a_column_is_not_taken_for_the_tip() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/side_contact.toml");
    let scenario = Scenario::read(file).unwrap();
    let simulation = scenario.simulate().unwrap();
    let mut log = simulation.recording.log;
    for (row, index) in log.rows.iter_mut().zip(&simulation.recording.rows) {
        row.odom_from_robot = scenario.path[*index].map_from_robot;
    }
    let report = contacts(&log, &scenario.robot, &ContactOptions::default()).unwrap();
    let (mut worst, mut sum, mut count, mut told) = (0.0_f64, 0.0, 0.0, 0.0);
    for step in &report.steps {
        let Some(position) = step.position() else { continue };
        let touches = simulation.sweep.contacts.iter();
        let Some(touch) = touches.min_by(|a, b| (a.t - step.t).abs().total_cmp(&(b.t - step.t).abs())) else {
            continue;
        };
        let error = position.distance(touch.position);
        worst = worst.max(error);
        sum += error;
        count += 1.0;
        told += f64::from(touch.part == Part::Side && step.kind == ContactKind::Side);
    }
    println!(
        "{:.3} mm in the mean, {:.2} mm at worst, {told} of {count} steps told as sides",
        1e3 * sum / count,
        1e3 * worst
    );
    assert!(worst < 2e-3 && sum / count < 0.6e-3, "mean {}, worst {worst}", sum / count);
    assert!(told > 20.0, "{told} sides are told as such");
}
