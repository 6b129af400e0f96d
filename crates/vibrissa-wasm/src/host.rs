//! What the page has read and what is going on; one for each instance of the module.

use crate::driving::Driving;
use crate::localizing::Localizing;
use std::cell::RefCell;
use vibrissa::flow::pose::{Localization, StampedPose};
use vibrissa::flow::preimage::StateGrid;
use vibrissa::flow::sensor_log::LogRow;
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::world::{Map, Robot};
use vibrissa::{Error, Result, SensorLog};

/// The state behind the exported functions.
#[derive(Default)]
pub(crate) struct Host {
    /// What the page has written for the next call.
    pub(crate) input: Vec<u8>,
    /// The numbers of the last call.
    pub(crate) numbers: Vec<f64>,
    /// The words of the last call.
    pub(crate) text: String,
    /// Name and bytes of a file that the next map may name: the image of a `.yaml`.
    pub(crate) beside: Option<(String, Vec<u8>)>,
    pub(crate) map: Option<Map>,
    pub(crate) robot: Robot,
    pub(crate) log: SensorLog,
    pub(crate) truth: Vec<StampedPose>,
    /// The states of the last preimage.
    pub(crate) states: Option<StateGrid>,
    pub(crate) driving: Option<Driving>,
    pub(crate) localizing: Option<Localizing>,
    pub(crate) answer: Option<Localization>,
}

thread_local! {
    static HOST: RefCell<Host> = RefCell::default();
}

/// Runs `work` on the host; the exported functions do not call each other.
pub(crate) fn with<T>(work: impl FnOnce(&mut Host) -> T) -> T {
    HOST.with_borrow_mut(work)
}

impl Host {
    /// The map.
    pub(crate) fn map(&self) -> Result<&Map> {
        self.map.as_ref().ok_or_else(|| Error::usage("no map was read yet"))
    }

    /// The input as text.
    pub(crate) fn input_text(&self) -> String {
        String::from_utf8_lossy(&self.input).into_owned()
    }

    /// The input as numbers, little-endian.
    pub(crate) fn input_numbers(&self) -> Vec<f64> {
        let chunks = self.input.chunks_exact(8);
        chunks.map(|bytes| bytes.try_into().map_or(f64::NAN, f64::from_le_bytes)).collect()
    }

    pub(crate) fn push(&mut self, values: impl IntoIterator<Item = f64>) {
        self.numbers.extend(values);
    }

    pub(crate) fn count(&mut self, count: usize) {
        self.numbers.push(count as f64);
    }

    pub(crate) fn point(&mut self, p: Vec2) {
        self.push([p.x, p.y]);
    }

    /// Points after their count.
    pub(crate) fn points(&mut self, points: &[Vec2]) {
        self.count(points.len());
        points.iter().for_each(|&p| self.point(p));
    }

    pub(crate) fn pose(&mut self, pose: Pose2) {
        self.push([pose.x, pose.y, pose.theta]);
    }

    pub(crate) fn row(&mut self, row: &LogRow) {
        self.push([row.t]);
        self.pose(row.odom_from_robot);
        self.push(row.readings.iter().copied());
    }

    /// An error in the words of the command.
    pub(crate) fn words_of(&self, error: Error) -> String {
        let remedy = if error.is_usage() {
            "correct the value; `vibrissa COMMAND --help` tells units and ranges"
        } else {
            "correct the file; docs/files.md tells columns, keys and units"
        };
        error.or_remedy(remedy).to_string()
    }
}
