//! A whole live run in one file, `live.toml`.

use crate::config::{BAUD, ESTIMATE_RATE, RATE, RATE_OF_TWO};
use crate::decode::{Decoder, WireFormat};
use crate::source::Wire;
use crate::timing::TimeBase;
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use toml::de::DeValue;
use vibrissa_core::config::budgets::TOML_BYTES;
use vibrissa_core::config::{SettingValue, Slot};
use vibrissa_core::localizer::Method;
use vibrissa_io::Dimension;
use vibrissa_io::text::{did_you_mean, read_text};
use vibrissa_io::toml_section::{Allowed, Section, Source, show};

/// What a live run is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The map.
    pub map: PathBuf,
    /// The robot; none for the paper's whisker.
    pub robot: Option<PathBuf>,
    /// The estimator with its options.
    pub method: Method,
    /// Estimates a second of row time that are written (Hz).
    pub estimate_rate: f64,
    /// The sources; the first one with readings gives the rows.
    pub sources: Vec<SourceSetup>,
    /// The text that it was read from.
    pub text: String,
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
}

const TOP: [&str; 6] = ["map", "robot", "method", "options", "estimates", "source"];
const WIRES: [&str; 5] = ["serial", "tcp", "udp", "unix", "pipe"];
const KEYS: [&str; 14] = [
    "name",
    "serial",
    "tcp",
    "udp",
    "unix",
    "pipe",
    "baud",
    "format",
    "columns",
    "whisker",
    "rate",
    "time",
    "delay",
    "checksums",
];
const TIMES: [&str; 4] = ["stamps", "count", "arrival", "own"];
const RATES: Allowed = Allowed { holds: |v| (0.1..=1e5).contains(&v), text: "0.1 to 100000 Hz", remedy: "" };
const DELAYS: Allowed = Allowed {
    holds: |v| v.abs() <= 10.0,
    text: "-10 to 10 s",
    remedy: "a bare number is in seconds; write \"2 ms\" for milliseconds",
};
/// What hardware and drivers take.
const BAUDS: core::ops::RangeInclusive<u64> = 50..=12_000_000;

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
        for (key, file) in [("map", Some(&self.map)), ("robot", self.robot.as_ref())] {
            let Some(file) = file.filter(|file| !file.exists()) else { continue };
            let names =
                |line: &str| line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='));
            let line = self.text.lines().position(names).map_or(1, |index| index + 1);
            return Err(Error::data(format!("the {key} that the setup names is not there"))
                .in_file(path)
                .at_line(line)
                .value(file.display())
                .remedy("check the spelling; relative paths start at the folder of the setup"));
        }
        Ok(())
    }

    /// Takes relative paths from this folder.
    pub fn based_on(&mut self, folder: &Path) {
        self.map = folder.join(&self.map);
        self.robot = self.robot.as_ref().map(|robot| folder.join(robot));
        for source in &mut self.sources {
            match &mut source.wire {
                Wire::Serial { port: path, .. } | Wire::Unix(path) => *path = folder.join(&*path),
                Wire::Pipe(path) if path.as_os_str() != "-" => *path = folder.join(&*path),
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
    let map = top.text("map")?.ok_or_else(|| {
        Error::data("the setup names no map").in_file(name).at_line(1).remedy("add map = \"arena.svg\" at its head")
    })?;
    let entries = top.entries("source")?;
    if entries.is_empty() {
        return Err(Error::data("the setup has no source").in_file(name).at_line(1).remedy(
            "add [[source]] with serial = \"/dev/ttyACM0\" and format = \"serial\"; docs/live.md shows whole files",
        ));
    }
    let alone = entries.len() == 1;
    let sources: Vec<SourceSetup> =
        entries.iter().enumerate().map(|(index, entry)| source_entry(entry, index, alone)).collect::<Result<_>>()?;
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
        map: map.into(),
        robot: top.text("robot")?.map(PathBuf::from),
        method: method(&top)?,
        estimate_rate: top.number("estimates", Dimension::Frequency, &RATES)?.unwrap_or(ESTIMATE_RATE),
        sources,
        text: text.to_owned(),
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

fn source_entry(entry: &Section<'_>, index: usize, alone: bool) -> Result<SourceSetup> {
    entry.only(&KEYS)?;
    let wire = wire(entry)?;
    let format = match entry.text("format")? {
        Some(word) => word.parse::<WireFormat>().map_err(|e| at(entry, "format", e))?,
        None => WireFormat::Csv,
    };
    let columns = texts(entry, "columns")?;
    let whisker = entry.text("whisker")?.unwrap_or_default().to_owned();
    let decoder = Decoder::new(format, columns.as_deref(), &whisker)
        .map_err(|e| at(entry, if columns.is_some() { "columns" } else { "format" }, e))?;
    let whole = decoder.has_pose() && !decoder.channels().is_empty() || (alone && !decoder.is_ready());
    Ok(SourceSetup {
        name: entry.text("name")?.map_or_else(|| format!("source{index}"), str::to_owned),
        time: time(entry, format, columns.as_deref(), whole)?,
        checksums: flag(entry, "checksums")?,
        delay: entry.number("delay", Dimension::Time, &DELAYS)?.unwrap_or(0.0),
        wire,
        format,
        columns,
        whisker,
    })
}

fn at(entry: &Section<'_>, key: &str, error: Error) -> Error {
    error.in_file(entry.source.name).at_line(entry.line_of(key))
}

fn wire(entry: &Section<'_>) -> Result<Wire> {
    let given: Vec<&str> = WIRES.into_iter().filter(|key| entry.get(key).is_some()).collect();
    let [key] = given[..] else {
        return Err(entry
            .source
            .fault(&entry.span, "a source has one wire")
            .value(if given.is_empty() { "none of them".to_owned() } else { given.join(", ") })
            .allowed(WIRES.join(", "))
            .remedy("such as serial = \"/dev/ttyACM0\", udp = \"0.0.0.0:9000\" or pipe = \"-\""));
    };
    let text = entry.text(key)?.unwrap_or_default();
    let rates = format!("{} to {}", BAUDS.start(), BAUDS.end());
    let firmware = "use the number in the firmware's Serial.begin()";
    if let Some(value) = entry.get("baud").filter(|value| value.get_ref().as_integer().is_none()) {
        return Err(entry
            .source
            .fault(&value.span(), format!("{} must be a whole number", entry.key("baud")))
            .value(show(value.get_ref()))
            .allowed(rates)
            .remedy(firmware));
    }
    let baud = entry.whole("baud")?;
    if let Some(baud) = baud {
        let fault = |what: &str| entry.source.fault(&entry.span_of("baud"), what).value(baud);
        if key != "serial" {
            return Err(fault("only serial ports have a baud rate").remedy("leave it out"));
        }
        if !BAUDS.contains(&baud) {
            return Err(fault("baud is out of range").allowed(rates).remedy(firmware));
        }
    }
    let address = |text: &str| -> Result<String> {
        match text.rsplit_once(':') {
            Some((_, port)) if port.parse::<u16>().is_ok() => Ok(text.to_owned()),
            _ => Err(entry
                .source
                .fault(&entry.span_of(key), format!("{} is no address", entry.key(key)))
                .value(format!("\"{text}\""))
                .allowed("host:port, such as \"192.168.0.5:9000\"")),
        }
    };
    Ok(match key {
        "serial" => Wire::Serial { port: text.into(), baud: baud.map_or(BAUD, |baud| baud as u32) },
        "tcp" => Wire::Tcp(address(text)?),
        "udp" => Wire::Udp(address(text)?),
        "unix" => Wire::Unix(text.into()),
        _ => Wire::Pipe(text.into()),
    })
}

/// What the times of a source are made from: what is asked for, else what its lines have.
fn time(entry: &Section<'_>, format: WireFormat, columns: Option<&[String]>, whole: bool) -> Result<TimeBase> {
    let rate = entry.number("rate", Dimension::Frequency, &RATES)?;
    let stamped = match format {
        WireFormat::Serial | WireFormat::Serial2 => false,
        WireFormat::Plotter => columns.is_some_and(|names| names.iter().any(|name| is_time(name.rsplit(':').next()))),
        WireFormat::Csv => columns.is_none_or(|names| names.iter().any(|name| is_time(Some(name)))),
        WireFormat::Ratatouille | WireFormat::Openwhisker | WireFormat::Tum | WireFormat::Head => true,
    };
    let nominal = match format {
        WireFormat::Serial => Some(RATE),
        WireFormat::Serial2 => Some(RATE_OF_TWO),
        _ => None,
    };
    let word = entry.text("time")?;
    let fault = |what: &str| entry.source.fault(&entry.span_of("time"), what);
    let rate = rate.or(nominal);
    match word {
        None if stamped && whole => Ok(TimeBase::Own),
        None if stamped => Ok(TimeBase::Stamps),
        None => Ok(rate.map_or(TimeBase::Arrival, TimeBase::Counted)),
        Some("arrival") => Ok(TimeBase::Arrival),
        Some("count") => rate.map(TimeBase::Counted).ok_or_else(|| {
            fault("a count needs its rate").remedy("add rate = \"300 Hz\", what the firmware is set to")
        }),
        Some(word @ ("stamps" | "own")) if !stamped => {
            Err(fault("the lines of this source have no stamps").value(format!("\"{word}\"")).allowed("count, arrival"))
        }
        Some("stamps") => Ok(TimeBase::Stamps),
        Some("own") => Ok(TimeBase::Own),
        Some(word) => Err(fault("unknown time")
            .value(format!("\"{word}\""))
            .allowed(TIMES.join(", "))
            .remedy(did_you_mean(word, &TIMES))),
    }
}

fn is_time(name: Option<&str>) -> bool {
    matches!(name.map(str::trim), Some("t" | "t_ms" | "t_us"))
}

fn flag(entry: &Section<'_>, key: &str) -> Result<bool> {
    let Some(value) = entry.get(key) else { return Ok(false) };
    value.get_ref().as_bool().ok_or_else(|| {
        entry
            .source
            .fault(&value.span(), format!("{} must be true or false", entry.key(key)))
            .value(show(value.get_ref()))
    })
}

fn texts(entry: &Section<'_>, key: &str) -> Result<Option<Vec<String>>> {
    let Some(value) = entry.get(key) else { return Ok(None) };
    let wrong = |found: String| {
        entry
            .source
            .fault(&value.span(), format!("{} must be a list of texts", entry.key(key)))
            .value(found)
            .remedy("such as columns = [\"t_us\", \"bx_uT\", \"by_uT\", \"bz_uT\"]")
    };
    let list = value.get_ref().as_array().ok_or_else(|| wrong(show(value.get_ref())))?;
    let one = |value: &toml::Spanned<DeValue<'_>>| match value.get_ref().as_str() {
        Some(text) => Ok(text.trim().to_owned()),
        None => Err(wrong(show(value.get_ref()))),
    };
    list.iter().map(one).collect::<Result<Vec<_>>>().map(Some)
}

/// The method with the options of the table `options`.
fn method(top: &Section<'_>) -> Result<Method> {
    let mut method = match top.text("method")? {
        Some(name) => Method::named(name).map_err(|e| {
            at(top, "method", e.into_data()).remedy(did_you_mean(name, &Method::all().each_ref().map(Method::name)))
        })?,
        None => Method::default(),
    };
    let Some(options) = top.section("options")? else { return Ok(method) };
    let names: Vec<&str> = method.settings().iter().map(|setting| setting.name).collect();
    options.only(&names)?;
    for name in names.into_iter().filter(|name| options.get(name).is_some()) {
        let kind = method.settings().into_iter().find(|s| s.name == name).map(|setting| match setting.field {
            Slot::Count(_) => 0,
            Slot::Choice(_) => 1,
            Slot::Region(_) => 2,
            Slot::Number(_) | Slot::OptionalNumber(..) => 3,
        });
        let value = match kind {
            Some(0) => SettingValue::Count(options.whole(name)?.unwrap_or_default() as usize),
            Some(1) => SettingValue::Choice(options.text(name)?.unwrap_or_default().to_owned()),
            Some(2) => SettingValue::Region(region(&options, name)?),
            _ => SettingValue::Number(number(&options, name)?),
        };
        method.set(name, value).map_err(|e| at(&options, name, e.into_data()))?;
    }
    method.check().map_err(|e| at(top, "options", e.into_data()))?;
    Ok(method)
}

fn number(options: &Section<'_>, name: &str) -> Result<f64> {
    let any = Allowed { holds: |v| !v.is_nan(), text: "a number", remedy: "" };
    Ok(options.number(name, Dimension::Ratio, &any)?.unwrap_or_default())
}

fn region(options: &Section<'_>, name: &str) -> Result<[[f64; 2]; 3]> {
    let wrong = || {
        options
            .source
            .fault(&options.span_of(name), format!("{} must be six numbers", options.key(name)))
            .remedy("least x, largest x, least y, largest y (m), least heading, largest heading (rad)")
    };
    let list = options.get(name).and_then(|value| value.get_ref().as_array()).ok_or_else(wrong)?;
    let values: Vec<f64> = list
        .iter()
        .map(|value| match value.get_ref() {
            DeValue::Float(f) => f.as_str().parse::<f64>().ok(),
            DeValue::Integer(i) => i.as_str().parse::<f64>().ok(),
            _ => None,
        })
        .collect::<Option<_>>()
        .ok_or_else(wrong)?;
    let [a, b, c, d, e, f] = values[..] else { return Err(wrong()) };
    Ok([[a, b], [c, d], [e, f]])
}
