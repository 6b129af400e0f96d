//! Reference data that is not ours to publish, or too large: a folder `shared` beside the repository.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file or folder of it. Where it is missing a line says so, past the harness, which keeps what passing tests print: nobody takes
/// a test that had nothing to compare with for one that passed.
pub(crate) fn shared(path: &str) -> Option<PathBuf> {
    let place = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")).join(path);
    if place.exists() {
        return Some(place);
    }
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let line = format!("SKIPPED: {test}: ../shared/{path} is not there, so nothing was compared with it\n");
    let _ = std::io::stderr().write_all(line.as_bytes());
    None
}
