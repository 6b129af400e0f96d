//! What the threads of a run share: rows on their way, what the estimator has come to.

use super::Health;
use crate::Error;
use crate::config::{READ_PATIENCE, ROWS_BEFORE_MERGING, ROWS_WAITING};
use crate::counts::Counts;
use crate::estimate::{Told, UsedRow, merged};
use crate::join::JoinedRow;
use crate::latency::Histogram;
use crate::pipeline::{Notice, Pipeline};
use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use vibrissa_core::flow::sensor_log::Channel;
use vibrissa_core::world::Robot;

/// What the joining thread hands over at once.
pub(super) struct Handed {
    pub(super) rows: Vec<JoinedRow>,
    pub(super) notices: Vec<Notice>,
    pub(super) fault: Option<Error>,
}

/// What the estimating thread counts.
#[derive(Clone, Default)]
pub(super) struct Progress {
    /// Number of the last row that it took or passed over, and when it was done (host, s).
    pub(super) done: (u64, f64),
    pub(super) rows: u64,
    pub(super) merged: u64,
    pub(super) refused: u64,
    /// From arrival to having been taken (s).
    pub(super) taken: Histogram,
}

#[derive(Default)]
pub(super) struct Queue {
    /// Rows for the estimator, and the same rows for those who look on.
    rows: VecDeque<UsedRow>,
    fresh: VecDeque<JoinedRow>,
    /// The channels and the robot, once they are known.
    known: Option<(Vec<Channel>, Robot)>,
    /// The same for those who look on.
    began: Option<(Vec<Channel>, Robot)>,
    notices: Vec<Notice>,
    counts: Vec<(String, Counts)>,
    /// Estimates that are not told yet.
    estimates: Vec<Told>,
    progress: Progress,
    /// Whether no rows come any more, and whether nobody takes them.
    ended: bool,
    gone: bool,
    /// Whether the estimator has ended.
    finished: bool,
    fault: Option<Error>,
}

/// The queue and who waits for it.
pub(super) struct Shared {
    queue: Mutex<Queue>,
    /// The estimator waits for rows,
    more: Condvar,
    /// the joining thread for the estimator, where sources are patient,
    fewer: Condvar,
    /// and whoever tells for anything.
    news: Condvar,
    /// Whether the sources wait until their rows are used: files do.
    pub(super) patient: bool,
}

/// What is to be told.
pub(super) struct News {
    /// The channels and the robot, once they are known.
    pub(super) began: Option<(Vec<Channel>, Robot)>,
    pub(super) rows: VecDeque<JoinedRow>,
    pub(super) notices: Vec<Notice>,
    pub(super) estimates: Vec<Told>,
    /// Number of the last row that the estimator is done with, and when (host, s).
    pub(super) done: (u64, f64),
    pub(super) finished: bool,
}

impl Shared {
    pub(super) fn new(patient: bool) -> Self {
        Self { queue: Mutex::default(), more: Condvar::new(), fewer: Condvar::new(), news: Condvar::new(), patient }
    }

    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes rows and words of the joining thread; `known` is set once the channels have been handed over.
    pub(super) fn hand_over(&self, pipeline: &Pipeline, known: &mut bool, handed: Handed) {
        let Handed { rows, notices, fault } = handed;
        let mut queue = self.lock();
        while self.patient && queue.rows.len() >= ROWS_BEFORE_MERGING && !queue.gone {
            queue = self.fewer.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
        let wakes = !rows.is_empty() || !notices.is_empty() || fault.is_some();
        if !*known && let Some(channels) = pipeline.channels() {
            *known = true;
            let all = (channels.to_vec(), pipeline.robot());
            queue.known = Some(all.clone());
            queue.began = Some(all);
        }
        queue.fresh.extend(rows.iter().cloned());
        let stale = queue.fresh.len().saturating_sub(ROWS_WAITING);
        queue.fresh.drain(..stale);
        queue.rows.extend(rows.into_iter().map(|joined| UsedRow { joined, merged: 1 }));
        if queue.rows.len() > ROWS_WAITING && !self.patient {
            let all = core::mem::take(&mut queue.rows);
            queue.rows = merged(all.into_iter(), ROWS_WAITING / 2).into();
        }
        queue.notices.extend(notices);
        queue.counts = pipeline.counts().map(|(name, counts)| (name.to_owned(), *counts)).collect();
        queue.fault = queue.fault.take().or(fault);
        drop(queue);
        if wakes {
            self.more.notify_all();
            self.news.notify_all();
        }
    }

    /// No rows come any more.
    pub(super) fn end(&self) {
        self.lock().ended = true;
        self.more.notify_all();
    }

    /// The channels and the robot; none where the sources ended before they said what they hold.
    pub(super) fn known(&self) -> Result<Option<(Vec<Channel>, Robot)>, Error> {
        let mut queue = self.lock();
        loop {
            if let Some(fault) = queue.fault.take() {
                return Err(fault);
            }
            if let Some(known) = queue.known.take() {
                return Ok(Some(known));
            }
            if queue.ended {
                return Ok(None);
            }
            queue = self.more.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits for rows and takes all that are there, of many the newest of each stretch; none when no more come.
    pub(super) fn rows(&self) -> Result<Option<Vec<UsedRow>>, Error> {
        let mut queue = self.lock();
        loop {
            if let Some(fault) = queue.fault.take() {
                return Err(fault);
            }
            if !queue.rows.is_empty() {
                let all = core::mem::take(&mut queue.rows);
                self.fewer.notify_all();
                let most = if self.patient { usize::MAX } else { ROWS_BEFORE_MERGING };
                return Ok(Some(merged(all.into_iter(), most)));
            }
            if queue.ended {
                return Ok(None);
            }
            queue = self.more.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// The estimator has taken a row.
    pub(super) fn took(&self, used: &UsedRow, now: f64, told: Option<Told>, refused: bool, notice: Option<Notice>) {
        let mut queue = self.lock();
        let progress = &mut queue.progress;
        progress.done = (used.joined.row.line as u64, now);
        progress.rows += 1;
        progress.merged += used.merged - 1;
        progress.refused += u64::from(refused);
        progress.taken.push(now - used.joined.arrival);
        queue.notices.extend(notice);
        queue.estimates.extend(told);
        drop(queue);
        self.news.notify_all();
    }

    /// The estimator takes no more rows.
    pub(super) fn finish(&self) {
        let mut queue = self.lock();
        (queue.gone, queue.finished) = (true, true);
        drop(queue);
        self.fewer.notify_all();
        self.news.notify_all();
    }

    /// Waits for news, so long (s) at most, and takes them.
    pub(super) fn news(&self, patience: f64) -> News {
        let patience = Duration::try_from_secs_f64(patience.min(READ_PATIENCE)).unwrap_or_default();
        let mut queue = self.lock();
        if queue.is_quiet() {
            queue = self.news.wait_timeout(queue, patience).map_or_else(|e| e.into_inner().0, |(queue, _)| queue);
        }
        News {
            began: queue.began.take(),
            rows: core::mem::take(&mut queue.fresh),
            notices: core::mem::take(&mut queue.notices),
            estimates: core::mem::take(&mut queue.estimates),
            done: queue.progress.done,
            finished: queue.finished,
        }
    }

    /// How the run does.
    pub(super) fn look(&self, health: &mut Health) {
        let queue = self.lock();
        health.sources.clone_from(&queue.counts);
        let Progress { rows, merged, refused, .. } = queue.progress;
        (health.rows, health.merged, health.refused) = (rows, merged, refused);
        health.taken.clone_from(&queue.progress.taken);
    }
}

impl Queue {
    fn is_quiet(&self) -> bool {
        self.fresh.is_empty() && self.notices.is_empty() && self.estimates.is_empty() && !self.finished
    }
}
