//! What a run writes into its recording, and how it is read again.

use crate::estimate::{Told, UsedRow};
use crate::pipeline::Notice;
use crate::record::{RecordTopic, Recorder, Storage};
use crate::setup::{Setup, from_toml};
use crate::source::{Arrived, Chunk};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use vibrissa_core::flow::pose::Status;
use vibrissa_core::flow::sensor_log::Channel;
use vibrissa_io::ros::{
    Header, Kind, Stamp, decode_bytes, decode_named, decode_text, encode_bytes, encode_named, encode_pose, encode_text,
    read_bag,
};
use vibrissa_io::text::cannot_open;

const ROW: &str = "/vibrissa/row";
const ESTIMATE: &str = "/vibrissa/estimate";
/// Which row an estimate is of, and after which the estimator said it.
const TOLD: &str = "/vibrissa/told";
const TOLD_NAMES: [&str; 2] = ["row", "from"];
const SETUP: &str = "/vibrissa/setup";
const RAW: &str = "/raw/";
const EVENT: &str = "/event";
/// The frame of what is in the map, and that of odometry.
const MAP: &str = "map";
const ODOM: &str = "odom";

/// Writes a run down.
#[derive(Debug)]
pub struct Journal {
    recorder: Recorder,
    raw: Vec<(RecordTopic, RecordTopic)>,
    row: RecordTopic,
    estimate: RecordTopic,
    pose: RecordTopic,
    notice: RecordTopic,
    told: RecordTopic,
}

impl Journal {
    /// Begins the recording of a setup whose relative paths start at `folder`.
    #[must_use]
    pub fn begin(storage: impl Storage + 'static, setup: &Setup, folder: &Path, now: f64) -> Self {
        let mut topics: Vec<(String, Kind, bool)> = vec![
            (ROW.into(), Kind::Joints, false),
            (ESTIMATE.into(), Kind::Text, false),
            ("/vibrissa/pose".into(), Kind::PoseWithCovariance, false),
            ("/vibrissa/notice".into(), Kind::Text, false),
            (SETUP.into(), Kind::Text, true),
            (TOLD.into(), Kind::Joints, false),
        ];
        for source in &setup.sources {
            topics.push((format!("{RAW}{}", source.name), Kind::Bytes, false));
            topics.push((format!("{RAW}{}{EVENT}", source.name), Kind::Text, false));
        }
        let (recorder, topics) = Recorder::begin(storage, &topics);
        let told = format!("{}\n{}\n{}", env!("CARGO_PKG_VERSION"), folder.display(), setup.text);
        recorder.push(topics[4], now, encode_text(&told));
        Self {
            recorder,
            row: topics[0],
            estimate: topics[1],
            pose: topics[2],
            notice: topics[3],
            told: topics[5],
            raw: topics[6..].chunks_exact(2).map(|pair| (pair[0], pair[1])).collect(),
        }
    }

    /// The recorder, for what it counts.
    #[must_use]
    pub fn recorder(&self) -> &Recorder {
        &self.recorder
    }

    /// Writes down what arrived.
    pub fn chunk(&self, chunk: &Chunk) {
        let (bytes, event) = self.raw[chunk.source];
        let (topic, message) = match &chunk.what {
            Arrived::Bytes(raw) => (bytes, encode_bytes(raw)),
            Arrived::Opened => (event, encode_text("opened")),
            Arrived::Gone(reason) => (event, encode_text(&format!("gone: {reason}"))),
            Arrived::Ended => (event, encode_text("ended")),
        };
        self.recorder.push(topic, chunk.arrival, message);
    }

    /// Writes down a row before the estimator sees it.
    pub fn row(&self, names: &[String], used: &UsedRow) {
        let row = &used.joined.row;
        let pose = row.odom_from_robot;
        let mut values = vec![row.line as f64, used.merged as f64, row.t, pose.x, pose.y, pose.theta];
        values.extend(&row.readings);
        values.extend(row.heading);
        let mut names = names.to_vec();
        names.truncate(6 + row.readings.len());
        names.extend(row.heading.map(|_| "heading".to_owned()));
        let header = Header { stamp: Stamp::from_seconds(row.t), frame: ODOM };
        self.recorder.push(self.row, used.joined.arrival, encode_named(header, &names, &values));
    }

    /// Writes down an estimate.
    pub fn estimate(&self, told: &Told) {
        let names = TOLD_NAMES.map(str::to_owned);
        let header = Header { stamp: Stamp::from_seconds(told.t), frame: ODOM };
        self.recorder.push(self.told, told.t, encode_named(header, &names, &[told.row as f64, told.from as f64]));
        self.recorder.push(self.estimate, told.t, encode_text(&told.line));
        let best = told.estimate.hypotheses.first().filter(|_| told.estimate.status != Status::Inconsistent);
        if let Some(best) = best {
            let header = Header { stamp: Stamp::from_seconds(told.t), frame: MAP };
            let covariance = best.covariance.unwrap_or([[0.0; 3]; 3]);
            self.recorder.push(self.pose, told.t, encode_pose(header, best.pose, Some(&covariance)));
        }
    }

    /// Writes down what happened to a source.
    pub fn notice(&self, notice: &Notice) {
        self.recorder.push(self.notice, notice.t, encode_text(&format!("{}: {}", notice.source, notice.text)));
    }

    /// Closes the recording.
    ///
    /// # Errors
    ///
    /// What the disk refuses to the end.
    pub fn finish(self) -> core::result::Result<(), String> {
        self.recorder.finish()
    }
}

/// The names of a row's values in the recording.
#[must_use]
pub fn row_names(channels: &[Channel]) -> Vec<String> {
    let front = ["row", "merged", "t", "x", "y", "theta"].map(str::to_owned);
    front.into_iter().chain(channels.iter().map(Channel::column)).collect()
}

/// What one has to know of a recording before it is played.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// The file.
    pub path: PathBuf,
    /// The setup of the run.
    pub setup: Setup,
    /// The version that recorded it.
    pub version: String,
    /// The numbers of the rows that the estimator took.
    pub used: Vec<u64>,
    /// How many messages of raw bytes there are.
    pub chunks: u64,
    /// What looked wrong.
    pub warnings: Vec<String>,
    /// The lines of the estimates.
    pub lines: Vec<String>,
    /// Of each the number of its row, and that of the row after which the estimator said it; empty in recordings of versions
    /// that told every estimate when it was there.
    pub told: Vec<(u64, u64)>,
}

/// Reads what a recording holds beside its raw bytes. `path` is the file, or a folder with exactly one.
///
/// # Errors
///
/// No recording of a live run.
pub fn read(path: &Path) -> Result<Recorded> {
    let path = the_file(path)?;
    let file = File::open(&path).map_err(|e| cannot_open(&path, "recording", &e))?;
    let (mut setup, mut used, mut lines, mut chunks, mut told_rows) = (None, Vec::new(), Vec::new(), 0, Vec::new());
    let bag = read_bag(std::io::BufReader::new(file), &path.to_string_lossy(), |topic, _, bytes| {
        match topic.name.as_str() {
            ROW => used.extend(decode_named(bytes).and_then(|(_, (_, values))| Some(*values.first()? as u64))),
            TOLD => told_rows.extend(decode_named(bytes).and_then(|(_, (_, values))| match values[..] {
                [row, from] => Some((row as u64, from as u64)),
                _ => None,
            })),
            ESTIMATE => lines.extend(decode_text(bytes).map(str::to_owned)),
            SETUP => setup = decode_text(bytes).map(str::to_owned).or(setup.take()),
            _ => chunks += u64::from(topic.kind == Some(Kind::Bytes)),
        }
        Ok(())
    })?;
    let told = setup.as_deref().and_then(|text| text.split_once('\n'));
    let (version, (folder, text)) =
        told.and_then(|(version, rest)| Some((version, rest.split_once('\n')?))).ok_or_else(|| {
            Error::data("this is no recording of a live run")
                .in_file(&path)
                .value("it holds no /vibrissa/setup")
                .remedy("`vibrissa localize` reads other recordings")
        })?;
    let mut setup = from_toml(text, &format!("the setup in {}", path.display()))?;
    setup.based_on(Path::new(folder));
    Ok(Recorded {
        version: version.to_owned(),
        setup,
        used,
        chunks,
        warnings: bag.warnings,
        lines,
        path,
        told: told_rows,
    })
}

/// The recording itself, or the only one in a folder.
fn the_file(path: &Path) -> Result<PathBuf> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let entries = std::fs::read_dir(path).map_err(|e| cannot_open(path, "recording", &e))?;
    let mut found: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "mcap"))
        .collect();
    found.sort();
    match found.as_slice() {
        [only] => Ok(only.clone()),
        [] => Err(Error::data("the folder holds no recording").in_file(path).allowed("a file .mcap")),
        several => Err(Error::data("the folder holds several recordings")
            .in_file(path)
            .value(several.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", "))
            .remedy("name one of them")),
    }
}

/// Calls `told` with everything that arrived during the recorded run, in order.
///
/// # Errors
///
/// A file that cannot be read; what `told` finds at fault.
pub fn chunks(recorded: &Recorded, mut told: impl FnMut(Chunk) -> Result<()>) -> Result<()> {
    let file = File::open(&recorded.path).map_err(|e| cannot_open(&recorded.path, "recording", &e))?;
    let sources: BTreeMap<String, usize> =
        recorded.setup.sources.iter().enumerate().map(|(index, source)| (source.name.clone(), index)).collect();
    read_bag(std::io::BufReader::new(file), &recorded.path.to_string_lossy(), |topic, logged, bytes| {
        let Some(name) = topic.name.strip_prefix(RAW) else { return Ok(()) };
        let event = name.strip_suffix(EVENT).filter(|_| topic.kind == Some(Kind::Text));
        let Some(&source) = sources.get(event.unwrap_or(name)) else { return Ok(()) };
        let arrival = seconds(logged);
        let what = if event.is_some() {
            match decode_text(bytes) {
                Some("opened") => Arrived::Opened,
                Some("ended") => Arrived::Ended,
                Some(reason) => Arrived::Gone(reason.strip_prefix("gone: ").unwrap_or(reason).to_owned()),
                None => return Ok(()),
            }
        } else {
            match decode_bytes(bytes) {
                Some(raw) => Arrived::Bytes(raw.to_vec()),
                None => return Ok(()),
            }
        };
        told(Chunk { source, arrival, what })
    })
    .map(|_| ())
}

/// A logged time (ns) in seconds, the same to the bit as when it was recorded.
fn seconds(logged: u64) -> f64 {
    let (sec, nanosec) = (logged / 1_000_000_000, logged % 1_000_000_000);
    Stamp { sec: i32::try_from(sec).unwrap_or(i32::MAX), nanosec: nanosec as u32 }.seconds()
}

/// A time (s) as the recording holds it: to a nanosecond.
#[must_use]
pub fn recorded_time(t: f64) -> f64 {
    Stamp::from_seconds(t).seconds()
}
