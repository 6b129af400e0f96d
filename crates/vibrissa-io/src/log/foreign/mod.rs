//! Logs that other people's sensors leave: one reader for each format, and an account of everything that was mended.
//!
//! | format | holds | time | units in the file |
//! | --- | --- | --- | --- |
//! | `serial` | flux of one sensor, text lines `x,y,z` | none: made from the nominal 300 Hz | µT |
//! | `serial2` | flux of two sensors, lines taking turns | none: made from 150 Hz each | µT |
//! | `ratatouille` | counts of two axes, header optional | host stamps, smoothed | counts |
//! | `openwhisker` | counts of three axes, distance from the tip, bend | host stamps | counts (16 bit, wrapping), mm |
//! | `rostopic` | `rostopic echo` of odometry, wrench, magnetic field, twist | message stamps | m, rad, N m, N, T |
//! | `csv` | named columns, SI; no odometry needed | column `t`, if there | as named |
//! | `contour` | positions of a whisker's tip | none | m |
//!
//! A format is named by the caller, never guessed, and so are units. A reader drops what it cannot read and counts it;
//! [`Repairs`] says so in words. Nothing in a file makes a reader panic.

mod contour;
mod lines;
mod openwhisker;
mod ratatouille;
mod repairs;
mod rostopic;
mod serial;
mod stamps;
mod table;
mod yaml;

use crate::config::budgets::FOREIGN_BYTES;
use crate::config::limits::MOST_LOG_ROWS;
use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use crate::plane::Pose2;
use crate::text::{beyond, did_you_mean, listed, open, read_bytes};
use crate::{Error, Result};
use core::str::FromStr;
use std::io::Read;
use std::path::Path;

pub use lines::{number, numbers};
pub use openwhisker::CarriedCounts;
pub use repairs::Repairs;
pub use serial::{TakingTurns, flux_line, is_saturated};
pub use stamps::host_stamp;

/// The formats by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text lines `x,y,z` in µT at 300 Hz, without time, with banner and error lines in between.
    Serial,
    /// As [`Format::Serial`], two sensors taking turns at 150 Hz each.
    Serial2,
    /// Host stamp and two raw counts a line; the header is optional.
    Ratatouille,
    /// Host stamp, three raw 16-bit counts that wrap, distance from the tip and lateral travel in mm.
    Openwhisker,
    /// What `rostopic echo` prints of `nav_msgs/Odometry`, `geometry_msgs/WrenchStamped`, `sensor_msgs/MagneticField`
    /// and `geometry_msgs/TwistStamped`.
    Rostopic,
    /// A header line that names the columns, then numbers in SI units or counts.
    Csv,
    /// Tip positions `x,y` in m, or the same as `rostopic echo` of a `geometry_msgs/TwistStamped`.
    Contour,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 7] =
        [Self::Serial, Self::Serial2, Self::Ratatouille, Self::Openwhisker, Self::Rostopic, Self::Csv, Self::Contour];

    /// The word that names it on a command line.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Serial => "serial",
            Self::Serial2 => "serial2",
            Self::Ratatouille => "ratatouille",
            Self::Openwhisker => "openwhisker",
            Self::Rostopic => "rostopic",
            Self::Csv => "csv",
            Self::Contour => "contour",
        }
    }
}

impl Format {
    /// The format of a recording of taps that nobody named: [`Format::Csv`] where the first line names a column `t`, else
    /// [`Format::Ratatouille`].
    #[must_use]
    pub fn of_taps(path: &Path) -> Self {
        let mut start = Vec::new();
        if let Ok(file) = open(path, "log") {
            // A file that cannot be read is told by the reader.
            let _ = file.take(4096).read_to_end(&mut start);
        }
        let first = start.split(|b| *b == b'\n').next().unwrap_or_default();
        let named = String::from_utf8_lossy(first).split(',').any(|name| name.trim() == "t");
        if named { Self::Csv } else { Self::Ratatouille }
    }
}

impl FromStr for Format {
    type Err = Error;

    fn from_str(word: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|format| format.as_str() == word).ok_or_else(|| {
            let known = Self::ALL.map(Self::as_str);
            Error::usage("unknown --format").value(word).allowed(known.join(", ")).remedy(did_you_mean(word, &known))
        })
    }
}

/// One column of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// `bx`, `ax`, `moment`, `x`, `theta`, `dist`, …; of several sensors `NAME.bx`.
    pub name: String,
    /// The unit of the values here: SI, or counts.
    pub unit: &'static str,
    /// One value for each row.
    pub values: Vec<f64>,
}

/// A foreign log after reading: columns of equal length, and what was mended on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The format that it was read as.
    pub format: Format,
    /// The file, for messages.
    pub source: String,
    /// Time from the first row on (s); empty where neither file nor format knows it.
    pub t: Vec<f64>,
    /// The line of the file that each row came from, counted from 1.
    pub lines: Vec<usize>,
    /// The columns.
    pub series: Vec<Series>,
    /// What was mended.
    pub repairs: Repairs,
}

impl Recording {
    /// Reads a file of a known format.
    ///
    /// # Errors
    ///
    /// A file that cannot be opened, or that holds not one row of this format.
    pub fn read(path: impl AsRef<Path>, format: Format) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_bytes(path, "log", FOREIGN_BYTES)?;
        Self::from_bytes(&bytes, format, &path.to_string_lossy())
    }

    /// The recording in the bytes of a file; `name` stands for the file in messages.
    ///
    /// # Errors
    ///
    /// Not one row of this format.
    pub fn from_bytes(bytes: &[u8], format: Format, name: &str) -> Result<Self> {
        let mut recording = match format {
            Format::Serial => serial::read_one(bytes),
            Format::Serial2 => serial::read_two(bytes),
            Format::Ratatouille => ratatouille::read(bytes),
            Format::Openwhisker => openwhisker::read(bytes),
            Format::Rostopic => rostopic::read(bytes),
            Format::Csv => table::read(bytes),
            Format::Contour => contour::read(bytes),
        };
        recording.source = name.to_owned();
        if recording.lines.len() > MOST_LOG_ROWS {
            let remedy = "cut it into parts, or keep every tenth line";
            let rows = format!("{} or more", recording.lines.len());
            return Err(beyond("the recording has too many rows", rows, MOST_LOG_ROWS, remedy).in_file(name));
        }
        if recording.lines.is_empty() {
            return Err(Error::data(format!("not one row of the format {}", format.as_str()))
                .in_file(name)
                .value(format!("{} lines were dropped", recording.repairs.lines_dropped))
                .remedy("check --format; docs/calibration.md shows a line of each"));
        }
        Ok(recording)
    }

    fn new(format: Format, columns: &[(&str, &'static str)]) -> Self {
        let series = columns.iter().map(|&(name, unit)| Series { name: name.to_owned(), unit, values: Vec::new() });
        Self {
            format,
            source: String::new(),
            t: Vec::new(),
            lines: Vec::new(),
            series: series.collect(),
            repairs: Repairs::default(),
        }
    }

    fn push(&mut self, line: usize, values: impl IntoIterator<Item = f64>) {
        // One row beyond the budget tells that there are more; further ones would only take memory.
        if self.lines.len() > MOST_LOG_ROWS {
            return;
        }
        self.lines.push(line);
        for (series, value) in self.series.iter_mut().zip(values) {
            series.values.push(value);
        }
    }

    /// The values of a column, where it is there.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.series.iter().find(|series| series.name == name).map(|series| series.values.as_slice())
    }

    /// The values of a column.
    ///
    /// # Errors
    ///
    /// No such column; the message lists those that are there.
    pub fn require(&self, name: &str) -> Result<&[f64]> {
        self.column(name).ok_or_else(|| {
            let held: Vec<&str> = self.series.iter().map(|s| s.name.as_str()).collect();
            Error::data(format!("the recording has no column `{name}`"))
                .in_file(&self.source)
                .value(format!("it holds {}", listed(&held)))
                .remedy(did_you_mean(name, &held))
        })
    }

    /// Rows a second, from the first row to the last (Hz); none without time.
    #[must_use]
    pub fn rate(&self) -> Option<f64> {
        let span = self.t.last()? - self.t.first()?;
        (span > 0.0).then(|| (self.t.len() - 1) as f64 / span)
    }

    /// Takes the readings of the sensor `reference`, which feels the ambient field alone, away from those of `sensor`.
    ///
    /// # Errors
    ///
    /// A recording without these two sensors.
    pub fn subtract_reference(&mut self, sensor: &str, reference: &str) -> Result<()> {
        for axis in ["bx", "by", "bz"] {
            let ambient = self.require(&format!("{reference}.{axis}"))?.to_vec();
            let name = format!("{sensor}.{axis}");
            self.require(&name)?;
            for series in self.series.iter_mut().filter(|series| series.name == name) {
                series.values.iter_mut().zip(&ambient).for_each(|(value, ambient)| *value -= ambient);
            }
        }
        self.repairs.reference_subtracted += self.lines.len();
        Ok(())
    }

    /// The recording as a log for localization.
    ///
    /// # Errors
    ///
    /// A recording without odometry or without readings.
    pub fn to_log(&self) -> Result<SensorLog> {
        let missing = |what: &str| {
            Error::data(format!("the recording holds no {what}"))
                .in_file(&self.source)
                .value(format!("format {}", self.format.as_str()))
                .remedy("merge it with the robot's odometry into a log .csv; docs/files.md names the columns")
        };
        let [Some(x), Some(y), Some(theta)] = ["x", "y", "theta"].map(|name| self.column(name)) else {
            return Err(missing("odometry"));
        };
        let measured: Vec<(Channel, &Series)> =
            self.series.iter().filter_map(|series| channel(&series.name).map(|channel| (channel, series))).collect();
        if measured.is_empty() {
            return Err(missing("readings"));
        }
        if self.t.len() != self.lines.len() {
            return Err(missing("time"));
        }
        let row = |i: usize| LogRow {
            t: self.t[i],
            odom_from_robot: Pose2::new(x[i], y[i], theta[i]),
            readings: measured.iter().map(|(_, series)| series.values[i]).collect(),
            heading: None,
            line: self.lines[i],
        };
        Ok(SensorLog {
            rows: (0..self.lines.len()).map(row).collect(),
            warnings: self.repairs.words(),
            source: Some(self.source.clone().into()),
            channels: measured.into_iter().map(|(channel, _)| channel).collect(),
        })
    }
}

fn channel(name: &str) -> Option<Channel> {
    let (whisker, word) = name.rsplit_once('.').unwrap_or(("", name));
    let quantity = Quantity::ALL.into_iter().find(|q| q.word() == word)?;
    Some(Channel { whisker: whisker.to_owned(), quantity })
}
