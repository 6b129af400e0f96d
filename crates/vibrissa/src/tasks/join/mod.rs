//! Readings and odometry that were recorded apart, as one log.
//!
//! A whisker that slides slowly is in equilibrium, so that over a short way its reading is a smooth function of the robot's pose.
//! The delay is the one with which poses explain readings best: windows of a quarter of a second, in each a reading that is
//! linear in x, y and heading. Uniform motion fits with every delay; starts, stops and turns tell it.

mod delay;

pub use delay::{DelayEstimate, estimate_delay};

use crate::flow::pose::StampedPose;
use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use crate::flow::trajectory::pose_at;
use crate::io::log::foreign::{Format, Recording};
use crate::{Error, Result};
use std::path::Path;

/// Largest delay that is looked for unless said otherwise (s), on either side of recordings that begin together.
pub const SEARCH: f64 = 5.0;
/// A delay that is told worse (s) is no answer: at 0.15 m/s it is 3 mm.
const WORST: f64 = 0.02;

/// How readings are put on the odometry's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay {
    /// Odometry time of the first reading, less that of the first pose (s), known.
    Known(f64),
    /// To be estimated, up to so much (s) on either side.
    Estimated(f64),
}

/// What was joined.
#[derive(Clone, Debug, PartialEq)]
pub struct Joined {
    /// The log, its times on the odometry's clock.
    pub log: SensorLog,
    /// Odometry time of the first reading, less that of the first pose (s), and what was estimated.
    pub delay: f64,
    /// How well it is known; none where it was given.
    pub estimate: Option<DelayEstimate>,
    /// Readings without odometry at their time.
    pub outside: usize,
}

/// Joins readings, whose times start at zero, with odometry; the nameless ones become those of `whisker`, where it is not empty.
///
/// # Errors
///
/// No readings, no time, fewer than 50 readings, no common time, a delay that the motion does not tell.
pub fn join(readings: &Recording, odometry: &[StampedPose], whisker: &str, delay: Delay) -> Result<Joined> {
    let measured: Vec<(Channel, &[f64])> = readings
        .series
        .iter()
        .filter_map(|series| Some((channel(&series.name, whisker)?, series.values.as_slice())))
        .collect();
    if measured.is_empty() {
        return Err(Error::data("the recording holds no readings")
            .in_file(&readings.source)
            .value(format!("format {}", readings.format.as_str()))
            .remedy("name the format (--format), or the columns as docs/files.md does"));
    }
    if readings.t.len() != readings.lines.len() {
        return Err(Error::data("the readings have no time")
            .in_file(&readings.source)
            .remedy("add the column `t` (s)"));
    }
    let (Some(first), Some(_)) = (odometry.first(), readings.t.first()) else {
        return Err(Error::data("the odometry holds no pose"));
    };
    // Times that were made from a nominal rate are as wrong as the rate is.
    let free_rate = readings.repairs.stamps_made > 0;
    let columns: Vec<&[f64]> = measured.iter().map(|(_, values)| *values).collect();
    let (offset, rate, estimate) = match delay {
        Delay::Known(delay) => (first.t + delay, 1.0, None),
        Delay::Estimated(most) => {
            let found = estimate_delay(&readings.t, &columns, odometry, most, free_rate)
                .map_err(|e| e.in_file(&readings.source))?;
            (first.t + found.delay, found.rate, Some(found))
        }
    };
    if let Some(found) = estimate.filter(|found| found.delay_std > WORST || found.rival) {
        let remedy = "give the delay (--delay), or record a run with stops and turns in contact: uniform motion fits with \
                      every delay";
        return Err(Error::data("the motion does not tell the delay between readings and odometry")
            .in_file(&readings.source)
            .value(format!("{:.3} s, standard deviation {:.3} s", found.delay, found.delay_std))
            .allowed(format!("a standard deviation up to {WORST} s, and no rival"))
            .remedy(remedy));
    }
    let mut outside = 0;
    let mut rows = Vec::new();
    for (index, &read_at) in readings.t.iter().enumerate() {
        let t = offset + rate * read_at;
        let Some(odom_from_robot) = pose_at(odometry, t) else {
            outside += 1;
            continue;
        };
        let readings = columns.iter().map(|values| values[index]).collect();
        rows.push(LogRow { t, odom_from_robot, readings, heading: None, line: rows.len() + 2 });
    }
    if rows.is_empty() {
        return Err(Error::data("readings and odometry share no time")
            .in_file(&readings.source)
            .value(format!("the first reading lies {:.3} s behind the first pose", offset - first.t))
            .remedy("check --delay"));
    }
    let channels = measured.into_iter().map(|(channel, _)| channel).collect();
    let log = SensorLog { channels, rows, warnings: readings.repairs.words(), source: None };
    Ok(Joined { log, delay: offset - first.t, estimate, outside })
}

/// The channel of a column of readings; odometry that a recording holds beside them is not one.
fn channel(name: &str, of: &str) -> Option<Channel> {
    let (whisker, word) = name.rsplit_once('.').unwrap_or((of, name));
    let quantity = Quantity::ALL.into_iter().find(|quantity| quantity.word() == word)?;
    Some(Channel { whisker: whisker.to_owned(), quantity })
}

/// The readings of a file by its format; without one CSV, or what the paper's sensor sends where the file is `.txt`.
///
/// # Errors
///
/// As [`Recording::read`].
pub fn read_readings(path: impl AsRef<Path>, format: Option<Format>) -> Result<Recording> {
    let path = path.as_ref();
    let is_text = path.extension().is_some_and(|extension| extension == "txt");
    Recording::read(path, format.unwrap_or(if is_text { Format::Serial } else { Format::Csv }))
}
