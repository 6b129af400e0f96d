//! The scenario's TOML file.

use super::{LegStart, Scenario, check, errors_section, noise_section, path_section, sensing_section, world_section};
use crate::config::budgets::TOML_BYTES;
use crate::io::text::read_text;
use crate::io::toml_section::{Section, Source};
use crate::{Error, Result};
use std::path::Path;

const KEYS: [&str; 11] =
    ["title", "map", "robot", "whisker", "odometry", "outline", "path", "sensing", "noise", "errors", "seed"];

impl Scenario {
    /// Reads a scenario file (`.toml`); the paths of map and robot in it start at its folder.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, a key or value at fault, or a path that is not free: the message names file, line,
    /// value, allowed range and remedy, and for paths the place on the map and the time.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_toml(&read_text(path, "scenario", TOML_BYTES)?, &path.to_string_lossy(), folder)
    }

    /// The scenario in a TOML text; `name` stands for the file in messages, `folder` is where its paths start.
    ///
    /// # Errors
    ///
    /// As [`Scenario::read`].
    pub fn from_toml(text: &str, name: &str, folder: impl AsRef<Path>) -> Result<Self> {
        parse(text, name, folder.as_ref())
            .map_err(|e| e.or_remedy("correct the line; docs/scenarios.md lists every key with its unit and range"))
    }
}

fn parse(text: &str, name: &str, folder: &Path) -> Result<Scenario> {
    let source = Source::new(text, name);
    let root = source.parse()?;
    let top = Section::top(&source, &root);
    top.only(&KEYS)?;
    let map = world_section::map(&top, folder)?;
    let robot = world_section::robot(&top, folder)?;
    let outline = world_section::outline(&top, &robot)?;
    let path_table = top.section("path")?.ok_or_else(|| {
        Error::data("the scenario has no path").in_file(name).remedy("add a [path] section with waypoints")
    })?;
    let way = path_section::way(&path_table, &map)?;
    let sensing = match top.section("sensing")? {
        Some(section) => sensing_section::sensing(&section, &robot, way.rate)?,
        None => sensing_section::Sensing::default(),
    };
    let mut recorder = match top.section("noise")? {
        Some(section) => noise_section::recorder(&section)?,
        None => crate::simulate::recorder::Recorder::default(),
    };
    recorder.noise.seed = top.whole("seed")?.unwrap_or(1);
    (recorder.magnetometer, recorder.columns) = (sensing.magnetometer, sensing.columns);
    recorder.strip_cell = sensing.strip_cell;
    recorder.heading_noise = sensing.heading_noise;
    if let Some(section) = top.section("errors")? {
        recorder.truth = errors_section::truth(&section, &robot, recorder.heading_noise.is_some())?;
    }
    let scenario = Scenario {
        title: top.text("title")?.map_or_else(|| stem(name), str::to_owned),
        map,
        map_file: world_section::map_file(&top, folder)?,
        robot,
        outline,
        path: way.poses,
        recorder,
        serial: sensing.serial,
        source: name.into(),
        legs: way.legs,
    };
    check::free(&scenario).map_err(|fault| at_line(fault.error, &scenario, fault.t).in_file(name))?;
    Ok(scenario)
}

fn stem(name: &str) -> String {
    Path::new(name).file_stem().map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// Adds the line of the leg that the robot is on at the time `t`.
fn at_line(error: Error, scenario: &Scenario, t: f64) -> Error {
    let leg = scenario.legs.iter().rev().find(|leg: &&LegStart| leg.t < t || leg.t <= 0.0);
    leg.map_or(error.clone(), |leg| error.at_line(leg.line))
}
