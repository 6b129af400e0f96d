//! Logs from recordings with ROS 2 messages (MCAP).
//!
//! Each reading gives a row; odometry is interpolated at its time. Times are those of the messages' headers.

use super::ImuTopics;
use super::bag_imu::{self, ImuTrack};
use super::columns::channel;
use super::doubts::Doubts;
use crate::config::budgets::MOST_MESSAGES;
use crate::config::limits::{LARGEST_ODOMETRY, ODOMETRY_GAP};
use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use crate::plane::{Pose2, Twist2};
use crate::ros::{self, BagSummary, Header, Kind, Stamp};
use crate::text::{counted, listed, open};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The messages of one topic in order of time: stamps and numbers.
#[derive(Clone, Debug, Default)]
struct Track {
    rows: Vec<(f64, [f64; 3])>,
    dropped: usize,
    unstamped: bool,
}

/// All that a recording holds for us, by topic.
#[derive(Default)]
struct Tracks {
    odometry: BTreeMap<String, Track>,
    readings: BTreeMap<(String, bool), Track>,
    units: BTreeMap<String, ImuTrack>,
    /// Rows of a live run, with the names of their numbers.
    rows: Vec<LogRow>,
    names: Vec<String>,
    damaged: usize,
    /// How many messages are kept, rows of a live run by their numbers.
    kept: usize,
}

/// The topic of the rows that an estimator took during a live run.
const ROW: &str = "/vibrissa/row";
/// What a row holds in front of its readings.
const FRONT: [&str; 6] = ["row", "merged", "t", "x", "y", "theta"];

/// The error for more messages than are kept.
pub(super) fn too_many_messages() -> Error {
    Error::data("the recording has too many messages of readings and odometry")
        .value(format!("more than {MOST_MESSAGES}"))
        .allowed(format!("up to {MOST_MESSAGES}"))
        .remedy("cut it into parts: `mcap filter --start … --end …`")
}

/// The recording in a folder that holds exactly one.
pub(super) fn only_recording(folder: &Path) -> Option<PathBuf> {
    let is_recording = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "mcap");
    let mut recordings =
        std::fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path())).filter(is_recording);
    let only = recordings.next()?;
    recordings.next().is_none().then_some(only)
}

/// Reads a recording (`.mcap`).
pub(super) fn read_mcap(path: &Path, imu: &ImuTopics) -> Result<SensorLog> {
    let file = open(path, "log")?;
    from_mcap_with(file, &path.to_string_lossy(), imu)
}

/// The log in an MCAP recording of ROS 2 messages; `name` stands for the file in messages.
///
/// | message | gives |
/// | --- | --- |
/// | `nav_msgs/Odometry` | the robot in the odometry frame |
/// | `geometry_msgs/WrenchStamped` | `moment`: the torque about z at the whisker's base, counter-clockwise positive |
/// | `sensor_msgs/MagneticField` | `bx`, `by`, `bz` |
/// | `sensor_msgs/Imu` | `heading`, or turns instead of the odometry's, where its topic is named ([`from_mcap_with`]) |
/// | `sensor_msgs/JointState` on `/vibrissa/row` | all: the rows that a live run took, in the place of everything else |
///
/// The whisker's name is the part of the topic before a last part `wrench` or `magnetic_field`, otherwise its last
/// part; a single topic of readings outside `/whisker/NAME/…` leaves it open. The topic with most readings gives the
/// rows; odometry and other readings are interpolated at their times. Rows outside the odometry are left out.
///
/// # Errors
///
/// What is not such a recording, holds no odometry or no readings, or several topics of odometry.
pub fn from_mcap(source: impl Read, name: &str) -> Result<SensorLog> {
    from_mcap_with(source, name, &ImuTopics::default())
}

/// As [`from_mcap`], with what these topics of `sensor_msgs/Imu` tell.
///
/// # Errors
///
/// As [`from_mcap`]; a topic that is not there or does not measure what it is named for.
pub fn from_mcap_with(source: impl Read, name: &str, imu: &ImuTopics) -> Result<SensorLog> {
    let mut tracks = Tracks::default();
    let bag = ros::read_bag(source, name, |topic, logged, bytes| {
        if tracks.kept >= MOST_MESSAGES {
            return Err(too_many_messages());
        }
        if let Some(kind) = topic.kind {
            tracks.take(kind, &topic.name, logged, bytes);
        }
        Ok(())
    })?;
    let log = tracks.log(bag, name, imu).map_err(|error| error.in_file(name))?;
    Ok(SensorLog { source: Some(name.into()), ..log })
}

impl Track {
    fn push(&mut self, header: Header, logged: u64, values: [f64; 3]) {
        let t = if header.stamp == Stamp::default() && logged > 0 {
            self.unstamped = true;
            logged as f64 * 1e-9
        } else {
            header.stamp.seconds()
        };
        if values.iter().all(|v| v.is_finite()) {
            self.rows.push((t, values));
        } else {
            self.dropped += 1;
        }
    }

    /// Sorts the messages by time, and keeps the first of each time.
    fn sort(&mut self) {
        let before = self.rows.len();
        self.rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.rows.dedup_by(|later, earlier| later.0 <= earlier.0);
        self.dropped += before - self.rows.len();
    }

    /// The neighbours of a time and how far it lies between them; none outside the track.
    fn around(&self, t: f64) -> Option<([f64; 3], [f64; 3], f64, f64)> {
        let after = self.rows.partition_point(|row| row.0 < t);
        let next = self.rows.get(after)?;
        if next.0 <= t {
            return Some((next.1, next.1, 0.0, 0.0));
        }
        let before = self.rows.get(after.checked_sub(1)?)?;
        let gap = next.0 - before.0;
        Some((before.1, next.1, (t - before.0) / gap, gap))
    }
}

impl Tracks {
    fn take(&mut self, kind: Kind, topic: &str, logged: u64, bytes: &[u8]) {
        let taken = match kind {
            Kind::Odometry => ros::decode_odometry(bytes).map(|(header, pose)| {
                let track = self.odometry.entry(topic.to_owned()).or_default();
                track.push(header, logged, [pose.x, pose.y, pose.theta]);
            }),
            Kind::Wrench => ros::decode_wrench(bytes).map(|(header, moment)| {
                let track = self.readings.entry((topic.to_owned(), false)).or_default();
                track.push(header, logged, [moment, 0.0, 0.0]);
            }),
            Kind::Field => ros::decode_field(bytes).map(|(header, flux)| {
                self.readings.entry((topic.to_owned(), true)).or_default().push(header, logged, flux);
            }),
            Kind::Imu => ros::decode_imu(bytes).map(|(header, reading)| {
                self.units.entry(topic.to_owned()).or_default().push(header, logged, reading);
            }),
            Kind::Joints if topic == ROW => self.row_of_run(bytes),
            _ => Some(()),
        };
        self.damaged += usize::from(taken.is_none());
        self.kept += usize::from(taken.is_some());
    }

    /// A row of a live run, exact.
    fn row_of_run(&mut self, bytes: &[u8]) -> Option<()> {
        let (_, (names, values)) = ros::decode_named(bytes)?;
        let [_, _, t, x, y, theta] = *values.first_chunk()?;
        let headed = names.last() == Some(&"heading");
        let readings = FRONT.len()..names.len() - usize::from(headed);
        if names.get(..FRONT.len()) != Some(&FRONT[..]) || values.iter().any(|value| !value.is_finite()) {
            return None;
        }
        if self.rows.is_empty() {
            self.names = names.get(readings.clone())?.iter().map(|&name| name.to_owned()).collect();
        }
        let is_next = self.rows.last().is_none_or(|last| last.t < t) && readings.len() == self.names.len();
        let row = LogRow {
            t,
            odom_from_robot: Pose2::new(x, y, theta),
            readings: values.get(readings)?.to_vec(),
            heading: headed.then(|| values.last().copied()).flatten(),
            line: 0,
        };
        is_next.then(|| self.rows.push(row))
    }

    /// The log of a live run: the rows that its estimator took.
    fn log_of_run(self, bag: BagSummary) -> Result<SensorLog> {
        let channels: Option<Vec<Channel>> = self.names.iter().map(|name| channel(name)).collect();
        let channels = channels.ok_or_else(|| {
            Error::data("the rows of the live run hold unknown readings")
                .value(listed(&self.names))
                .remedy("read it by the version that recorded it: `vibrissa live --replay`")
        })?;
        let mut warnings = bag.warnings;
        if self.damaged > 0 {
            warnings
                .push(format!("{} dropped: damaged, or not plain CDR", counted(self.damaged, "message", "messages")));
        }
        Ok(SensorLog { channels, rows: self.rows, warnings, ..SensorLog::default() })
    }

    fn log(mut self, bag: BagSummary, name: &str, imu: &ImuTopics) -> Result<SensorLog> {
        if !self.rows.is_empty() {
            return self.log_of_run(bag);
        }
        let mut units = core::mem::take(&mut self.units);
        let mut warnings = bag.warnings.clone();
        let found = |what: &str| {
            let held: Vec<String> = bag.topics.iter().map(|t| format!("{} ({})", t.name, t.kind_name)).collect();
            Error::data(format!("the recording holds no {what}")).value(if held.is_empty() {
                "no topics".to_owned()
            } else {
                format!("its topics are {}", listed(&held))
            })
        };
        self.odometry.values_mut().chain(self.readings.values_mut()).for_each(Track::sort);
        for (topic, track) in self.odometry.iter().chain(self.readings.iter().map(|((topic, _), track)| (topic, track)))
        {
            if track.unstamped {
                warnings.push(format!("{topic}: messages without a time are taken for as old as they were logged"));
            }
            if track.dropped > 0 {
                warnings.push(format!(
                    "{topic}: {} dropped: same time, or not finite",
                    counted(track.dropped, "message", "messages")
                ));
            }
        }
        if self.damaged > 0 {
            warnings
                .push(format!("{} dropped: damaged, or not plain CDR", counted(self.damaged, "message", "messages")));
        }
        self.readings.retain(|_, track| !track.rows.is_empty());
        let odometry = self.only_odometry().ok_or_else(|| {
            found("odometry").allowed("a topic of nav_msgs/msg/Odometry").remedy("record the robot's odometry too")
        })??;
        let Some((_, main)) = self.readings.iter().max_by_key(|(_, track)| track.rows.len()) else {
            return Err(found("readings")
                .allowed("topics of geometry_msgs/msg/WrenchStamped or sensor_msgs/msg/MagneticField")
                .remedy("record the whiskers too; docs/ros.md tells how topics are named"));
        };
        let mut log = SensorLog { channels: self.channels()?, warnings, ..SensorLog::default() };
        let (mut outside, mut gaps, mut doubts) = (0, 0, Doubts::default());
        for &(t, _) in &main.rows {
            let Some((row, gap)) = self.row(t, odometry) else {
                outside += 1;
                continue;
            };
            gaps += usize::from(gap > ODOMETRY_GAP);
            let row = LogRow { line: 0, ..row };
            if row.odom_from_robot.x.abs().max(row.odom_from_robot.y.abs()) > LARGEST_ODOMETRY {
                return Err(Error::data("the odometry is out of range")
                    .value(format!("{:e}, {:e} m", row.odom_from_robot.x, row.odom_from_robot.y))
                    .allowed(format!("-{LARGEST_ODOMETRY:e} to {LARGEST_ODOMETRY:e} m"))
                    .remedy("odometry is in metres"));
            }
            doubts.look(log.rows.len() + 1, &row, row.odom_from_robot.theta, log.rows.last(), &log.channels);
            log.rows.push(row);
        }
        if log.rows.is_empty() {
            return Err(Error::data("odometry and readings share no time")
                .value(format!("odometry {}, readings {}", span(odometry), span(main)))
                .remedy("stamp both by the same clock"));
        }
        bag_imu::apply(&mut log.rows, &mut units, imu, &mut log.warnings)?;
        if outside > 0 {
            log.warnings
                .push(format!("{} left out: no odometry at their time", counted(outside, "reading", "readings")));
        }
        if gaps > 0 {
            log.warnings.push(format!(
                "{} in gaps of more than {ODOMETRY_GAP} s of the odometry",
                counted(gaps, "reading", "readings")
            ));
        }
        log.warnings.extend(doubts.warnings(name));
        Ok(log)
    }

    /// The topic of odometry; none when there is none, an error when there are several and none is called `/odom`.
    fn only_odometry(&self) -> Option<Result<&Track>> {
        let mut with_rows = self.odometry.iter().filter(|(_, track)| !track.rows.is_empty());
        let first = with_rows.next()?;
        if with_rows.next().is_none() {
            return Some(Ok(first.1));
        }
        let usual = self.odometry.get("/odom").filter(|track| !track.rows.is_empty());
        let topics: Vec<&str> = self.odometry.keys().map(String::as_str).collect();
        Some(usual.ok_or_else(|| {
            Error::data("the recording holds several topics of odometry")
                .value(topics.join(", "))
                .allowed("one, or one called /odom")
                .remedy("`mcap filter` keeps one of the topics")
        }))
    }

    /// The columns of all topics of readings.
    fn channels(&self) -> Result<Vec<Channel>> {
        let alone = self.readings.len() == 1;
        let mut channels: Vec<Channel> = Vec::new();
        for (topic, is_field) in self.readings.keys() {
            let whisker = whisker_name(topic, alone).to_owned();
            let quantities: &[Quantity] =
                if *is_field { &[Quantity::FluxX, Quantity::FluxY, Quantity::FluxZ] } else { &[Quantity::Moment] };
            for &quantity in quantities {
                let channel = Channel { whisker: whisker.clone(), quantity };
                if channels.contains(&channel) {
                    return Err(Error::data("two topics tell of the same whisker")
                        .value(format!("{topic}, of {}", channel.column()))
                        .remedy("name them /whisker/NAME/wrench and /whisker/NAME/magnetic_field"));
                }
                channels.push(channel);
            }
        }
        Ok(channels)
    }

    /// The row of a time, and how large the gap of the odometry around it is (s).
    fn row(&self, t: f64, odometry: &Track) -> Option<(LogRow, f64)> {
        let (before, after, share, gap) = odometry.around(t)?;
        let [before, after] = [before, after].map(|[x, y, theta]| Pose2::new(x, y, theta));
        let step = before.between(after).log();
        let part = Twist2 { x: share * step.x, y: share * step.y, theta: share * step.theta };
        let mut readings = Vec::new();
        for ((_, is_field), track) in &self.readings {
            let (before, after, share, _) = track.around(t)?;
            let count = if *is_field { 3 } else { 1 };
            readings.extend((0..count).map(|k| before[k] + share * (after[k] - before[k])));
        }
        let odom_from_robot = if share > 0.0 { before.compose(Pose2::exp(part)) } else { before };
        Some((LogRow { t, odom_from_robot, readings, heading: None, line: 0 }, gap))
    }
}

fn span(track: &Track) -> String {
    match (track.rows.first(), track.rows.last()) {
        (Some(first), Some(last)) => format!("{} to {} s", first.0, last.0),
        _ => "none".to_owned(),
    }
}

/// The whisker that a topic tells of; the empty name leaves it open.
fn whisker_name(topic: &str, alone: bool) -> &str {
    let parts: Vec<&str> = topic.split('/').filter(|part| !part.is_empty()).collect();
    let inner = match parts[..] {
        [.., name, "wrench" | "magnetic_field"] => name,
        ["wrench" | "magnetic_field"] | [] => "",
        [.., name] => name,
    };
    let said = matches!(parts[..], [.., "whisker", _, "wrench" | "magnetic_field"]);
    if inner == "whisker" || (alone && !said) { "" } else { inner }
}

#[cfg(test)]
mod tests {
    use super::whisker_name;

    #[test]
    fn topics_name_their_whiskers() {
        for (topic, several, alone) in [
            ("/whisker/left/wrench", "left", "left"),
            ("/robot1/whisker/left/magnetic_field", "left", "left"),
            ("/whisker/wrench", "", ""),
            ("/wrench", "", ""),
            ("/left/wrench", "left", ""),
            ("/ft_sensor", "ft_sensor", ""),
            ("", "", ""),
        ] {
            assert_eq!(whisker_name(topic, false), several, "{topic}");
            assert_eq!(whisker_name(topic, true), alone, "{topic}");
        }
    }
}
