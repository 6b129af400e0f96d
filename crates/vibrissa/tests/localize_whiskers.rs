//! Several whiskers on one robot: each touch is one more constraint, wherever the other whiskers touch.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use std::path::Path;
use vibrissa::flow::pose::Status;
use vibrissa::sim::Scenario;
use vibrissa::{Method, localize};

#[test]
fn whiskers_on_opposite_walls_agree_on_a_place() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/pipe.toml");
    let scenario = Scenario::read(file).unwrap();
    let sweep = scenario.simulate().unwrap().sweep;
    // The first stretch along both walls; the rest only takes longer.
    let mut log = sweep.log;
    log.rows.truncate(260);
    let answer =
        localize(&log, &scenario.map, &scenario.robot, &Method::Deterministic(Default::default()), &mut |_| {})
            .unwrap();
    assert_ne!(answer.status, Status::Inconsistent, "{:?}", answer.events);
    let truth = sweep.truth[259].map_from_robot;
    let near = |x: f64, y: f64| (x - truth.x).hypot(y - truth.y) < 2e-3;
    assert!(answer.hypotheses.iter().any(|h| near(h.pose.x, h.pose.y)), "{truth:?}: {:?}", answer.hypotheses);
}
