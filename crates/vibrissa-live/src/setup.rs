//! A whole live run in one file, `live.toml`.

mod columns;
mod method;
mod time;
mod wire;

use crate::config::ESTIMATE_RATE;
use crate::decode::{Decoder, WireFormat};
use crate::source::Wire;
use crate::timing::TimeBase;
use crate::{Error, Result};
use columns::{flag, said};
use method::method;
use std::path::{Path, PathBuf};
use time::{RATES, time};
use vibrissa_core::config::budgets::TOML_BYTES;
use vibrissa_core::localizer::Method;
use vibrissa_core::world::Robot;
use vibrissa_io::Dimension;
use vibrissa_io::text::read_text;
use vibrissa_io::toml_section::{Allowed, Section, Source};
use wire::{WIRES, wire};

/// What a live run is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The map; none for a run that makes one.
    pub map: Option<PathBuf>,
    /// The robot; none for the paper's whisker.
    pub robot: Option<PathBuf>,
    /// The estimator with its options.
    pub method: Method,
    /// Estimates a second of row time that are written (Hz).
    pub estimate_rate: f64,
    /// The sources; the first one with readings gives the rows.
    pub sources: Vec<SourceSetup>,
    /// The text that it was read from,
    pub text: String,
    /// and the name of its file, for messages.
    pub name: String,
}

/// One source.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceSetup {
    /// Its name, in words and topics.
    pub name: String,
    /// Where its bytes come from.
    pub wire: Wire,
    /// What its lines hold.
    pub format: WireFormat,
    /// The columns of lines without a header.
    pub columns: Option<Vec<String>>,
    /// Whose readings they are that do not say it.
    pub whisker: String,
    /// What times are made from.
    pub time: TimeBase,
    /// Whether every line has a checksum, the first one too.
    pub checksums: bool,
    /// How much older a frame is than its stamp or arrival says (s).
    pub delay: f64,
    /// The line of the setup in which it begins.
    pub line: usize,
}

impl SourceSetup {
    /// The decoder of its lines.
    ///
    /// # Errors
    ///
    /// As [`Decoder::new`].
    pub fn decoder(&self) -> Result<Decoder> {
        let decoder = Decoder::new(self.format, self.columns.as_deref(), &self.whisker)?;
        Ok(if self.checksums { decoder.with_checksums() } else { decoder })
    }

    /// Refuses readings of whiskers that the robot does not have; `name` is the setup's file.
    pub(crate) fn fits(&self, decoder: &Decoder, robot: &Robot, name: &str) -> Result<()> {
        let names: Vec<&str> = robot.whiskers.iter().map(|whisker| whisker.name.as_str()).collect();
        let fits = |whisker: &str| names.contains(&whisker) || (whisker.is_empty() && names.len() == 1);
        let Some(stranger) = decoder.channels().iter().find(|channel| !fits(&channel.whisker)) else { return Ok(()) };
        let error = if stranger.whisker.is_empty() {
            Error::data(format!("the source \"{}\" does not say whose readings it holds", self.name))
        } else {
            Error::data(format!(
                "the source \"{}\" holds readings of a whisker that the robot does not have",
                self.name
            ))
        };
        Err(error
            .in_file(name)
            .at_line(self.line)
            .value(stranger.column())
            .allowed(names.join(", "))
            .remedy("name the columns NAME.moment, or add whisker = \"NAME\" to the source, NAME as in the robot file"))
    }
}

const TOP: [&str; 6] = ["map", "robot", "method", "options", "estimates", "source"];
/// The keys of a source beside its wire.
const KEYS: [&str; 11] =
    ["name", "baud", "speed", "message", "format", "columns", "whisker", "rate", "time", "delay", "checksums"];
const DELAYS: Allowed = Allowed {
    holds: |v| v.abs() <= 10.0,
    text: "-10 to 10 s",
    remedy: "a bare number is in seconds; write \"2 ms\" for milliseconds",
};

/// Reads `live.toml`; relative paths are taken from its folder.
///
/// # Errors
///
/// A file that cannot be read or is at fault; the message names file, line, value, allowed range and the next step.
pub fn read(path: impl AsRef<Path>) -> Result<Setup> {
    let path = path.as_ref();
    let text = read_text(path, "setup", TOML_BYTES)?;
    let mut setup = from_toml(&text, &path.to_string_lossy())?;
    if let Some(folder) = path.parent() {
        setup.based_on(folder);
    }
    setup.check_files(path)?;
    for source in &mut setup.sources {
        source.wire.load().map_err(|error| error.or_remedy("correct the file that the setup plays"))?;
    }
    Ok(setup)
}

/// The setup in a TOML text; `name` stands for the file in messages.
///
/// # Errors
///
/// As [`read`].
pub fn from_toml(text: &str, name: &str) -> Result<Setup> {
    parse(text, name).map_err(|e| e.or_remedy("correct the line; docs/live.md lists every key with its unit and range"))
}

impl Setup {
    /// Refuses a map or a robot that is not there, with the line that names it.
    fn check_files(&self, path: &Path) -> Result<()> {
        let played = self.sources.iter().filter_map(|source| match &source.wire {
            Wire::Played(playback) => Some((playback.kind.key(), Some(&playback.path), source.line)),
            _ => None,
        });
        for (key, file, from) in
            [("map", self.map.as_ref(), 1), ("robot", self.robot.as_ref(), 1)].into_iter().chain(played)
        {
            let Some(file) = file.filter(|file| !file.exists()) else { continue };
            let names =
                |line: &str| line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='));
            let line = self.text.lines().skip(from - 1).position(names).map_or(from, |index| index + from);
            return Err(Error::data(format!("the {key} that the setup names is not there"))
                .in_file(path)
                .at_line(line)
                .value(file.display())
                .remedy("check the spelling; relative paths start at the folder of the setup"));
        }
        Ok(())
    }

    /// Refuses sources whose readings are of whiskers that the robot does not have, as far as they have said what they hold.
    ///
    /// # Errors
    ///
    /// The first such reading, with the line of its source.
    pub fn fits(&self, robot: &Robot) -> Result<()> {
        if matches!(self.method, Method::Probabilistic(_)) {
            robot.require_level("a live run by the probabilistic method")?;
        }
        for source in &self.sources {
            source.fits(&source.decoder()?, robot, &self.name)?;
        }
        Ok(())
    }

    /// Takes relative paths from this folder.
    pub fn based_on(&mut self, folder: &Path) {
        self.map = self.map.as_ref().map(|map| folder.join(map));
        self.robot = self.robot.as_ref().map(|robot| folder.join(robot));
        for source in &mut self.sources {
            match &mut source.wire {
                Wire::Serial { port: path, .. } | Wire::Unix(path) => *path = folder.join(&*path),
                Wire::Pipe(path) if path.as_os_str() != "-" => *path = folder.join(&*path),
                Wire::Played(playback) => playback.path = folder.join(&playback.path),
                _ => {}
            }
        }
    }
}

fn parse(text: &str, name: &str) -> Result<Setup> {
    let source = Source::new(text, name);
    let root = source.parse()?;
    let top = Section::top(&source, &root);
    top.only(&TOP)?;
    let entries = top.entries("source")?;
    if entries.is_empty() {
        return Err(Error::data("the setup has no source").in_file(name).at_line(1).remedy(
            "add [[source]] with serial = \"/dev/ttyACM0\" and format = \"serial\"; docs/live.md shows whole files",
        ));
    }
    let alone = entries.len() == 1;
    let all_ros = entries.iter().all(|entry| entry.get("ros2").is_some());
    let sources: Vec<SourceSetup> = entries
        .iter()
        .enumerate()
        .map(|(index, entry)| source_entry(entry, index, (alone, all_ros)))
        .collect::<Result<_>>()?;
    for (index, one) in sources.iter().enumerate() {
        if sources[..index].iter().any(|other| other.name == one.name) {
            return Err(entries[index]
                .source
                .fault(&entries[index].span_of("name"), "two sources have the same name")
                .value(format!("\"{}\"", one.name))
                .remedy("rename one; names stand in words and topics"));
        }
        if sources[..index].iter().any(|other| other.wire == one.wire) {
            return Err(entries[index]
                .source
                .fault(&entries[index].span, "two sources read the same port")
                .value(one.wire.shown())
                .remedy("a port's bytes go to one source; one stream may hold several whiskers (columns, serial2)"));
        }
    }
    check_odometry(&sources, &entries)?;
    Ok(Setup {
        map: top.text("map")?.map(PathBuf::from),
        robot: top.text("robot")?.map(PathBuf::from),
        method: method(&top)?,
        estimate_rate: top.number("estimates", Dimension::Frequency, &RATES)?.unwrap_or(ESTIMATE_RATE),
        sources,
        text: text.to_owned(),
        name: name.to_owned(),
    })
}

/// Refuses what cannot be joined, as far as it is known before the first line.
fn check_odometry(sources: &[SourceSetup], entries: &[Section<'_>]) -> Result<()> {
    let decoders: Vec<Decoder> = sources.iter().map(SourceSetup::decoder).collect::<Result<_>>()?;
    let with_pose: Vec<usize> = (0..decoders.len()).filter(|&i| decoders[i].has_pose()).collect();
    let known = decoders.iter().all(Decoder::is_ready);
    let fault = |index: usize, what: &str| entries[index].source.fault(&entries[index].span, what);
    if let [_, second, ..] = with_pose[..] {
        return Err(fault(second, "two sources give odometry")
            .value(with_pose.iter().map(|&i| sources[i].name.as_str()).collect::<Vec<_>>().join(", "))
            .remedy("name the columns x, y, theta of the other one \"-\""));
    }
    if known && with_pose.is_empty() {
        return Err(fault(0, "no source gives odometry")
            .allowed("one with the columns x, y, theta, or format = \"tum\"")
            .remedy("a whisker's line holds no odometry: add a [[source]] for the robot's, or columns to this one"));
    }
    if known && decoders.iter().all(|decoder| decoder.channels().is_empty()) {
        return Err(fault(0, "no source gives readings")
            .allowed("one with columns such as moment or bx, by, bz, or a format of a sensor")
            .remedy("add a [[source]] for the whisker"));
    }
    Ok(())
}

fn source_entry(entry: &Section<'_>, index: usize, (alone, all_ros): (bool, bool)) -> Result<SourceSetup> {
    let known: Vec<&str> = WIRES.into_iter().chain(KEYS).collect();
    entry.only(&known)?;
    let wire = wire(entry)?;
    let format = match entry.text("format")? {
        Some(word) => word.parse::<WireFormat>().map_err(|e| at(entry, "format", e))?,
        None => WireFormat::Csv,
    };
    let given = said(entry)?;
    let columns = match &wire {
        Wire::Ros2 { message, .. } => message.columns().or(given),
        _ => given,
    };
    let whisker = entry.text("whisker")?.unwrap_or_default().to_owned();
    let decoder = Decoder::new(format, columns.as_deref(), &whisker)
        .map_err(|e| at(entry, if columns.is_some() { "columns" } else { "format" }, e))?;
    let whole = match &wire {
        Wire::Played(_) => true,
        Wire::Ros2 { .. } => all_ros,
        _ => decoder.has_pose() && !decoder.channels().is_empty() || (alone && !decoder.is_ready()),
    };
    let time = time(entry, format, columns.as_deref(), whole)?;
    if let (Wire::Played(playback), false) = (&wire, time == TimeBase::Own)
        && (playback.speed - 1.0).abs() > 0.0
    {
        return Err(entry
            .source
            .fault(&entry.span_of("speed"), "at another speed the times of a log are not those of its arrival")
            .value(format!("speed = {}", playback.speed))
            .remedy("leave `time` out, or the speed"));
    }
    Ok(SourceSetup {
        name: entry.text("name")?.map_or_else(|| format!("source{index}"), str::to_owned),
        time,
        checksums: flag(entry, "checksums")?,
        delay: entry.number("delay", Dimension::Time, &DELAYS)?.unwrap_or(0.0),
        wire,
        format,
        columns,
        whisker,
        line: entry.source.line(&entry.span),
    })
}

fn at(entry: &Section<'_>, key: &str, error: Error) -> Error {
    error.in_file(entry.source.name).at_line(entry.line_of(key))
}
