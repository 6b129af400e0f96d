//! Sliding tips against sweeps of an independent discrete rod with 5 % noise, and against our own simulator's: the tip is known there, step by
//! step.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/shared.rs"]
mod shared;

use shared::shared;
use vibrissa::config::ContactOptions;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::io::read_tum;
use vibrissa::plane::Vec2;
use vibrissa::sim::Part;
use vibrissa::tasks::contact::{ContactKind, contacts};
use vibrissa::tasks::demo;
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
    let Some(folder) = shared("sweeps") else { return };
    let noise = MomentNoise { moment_relative: 0.05, moment_absolute: 1e-6 };
    let robot = Robot { whiskers: vec![MountedWhisker { noise, ..MountedWhisker::default() }], ..Robot::default() };
    let mut counts = (0, 0);
    for (name, lift_offs) in SWEEPS {
        let mut log = vibrissa::read_log(folder.join(format!("{name}.csv"))).unwrap();
        let truth = read_tum(folder.join(format!("{name}.truth.tum"))).unwrap();
        for (row, pose) in log.rows.iter_mut().zip(&truth) {
            row.odom_from_robot = pose.map_from_robot;
        }
        let text = std::fs::read_to_string(folder.join(format!("{name}.contacts.csv"))).unwrap();
        let rows = text.lines().skip(1);
        let tips: Vec<Vec<f64>> = rows.map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
        let tips: Vec<(f64, Vec2)> = tips.iter().map(|tip| (tip[0], Vec2::new(tip[1], tip[2]))).collect();
        traced(name, &log, &robot, &tips, lift_offs, &mut counts);
    }
    mostly_within(counts);
}

/// The same where no folder with other sweeps is: the demo's sweep, with other noise each time.
#[test]
fn tips_of_the_simulator_are_traced_and_told() {
    let (robot, mut counts) = (Robot::default(), (0, 0));
    for seed in 1..=6 {
        let sweep = demo::sweep(seed).unwrap();
        let mut log = sweep.log;
        for (row, pose) in log.rows.iter_mut().zip(&sweep.truth) {
            row.odom_from_robot = pose.map_from_robot;
        }
        let tips: Vec<(f64, Vec2)> = sweep
            .contacts
            .iter()
            .filter(|touch| touch.part == Part::Tip)
            .map(|touch| (touch.t, touch.position))
            .collect();
        assert!(tips.len() > 100, "{}", tips.len());
        traced(&format!("demo {seed}"), &log, &robot, &tips, 0, &mut counts);
    }
    mostly_within(counts);
}

/// Checks where and when contacts are told; adds how many are within two standard deviations, of how many.
fn traced(
    name: &str,
    log: &SensorLog,
    robot: &Robot,
    tips: &[(f64, Vec2)],
    lift_offs: usize,
    (within, all): &mut (u32, u32),
) {
    let report = contacts(log, robot, &ContactOptions::default()).unwrap();
    let mut errors = Vec::new();
    for step in report.steps.iter().filter(|s| s.kind == ContactKind::Tip) {
        let Some((_, tip)) = tips.iter().find(|(t, _)| (t - step.t).abs() < 1e-4) else { continue };
        let off = step.position().unwrap() - *tip;
        let across = off.dot(Vec2::from_angle(step.normal.unwrap())).abs();
        *within += u32::from(across <= 2.0 * step.std.unwrap() + 2e-5);
        *all += 1;
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

fn mostly_within((within, all): (u32, u32)) {
    let share = f64::from(within) / f64::from(all);
    println!("{share:.3} of {all} tips are within two standard deviations across the wall");
    assert!(share > 0.93);
}
