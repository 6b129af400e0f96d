//! Recordings of taps: read one by one, gathered by distance.

use super::distance::DistanceSet;
use crate::config::TapOptions;
use crate::flow::taps::{Tap, taps};
use crate::io::log::foreign::{Format, Recording, Repairs};
use crate::world::calibration::Source;
use crate::{Error, Result};
use std::path::Path;

/// Distances nearer than this are one (m).
const SAME: f64 = 1e-9;

/// The taps of a recording in `channel`, and what was read; `reference` names the sensor that feels the ambient field alone.
///
/// # Errors
///
/// As [`Recording::read`]; data: no such column or sensor, no time.
pub fn read_taps(
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
    let reading = recording.require(channel)?;
    if recording.t.is_empty() {
        return Err(Error::data("the recording has no time")
            .in_file(path)
            .remedy("taps need a column t, or a format that knows its rate"));
    }
    let found = taps(&recording.t, reading, &TapOptions::default());
    Ok((recording, found))
}

/// Taps of many recordings, by distance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TapSets {
    /// The slopes, one set for each distance.
    pub sets: Vec<DistanceSet>,
    /// The recordings with taps.
    pub data: Vec<Source>,
    /// What was mended in all recordings.
    pub repairs: Repairs,
}

impl TapSets {
    /// Adds a recording's taps at a distance from the base (m); false where it has none and is left out.
    ///
    /// Several recordings of one distance belong together: none of them may be judged by the others.
    pub fn add(&mut self, path: &Path, distance: f64, recording: &Recording, found: &[Tap]) -> bool {
        self.repairs = self.repairs.and(recording.repairs);
        if found.is_empty() {
            return false;
        }
        let samples: Vec<(f64, f64)> = found.iter().map(|tap| (distance, tap.slope)).collect();
        let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let (rows, used) = (recording.lines.len(), samples.len());
        self.data.push(Source { file, rows, used, distance: Some(distance) });
        let near = |set: &&mut DistanceSet| set.samples.first().is_some_and(|s| (s.0 - distance).abs() < SAME);
        match self.sets.iter_mut().find(near) {
            Some(set) => set.samples.extend(samples),
            None => self.sets.push(DistanceSet { source: path.display().to_string(), samples }),
        }
        true
    }
}
