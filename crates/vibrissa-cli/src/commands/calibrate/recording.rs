//! Reading recordings for calibrations and taps.

use super::tell;
use std::path::Path;
use vibrissa::Result;
use vibrissa::flow::taps::Tap;
use vibrissa::io::log::foreign::{Format, Recording, Repairs};
use vibrissa::tasks::calibrate;

/// The taps of a recording and what was read; tells what was mended.
pub(in crate::commands) fn read_taps(
    path: &Path,
    format: Option<Format>,
    channel: &str,
    reference: Option<&str>,
) -> Result<(Recording, Vec<Tap>)> {
    let (recording, found) = calibrate::read_taps(path, format, channel, reference)?;
    say_repairs(&recording);
    Ok((recording, found))
}

/// Tells on standard error what was mended.
pub(in crate::commands) fn say_repairs(recording: &Recording) {
    tell(&recording.repairs.words(), &recording.source);
}

/// Every kind of repair that was made, with its count.
pub(in crate::commands) fn repairs_json(repairs: Repairs) -> serde_json::Value {
    let made = repairs.counts().into_iter().filter(|(_, count)| *count > 0);
    made.map(|(name, count)| (name.to_owned(), serde_json::json!(count))).collect::<serde_json::Map<_, _>>().into()
}
