//! How well `join` tells the delay between readings and odometry that were recorded apart: uneven drives of 13 s along the demo's
//! wall, with delays of either sign of up to 4.9 s, so that up to a third of the readings lie beside the odometry.
//!
//!     cargo run --release -p vibrissa --example join_delays

#![allow(clippy::unwrap_used, reason = "an example that cannot go on ends")]

#[path = "../tests/data/uneven.rs"]
mod uneven;

use uneven::uneven;
use vibrissa::flow::pose::StampedPose;
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::tasks::join::{Delay, join};

/// Readings a second (Hz).
const RATE: f64 = 300.0;
/// When the readings begin after the odometry (s), negative where before it.
const DELAYS: [f64; 12] = [-3.1, -1.0, -0.2, -0.011, 0.0, 0.003, 0.4, 1.7, 4.9, 2.2, -4.5, 0.09];

/// How far the delay in the middle of the readings is off, and its told standard deviation (s); none where it is refused. The
/// odometry has each `nth` pose; `clock` is how long the sensor's second is, none where its lines have stamps.
fn found(seed: usize, nth: usize, clock: Option<f64>) -> Option<(f64, f64)> {
    let (sweep, delay) = (uneven(seed as u64, seed), DELAYS[seed]);
    let rows = &sweep.log.rows;
    let poses = rows.iter().filter(|row| row.t >= -delay).step_by(nth);
    let odometry: Vec<StampedPose> =
        poses.map(|row| StampedPose { t: row.t - 77.0, map_from_robot: row.odom_from_robot }).collect();
    let first = rows.iter().find(|row| row.t >= delay)?.t;
    let text: String = match clock {
        None => {
            let later = rows.iter().filter(|row| row.t >= first);
            let lines: String = later.map(|row| format!("{},{}\n", row.t - first, row.readings[0])).collect();
            format!("t,moment\n{lines}")
        }
        Some(second) => {
            let times = (0..).map(|i| first + f64::from(i) * second / RATE);
            let at = |t: f64| rows.iter().find(|row| row.t >= t);
            times.map_while(at).map(|row| format!("{:.2},0.00,12.00\r\n", 1e5 * row.readings[0])).collect()
        }
    };
    let format = if clock.is_some() { Format::Serial } else { Format::Csv };
    let readings = Recording::from_bytes(text.as_bytes(), format, "readings").unwrap();
    let estimate = join(&readings, &odometry, "", Delay::Estimated(6.0)).ok()?.estimate?;
    let half = 0.5 * readings.t.last()?;
    let truth = first - (odometry[0].t + 77.0) + half * clock.unwrap_or(1.0);
    Some((estimate.delay + half * estimate.rate - truth, estimate.delay_std))
}

fn main() {
    println!("| odometry | lines have | told | off: median | largest | in standard deviations: median | largest |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for (hz, nth) in [(300, 1), (50, 6), (20, 15)] {
        for stamped in [true, false] {
            // Without stamps the sensor is up to 1.5 % slower or faster than it should be.
            let clock = |seed: usize| (!stamped).then_some(1.0 + 0.0025 * (seed as f64 - 6.0));
            let all: Vec<(f64, f64)> = (0..DELAYS.len()).filter_map(|seed| found(seed, nth, clock(seed))).collect();
            let sorted = |of: &dyn Fn(&(f64, f64)) -> f64| {
                let mut values: Vec<f64> = all.iter().map(of).collect();
                values.sort_by(f64::total_cmp);
                (values[values.len() / 2], values[values.len() - 1])
            };
            if all.is_empty() {
                println!("| {hz} Hz | | none of {} | | | | |", DELAYS.len());
                continue;
            }
            let (off, ratio) = (sorted(&|one| 1e3 * one.0.abs()), sorted(&|one| (one.0 / one.1).abs()));
            println!(
                "| {hz} Hz | {} | {} of {} | {:.1} ms | {:.1} ms | {:.1} | {:.1} |",
                if stamped { "stamps" } else { "no time" },
                all.len(),
                DELAYS.len(),
                off.0,
                off.1,
                ratio.0,
                ratio.1
            );
        }
    }
}
