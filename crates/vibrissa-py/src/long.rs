//! Work that takes a while: Python runs on, Ctrl-C ends it, progress is told.

use crate::error::OrRaise;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;
use vibrissa::Stop;

/// How often signals are looked at and progress is told.
const POLL: Duration = Duration::from_millis(50);
/// The worker's stack, that of a main thread.
const STACK: usize = 8 << 20;

/// What the caller and the worker know of each other.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    done: AtomicUsize,
    cancelled: Stop,
}

/// Thrown through the worker when nobody waits for its answer any more.
struct Cancelled;

impl Watch {
    /// Tells that `done` parts are done; does not return once the caller has given up.
    pub(crate) fn tell(&self, done: usize) {
        self.done.store(done, Ordering::Relaxed);
        if self.is_cancelled() {
            // Unwinds without a message; the thread ends, and nobody joins it.
            resume_unwind(Box::new(Cancelled));
        }
    }

    /// Whether the caller has given up.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancelled.is_asked()
    }

    /// The request to stop, for work that takes it.
    pub(crate) fn stop(&self) -> &Stop {
        &self.cancelled
    }
}

/// Does `work` on a thread of its own, without the interpreter's lock, while this thread looks for signals and calls
/// `progress(done, total)`.
///
/// A signal or a fault of the callback is raised within a tenth of a second; work that does not look at its watch runs to
/// its end in the background.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    total: usize,
    work: impl FnOnce(&Watch) -> vibrissa::Result<T> + Send + 'static,
) -> PyResult<T> {
    let watch = Arc::new(Watch::default());
    let (send, mut receive) = channel();
    let theirs = Arc::clone(&watch);
    let body = move || {
        // Nobody may be waiting any more.
        let _ = send.send(work(&theirs));
    };
    thread::Builder::new().name("vibrissa".into()).stack_size(STACK).spawn(body)?;
    let mut told = 0;
    loop {
        let (answer, back) = py.detach(move || (receive.recv_timeout(POLL), receive));
        receive = back;
        let done = watch.done.load(Ordering::Relaxed);
        let attended = attend(py, progress.filter(|_| done > told), done, total);
        if attended.is_err() {
            watch.cancelled.ask();
        }
        attended?;
        told = done;
        match answer {
            Ok(answer) => return answer.or_raise(py),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("vibrissa failed inside; this is a bug, please report it"));
            }
        }
    }
}

fn attend(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, done: usize, total: usize) -> PyResult<()> {
    py.check_signals()?;
    progress.map_or(Ok(()), |progress| progress.call1((done, total)).map(|_| ()))
}
