//! How near the truth an answer comes that may tell several places, some of them open along a curve.

use vibrissa::config::ProbabilisticOptions;
use vibrissa::flow::pose::Status;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::sim::Scenario;
use vibrissa::{Method, localize};

/// A place this near to the truth is the right one (m).
pub(super) const RIGHT: f64 = 0.01;

/// How near the nearest place that the probabilistic method tells is to the truth (m). Fails where it settles on a wrong one.
pub(super) fn nearest(scenario: &Scenario, log: &SensorLog, truth: Vec2, what: &str) -> f64 {
    let method = Method::Probabilistic(ProbabilisticOptions::default());
    let answer = localize(log, &scenario.map, &scenario.robot, &method, &mut |_| {}).unwrap();
    let off = |pose: &Pose2| pose.position().distance(truth);
    let each = answer.hypotheses.iter().map(|h| h.ridge.iter().map(off).fold(off(&h.pose), f64::min));
    let nearest = each.fold(f64::INFINITY, f64::min);
    println!("{what}: {}, {:.2} mm off", answer.status, 1e3 * nearest);
    assert!(answer.status != Status::Localized || off(&answer.hypotheses[0].pose) < RIGHT, "{what}");
    nearest
}
