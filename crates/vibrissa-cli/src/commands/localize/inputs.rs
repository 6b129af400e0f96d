//! The files that a localization reads.

use std::path::Path;
use vibrissa::figure::Outline;
use vibrissa::flow::pose::{Localization, StampedPose};
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::flow::trajectory::read_tum;
use vibrissa::world::Robot;
use vibrissa::{Error, LocalizeOptions, Result};

/// What a localization works on.
pub(super) struct Inputs {
    log: SensorLog,
    map: Map,
    robot: Robot,
    title: String,
    pub(super) truth: Option<Vec<StampedPose>>,
}

impl Inputs {
    /// Reads every file; the first fault ends it.
    pub(super) fn read(log: &Path, map: &Path, robot: Option<&Path>, truth: Option<&Path>) -> Result<Self> {
        Ok(Self {
            title: format!("{} on {}", file_name(log), file_name(map)),
            map: read_map(map)?,
            robot: robot.map_or_else(|| Ok(Robot::default()), read_robot)?,
            log: read_log(log)?,
            truth: truth.map(read_tum).transpose()?,
        })
    }

    /// What looked wrong but could be read.
    pub(super) fn warnings(&self) -> impl Iterator<Item = &str> {
        self.log.warnings.iter().map(String::as_str)
    }

    /// The answer; `observer` is called after each row.
    pub(super) fn localize(&self, options: &LocalizeOptions, observer: &mut dyn FnMut(usize)) -> Result<Localization> {
        vibrissa::localize(&self.log, &self.robot, options, observer)
    }

    /// The headline of the figure.
    pub(super) fn title(&self) -> String {
        self.title.clone()
    }

    /// How many rows the log has.
    pub(super) fn rows(&self) -> usize {
        self.log.rows.len()
    }

    /// The map as lines to draw.
    pub(super) fn outlines(&self) -> Vec<Outline> {
        self.map.clone()
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Stands in until the library reads maps.
type Map = Vec<Outline>;

fn read_map(path: &Path) -> Result<Map> {
    Err(not_yet("maps", path))
}

fn read_robot(path: &Path) -> Result<Robot> {
    Err(not_yet("robots", path))
}

fn read_log(path: &Path) -> Result<SensorLog> {
    Err(not_yet("sensor logs", path))
}

fn not_yet(what: &str, path: &Path) -> Error {
    Error::data(format!("{what} cannot be read yet")).in_file(path).remedy("use a later version")
}
