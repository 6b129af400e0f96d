//! Words about a stream that does not look like what it was said to be: each said once, and again after a stretch that was whole.

use crate::config::{DAMAGED_SHARE, ENDLESS, FEWEST_LINES, MISSING_SHARE, STRETCH, WHOLE_SHARE, ZEROS};
use crate::counts::Counts;

/// What a stretch of a stream looked like, from good to bad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Look {
    #[default]
    Whole,
    Lossy,
    Foreign,
}

/// What was said of one stream.
#[derive(Clone, Debug, Default)]
pub(crate) struct Doubts {
    /// The counts where this stretch began.
    begun: Counts,
    told: Look,
    /// Bytes at the end of the last line.
    line_end: u64,
    lines: u64,
    endless: bool,
    /// Frames on end that are all zero, and whether that was said.
    zeros: u64,
    silent: bool,
}

impl Doubts {
    /// A frame was read.
    pub(crate) fn frame(&mut self, is_zero: bool) {
        self.zeros = if is_zero { self.zeros + 1 } else { 0 };
        self.silent &= is_zero;
    }

    /// The stream broke off: what is missing around the gap says nothing about its lines.
    pub(crate) fn break_off(&mut self, counts: &Counts) {
        self.begun = *counts;
        self.line_end = counts.bytes;
    }

    /// Looks at the counts after some bytes; `format` and `on_wire` say what the lines should be and what to check where they are not.
    pub(crate) fn words(&mut self, counts: &Counts, format: &str, on_wire: &str) -> Vec<String> {
        let mut words = Vec::new();
        words.extend(self.of_stretch(counts, format, on_wire));
        words.extend(self.of_line_ends(counts, format));
        if self.zeros >= ZEROS && !core::mem::replace(&mut self.silent, true) {
            words.push(format!("{ZEROS} readings on end are all zero: is the sensor connected?"));
        }
        words
    }

    fn of_stretch(&mut self, counts: &Counts, format: &str, on_wire: &str) -> Option<String> {
        let since = |of: fn(&Counts) -> u64| of(counts).saturating_sub(of(&self.begun));
        let (lines, damaged, lost) = (since(|c| c.lines), since(|c| c.damaged), since(|c| c.lost));
        let late = since(|c| c.late);
        let is_foreign = damaged as f64 > DAMAGED_SHARE * lines as f64;
        if lines < if is_foreign { FEWEST_LINES } else { STRETCH } {
            return None;
        }
        // A damaged frame that has a number is lost by it, too.
        let unread = damaged.max(lost);
        let sent = (since(|c| c.frames) + unread).saturating_sub(since(|c| c.repeated));
        let missing = unread + late;
        let share = missing as f64 / sent.max(1) as f64;
        let look = match share {
            _ if is_foreign => Look::Foreign,
            share if share >= MISSING_SHARE => Look::Lossy,
            _ => Look::Whole,
        };
        self.begun = *counts;
        let is_news = look > self.told;
        if is_news || share <= WHOLE_SHARE {
            self.told = look;
        }
        match look {
            Look::Foreign if is_news => {
                Some(format!("{damaged} of {lines} lines are no {format}: check baud rate and format{on_wire}"))
            }
            Look::Lossy if is_news => {
                let kinds = [(damaged, "damaged"), (lost, "lost by their numbers or times"), (late, "late")];
                let kinds: Vec<String> =
                    kinds.iter().filter(|(n, _)| *n > 0).map(|(n, kind)| format!("{n} {kind}")).collect();
                Some(format!(
                    "{missing} of the last {sent} frames are missing ({}): check the connection{on_wire}",
                    kinds.join(", ")
                ))
            }
            _ => None,
        }
    }

    /// Noise without line ends makes no lines.
    fn of_line_ends(&mut self, counts: &Counts, format: &str) -> Option<String> {
        if counts.lines > self.lines {
            (self.lines, self.line_end, self.endless) = (counts.lines, counts.bytes, false);
        }
        let bytes = counts.bytes - self.line_end;
        let is_endless = bytes > ENDLESS;
        if !is_endless || core::mem::replace(&mut self.endless, true) {
            return None;
        }
        Some(format!("{} kB without the end of a line of {format}: check baud rate and format", bytes / 1000))
    }
}

#[cfg(test)]
mod tests {
    use super::Doubts;
    use crate::counts::Counts;

    /// Sends so many lines of which each `nth` is damaged (none where it is 0), and collects what is said.
    fn send(doubts: &mut Doubts, counts: &mut Counts, lines: u64, nth: u64) -> Vec<String> {
        let mut said = Vec::new();
        for k in 0..lines {
            let is_damaged = nth > 0 && k % nth == 0;
            counts.lines += 1;
            counts.bytes += 30;
            counts.damaged += u64::from(is_damaged);
            counts.frames += u64::from(!is_damaged);
            said.extend(doubts.words(counts, "csv", ""));
        }
        said
    }

    #[test]
    fn damage_is_told_once_and_again_after_a_whole_stretch() {
        let (mut doubts, mut counts) = (Doubts::default(), Counts::default());
        assert!(send(&mut doubts, &mut counts, 1000, 0).is_empty());
        // A few hundredths are seen in the count alone.
        assert!(send(&mut doubts, &mut counts, 1000, 50).is_empty());
        let said = send(&mut doubts, &mut counts, 1000, 4);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].starts_with("25 of the last 100 frames are missing (25 damaged)"), "{said:?}");
        // Not long enough to be whole again, then long enough.
        assert!(send(&mut doubts, &mut counts, 1000, 40).is_empty());
        assert!(send(&mut doubts, &mut counts, 1000, 4).is_empty());
        assert!(send(&mut doubts, &mut counts, 200, 0).is_empty());
        assert_eq!(send(&mut doubts, &mut counts, 1000, 4).len(), 1);
        // It gets worse, an hour after a good beginning.
        let said = send(&mut doubts, &mut counts, 1000, 1);
        assert_eq!(said, ["50 of 50 lines are no csv: check baud rate and format"]);
    }

    #[test]
    fn frames_that_their_numbers_miss_and_late_ones_are_told_but_not_those_of_a_gap() {
        let (mut doubts, mut counts) = (Doubts::default(), Counts::default());
        send(&mut doubts, &mut counts, 250, 0);
        counts.lost += 700;
        doubts.break_off(&counts);
        assert!(send(&mut doubts, &mut counts, 500, 0).is_empty());
        counts.lost += 9;
        counts.late += 8;
        let said = send(&mut doubts, &mut counts, 100, 0);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].starts_with("17 of the last 109 frames") && said[0].contains("9 lost"), "{said:?}");
        assert!(said[0].contains("8 late"), "{said:?}");
    }

    #[test]
    fn noise_without_line_ends_is_told_whenever_it_begins() {
        let (mut doubts, mut counts) = (Doubts::default(), Counts::default());
        for _ in 0..2 {
            assert!(send(&mut doubts, &mut counts, 300, 0).is_empty());
            let mut said = Vec::new();
            for _ in 0..100 {
                counts.bytes += 4096;
                said.extend(doubts.words(&counts, "csv", ""));
            }
            assert_eq!(said.len(), 1, "{said:?}");
            assert!(said[0].contains("without the end of a line"), "{said:?}");
        }
    }

    #[test]
    fn a_silent_sensor_is_told_each_time() {
        let (mut doubts, mut counts) = (Doubts::default(), Counts::default());
        for _ in 0..2 {
            let mut said = Vec::new();
            for k in 0..700 {
                doubts.frame(k > 0);
                said.extend(send(&mut doubts, &mut counts, 1, 0));
            }
            assert_eq!(said, ["300 readings on end are all zero: is the sensor connected?"]);
        }
    }
}
