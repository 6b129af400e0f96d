//! The robot's TOML file.

mod beam;

use super::text::{did_you_mean, line_at, read_text};
use super::units::{Dimension, parse_quantity};
use super::{MomentNoise, MountedWhisker, Odometry, Robot};
use crate::plane::Pose2;
use crate::{Error, Result};
use beam::beam;
use core::f64::consts::TAU;
use core::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

const WHISKER_KEYS: [&str; 14] = [
    "name",
    "length",
    "flexural_rigidity",
    "young_modulus",
    "diameter",
    "tip_ratio",
    "curvature",
    "segments",
    "base_stiffness",
    "strain_limit",
    "mount",
    "friction",
    "calibration",
    "noise",
];

/// Above this disagreement, a flexural rigidity given beside modulus and diameter contradicts them.
const RIGIDITY_AGREEMENT: f64 = 0.01;

impl Robot {
    /// Reads a robot file (`.toml`). A relative `calibration` path is taken from the file's folder.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or is at fault; the message names file, line, value, allowed range and remedy.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let mut robot = Self::from_toml(&read_text(path, "robot")?, &path.to_string_lossy())?;
        if let Some(folder) = path.parent() {
            for calibration in robot.whiskers.iter_mut().filter_map(|w| w.calibration.as_mut()) {
                *calibration = folder.join(&*calibration);
            }
        }
        Ok(robot)
    }

    /// The robot in a TOML text; `name` stands for the file in messages.
    ///
    /// A bare number is SI; a string carries its unit. What is missing is the paper's whisker, so the empty text is
    /// the paper's sensor.
    ///
    /// # Errors
    ///
    /// As [`Robot::read`].
    pub fn from_toml(text: &str, name: &str) -> Result<Self> {
        Self::parse_toml(text, name)
            .map_err(|e| e.or_remedy("correct the line; docs/files.md lists every key with its unit and range"))
    }

    fn parse_toml(text: &str, name: &str) -> Result<Self> {
        let source = Source { text: text.strip_prefix('\u{feff}').unwrap_or(text), name };
        let root = DeTable::parse(source.text).map_err(|e| {
            let line = e.span().map_or(1, |span| source.line(&span));
            Error::data("not valid TOML").in_file(name).at_line(line).value(e.message())
        })?;
        let top = Section { source: &source, table: root.get_ref(), path: String::new(), span: root.span() };
        top.only(&["whisker", "odometry"])?;
        let odometry = match top.section("odometry")? {
            Some(section) => odometry(&section)?,
            None => Odometry::default(),
        };
        let whiskers = whiskers(&top)?;
        Ok(Self { whiskers, odometry })
    }
}

struct Source<'a> {
    text: &'a str,
    name: &'a str,
}

impl Source<'_> {
    fn line(&self, span: &Range<usize>) -> usize {
        line_at(self.text.as_bytes(), span.start)
    }

    fn fault(&self, span: &Range<usize>, what: impl Into<String>) -> Error {
        Error::data(what).in_file(self.name).at_line(self.line(span))
    }
}

/// Where a number must lie, and how to say so.
struct Allowed {
    holds: fn(f64) -> bool,
    text: &'static str,
    remedy: &'static str,
}

const POSITIVE: Allowed = Allowed { holds: |v| v > 0.0 && v.is_finite(), text: "above 0", remedy: "" };
const FINITE: Allowed = Allowed { holds: f64::is_finite, text: "a finite number", remedy: "" };
const NOT_NEGATIVE: Allowed = Allowed { holds: |v| v >= 0.0 && v.is_finite(), text: "0 or more", remedy: "" };
const TIP_RATIO: Allowed = Allowed {
    holds: |v| (1e-3..=1.0).contains(&v),
    text: "0.001 to 1",
    remedy: "tip radius divided by base radius; a sharp tip needs a small number such as 0.05",
};
const STIFFNESS: Allowed = Allowed { holds: |v| v > 0.0, text: "above 0, or inf", remedy: "a clamped base is inf" };
const FRACTION: Allowed =
    Allowed { holds: |v| (0.0..1.0).contains(&v), text: "0 or more, below 1", remedy: "5 % is 0.05 or \"5 %\"" };
const LENGTH: Allowed = Allowed {
    holds: |v| v > 0.0 && v <= 10.0,
    text: "above 0, up to 10 m",
    remedy: "a bare number is in metres; write \"75 mm\" for millimetres",
};
const DIAMETER: Allowed = Allowed {
    holds: |v| v > 0.0 && v <= 0.1,
    text: "above 0, up to 0.1 m",
    remedy: "a bare number is in metres; write \"0.58 mm\" for millimetres",
};
const MOUNT: Allowed = Allowed {
    holds: |v| v.abs() <= 100.0,
    text: "-100 to 100 m",
    remedy: "a bare number is in metres; write \"75 mm\" for millimetres",
};
const HEADING: Allowed = Allowed {
    holds: |v| v.abs() <= TAU,
    text: "-2 pi to 2 pi rad",
    remedy: "a bare number is in radians; write \"90 deg\" for degrees",
};

/// One table of the file, with its path for messages.
struct Section<'a> {
    source: &'a Source<'a>,
    table: &'a DeTable<'a>,
    path: String,
    span: Range<usize>,
}

impl<'a> Section<'a> {
    fn key(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.table.get(key)
    }

    /// Rejects every key but `known`, the first in the file first.
    fn only(&self, known: &[&str]) -> Result<()> {
        let unknown = |key: &&Spanned<_>| !known.contains(&Spanned::<std::borrow::Cow<'_, str>>::get_ref(key).as_ref());
        match self.table.keys().filter(unknown).min_by_key(|key| key.span().start) {
            Some(key) => {
                let word = key.get_ref().as_ref();
                Err(self
                    .source
                    .fault(&key.span(), "unknown key")
                    .value(self.key(word))
                    .remedy(did_you_mean(word, known)))
            }
            None => Ok(()),
        }
    }

    fn section(&self, key: &str) -> Result<Option<Section<'a>>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref().as_table() {
            Some(table) => Ok(Some(Section { source: self.source, table, path: self.key(key), span: value.span() })),
            None => Err(self.source.fault(&value.span(), format!("{} must be a table", self.key(key)))),
        }
    }

    fn text(&self, key: &str) -> Result<Option<&'a str>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(text) if !text.trim().is_empty() => Ok(Some(text.trim())),
            _ => Err(self
                .source
                .fault(&value.span(), format!("{} must be a text in quotes", self.key(key)))
                .value(show(value.get_ref()))),
        }
    }

    fn number(&self, key: &str, dimension: Dimension, allowed: &Allowed) -> Result<Option<f64>> {
        self.get(key).map(|value| self.quantity(&self.key(key), value, dimension, allowed)).transpose()
    }

    /// A number in SI or a text with a unit, checked.
    fn quantity(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        dimension: Dimension,
        allowed: &Allowed,
    ) -> Result<f64> {
        let raw = value.get_ref();
        let fault = |what: String| self.source.fault(&value.span(), what);
        let number = match raw {
            DeValue::Float(f) => f.as_str().parse::<f64>().ok(),
            DeValue::Integer(i) if i.radix() == 10 => i.as_str().parse::<f64>().ok(),
            DeValue::String(text) => Some(
                parse_quantity(text, dimension)
                    .map_err(|e| e.about(key).in_file(self.source.name).at_line(self.source.line(&value.span())))?,
            ),
            _ => None,
        };
        let Some(number) = number else {
            let example = format!("1.5 or \"1.5 {}\"", dimension.allowed()[0]);
            return Err(fault(format!("{key} must be a number or a text with a unit"))
                .value(show(raw))
                .allowed(if dimension == Dimension::Ratio { "0.05 or \"5 %\"".to_owned() } else { example }));
        };
        if (allowed.holds)(number) {
            return Ok(number);
        }
        let shown = match raw {
            DeValue::String(_) => format!("{} = {number} {}", show(raw), dimension.unit()),
            _ => format!("{} {}", show(raw), dimension.unit()),
        };
        let error = fault(format!("{key} is out of range")).value(shown.trim()).allowed(allowed.text);
        // Remedies are about units and ranges; a negative number has neither mistaken.
        Err(if allowed.remedy.is_empty() || number.is_nan() || number < 0.0 {
            error
        } else {
            error.remedy(allowed.remedy)
        })
    }
}

/// A value as the file's author wrote it, roughly.
fn show(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(s) => format!("\"{s}\""),
        DeValue::Integer(i) => i.to_string(),
        DeValue::Float(f) => f.as_str().to_owned(),
        DeValue::Boolean(b) => b.to_string(),
        other => format!("{} here", other.type_str()),
    }
}

fn odometry(section: &Section<'_>) -> Result<Odometry> {
    section.only(&["translation_relative", "rotation_relative"])?;
    let default = Odometry::default();
    let ratio = |key| section.number(key, Dimension::Ratio, &FRACTION);
    Ok(Odometry {
        translation_relative: ratio("translation_relative")?.unwrap_or(default.translation_relative),
        rotation_relative: ratio("rotation_relative")?.unwrap_or(default.rotation_relative),
    })
}

fn whiskers(top: &Section<'_>) -> Result<Vec<MountedWhisker>> {
    let Some(value) = top.get("whisker") else { return Ok(Robot::default().whiskers) };
    let fault = |span: &Range<usize>, what: &str| top.source.fault(span, what);
    let Some(list) = value.get_ref().as_array() else {
        return Err(
            fault(&value.span(), "a whisker is written as a list entry").remedy("write [[whisker]], not [whisker]")
        );
    };
    if list.is_empty() {
        return Err(fault(&value.span(), "the robot has no whisker")
            .remedy("add a [[whisker]] section, or leave the key out for the paper's whisker"));
    }
    let mut whiskers: Vec<MountedWhisker> = Vec::new();
    for (index, entry) in list.iter().enumerate() {
        let Some(table) = entry.get_ref().as_table() else {
            return Err(fault(&entry.span(), "a whisker must be a table").remedy("write [[whisker]] sections"));
        };
        let path = if list.len() == 1 { "whisker".to_owned() } else { format!("whisker[{index}]") };
        let section = Section { source: top.source, table, path, span: entry.span() };
        let whisker = whisker(&section, index)?;
        if whiskers.iter().any(|w| w.name == whisker.name) {
            let span = section.get("name").map_or(section.span.clone(), Spanned::span);
            return Err(fault(&span, "two whiskers have the same name")
                .value(format!("\"{}\"", whisker.name))
                .remedy("give each whisker a name of its own; the log's columns are named after it"));
        }
        whiskers.push(whisker);
    }
    Ok(whiskers)
}

fn whisker(section: &Section<'_>, index: usize) -> Result<MountedWhisker> {
    section.only(&WHISKER_KEYS)?;
    let number = |key, dimension, allowed: &Allowed| section.number(key, dimension, allowed);
    let mounted = MountedWhisker::default();
    Ok(MountedWhisker {
        name: name(section, index)?,
        beam: beam(section)?,
        robot_from_whisker: mount(section)?.unwrap_or(mounted.robot_from_whisker),
        friction: number("friction", Dimension::Ratio, &NOT_NEGATIVE)?.unwrap_or(mounted.friction),
        calibration: section.text("calibration")?.map(PathBuf::from),
        noise: section.section("noise")?.map_or(Ok(mounted.noise), |s| noise(&s))?,
    })
}

fn name(section: &Section<'_>, index: usize) -> Result<String> {
    let Some(name) = section.text("name")? else { return Ok(format!("w{index}")) };
    if name.contains(['.', ',']) || name.contains(char::is_whitespace) {
        let span = section.get("name").map_or(section.span.clone(), Spanned::span);
        return Err(section
            .source
            .fault(&span, "a whisker's name cannot hold dots, commas or spaces")
            .value(format!("\"{name}\""))
            .remedy("the log's columns are NAME.moment; use letters, digits, - and _"));
    }
    Ok(name.to_owned())
}

fn noise(section: &Section<'_>) -> Result<MomentNoise> {
    section.only(&["moment_relative", "moment_absolute"])?;
    let default = MomentNoise::default();
    Ok(MomentNoise {
        moment_relative: section
            .number("moment_relative", Dimension::Ratio, &FRACTION)?
            .unwrap_or(default.moment_relative),
        moment_absolute: section
            .number("moment_absolute", Dimension::Moment, &NOT_NEGATIVE)?
            .unwrap_or(default.moment_absolute),
    })
}

fn mount(section: &Section<'_>) -> Result<Option<Pose2>> {
    let Some(value) = section.get("mount") else { return Ok(None) };
    let key = section.key("mount");
    let parts: &[_] = value.get_ref().as_array().map_or(&[], |a| a);
    let [x, y, theta] = parts else {
        return Err(section
            .source
            .fault(&value.span(), format!("{key} must be three values: x, y, theta"))
            .allowed("[0.05, 0.0, 1.5708] or [\"50 mm\", 0, \"90 deg\"]"));
    };
    let length = |v, part| section.quantity(&format!("{key} {part}"), v, Dimension::Length, &MOUNT);
    let heading = section.quantity(&format!("{key} theta"), theta, Dimension::Angle, &HEADING)?;
    Ok(Some(Pose2::new(length(x, "x")?, length(y, "y")?, heading)))
}
