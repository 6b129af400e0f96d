//! Readings and odometry recorded apart: the delay that the simulator put between them is found, within its told error.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on must fail")]

#[path = "data/uneven.rs"]
mod uneven;

use uneven::uneven;
use vibrissa::flow::pose::StampedPose;
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::plane::Pose2;
use vibrissa::sim::Sweep;
use vibrissa::tasks::demo;
use vibrissa::tasks::join::{Delay, join};
use vibrissa::world::Robot;
use vibrissa::{Method, Status, localize};

/// The odometry at 50 Hz.
fn odometry(sweep: &Sweep) -> Vec<StampedPose> {
    let row = |row: &vibrissa::flow::sensor_log::LogRow| StampedPose {
        t: 100.0 + row.t,
        map_from_robot: row.odom_from_robot,
    };
    sweep.log.rows.iter().step_by(6).map(row).collect()
}

#[test]
fn the_delay_of_stamped_readings_is_found_within_its_error() {
    for (seed, delay) in [(1, 0.8), (2, 0.0), (3, 0.137)] {
        let sweep = uneven(seed, 0);
        // The readings begin so much later than the odometry.
        let rows: Vec<_> = sweep.log.rows.iter().filter(|row| row.t >= delay).collect();
        let text: String = rows.iter().map(|row| format!("{},{}\n", row.t + 5000.0, row.readings[0])).collect();
        let readings =
            Recording::from_bytes(format!("t,moment\n{text}").as_bytes(), Format::Csv, "readings.csv").unwrap();
        // Recordings of CSV keep their own origin of time.
        let shift = readings.t[0];
        let readings = Recording { t: readings.t.iter().map(|t| t - shift).collect(), ..readings };
        let joined = join(&readings, &odometry(&sweep), "", Delay::Estimated(2.0)).unwrap();
        let found = joined.estimate.unwrap();
        let error = found.delay - rows[0].t;
        println!("seed {seed}: {:.2} ms off, told {:.2} ms", 1e3 * error, 1e3 * found.delay_std);
        assert!(error.abs() < 8e-3 && error.abs() < 4.0 * found.delay_std, "{found:?} for {}", rows[0].t);
        let answer = localize(&joined.log, &demo::arena().unwrap(), &Robot::default(), &Method::default(), &mut |_| {});
        assert_eq!(answer.unwrap().status, Status::Localized);
    }
}

/// Readings that began before the odometry are beside it for a while, and say nothing there.
#[test]
fn readings_that_begin_before_the_odometry_are_joined() {
    for (seed, before) in [(1, 1.0), (5, 2.5)] {
        let sweep = uneven(seed, 0);
        let moments: String =
            sweep.log.rows.iter().map(|row| format!("{},{}\n", row.t, -1e3 * row.readings[0])).collect();
        let readings =
            Recording::from_bytes(format!("t,moment\n{moments}").as_bytes(), Format::Csv, "readings.csv").unwrap();
        let poses: Vec<StampedPose> = odometry(&sweep).into_iter().filter(|pose| pose.t >= 100.0 + before).collect();
        let truth = 100.0 - poses[0].t;
        let joined = join(&readings, &poses, "", Delay::Estimated(5.0)).unwrap();
        let found = joined.estimate.unwrap();
        println!("{:.2} ms off, told {:.2} ms", 1e3 * (found.delay - truth), 1e3 * found.delay_std);
        assert!((found.delay - truth).abs() < 4.0 * found.delay_std, "{found:?} for {truth}");
        assert!(joined.outside > 200);
        // Where the search ends too early nothing is told.
        assert!(join(&readings, &poses, "", Delay::Estimated(0.5 * before)).is_err());
    }
}

#[test]
fn flux_lines_without_time_find_delay_and_rate() {
    let sweep = uneven(4, 0);
    // The sensor is one percent slower than it should be.
    let (true_rate, delay) = (297.0, 0.6);
    let mut text = String::from("Sensor ready\n");
    let end = sweep.log.rows.last().unwrap().t;
    for i in 0.. {
        let t = delay + f64::from(i) / true_rate;
        if t > end {
            break;
        }
        let row = sweep.log.rows.partition_point(|row| row.t < t).min(sweep.log.rows.len() - 1);
        text.push_str(&format!("{:.2},0.00,12.00\r\n", 1e5 * sweep.log.rows[row].readings[0]));
    }
    let readings = Recording::from_bytes(text.as_bytes(), Format::Serial, "serial.txt").unwrap();
    let joined = join(&readings, &odometry(&sweep), "", Delay::Estimated(2.0)).unwrap();
    let found = joined.estimate.unwrap();
    println!("{found:?}");
    assert!((found.rate - 300.0 / true_rate).abs() < 4.0 * found.rate_std && found.rate_std < 0.01, "{found:?}");
    let middle = &joined.log.rows[joined.log.rows.len() / 2];
    let truth = delay + (joined.log.rows.len() / 2) as f64 / true_rate;
    let error = middle.t - 100.0 - truth;
    println!("{:.2} ms off in the middle, told {:.2} ms", 1e3 * error, 1e3 * found.delay_std);
    assert!(error.abs() < 4.0 * found.delay_std + 2e-3, "the middle row is off by {error} s, {found:?}");
    assert!((joined.log.rows[joined.log.rows.len() - 1].t - 100.0 - end).abs() < 0.05);
}

#[test]
fn uniform_motion_tells_no_delay_and_says_so() {
    let sweep = demo::sweep(1).unwrap();
    let rows = &sweep.log.rows[100..400];
    let text: String = rows.iter().map(|row| format!("{},{}\n", row.t, row.readings[0] * 0.0 + 1e-3 * row.t)).collect();
    let readings = Recording::from_bytes(format!("t,moment\n{text}").as_bytes(), Format::Csv, "readings.csv").unwrap();
    let poses: Vec<StampedPose> = (0..200)
        .map(|i| StampedPose { t: 0.02 * f64::from(i), map_from_robot: Pose2::new(0.002 * f64::from(i), 0.0, 0.0) })
        .collect();
    let error = join(&readings, &poses, "", Delay::Estimated(1.0)).unwrap_err().to_string();
    assert!(error.contains("does not tell the delay") && error.contains("--delay"), "{error}");
    let known = join(&readings, &poses, "left", Delay::Known(0.25)).unwrap();
    assert_eq!(known.log.channels[0].column(), "left.moment");
    assert!((known.log.rows[0].t - 0.25 - readings.t[0]).abs() < 1e-12);
}
