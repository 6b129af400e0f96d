//! The thread that synchronises: it alone waits for the disk.

use crate::config::SYNC;
use std::io::{Error, Result};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What is asked for and what was done (bytes of the file).
#[derive(Debug, Default)]
struct Progress {
    asked: u64,
    done: u64,
    fault: Option<Error>,
    ended: bool,
}

#[derive(Debug, Default)]
struct Both {
    progress: Mutex<Progress>,
    changed: Condvar,
}

impl Both {
    fn lock(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for work: up to where the file is to be synchronised; none at the end.
    fn work(&self) -> Option<u64> {
        let mut progress = self.lock();
        loop {
            if progress.ended {
                return None;
            }
            // After a fault whoever writes has to write again first.
            if progress.fault.is_none() && progress.asked > progress.done {
                return Some(progress.asked);
            }
            progress = self.changed.wait(progress).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn worked(&self, length: u64, result: Result<()>) {
        let mut progress = self.lock();
        match result {
            Ok(()) => progress.done = length,
            Err(error) => progress.fault = Some(error),
        }
    }

    /// Waits so long, or until the end.
    fn pause(&self, time: Duration) {
        let progress = self.lock();
        // Both ends of the wait mean the same.
        let _ = self.changed.wait_timeout_while(progress, time, |progress| !progress.ended);
    }
}

/// The thread, and what it shares.
#[derive(Debug)]
pub(super) struct Synchronising {
    both: Arc<Both>,
    thread: JoinHandle<()>,
}

impl Synchronising {
    pub(super) fn begin(mut synchronise: super::Synchroniser) -> Self {
        let both = Arc::new(Both::default());
        let theirs = Arc::clone(&both);
        let thread = std::thread::spawn(move || {
            let period = Duration::from_secs_f64(SYNC);
            while let Some(length) = theirs.work() {
                let began = Instant::now();
                theirs.worked(length, synchronise());
                theirs.pause(period.saturating_sub(began.elapsed()));
            }
        });
        Self { both, thread }
    }

    /// The file is to be on the disk up to here.
    pub(super) fn ask(&self, length: u64) {
        self.both.lock().asked = length;
        self.both.changed.notify_all();
    }

    /// Up to where it is, and what the disk said where it refused, once.
    pub(super) fn progress(&self) -> (u64, Option<Error>) {
        let mut progress = self.both.lock();
        let fault = progress.fault.take();
        if fault.is_some() {
            // What is written again is asked for anew.
            progress.asked = progress.done;
        }
        (progress.done, fault)
    }

    /// Ends when the thread has done what it is at; up to where the file is on the disk, none where the disk has refused.
    pub(super) fn end(self) -> Option<u64> {
        self.both.lock().ended = true;
        self.both.changed.notify_all();
        // A thread that panicked has nothing left to say.
        let _ = self.thread.join();
        let progress = self.both.lock();
        progress.fault.is_none().then_some(progress.done)
    }
}
