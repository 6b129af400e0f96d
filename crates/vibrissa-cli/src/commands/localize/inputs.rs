//! The files that a localization reads.

use crate::interrupt::stop;
use std::path::Path;
use vibrissa::figure::Outline;
use vibrissa::flow::pose::{Localization, StampedPose};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::io::read_tum;
#[cfg(feature = "mcap")]
use vibrissa::io::recording::{StampedStates, localization_mcap};
use vibrissa::tasks::RowObserver;
use vibrissa::world::{Map, Robot};
use vibrissa::{Method, Result};

/// How far a drawn boundary may be from the map's (m).
const DRAWING_TOLERANCE: f64 = 2e-5;

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
    pub(super) fn read(args: &super::Args) -> Result<Self> {
        Ok(Self {
            title: format!("{} on {}", file_name(&args.log), file_name(&args.map)),
            map: vibrissa::read_map(&args.map)?,
            robot: super::robot::read(args.reading.robot.as_deref(), &args.method.method)?,
            log: args.reading.read(&args.log)?,
            truth: args.truth.as_deref().map(read_tum).transpose()?,
        })
    }

    /// What looked wrong but could be read.
    pub(super) fn warnings(&self) -> Vec<String> {
        let mounted = |name: &str| self.robot.whiskers.iter().any(|w| w.name == name);
        let strange = |c: &&Channel| c.quantity == Quantity::Moment && !c.whisker.is_empty() && !mounted(&c.whisker);
        let unused = self.log.channels.iter().filter(strange).map(|channel| {
            format!("the column `{}` is not used: the robot has no whisker of this name", channel.column())
        });
        let doubts = vibrissa::tasks::doubts(Some(&self.log), &self.robot, Some(&self.map));
        self.map.warnings.iter().chain(&self.log.warnings).cloned().chain(unused).chain(doubts).collect()
    }

    /// The answer; `observer` is called after each row, may ask the localizer, and may break off.
    pub(super) fn localize(&self, method: &Method, observer: &mut RowObserver) -> Result<Localization> {
        vibrissa::tasks::localize_until(&self.log, &self.map, &self.robot, method, &stop(), observer)
    }

    /// What to try, where the answer is `inconsistent`; `go_on` may break off.
    pub(super) fn advise(
        &self,
        answer: &mut Localization,
        method: &Method,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<()> {
        vibrissa::tasks::advise(answer, &self.log, &self.map, &self.robot, method, go_on)
    }

    /// The recording of an answer and the states along the way (MCAP).
    #[cfg(feature = "mcap")]
    pub(super) fn recording(&self, answer: &Localization, states: &[StampedStates]) -> Result<Vec<u8>> {
        localization_mcap(&self.log, &self.map, answer, states, self.truth.as_deref())
    }

    /// What looks wrong in the log's times for a recording.
    #[cfg(feature = "mcap")]
    pub(super) fn clock_warning(&self) -> Option<String> {
        vibrissa::io::recording::clock_warning(&self.log)
    }

    /// The headline of the figure.
    pub(super) fn title(&self) -> String {
        self.title.clone()
    }

    /// The rows of the log.
    pub(super) fn rows(&self) -> &[LogRow] {
        &self.log.rows
    }

    /// The map as lines to draw.
    pub(super) fn outlines(&self) -> Vec<Outline> {
        outlines(&self.map)
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The map's boundaries flattened finely enough for any screen.
pub(in crate::commands) fn outlines(map: &Map) -> Vec<Outline> {
    vibrissa::tasks::outlines(map, DRAWING_TOLERANCE)
}
