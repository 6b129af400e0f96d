//! Stopping early: a signal's request, and the work that heeds it between two rows.

use std::sync::atomic::{AtomicBool, Ordering};

/// Whether somebody asked to stop; signals reach the whole process, so this belongs to the process.
static ASKED: AtomicBool = AtomicBool::new(false);
/// Whether work is under way that looks at [`ASKED`].
static HEEDED: AtomicBool = AtomicBool::new(false);

/// Asks the work under way to stop and to keep what it has; false where none will, or where it was asked before.
///
/// For a signal handler, which ends the process on false: results are staged, so that earlier ones stay whole.
#[must_use]
pub fn interrupt() -> bool {
    HEEDED.load(Ordering::SeqCst) && !ASKED.swap(true, Ordering::SeqCst)
}

/// Whether work was stopped early.
pub(crate) fn stopped() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// A stretch of work that heeds requests to stop.
pub(crate) struct Heedful(());

impl Heedful {
    /// Heeds requests from now on.
    pub(crate) fn begin() -> Self {
        HEEDED.store(true, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for Heedful {
    fn drop(&mut self) {
        HEEDED.store(false, Ordering::SeqCst);
    }
}

/// Forgets earlier requests, for shells that run several commands in one process.
pub(crate) fn reset() {
    ASKED.store(false, Ordering::SeqCst);
}
