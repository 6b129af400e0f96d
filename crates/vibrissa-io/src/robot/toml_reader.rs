//! The robot's TOML file.

use super::beam::beam;
use super::errors::{DELAY, whisker_errors};
use super::lean::{lean, leaning};
use crate::Result;
use crate::config::budgets::{LONGEST_NAME, MOST_WHISKERS, TOML_BYTES};
use crate::plane::Pose2;
use crate::text::{beyond, read_text};
use crate::toml_section::{Allowed, FRACTION, HEADING, MOUNT, NOT_NEGATIVE, Section, Source};
use crate::units::Dimension;
use crate::world::{MomentNoise, MountedWhisker, Odometry, ReadingNoise, Robot};
use core::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

const WHISKER_KEYS: [&str; 23] = [
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
    "mount_height",
    "elevation",
    "roll",
    "friction",
    "calibration",
    "noise",
    "zero_error",
    "zero_drift_error",
    "mount_error",
    "length_error",
    "stiffness_error",
    "gain_error",
];

/// Above this disagreement, a flexural rigidity given beside modulus and diameter contradicts them.
pub(super) const RIGIDITY_AGREEMENT: f64 = 0.01;

/// Reads a robot file (`.toml`). A relative `calibration` path is taken from the file's folder.
///
/// # Errors
///
/// A file that cannot be read or is at fault; the message names file, line, value, allowed range and remedy.
pub fn read(path: impl AsRef<Path>) -> Result<Robot> {
    let path = path.as_ref();
    let mut robot = from_toml(&read_text(path, "robot", TOML_BYTES)?, &path.to_string_lossy())?;
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
/// As [`read`].
pub fn from_toml(text: &str, name: &str) -> Result<Robot> {
    parse(text, name)
        .map_err(|e| e.or_remedy("correct the line; docs/files.md lists every key with its unit and range"))
}

fn parse(text: &str, name: &str) -> Result<Robot> {
    let source = Source::new(text, name);
    let root = source.parse()?;
    let top = Section::top(&source, &root);
    top.only(&["whisker", "body", "odometry", "map"])?;
    let odometry = match top.section("odometry")? {
        Some(section) => odometry_section(&section)?,
        None => Odometry::default(),
    };
    let whiskers = whisker_entries(&top)?;
    let map_scale = match top.section("map")? {
        Some(section) => {
            section.only(&["scale_error"])?;
            map_scale(&section)?
        }
        None => Robot::default().map_scale,
    };
    let robot = Robot { whiskers, odometry, map_scale };
    leaning(&top, robot)
}

/// The bound on the map's scale in a `[map]` section.
pub fn map_scale(section: &Section<'_>) -> Result<f64> {
    Ok(section.number("scale_error", Dimension::Ratio, &FRACTION)?.unwrap_or(Robot::default().map_scale))
}

pub(super) const TIP_RATIO: Allowed = Allowed {
    holds: |v| (1e-3..=1.0).contains(&v),
    text: "0.001 to 1",
    remedy: "tip radius divided by base radius; a sharp tip needs a small number such as 0.05",
};
pub(super) const STIFFNESS: Allowed =
    Allowed { holds: |v| v > 0.0, text: "above 0, or inf", remedy: "a clamped base is inf" };
pub(super) const DIAMETER: Allowed = Allowed {
    holds: |v| v > 0.0 && v <= 0.1,
    text: "above 0, up to 0.1 m",
    remedy: "a bare number is in metres; write \"0.58 mm\" for millimetres",
};
/// The bounds in an `[odometry]` section.
pub fn odometry_section(section: &Section<'_>) -> Result<Odometry> {
    section.only(&["translation_relative", "rotation_relative", "delay_error"])?;
    let default = Odometry::default();
    let ratio = |key| section.number(key, Dimension::Ratio, &FRACTION);
    Ok(Odometry {
        translation_relative: ratio("translation_relative")?.unwrap_or(default.translation_relative),
        rotation_relative: ratio("rotation_relative")?.unwrap_or(default.rotation_relative),
        delay: section.number("delay_error", Dimension::Time, &DELAY)?.unwrap_or(default.delay),
    })
}

/// The whiskers in the `[[whisker]]` entries of a file; the paper's where there are none.
pub fn whisker_entries(top: &Section<'_>) -> Result<Vec<MountedWhisker>> {
    let Some(value) = top.get("whisker") else { return Ok(Robot::default().whiskers) };
    let fault = |span: &Range<usize>, what: &str| top.source.fault(span, what);
    let Some(list) = value.get_ref().as_array() else {
        return Err(
            fault(&value.span(), "a whisker is written as a list entry").remedy("write [[whisker]], not [whisker]")
        );
    };
    if list.len() > MOST_WHISKERS {
        let remedy = "leave out those that are not used";
        return Err(beyond("the robot has too many whiskers", list.len(), MOST_WHISKERS, remedy)
            .in_file(top.source.name)
            .at_line(top.source.line(&value.span())));
    }
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
    let beam = beam(section)?;
    Ok(MountedWhisker {
        name: name(section, index)?,
        errors: whisker_errors(section, beam.length)?,
        beam,
        robot_from_whisker: mount(section)?.unwrap_or(mounted.robot_from_whisker),
        lean: lean(section)?,
        friction: number("friction", Dimension::Ratio, &NOT_NEGATIVE)?.unwrap_or(mounted.friction),
        calibration: section.text("calibration")?.map(PathBuf::from),
        ..section.section("noise")?.map_or(Ok(mounted), |s| noise(&s))?
    })
}

fn name(section: &Section<'_>, index: usize) -> Result<String> {
    let Some(name) = section.text("name")? else { return Ok(format!("w{index}")) };
    if name.len() > LONGEST_NAME {
        let remedy = "give it a short name; the log's columns are named after it";
        return Err(beyond("a whisker's name is too long", format!("{} bytes", name.len()), LONGEST_NAME, remedy)
            .in_file(section.source.name)
            .at_line(section.line_of("name")));
    }
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

/// The default whisker with these bounds on its readings.
fn noise(section: &Section<'_>) -> Result<MountedWhisker> {
    section.only(&[
        "moment_relative",
        "moment_absolute",
        "force_relative",
        "force_absolute",
        "slope_relative",
        "slope_absolute",
    ])?;
    let default = MountedWhisker::default();
    let bound = |relative, absolute, dimension, default: ReadingNoise| -> Result<ReadingNoise> {
        Ok(ReadingNoise {
            relative: section.number(relative, Dimension::Ratio, &FRACTION)?.unwrap_or(default.relative),
            absolute: section.number(absolute, dimension, &NOT_NEGATIVE)?.unwrap_or(default.absolute),
        })
    };
    let moment = bound("moment_relative", "moment_absolute", Dimension::Moment, default.noise.into())?;
    Ok(MountedWhisker {
        noise: MomentNoise { moment_relative: moment.relative, moment_absolute: moment.absolute },
        force_noise: bound("force_relative", "force_absolute", Dimension::Force, default.force_noise)?,
        slope_noise: bound("slope_relative", "slope_absolute", Dimension::Angle, default.slope_noise)?,
        ..default
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
