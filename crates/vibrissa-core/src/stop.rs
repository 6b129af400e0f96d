//! A request to end long work early.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request to end long work early: of those who wait for it to those who do it.
///
/// Work that takes it looks at it every few milliseconds and ends with what it has by then. Clones are one and the same request.
///
/// ```
/// use vibrissa_core::Stop;
///
/// let stop = Stop::default();
/// let theirs = stop.clone();
/// std::thread::spawn(move || theirs.ask()).join().unwrap();
/// assert!(stop.is_asked());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Asks the work to end.
    pub fn ask(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Takes the request back, for work that begins anew.
    pub fn withdraw(&self) {
        self.0.store(false, Ordering::SeqCst);
    }

    /// Whether the work is to end; this takes a nanosecond.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
