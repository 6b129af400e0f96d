//! A live run: a thread for each source, one that joins, one that estimates, one that writes.

use crate::config::{CHUNKS_WAITING, READ_PATIENCE, ROWS_BEFORE_MERGING, ROWS_WAITING};
use crate::counts::Counts;
use crate::estimate::{LiveEstimator, Told, UsedRow, merged};
use crate::join::JoinedRow;
use crate::journal::{Journal, recorded_time, row_names};
use crate::latency::Histogram;
use crate::pipeline::{Notice, Pipeline};
use crate::setup::Setup;
use crate::source::{Arrived, Chunk, HostClock, read_wire};
use crate::timing::TimeBase;
use crate::{Error, Result};
use core::ops::ControlFlow;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use vibrissa_core::flow::pose::{Estimate, Localization};
use vibrissa_core::flow::sensor_log::Channel;
use vibrissa_core::world::{Map, Robot};

/// A source that has said nothing for so long (s) is told of once.
const SILENT: f64 = 3.0;

/// What is told while a run goes on.
#[derive(Debug)]
pub enum Update<'a> {
    /// An estimate is due: it and how the run does.
    Estimate(&'a Told, &'a Health),
    /// Something happened to a source, or to a row.
    Notice(&'a Notice),
    /// Nothing new; the chance to stop.
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
    /// From the arrival of the last byte that a row needs to its estimate (s).
    pub latency: Histogram,
    /// From the time of a row to its estimate (s), with what the join waited for odometry; empty where rows have times of their own.
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

/// What the joining and the estimating thread share.
#[derive(Default)]
struct Queue {
    rows: VecDeque<UsedRow>,
    /// The channels and the robot, once they are known.
    known: Option<(Vec<Channel>, Robot)>,
    notices: Vec<Notice>,
    counts: Vec<(String, Counts)>,
    ended: bool,
    /// Whether nobody takes rows any more.
    gone: bool,
    fault: Option<Error>,
}

struct Shared {
    queue: Mutex<Queue>,
    more: Condvar,
    /// Whether the sources wait until their rows are used: files do.
    patient: bool,
    fewer: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Runs until every source has ended or `watch` breaks off. What arrives goes to the journal first.
///
/// # Errors
///
/// Sources that cannot be joined, a robot or a map that the method does not cover. Faults of devices and disks are notices: the
/// run goes on.
pub fn run(
    setup: &Setup,
    map: &Map,
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
    let shared = Shared { queue: Mutex::default(), more: Condvar::new(), patient, fewer: Condvar::new() };
    let result = std::thread::scope(|scope| {
        let (clock, stop, shared) = (&clock, &*stop, &shared);
        scope.spawn(move || join_chunks(pipeline, &receiver, journal, clock, stop, shared));
        let result = estimate_rows(setup, map, journal, clock, stop, shared, watch);
        stop.store(true, Ordering::Relaxed);
        shared.lock().gone = true;
        shared.fewer.notify_all();
        result
    });
    stop.store(true, Ordering::Relaxed);
    result
}

/// Chunks to rows, on a thread of its own.
fn join_chunks(
    mut pipeline: Pipeline,
    chunks: &Receiver<Chunk>,
    journal: Option<&Journal>,
    clock: &HostClock,
    stop: &AtomicBool,
    shared: &Shared,
) {
    let mut ended = 0;
    let sources = pipeline.counts().count();
    let began = clock.now();
    let mut silence_told = false;
    let mut known = false;
    while ended < sources && !stop.load(Ordering::Relaxed) {
        let (mut rows, mut fault) = (Vec::new(), None);
        match chunks.recv_timeout(Duration::from_secs_f64(READ_PATIENCE)) {
            Ok(mut chunk) => {
                chunk.arrival = recorded_time(chunk.arrival);
                if let Some(journal) = journal {
                    journal.chunk(&chunk);
                }
                ended += usize::from(chunk.what == Arrived::Ended);
                fault = pipeline.push(&chunk, &mut |row| rows.push(row)).err();
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let mut notices = pipeline.take_notices();
        if !silence_told && clock.now() > began + SILENT {
            silence_told = true;
            notices.extend(silent(&pipeline, clock.now()));
        }
        let failed = fault.is_some();
        hand_over(&pipeline, rows, notices, &mut known, shared, fault);
        if failed {
            break;
        }
    }
    let mut rows = Vec::new();
    pipeline.finish(&mut |row| rows.push(row));
    let notices = pipeline.take_notices();
    hand_over(&pipeline, rows, notices, &mut known, shared, None);
    shared.lock().ended = true;
    shared.more.notify_all();
}

/// A word about each source that has sent nothing.
fn silent(pipeline: &Pipeline, t: f64) -> Vec<Notice> {
    let quiet = pipeline.counts().filter(|(_, counts)| counts.bytes == 0 && counts.gone == 0);
    let word = "no bytes yet: is the device switched on, and the cable in?";
    quiet.map(|(name, _)| Notice { t, source: name.to_owned(), text: word.to_owned() }).collect()
}

fn hand_over(
    pipeline: &Pipeline,
    rows: Vec<JoinedRow>,
    notices: Vec<Notice>,
    known: &mut bool,
    shared: &Shared,
    fault: Option<Error>,
) {
    let mut queue = shared.lock();
    while shared.patient && queue.rows.len() >= ROWS_BEFORE_MERGING && !queue.gone {
        queue = shared.fewer.wait(queue).unwrap_or_else(PoisonError::into_inner);
    }
    let wakes = !rows.is_empty() || !notices.is_empty() || fault.is_some();
    if !*known && let Some(channels) = pipeline.channels() {
        *known = true;
        queue.known = Some((channels.to_vec(), pipeline.robot()));
    }
    queue.rows.extend(rows.into_iter().map(|joined| UsedRow { joined, merged: 1 }));
    if queue.rows.len() > ROWS_WAITING && !shared.patient {
        let all = core::mem::take(&mut queue.rows);
        queue.rows = merged(all.into_iter(), ROWS_WAITING / 2).into();
    }
    queue.notices.extend(notices);
    queue.counts = pipeline.counts().map(|(name, counts)| (name.to_owned(), *counts)).collect();
    queue.fault = queue.fault.take().or(fault);
    drop(queue);
    if wakes {
        shared.more.notify_all();
    }
}

/// What the estimating thread takes at once.
struct Batch {
    rows: Vec<UsedRow>,
    notices: Vec<Notice>,
    ended: bool,
}

fn take(shared: &Shared, health: &mut Health) -> Result<Batch> {
    let patience = Duration::from_secs_f64(READ_PATIENCE);
    let mut queue = shared.lock();
    if queue.rows.is_empty() && queue.notices.is_empty() && !queue.ended {
        queue = shared.more.wait_timeout(queue, patience).map_or_else(|e| e.into_inner().0, |(queue, _)| queue);
    }
    if let Some(fault) = queue.fault.take() {
        return Err(fault);
    }
    let all = core::mem::take(&mut queue.rows);
    health.sources = queue.counts.clone();
    shared.fewer.notify_all();
    let most = if shared.patient { usize::MAX } else { ROWS_BEFORE_MERGING };
    Ok(Batch { rows: merged(all.into_iter(), most), notices: core::mem::take(&mut queue.notices), ended: queue.ended })
}

/// Rows to estimates, on the calling thread.
fn estimate_rows(
    setup: &Setup,
    map: &Map,
    journal: Option<&Journal>,
    clock: &HostClock,
    stop: &AtomicBool,
    shared: &Shared,
    watch: &mut dyn FnMut(Update<'_>) -> ControlFlow<()>,
) -> Result<Finished> {
    let mut health = Health::default();
    // Until every stream has said what it holds there are no rows.
    let (channels, robot) = loop {
        let batch = take(shared, &mut health)?;
        if !told(&batch.notices, journal, watch) || watch(Update::Idle(&health)).is_break() {
            stop.store(true, Ordering::Relaxed);
        }
        let mut queue = shared.lock();
        if let Some(known) = queue.known.take() {
            for row in batch.rows.into_iter().rev() {
                queue.rows.push_front(row);
            }
            break known;
        }
        if batch.ended {
            return Ok(Finished { estimate: Estimate::default(), answer: None, health });
        }
    };
    let mut estimator = LiveEstimator::new(map, &robot, &channels, &setup.method, setup.estimate_rate)?;
    let names = row_names(&channels);
    let on_host_time = setup.sources.iter().all(|source| source.time != TimeBase::Own);
    let mut refusing = false;
    loop {
        let batch = take(shared, &mut health)?;
        let mut go_on = told(&batch.notices, journal, watch);
        if let Some(journal) = journal {
            (health.dropped, health.disk) = (journal.recorder().dropped(), journal.recorder().fault());
        }
        let is_empty = batch.rows.is_empty();
        for used in batch.rows {
            if let Some(journal) = journal {
                journal.row(&names, &used);
            }
            let step = estimator.step(&used.joined.row);
            let now = clock.now();
            health.rows += 1;
            health.merged += used.merged - 1;
            health.latency.push(now - used.joined.arrival);
            if on_host_time {
                health.age.push(now - used.joined.row.t);
            }
            match step {
                Ok(None) => refusing = false,
                Ok(Some(estimate)) => {
                    refusing = false;
                    if let Some(journal) = journal {
                        journal.estimate(&estimate);
                    }
                    go_on &= watch(Update::Estimate(&estimate, &health)).is_continue();
                }
                Err(error) => {
                    health.refused = estimator.refused();
                    let text = error.to_string().replace("\n  help: ", "; ");
                    let notice = Notice { t: used.joined.row.t, source: "rows".to_owned(), text };
                    if !refusing {
                        go_on &= told(&[notice], journal, watch);
                    }
                    refusing = true;
                }
            }
        }
        if is_empty {
            go_on &= watch(Update::Idle(&health)).is_continue();
        }
        if !go_on {
            stop.store(true, Ordering::Relaxed);
        }
        if batch.ended && is_empty {
            let estimate = estimator.estimate();
            return Ok(Finished { estimate, answer: Some(estimator.finish()), health });
        }
    }
}

/// Says what happened; whether to go on.
fn told(notices: &[Notice], journal: Option<&Journal>, watch: &mut dyn FnMut(Update<'_>) -> ControlFlow<()>) -> bool {
    let mut go_on = true;
    for notice in notices {
        if let Some(journal) = journal {
            journal.notice(notice);
        }
        go_on &= watch(Update::Notice(notice)).is_continue();
    }
    go_on
}
