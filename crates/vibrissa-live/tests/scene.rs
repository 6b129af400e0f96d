//! What viewers draw of a run: whiskers against a wall, readings in order, counts.

#![allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test that cannot go on must fail")]

use serde_json::Value;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity};
use vibrissa::plane::Pose2;
use vibrissa::tasks::demo;
use vibrissa::world::{MountedWhisker, Robot};
use vibrissa_live::estimate::LiveEstimator;
use vibrissa_live::join::JoinedRow;
use vibrissa_live::run::Health;
use vibrissa_live::scene::{Scene, health};

fn joined(row: &LogRow) -> JoinedRow {
    JoinedRow { row: row.clone(), arrival: 0.0, travel: [0.0; 2] }
}

#[test]
fn whiskers_are_told_as_the_map_bends_them_and_every_reading_once() {
    let (map, sweep) = (demo::arena().unwrap(), demo::sweep(1).unwrap());
    // The same whisker on a base of its own: the robot's origin lies elsewhere.
    let mount = Pose2::new(0.02, -0.01, 0.4);
    let whisker = MountedWhisker { robot_from_whisker: mount, ..MountedWhisker::default() };
    let robot = Robot { whiskers: vec![whisker], ..Robot::default() };
    let moment = Channel { whisker: String::new(), quantity: Quantity::Moment };
    let flux = Channel { whisker: String::new(), quantity: Quantity::FluxX };
    let channels = [flux, moment.clone()];
    let rows: Vec<LogRow> = sweep
        .log
        .rows
        .iter()
        .map(|row| LogRow {
            odom_from_robot: row.odom_from_robot.compose(mount.inverse()),
            readings: vec![1e-6, row.readings[0]],
            ..row.clone()
        })
        .collect();
    let mut estimator =
        LiveEstimator::new(&map, &robot, &channels, &vibrissa::localizer::Method::default(), 20.0).unwrap();
    let mut scene = Scene::new(&map, &robot, &channels);
    let (mut seen, mut worst, mut last) = (0, 0.0_f64, Value::Null);
    for row in &rows {
        let Some(told) = estimator.step(&joined(row)).unwrap() else { continue };
        let message = scene.whiskers(&told, row);
        let one = &message["whiskers"][0];
        let shape: Vec<[f64; 2]> = serde_json::from_value(one["shape"].clone()).unwrap();
        assert!((shape[0][0] - mount.x).abs() < 1e-6 && (shape[0][1] - mount.y).abs() < 1e-6);
        assert_eq!((one["readings"].as_array().unwrap().len(), &one["readings"][0]["column"]), (1, &"moment".into()));
        if told.estimate.hypotheses.len() == 1 && one["from"] == "map" {
            seen += 1;
            let read = &one["readings"][0];
            let off = (read["value"].as_f64().unwrap() - read["expected"].as_f64().unwrap()).abs();
            worst = worst.max(off - read["bound"].as_f64().unwrap());
            assert_eq!((shape.len(), one["touching"].as_bool()), (25, Some(true)));
        }
        last = message;
    }
    assert!(seen > 10 && worst < 1e-4, "{seen} bent whiskers, {worst} N m beyond the bound");
    assert_eq!(last["carried"], 0.0);
    let told: Vec<JoinedRow> = rows.iter().take(5).map(joined).collect();
    let readings = scene.readings(told.iter());
    assert_eq!(
        (&readings["columns"], &readings["units"]),
        (&serde_json::json!(["moment"]), &serde_json::json!(["N m"]))
    );
    let times: Vec<f64> = serde_json::from_value(readings["t"].clone()).unwrap();
    let values: Vec<Vec<f64>> = serde_json::from_value(readings["values"].clone()).unwrap();
    assert_eq!(times, rows[..5].iter().map(|row| row.t).collect::<Vec<_>>());
    assert_eq!(values, [rows[..5].iter().map(|row| row.readings[1]).collect::<Vec<_>>()]);
    let counts = health(&Health { sources: vec![("base".to_owned(), Default::default())], ..Health::default() });
    assert_eq!((&counts["missing"], &counts["sources"][0]["name"]), (&0.into(), &"base".into()));
}
