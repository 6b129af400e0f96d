//! The host's clock: seconds since 1970 that never jump.

use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Seconds since 1970 by the system's clock at the start, and by its steady clock from there on.
#[derive(Clone, Copy, Debug)]
pub struct HostClock {
    start: f64,
    began: Instant,
}

impl Default for HostClock {
    fn default() -> Self {
        Self::new()
    }
}

impl HostClock {
    /// The clock from now on.
    #[must_use]
    pub fn new() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { start: since.as_secs_f64(), began: Instant::now() }
    }

    /// Now (s since 1970).
    #[must_use]
    pub fn now(&self) -> f64 {
        self.start + self.began.elapsed().as_secs_f64()
    }
}
