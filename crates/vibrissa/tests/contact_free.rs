//! A free whisker has no contacts, and a whisker that is touched has one.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use vibrissa::config::ContactOptions;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::Pose2;
use vibrissa::tasks::contact::contacts;
use vibrissa::world::Robot;

/// Rows a second.
const RATE: f64 = 300.0;

/// A linear congruential generator: the test needs scatter, not quality.
struct Scatter(u64);

impl Scatter {
    /// Uniform in [0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn log(moments: impl Iterator<Item = f64>) -> SensorLog {
    let row = |(k, moment): (usize, f64)| {
        let t = k as f64 / RATE;
        let odom_from_robot = Pose2::new(0.05 * (0.3 * t).sin(), 0.02 * (0.7 * t).cos(), 0.2 * (0.11 * t).sin());
        LogRow { line: k + 2, t, odom_from_robot, readings: vec![moment], heading: None }
    };
    let channels = vec![Channel { whisker: String::new(), quantity: Quantity::Moment }];
    SensorLog { channels, rows: moments.enumerate().map(row).collect(), ..SensorLog::default() }
}

/// Steps in contact and events of a free whisker in so many hours: readings z of h = 0 with |h - z| <= relative |z| + absolute,
/// one in a hundred at the very bound.
fn phantoms(hours: usize) -> usize {
    let (robot, mut scatter) = (Robot::default(), Scatter(7));
    let noise = robot.whiskers[0].noise;
    let bound = noise.moment_absolute / (1.0 - noise.moment_relative);
    let mut found = 0;
    // Pieces of a minute, so that the log stays small.
    for _ in 0..60 * hours {
        let moments = (0..(60.0 * RATE) as usize).map(|_| {
            let signed = 2.0 * scatter.next() - 1.0;
            if scatter.next() < 0.01 { bound.copysign(signed) } else { bound * signed }
        });
        let report = contacts(&log(moments), &robot, &ContactOptions::default()).unwrap();
        found += report.steps.len() + report.events.len();
    }
    found
}

#[test]
fn a_free_whisker_has_no_contacts_in_two_hours() {
    assert_eq!(phantoms(2), 0);
}

#[test]
#[ignore = "half a minute; run with --ignored"]
fn a_free_whisker_has_no_contacts_in_a_hundred_hours() {
    assert_eq!(phantoms(100), 0);
}

#[test]
fn no_contact_above_twice_the_noise_is_missed() {
    let (robot, mut scatter) = (Robot::default(), Scatter(11));
    let noise = robot.whiskers[0].noise;
    let bound = noise.moment_absolute / (1.0 - noise.moment_relative);
    for _ in 0..200 {
        // Free, touched for one to four rows of one sign, free again.
        let (rows, start) = (1 + (4.0 * scatter.next()) as usize, 20 + (50.0 * scatter.next()) as usize);
        let sign = if scatter.next() < 0.5 { -1.0 } else { 1.0 };
        let moments: Vec<f64> = (0..100)
            .map(|row| match (start..start + rows).contains(&row) {
                true => sign * noise.moment_absolute * (2.0 + 3.0 * scatter.next()),
                false => bound * (2.0 * scatter.next() - 1.0),
            })
            .collect();
        let report = contacts(&log(moments.into_iter()), &robot, &ContactOptions::default()).unwrap();
        let of = |kind: &str| report.events.iter().filter(|event| event.kind == kind).count();
        assert_eq!((of("contact"), of("lift_off")), (1, 1), "{:?}", report.events);
        assert!(report.events.iter().all(|event| event.kind != "contact" || event.detail == "w0 touches"));
        assert!(!report.steps.is_empty());
    }
}

#[test]
fn the_readings_of_another_whisker_are_no_contact_of_this_one() {
    // A base that turns by half a turn under a millionth of what is read.
    let mut robot = Robot::default();
    robot.whiskers[0].beam.base_stiffness = 1e-9;
    robot.whiskers[0].beam.tip_ratio = 0.02;
    let log = vibrissa::tasks::demo::sweep(1).unwrap().log;
    let report = contacts(&log, &robot, &ContactOptions::default()).unwrap();
    assert!(report.steps.len() > 100 && report.stopped_at.is_none());
    assert!(report.steps.iter().all(|step| step.contact.is_none()), "nothing that bends so is found");
    assert!(report.events.iter().any(|event| event.kind == "no_point"), "{:?}", report.events);
}
