//! A live run: a thread for each source, one that joins, one that estimates, one that writes, and the calling one, which tells.

mod estimating;
mod joining;
mod queue;
mod silence;
mod telling;

use crate::Result;
use crate::config::CHUNKS_WAITING;
use crate::counts::Counts;
use crate::estimate::Told;
use crate::join::JoinedRow;
use crate::journal::Journal;
use crate::latency::Histogram;
use crate::pipeline::{Notice, Pipeline};
use crate::setup::Setup;
use crate::source::{HostClock, read_wire};
use crate::timing::TimeBase;
use core::ops::ControlFlow;
use estimating::estimate_rows;
use joining::join_chunks;
use queue::Shared;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use telling::Teller;
use vibrissa_core::flow::pose::{Estimate, Localization};
use vibrissa_core::flow::sensor_log::Channel;
use vibrissa_core::world::{Map, Robot};

/// What is told while a run goes on.
#[derive(Debug)]
pub enum Update<'a> {
    /// An estimate is due: it and how the run does.
    Estimate(&'a Told, &'a Health),
    /// Every source has said what it holds: the channels of the rows, and the robot with the bounds of its calibrations.
    Began(&'a [Channel], &'a Robot),
    /// A row was joined.
    Row(&'a JoinedRow),
    /// Something happened to a source, or to a row.
    Notice(&'a Notice),
    /// Nothing new, or nothing that is estimated; the chance to stop.
    Idle(&'a Health),
}

/// How a run does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Health {
    /// Counts of each source, by name.
    pub sources: Vec<(String, Counts)>,
    /// Rows that the estimator took.
    pub rows: u64,
    /// Rows that others stand for, because work piled up.
    pub merged: u64,
    /// Rows that the whisker cannot cause: left out.
    pub refused: u64,
    /// Messages that the recording had to leave out.
    pub dropped: u64,
    /// What the disk says while it refuses.
    pub disk: Option<String>,
    /// Rows whose pose was the last estimate carried on by odometry, because the estimator still worked on earlier ones.
    pub carried: u64,
    /// From the arrival of the last byte that a row needs to its pose (s), estimated or carried on.
    pub latency: Histogram,
    /// The same until the estimator has taken the row (s).
    pub taken: Histogram,
    /// From the time of a row to its pose (s), with what the join waited for odometry; empty where rows have times of their own.
    pub age: Histogram,
}

/// What a run ends with.
#[derive(Debug)]
pub struct Finished {
    /// The estimate after the last row.
    pub estimate: Estimate,
    /// The answer; none where no row came.
    pub answer: Option<Localization>,
    /// How it went.
    pub health: Health,
}

/// Runs until every source has ended or `watch` breaks off. What arrives goes to the journal first. Without a map rows are joined and told, and
/// nothing is estimated.
///
/// # Errors
///
/// Sources that cannot be joined, a robot or a map that the method does not cover. Faults of devices and disks are notices: the
/// run goes on.
pub fn run(
    setup: &Setup,
    map: Option<&Map>,
    robot: &Robot,
    journal: Option<&Journal>,
    watch: &mut dyn FnMut(Update<'_>) -> ControlFlow<()>,
) -> Result<Finished> {
    let pipeline = Pipeline::new(setup, robot)?;
    let clock = HostClock::new();
    let stop = Arc::new(AtomicBool::new(false));
    let (sender, receiver) = sync_channel(CHUNKS_WAITING);
    for (index, source) in setup.sources.iter().enumerate() {
        let (wire, sender, stop) = (source.wire.clone(), sender.clone(), Arc::clone(&stop));
        // Not joined at the end: a pipe that nobody writes to may never return.
        std::thread::spawn(move || read_wire(index, &wire, &clock, &sender, &stop));
    }
    drop(sender);
    let patient = setup.sources.iter().all(|source| source.wire.is_file());
    let shared = Shared::new(patient);
    let result = std::thread::scope(|scope| {
        let (clock, stop, shared) = (&clock, &*stop, &shared);
        scope.spawn(move || join_chunks(pipeline, &receiver, journal, clock, stop, shared));
        let how = (&setup.method, setup.estimate_rate);
        let estimating = scope.spawn(move || estimate_rows(map, how, journal, clock, shared));
        let teller = Teller {
            journal,
            clock,
            shared,
            stop,
            odometry: robot.odometry,
            on_host_time: setup.sources.iter().all(|source| source.time != TimeBase::Own),
            period: 1.0 / setup.estimate_rate,
            estimates: map.is_some(),
        };
        let health = teller.tell(watch);
        stop.store(true, Ordering::Relaxed);
        match estimating.join() {
            Ok(outcome) => outcome.map(|(estimate, answer)| Finished { estimate, answer, health }),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    });
    stop.store(true, Ordering::Relaxed);
    result
}
