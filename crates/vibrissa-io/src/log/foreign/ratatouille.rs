//! Host stamp and two raw counts a line.

use super::lines::{fields, lines, number};
use super::stamps::{even_times, host_stamp};
use super::{Format, Recording};

/// Largest 16-bit count.
pub(super) const LARGEST_COUNT: f64 = 65_535.0;

/// `STAMP,AX,AY`, with or without a header line; a last line that was cut is dropped, jitter of the stamps is taken out.
pub(super) fn read(bytes: &[u8]) -> Recording {
    let mut recording = Recording::new(Format::Ratatouille, &[("ax", "counts"), ("ay", "counts")]);
    // A line that was garbled took the place of a reading; the banner before the first is no such line.
    let (mut stamps, mut places, mut place): (Vec<f64>, Vec<usize>, usize) = (Vec::new(), Vec::new(), 0);
    for line in lines(bytes) {
        if line.text.is_empty() || (line.number == 1 && line.text.starts_with("timestamp")) {
            continue;
        }
        // Digits may be missing from a last line without a line end, though it looks whole.
        let Some((stamp, counts)) = row(line.text).filter(|_| line.ended) else {
            recording.repairs.drop_line(&line);
            place += usize::from(!stamps.is_empty());
            continue;
        };
        if stamps.last().is_some_and(|last| stamp < *last) {
            recording.repairs.out_of_order += 1;
            continue;
        }
        recording.repairs.saturated += counts.iter().filter(|c| **c <= 0.0 || **c >= LARGEST_COUNT).count();
        stamps.push(stamp);
        places.push(place);
        place += 1;
        recording.push(line.number, counts);
    }
    recording.t = even_times(&stamps, &places);
    recording.repairs.stamps_smoothed = stamps.len();
    recording
}

fn row(text: &str) -> Option<(f64, [f64; 2])> {
    let [stamp, x, y] = fields::<3>(text)?;
    let counts = [number(x)?, number(y)?];
    counts.iter().all(|c| (0.0..=LARGEST_COUNT).contains(c)).then_some((host_stamp(stamp)?, counts))
}
