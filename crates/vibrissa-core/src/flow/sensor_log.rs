//! The first door: what the robot recorded.

use crate::config::limits::LARGEST_ODOMETRY;
use crate::plane::Pose2;
use crate::world::Robot;
use crate::{Error, Result};
use std::path::PathBuf;

/// What a column of a log measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Bending moment about the whisker base (N m), counter-clockwise positive.
    Moment,
    /// Bending moment about the other transverse axis (N m), positive for a push towards the whisker's +z.
    Across,
    /// Magnetic flux density along the sensor's first axis (T).
    FluxX,
    /// Magnetic flux density along the sensor's second axis (T).
    FluxY,
    /// Magnetic flux density along the sensor's third axis (T).
    FluxZ,
    /// Raw counts of the sensor's first axis.
    CountX,
    /// Raw counts of the sensor's second axis.
    CountY,
    /// Raw counts of the sensor's third axis.
    CountZ,
    /// Contact force (N).
    Force,
    /// Slope of the whisker at its end (rad).
    Slope,
    /// Lower end of the touched strip, as arc length from the base (m).
    StripLo,
    /// Upper end of the touched strip, as arc length from the base (m).
    StripHi,
}

impl Quantity {
    /// Every quantity, in the order of the contract.
    pub const ALL: [Self; 12] = [
        Self::Moment,
        Self::Across,
        Self::FluxX,
        Self::FluxY,
        Self::FluxZ,
        Self::CountX,
        Self::CountY,
        Self::CountZ,
        Self::Force,
        Self::Slope,
        Self::StripLo,
        Self::StripHi,
    ];

    /// The word that names it in a log's header.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Moment => "moment",
            Self::Across => "across",
            Self::FluxX => "bx",
            Self::FluxY => "by",
            Self::FluxZ => "bz",
            Self::CountX => "ax",
            Self::CountY => "ay",
            Self::CountZ => "az",
            Self::Force => "force",
            Self::Slope => "slope",
            Self::StripLo => "strip_lo",
            Self::StripHi => "strip_hi",
        }
    }
}

/// One measured column of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The whisker's name; empty when the log does not name it (a log of one whisker).
    pub whisker: String,
    /// What is measured, and in which unit.
    pub quantity: Quantity,
}

/// One row of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct LogRow {
    /// Time stamp (s), strictly increasing over a log.
    pub t: f64,
    /// The robot in the odometry frame, whose origin is arbitrary.
    pub odom_from_robot: Pose2,
    /// One reading for each channel of the log, in its order.
    pub readings: Vec<f64>,
    /// Absolute heading in the map frame from an IMU or compass (rad), where logged.
    pub heading: Option<f64>,
    /// The line of the file that it was read from, counted from 1; 0 for a row that was not read from a file.
    pub line: usize,
}

impl LogRow {
    /// Refuses a row that is not in numbers: its time, its pose, or a reading of one of these channels; and one that has no such reading.
    ///
    /// Readers of files give no such row; rows that a program makes may be anything.
    ///
    /// # Errors
    ///
    /// Data: what is no number, or beyond [`LARGEST_ODOMETRY`]; the message names the line where there is one.
    pub fn check(&self, channels: impl IntoIterator<Item = usize>) -> Result<()> {
        let here = |error: Error| if self.line > 0 { error.at_line(self.line) } else { error };
        let Pose2 { x, y, theta } = self.odom_from_robot;
        for (name, value, largest) in [
            ("t", self.t, f64::MAX),
            ("x", x, LARGEST_ODOMETRY),
            ("y", y, LARGEST_ODOMETRY),
            ("theta", theta, f64::MAX),
        ] {
            if value.is_nan() || value.abs() > largest {
                let error = Error::data(format!("{name} of a row is no number that a robot can have")).value(value);
                let allowed =
                    if largest < f64::MAX { format!("up to {largest:e} m") } else { "a finite number".into() };
                return Err(here(error.allowed(allowed).remedy("leave the row out")));
            }
        }
        for channel in channels {
            match self.readings.get(channel) {
                Some(value) if value.is_finite() => {}
                Some(&value) => {
                    let error = Error::data(format!("reading {} of a row is not a number", channel + 1)).value(value);
                    return Err(here(error.allowed("a finite number").remedy("leave the row out")));
                }
                None => {
                    let error = Error::data(format!("a row has no reading {}", channel + 1));
                    let count = format!("{} readings", self.readings.len());
                    return Err(here(error.value(count).allowed("one reading for each channel of the log")));
                }
            }
        }
        Ok(())
    }
}

/// A recorded run: odometry and readings over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorLog {
    /// The measured columns.
    pub channels: Vec<Channel>,
    /// The rows, in time order.
    pub rows: Vec<LogRow>,
    /// What looked wrong but could be read, for people.
    pub warnings: Vec<String>,
    /// The file that it was read from, for messages.
    pub source: Option<PathBuf>,
}

impl SensorLog {
    /// The index of the channel with this quantity of the whisker called `whisker`; an unnamed channel belongs to any whisker.
    #[must_use]
    pub fn channel(&self, whisker: &str, quantity: Quantity) -> Option<usize> {
        let of = |name: &str| self.channels.iter().position(|c| c.quantity == quantity && c.whisker == name);
        of(whisker).or_else(|| of(""))
    }

    /// The index of the moment channel of the whisker called `whisker`; an unnamed channel belongs to any whisker.
    ///
    /// # Errors
    ///
    /// No such channel; the message lists what the log holds instead.
    pub fn moment_channel(&self, whisker: &str) -> Result<usize> {
        if let Some(index) = self.channel(whisker, Quantity::Moment) {
            return Ok(index);
        }
        let held: Vec<String> = self.channels.iter().map(Channel::column).collect();
        let error = Error::data(format!("the log has no moment column for the whisker \"{whisker}\""))
            .value(format!("it holds {}", if held.is_empty() { "no readings".to_owned() } else { held_words(&held) }))
            .allowed(format!("moment, or {whisker}.moment"));
        Err(if self.channels.iter().any(|c| c.quantity == Quantity::Moment) {
            error.remedy("name the columns after the robot's whiskers")
        } else {
            error.remedy(
                "flux and counts need `calibration = \"cal.json\"` in the robot file; --method probabilistic takes force and \
                 slope, too",
            )
        })
    }
}

/// A few of many columns.
fn held_words(held: &[String]) -> String {
    let more = if held.len() > 12 { format!(" and {} more", held.len() - 12) } else { String::new() };
    held.iter().take(12).map(String::as_str).collect::<Vec<_>>().join(", ") + &more
}

/// Refuses columns without a whisker's name where it is open whose they are: several whiskers would share one, or the whisker has
/// one of its own beside it.
///
/// # Errors
///
/// A robot of several whiskers with a column such as `moment`, a log with `moment` beside `w0.moment`; the message lists the names.
pub fn one_owner_each(robot: &Robot, channels: &[Channel]) -> Result<()> {
    let used = |c: &&Channel| !matches!(c.quantity, Quantity::Across | Quantity::StripLo | Quantity::StripHi);
    let remedy = "rename the column after its whisker, and take whiskers without a column out of the robot file";
    for nameless in channels.iter().filter(used).filter(|c| c.whisker.is_empty()) {
        let word = nameless.quantity.word();
        let columns =
            || robot.whiskers.iter().take(8).map(|w| format!("{}.{word}", w.name)).collect::<Vec<_>>().join(", ");
        if robot.whiskers.len() > 1 {
            let what =
                format!("the robot has several whiskers, but the log's column `{word}` does not say whose it is");
            let count = format!("{} whiskers", robot.whiskers.len());
            return Err(Error::data(what).value(count).allowed(columns()).remedy(remedy));
        }
        let named =
            |c: &&Channel| c.quantity == nameless.quantity && robot.whiskers.iter().any(|w| w.name == c.whisker);
        if let Some(named) = channels.iter().find(named) {
            return Err(Error::data(format!(
                "the log has `{word}` beside `{}`: which is the whisker's?",
                named.column()
            ))
            .value(format!("`{word}` and `{}`", named.column()))
            .allowed("one of the two")
            .remedy("leave out the other column"));
        }
    }
    Ok(())
}

impl Channel {
    /// The column's name in a log's header.
    #[must_use]
    pub fn column(&self) -> String {
        let word = self.quantity.word();
        if self.whisker.is_empty() { word.to_owned() } else { format!("{}.{word}", self.whisker) }
    }
}
