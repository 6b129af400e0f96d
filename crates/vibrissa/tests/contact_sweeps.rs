//! Sliding tips against sweeps of an independent discrete rod with 5 % noise: the tip is known there, step by step.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

use std::path::Path;
use vibrissa::config::ContactOptions;
use vibrissa::io::read_tum;
use vibrissa::plane::Vec2;
use vibrissa::tasks::contact::{ContactKind, contacts};
use vibrissa::world::{MomentNoise, MountedWhisker, Robot};

/// Every sweep, and how many whiskers' lift-offs it has.
const SWEEPS: [(&str, usize); 12] = [
    ("bays-00", 1),
    ("bays-01", 0),
    ("bays-02", 0),
    ("obstacle-00", 0),
    ("obstacle-01", 0),
    ("obstacle-02", 0),
    ("rough0-01", 0),
    ("rough0-02", 0),
    ("rough0-03", 0),
    ("square-00", 1),
    ("square-01", 2),
    ("square-02", 0),
];

#[test]
fn tips_are_traced_and_told() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/sweeps"));
    if !folder.is_dir() {
        println!("skipped: no shared folder with sweeps");
        return;
    }
    let noise = MomentNoise { moment_relative: 0.05, moment_absolute: 1e-6 };
    let robot = Robot { whiskers: vec![MountedWhisker { noise, ..MountedWhisker::default() }], ..Robot::default() };
    let (mut within, mut all) = (0_u32, 0_u32);
    for (name, lift_offs) in SWEEPS {
        let mut log = vibrissa::read_log(folder.join(format!("{name}.csv"))).unwrap();
        let truth = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
        for (row, pose) in log.rows.iter_mut().zip(&truth) {
            row.odom_from_robot = pose.map_from_robot;
        }
        let text = std::fs::read_to_string(folder.join(format!("{name}.contacts.csv"))).unwrap();
        let rows = text.lines().skip(1);
        let tips: Vec<Vec<f64>> = rows.map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
        let report = contacts(&log, &robot, &ContactOptions::default()).unwrap();
        let mut errors = Vec::new();
        for step in report.steps.iter().filter(|s| s.kind == ContactKind::Tip) {
            let Some(tip) = tips.iter().find(|tip| (tip[0] - step.t).abs() < 1e-4) else { continue };
            let off = step.position().unwrap() - Vec2::new(tip[1], tip[2]);
            let across = off.dot(Vec2::from_angle(step.normal.unwrap())).abs();
            within += u32::from(across <= 2.0 * step.std.unwrap() + 2e-5);
            all += 1;
            errors.push(off.norm());
        }
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let found = errors.len() as f64 / report.steps.len() as f64;
        println!("{name}: {:.3} mm in the mean over {} of {} steps", 1e3 * mean, errors.len(), report.steps.len());
        assert!(mean < 0.3e-3, "{name}: {mean}");
        assert!(found > 0.95, "{name}: {found}");
        let count = |kind: &str| report.events.iter().filter(|event| event.kind == kind).count();
        assert_eq!(count("lift_off"), lift_offs, "{name}: {:?}", report.events);
        assert!(count("tip_contact") > 0 && count("contact") == count("tip_contact"), "{name}: {:?}", report.events);
    }
    let share = f64::from(within) / f64::from(all);
    println!("{share:.3} of {all} tips are within two standard deviations across the wall");
    assert!(share > 0.93);
}
