//! Reading recordings for calibrations and taps.

use super::tell;
use std::path::Path;
use vibrissa::Result;
use vibrissa::config::TapOptions;
use vibrissa::flow::sensor_log::foreign::{Format, Recording, Repairs};
use vibrissa::flow::taps::{Tap, taps};

/// The taps of a recording and what was read.
pub(in crate::commands) fn read_taps(
    path: &Path,
    format: Option<Format>,
    channel: &str,
    reference: Option<&str>,
) -> Result<(Recording, Vec<Tap>)> {
    let mut recording = Recording::read(path, format.unwrap_or_else(|| Format::of_taps(path)))?;
    if let Some(reference) = reference {
        let sensor = channel.rsplit_once('.').map_or("", |(sensor, _)| sensor);
        recording.subtract_reference(sensor, reference)?;
    }
    say_repairs(&recording);
    let reading = recording.require(channel)?;
    if recording.t.is_empty() {
        return Err(vibrissa::Error::data("the recording has no time")
            .in_file(path)
            .remedy("taps need a column t, or a format that knows its rate"));
    }
    let found = taps(&recording.t, reading, &TapOptions::default());
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
