//! Logs as CSV.

use super::ImuTopics;
use super::columns::{Columns, ODOMETRY, without_units};
use super::csv_lines::{Line, Lines, fields};
use super::doubts::Doubts;
use super::text_form::{TextForm, recognised};
use crate::config::budgets::MOST_NUMBERS;
use crate::config::limits::{LARGEST_ODOMETRY, MOST_LOG_ROWS};
use crate::flow::sensor_log::{LogRow, SensorLog};
use crate::plane::Pose2;
use crate::text::{beyond, cannot_open, open, short};
use crate::{Error, Result};
use std::io::Read;
use std::path::Path;

/// Reads a log file: `.mcap`, or the folder of `ros2 bag record` around one, is a recording with ROS 2 messages, all
/// else CSV.
///
/// # Errors
///
/// A file that cannot be read or is at fault; the message names file, line and value.
pub fn read(path: impl AsRef<Path>) -> Result<SensorLog> {
    read_with(path, &ImuTopics::default())
}

/// As [`read`], with what these topics of a recording's inertial measurement units tell.
///
/// # Errors
///
/// As [`read`]; usage: topics named for a file that is no recording.
pub fn read_with(path: impl AsRef<Path>, imu: &ImuTopics) -> Result<SensorLog> {
    let path = path.as_ref();
    if path.is_dir() {
        #[cfg(feature = "mcap")]
        if let Some(only) = super::bag::only_recording(path) {
            return super::bag::read_mcap(&only, imu);
        }
        return Err(cannot_open(path, "log", &std::io::ErrorKind::IsADirectory.into()));
    }
    match path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase().as_str() {
        #[cfg(feature = "mcap")]
        "mcap" => return super::bag::read_mcap(path, imu),
        #[cfg(not(feature = "mcap"))]
        "mcap" => return Err(other_recording(path)),
        "bag" | "db3" => return Err(other_recording(path)),
        _ => {}
    }
    if !imu.is_empty() {
        return Err(Error::usage("topics of an inertial measurement unit are of recordings with ROS 2 messages")
            .value(path.display())
            .allowed("a .mcap file")
            .remedy("in a CSV log the column `heading` holds absolute headings"));
    }
    from_reader(open(path, "log")?, &path.to_string_lossy())
}

/// The log in the bytes of a file, for those who have bytes and no files; the extension of its name says the format, as for
/// [`read`].
///
/// # Errors
///
/// As [`read`], with the file's name as it is given.
pub fn from_bytes(bytes: &[u8], name: &str) -> Result<SensorLog> {
    let path = Path::new(name);
    match path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase().as_str() {
        #[cfg(feature = "mcap")]
        "mcap" => super::bag::from_mcap(bytes, name),
        #[cfg(not(feature = "mcap"))]
        "mcap" => Err(other_recording(path)),
        "bag" | "db3" => Err(other_recording(path)),
        _ => from_reader(bytes, name),
    }
}

/// The log in a CSV text; `name` stands for the file in messages.
///
/// # Errors
///
/// As [`from_reader`].
pub fn from_csv(text: &str, name: &str) -> Result<SensorLog> {
    from_reader(text.as_bytes(), name)
}

/// The log in a stream of CSV, read row by row; `name` stands for the file in messages.
///
/// The first line names the columns: `t,x,y,theta`, a reading for each whisker (`moment`, or `NAME.moment` where
/// there are several; see [`crate::flow::sensor_log::Quantity`]), and perhaps `heading`, in any order. A field may stand in quotes,
/// which end in its line. A last line without a line end is dropped with a warning, whatever it holds: the rest of its last number
/// may be missing.
///
/// # Errors
///
/// No header, a missing column, a line with too few or too many fields, a field that is not a finite number, a quote that does not
/// end in its line, a clock that does not increase, odometry beyond 1e8 m, no rows at all; a line of more
/// than a megabyte, more columns, rows or numbers than a log may have ([`crate::config::budgets`]).
pub fn from_reader(reader: impl Read, name: &str) -> Result<SensorLog> {
    let faulty = |e: Error| e.in_file(name).or_remedy("correct or remove the line, or record the log again");
    let (form, plain) = recognised(reader).map_err(faulty)?;
    let mut log = rows(plain, &form, name).map_err(faulty)?;
    log.warnings.splice(..0, form.warning().map(|words| format!("{name}: {words}")));
    Ok(SensorLog { source: Some(name.into()), ..log })
}

/// The error for recordings in other containers, and for MCAP in builds without it.
fn other_recording(path: &Path) -> Error {
    Error::data("a recording in a format that is not read here")
        .in_file(path)
        .allowed(".mcap, .csv")
        .remedy("`ros2 bag convert` makes MCAP of other recordings; MCAP itself needs a build with the feature `mcap`")
}

/// A fault in a row, held back until it is known whether the row was the last one.
struct Pending {
    error: Error,
    line: usize,
    /// Whether a writer that was stopped in the middle explains it even when the file ends in a line end.
    short: bool,
}

fn rows(reader: impl Read, form: &TextForm, name: &str) -> Result<SensorLog> {
    let mut lines = Lines::new(reader);
    let mut header = None;
    while header.is_none() {
        let Some(line) = lines.next()? else {
            let remedy = "its first line must name the columns: t,x,y,theta,moment";
            return Err(Error::data("the log is empty").remedy(remedy));
        };
        if !line.is_blank() {
            let names = fields(&line, form.delimiter).map(|fields| fields.iter().map(|field| text(field)).collect());
            let columns = names.and_then(without_units).and_then(Columns::new);
            header = Some(columns.map_err(|e| e.at_line(line.number))?);
        }
    }
    let Some(columns) = header else { return Err(Error::data("the log is empty")) };
    let mut log =
        SensorLog { channels: columns.channels.clone(), warnings: columns.warnings.clone(), ..SensorLog::default() };
    let (mut doubts, mut pending): (_, Option<Pending>) = (Doubts::default(), None);
    let mut cut = None;
    while let Some(line) = lines.next()? {
        if line.is_blank() {
            continue;
        }
        if let Some(pending) = pending {
            return Err(pending.error);
        }
        if !line.ended {
            cut = Some(line.number);
            break;
        }
        pending = row(&line, &columns, form, &mut log, &mut doubts).err();
    }
    log.warnings.extend(doubts.warnings(name));
    finish(log, pending, cut)
}

/// Drops a cut last line; any other fault is an error.
fn finish(mut log: SensorLog, pending: Option<Pending>, cut: Option<usize>) -> Result<SensorLog> {
    if let Some(line) = cut {
        log.warnings.push(format!(
            "line {line}: the last line is cut off: it has no line end, so its last number may be cut; 1 row dropped"
        ));
    } else if let Some(Pending { error, line, short }) = pending {
        if !short {
            return Err(error);
        }
        log.warnings.push(format!("line {line}: the last line is cut off; 1 row dropped"));
    }
    if log.rows.is_empty() {
        return Err(
            Error::data("the log has no rows").remedy("it holds only a header; was the recording stopped at once?")
        );
    }
    Ok(log)
}

fn text(field: &[u8]) -> String {
    String::from_utf8_lossy(field).into_owned()
}

/// Reads one row into the log.
fn row(
    read: &Line<'_>,
    columns: &Columns,
    form: &TextForm,
    log: &mut SensorLog,
    doubts: &mut Doubts,
) -> core::result::Result<(), Pending> {
    let line = read.number;
    let fault = |error: Error, short| Pending { error: error.at_line(line), line, short };
    let record = fields(read, form.delimiter).map_err(|error| fault(error, false))?;
    if record.len() != columns.names.len() {
        let short = record.len() < columns.names.len();
        let error = Error::data(if short { "a line with too few fields" } else { "a line with too many fields" })
            .value(record.len())
            .allowed(format!("{}, as the header names", columns.names.len()))
            .remedy(if short {
                "the line was cut; repair or remove it"
            } else {
                "use a dot as decimal mark, one field a column"
            });
        return Err(fault(error, short));
    }
    let number =
        |field: usize| number(record[field], form.decimal_comma, &columns.names[field]).map_err(|e| fault(e, false));
    let metres =
        |field: usize| number(field).and_then(|v| in_reach(v, &columns.names[field]).map_err(|e| fault(e, false)));
    let [t, x, y, theta] = columns.odometry;
    let (t, theta) = (number(t)?, number(theta)?);
    let row = LogRow {
        line,
        t,
        odom_from_robot: Pose2::new(metres(x)?, metres(y)?, theta),
        readings: columns.readings.iter().map(|&field| number(field)).collect::<core::result::Result<_, _>>()?,
        heading: columns.heading.map(number).transpose()?,
    };
    if log.rows.len().saturating_mul(log.channels.len()) >= MOST_NUMBERS {
        let remedy = "cut the log into parts, or leave out the columns that are not used";
        let value = format!("{} rows of {} readings", log.rows.len() + 1, log.channels.len());
        return Err(fault(beyond("the log holds too many numbers", value, MOST_NUMBERS, remedy), false));
    }
    if log.rows.len() >= MOST_LOG_ROWS {
        let error = Error::data("the log has too many rows")
            .allowed(format!("up to {MOST_LOG_ROWS}"))
            .remedy("cut the log into parts, or keep every tenth row");
        return Err(fault(error, false));
    }
    let previous = log.rows.last();
    if let Some(before) = previous.filter(|before| before.t >= t) {
        let error = Error::data(format!("{} does not increase", ODOMETRY[0]))
            .value(format!("{t} s after {} s", before.t))
            .remedy("sort the rows by time and remove repeated ones");
        return Err(fault(error, false));
    }
    doubts.look(line, &row, theta, previous, &columns.channels);
    log.rows.push(row);
    Ok(())
}

/// Refuses odometry that no robot on Earth has.
pub(super) fn in_reach(metres: f64, name: &str) -> Result<f64> {
    if metres.abs() <= LARGEST_ODOMETRY {
        return Ok(metres);
    }
    Err(Error::data(format!("{name} is out of range"))
        .value(format!("{metres:e} m"))
        .allowed(format!("-{LARGEST_ODOMETRY:e} to {LARGEST_ODOMETRY:e} m"))
        .remedy("odometry is in metres; remove the row if the recording failed there"))
}

pub(super) fn number(field: &[u8], decimal_comma: bool, name: &str) -> Result<f64> {
    let shown = || format!("\"{}\"", short(&text(field)));
    let pointed = decimal_comma.then(|| text(field).replace(',', "."));
    let digits = pointed.as_deref().or_else(|| core::str::from_utf8(field).ok());
    match digits.and_then(|f| f.parse::<f64>().ok()) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(Error::data(format!("{name} is not a finite number"))
            .value(shown())
            .remedy("remove the row, or fill the gap where the log is made")),
        None if field.is_empty() => Err(Error::data(format!("{name} is empty")).allowed("a number")),
        None => Err(Error::data(format!("{name} is not a number")).value(shown())),
    }
}
