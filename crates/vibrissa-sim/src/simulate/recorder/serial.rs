//! A recording as the text that a microcontroller prints on its serial line.

use super::Recording;
use crate::{Error, Result};
use std::fmt::Write;

/// Who speaks on the serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SerialLayout {
    /// One sensor, a line for every row.
    Single,
    /// Two sensors that take turns: even rows are the first whisker's, odd ones the second's.
    Interleaved,
}

/// The readings as lines `x,y,z` (µT along the chip's axes, two decimals, CR LF) without time stamps.
///
/// # Errors
///
/// Usage: another number of whiskers than the layout has sensors.
pub fn serial_text(recording: &Recording, layout: SerialLayout) -> Result<String> {
    let sensors = match layout {
        SerialLayout::Single => 1,
        SerialLayout::Interleaved => 2,
    };
    if let Some(wrong) = recording.flux.iter().map(Vec::len).find(|&count| count != sensors) {
        return Err(Error::usage("the serial layout does not fit the number of whiskers")
            .value(wrong)
            .allowed(sensors.to_string()));
    }
    let mut text = String::new();
    for (flux, row) in recording.flux.iter().zip(&recording.rows) {
        let [x, y, z] = flux[row % sensors].map(|tesla| tesla * 1e6);
        // Writing into a string cannot fail.
        let _ = write!(text, "{x:.2},{y:.2},{z:.2}\r\n");
    }
    Ok(text)
}
