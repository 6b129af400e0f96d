//! Contacts of a window: where one whisker touches after it was free, and the rows of it that judge a search.

use super::log_window::LogWindow;
use super::sensor::Sensor;
use core::ops::Range;

/// Fewest rows of contact to seed from.
pub(super) const FEWEST_ROWS: usize = 5;

/// Most rows that judge a search: readings next to each other tell much the same.
const MOST_JUDGING: f64 = 24.0;

/// A stretch of the window in which one whisker touches.
pub(super) struct ContactEpisode {
    pub(super) sensor: usize,
    pub(super) onset: usize,
    /// The row after its last.
    pub(super) end: usize,
    /// How far the robot goes in it (m).
    way: f64,
}

/// The contact with the longest way of those that did not begin at any of these times (s).
pub(super) fn longest_contact(window: &LogWindow, sensors: &[Sensor], searched: &[f64]) -> Option<ContactEpisode> {
    let mut best: Option<ContactEpisode> = None;
    for (index, sensor) in sensors.iter().enumerate() {
        let touches = |row: usize| window.contacts(row)[index];
        let mut row = 0;
        while row < window.len() {
            let onset = row;
            while row < window.len() && touches(row) {
                row += 1;
            }
            let known = |t: &f64| t.total_cmp(&window.time(onset)).is_eq();
            // What was in contact at the first row began before.
            if onset > 0 && row >= onset + FEWEST_ROWS && !searched.iter().any(known) {
                let way = window.way(onset, row - 1, sensor.length);
                if best.as_ref().is_none_or(|best| way > best.way) {
                    best = Some(ContactEpisode { sensor: index, onset, end: row, way });
                }
            }
            row = row.max(onset + 1);
        }
    }
    best
}

/// The rows that judge cells: the onset, then one for every `step` that the base or the tip travels, or evenly spread where these were too many;
/// of three neighbours always that with the middle reading, so that no single false one is taken.
pub(super) fn judging_rows(
    window: &LogWindow,
    (sensor, lever): (usize, f64),
    contact: Range<usize>,
    step: f64,
) -> Vec<usize> {
    let (onset, last) = (contact.start, contact.end - 1);
    let step = step.max(window.way(onset, last, lever) / MOST_JUDGING);
    let mut rows = vec![onset];
    let mut travelled = 0.0;
    for row in onset + 1..last {
        travelled += window.way(row - 1, row, lever);
        if travelled >= step {
            let mut three = [row - 1, row, row + 1];
            three.sort_by(|&a, &b| window.readings(a)[sensor].total_cmp(&window.readings(b)[sensor]));
            if three[1] > rows[rows.len() - 1] {
                rows.push(three[1]);
                travelled = 0.0;
            }
        }
    }
    rows
}
