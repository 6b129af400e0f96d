//! Stopping early: a signal's request, the work that heeds it between two rows, and what is left where the work takes too long to.

use crate::output::progress;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use vibrissa::Stop;

/// Whether somebody asked to stop; signals reach the whole process, so this belongs to the process.
static ASKED: LazyLock<Stop> = LazyLock::new(Stop::default);
/// Whether work is under way that looks at [`ASKED`].
static HEEDED: AtomicBool = AtomicBool::new(false);
/// Whether this work keeps what is known where it can be taken without it, so that nobody has to wait for it.
static HURRIED: AtomicBool = AtomicBool::new(false);
/// What to do with what is known so far, where the work does not end soon enough.
static LAST_RESORT: Mutex<Slot> = Mutex::new(Slot::Empty);
/// Held while results replace earlier ones, so that no end of the process leaves a mixture.
static REPLACING: Mutex<()> = Mutex::new(());

/// The last resort of the work under way.
enum Slot {
    /// Nothing is known yet.
    Empty,
    Ready(Box<dyn FnOnce() + Send>),
    /// It is under way, and the process ends with it.
    Taken,
}

/// How long work may take to end once it is asked to: people feel no delay yet.
const PATIENCE: Duration = Duration::from_millis(120);
/// How often is looked whether it has.
const LOOK_AGAIN: Duration = Duration::from_millis(5);

/// Asks the work under way to stop and to keep what it has; ends the process where no work heeds it or it was asked before (by the
/// last resort of work that ends in its own time), and where work
/// that can be done without has not stopped after a moment: with what is known so far, where anything is.
///
/// For a signal handler on a thread of its own. Results are staged, so that earlier ones stay whole.
pub fn interrupt() {
    let asked_before = ASKED.is_asked();
    ASKED.ask();
    if !HEEDED.load(Ordering::SeqCst) {
        leave();
    }
    if asked_before {
        // Work that ends in its own time says how it is ended at once.
        if !HURRIED.load(Ordering::SeqCst)
            && let Slot::Ready(resort) = core::mem::replace(&mut *slot(), Slot::Taken)
        {
            resort();
        }
        leave();
    }
    if !HURRIED.load(Ordering::SeqCst) {
        return;
    }
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        if !HEEDED.load(Ordering::SeqCst) {
            // The work has ended and delivers its results.
            return;
        }
        std::thread::sleep(LOOK_AGAIN);
    }
    let due = core::mem::replace(&mut *slot(), Slot::Taken);
    match due {
        Slot::Ready(resort) => resort(),
        _ => crate::output::warn("interrupted before anything was known: no results are written"),
    }
    leave();
}

/// Ends the process as shells tell the signal, between two replacements of results.
fn leave() -> ! {
    let _whole = replacing();
    progress::clear();
    std::process::exit(crate::INTERRUPTED.into());
}

/// Keeps the process from being ended by a signal as long as the value lives.
pub(crate) fn replacing() -> MutexGuard<'static, ()> {
    REPLACING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether work was stopped early.
pub(crate) fn stopped() -> bool {
    ASKED.is_asked()
}

/// The request to stop, for the library's work.
pub(crate) fn stop() -> Stop {
    ASKED.clone()
}

/// Says what to do where the work does not end soon enough.
pub(crate) fn last_resort(resort: impl FnOnce() + Send + 'static) {
    *slot() = Slot::Ready(Box::new(resort));
}

fn slot() -> MutexGuard<'static, Slot> {
    LAST_RESORT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A stretch of work that heeds requests to stop.
pub(crate) struct Heedful(());

impl Heedful {
    /// Heeds requests from now on, and ends in its own time: a recording is closed. Where it is asked again, the
    /// [last resort](last_resort) ends the process.
    pub(crate) fn begin() -> Self {
        HEEDED.store(true, Ordering::SeqCst);
        Self(())
    }

    /// Heeds requests from now on; where it takes too long the [last resort](last_resort) ends the process.
    pub(crate) fn hurried() -> Self {
        HURRIED.store(true, Ordering::SeqCst);
        Self::begin()
    }
}

impl Drop for Heedful {
    fn drop(&mut self) {
        let taken = match &mut *slot() {
            Slot::Taken => true,
            slot => {
                *slot = Slot::Empty;
                false
            }
        };
        HEEDED.store(false, Ordering::SeqCst);
        HURRIED.store(false, Ordering::SeqCst);
        if taken {
            // The signal's thread delivers in the place of this one, and ends the process.
            loop {
                std::thread::park();
            }
        }
    }
}

/// Forgets earlier requests, for shells that run several commands in one process.
pub(crate) fn reset() {
    ASKED.withdraw();
    *slot() = Slot::Empty;
}
