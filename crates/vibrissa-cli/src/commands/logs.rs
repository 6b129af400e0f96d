//! How sensor logs are read, and with which robot and truth, as every command that takes logs understands it.

use crate::output::warn;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use vibrissa::Result;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::io::log::ImuTopics;
use vibrissa::io::log::foreign::{Format, Recording};
use vibrissa::tasks::doubts;
use vibrissa::world::{Map, Robot};

/// What is told about a log's file beside its path.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct ImuArgs {
    /// Of a recording (.mcap): the topic of `sensor_msgs/Imu` whose orientation is the robot's heading in the map frame
    #[arg(long, value_name = "TOPIC", conflicts_with = "format")]
    headings: Option<String>,
    /// Of a recording (.mcap): the topic of `sensor_msgs/Imu` whose angular velocity about z says how the robot turns, instead of
    /// the odometry
    #[arg(long, value_name = "TOPIC", conflicts_with = "format")]
    yaw_rates: Option<String>,
}

/// A robot, and how its logs are written.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct LogArgs {
    /// The robot's whiskers and error bounds (.toml) [default: the paper's whisker at the robot's origin]
    #[arg(long, value_name = "ROBOT")]
    pub(super) robot: Option<PathBuf>,
    /// The format of a log that is not ours: rostopic (odometry and wrench or magnetic field) [default: our .csv]
    #[arg(long, value_name = "FORMAT")]
    format: Option<Format>,
    #[command(flatten)]
    imu: ImuArgs,
}

impl LogArgs {
    /// A log of this robot.
    pub(super) fn read(&self, path: &Path) -> Result<SensorLog> {
        read_log(path, self.format, &self.imu)
    }
}

/// Logs of which an outline is made, and what it is compared with.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct OutlineArgs {
    #[command(flatten)]
    log: LogArgs,
    /// The true shape (.geojson, .svg, .dxf, .yaml, .mcap), to report errors against
    #[arg(long, value_name = "MAP")]
    truth: Option<PathBuf>,
}

/// The same, read.
pub(super) struct Felt {
    pub(super) robot: Robot,
    pub(super) logs: Vec<SensorLog>,
    pub(super) truth: Option<Map>,
}

impl OutlineArgs {
    /// Reads every file; the first fault ends it. What looks wrong but could be read is warned of.
    pub(super) fn read(&self, logs: &[PathBuf]) -> Result<Felt> {
        let robot = self.log.robot.as_deref().map_or_else(|| Ok(Robot::default()), vibrissa::read_robot)?;
        let truth = self.truth.as_deref().map(vibrissa::read_map).transpose()?;
        let logs = logs.iter().map(|log| self.log.read(log)).collect::<Result<Vec<SensorLog>>>()?;
        let warnings = truth.iter().flat_map(|map| &map.warnings).chain(logs.iter().flat_map(|log| &log.warnings));
        warnings.for_each(|warning| warn(warning));
        let doubted = logs.iter().flat_map(|log| doubts(Some(log), &robot, None)).collect::<BTreeSet<String>>();
        doubted.iter().for_each(|warning| warn(warning));
        Ok(Felt { robot, logs, truth })
    }
}

/// A log in our own format, or in a foreign one with a warning of what was repaired.
pub(super) fn read_log(path: &Path, format: Option<Format>, imu: &ImuArgs) -> Result<SensorLog> {
    match format {
        Some(format) => Recording::read(path, format)?.to_log(),
        None => {
            let topics = ImuTopics { headings: imu.headings.clone(), yaw_rates: imu.yaw_rates.clone() };
            vibrissa::io::log::read_with(path, &topics)
        }
    }
}
