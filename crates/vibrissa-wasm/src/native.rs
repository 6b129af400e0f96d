//! The same buffers for callers in Rust, which need no pointers: fuzzing and tests.

use crate::host::{Host, with};

/// Hands over the input of the next call.
pub fn give(bytes: &[u8]) {
    with(|host| {
        host.input.clear();
        host.input.extend_from_slice(bytes);
    });
}

/// The numbers of the last call.
#[must_use]
pub fn numbers() -> Vec<f64> {
    with(|host| host.numbers.clone())
}

/// The words of the last call.
#[must_use]
pub fn text() -> String {
    with(|host| host.text.clone())
}

/// Forgets all that was read and what goes on.
pub fn reset() {
    with(|host| *host = Host::default());
}
