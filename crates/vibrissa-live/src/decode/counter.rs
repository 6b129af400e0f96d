//! Numbers of frames and stamps that begin anew after a while.

/// Frames that may overtake each other: a number that is older by no more is late, by more a device that began anew.
const OVERTAKEN: u64 = 64;

/// What a frame's number says about the frames before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// So many are missing before it.
    Next(u64),
    /// It was there before, or is older than the first.
    Repeated,
    /// It was missing until now: newer ones were there before.
    Late,
    /// The count began anew.
    Reset,
}

/// Follows the numbers of frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counter {
    last: Option<u64>,
    /// Which of the 64 numbers before the last one are missing, the youngest in the lowest bit.
    missing: u64,
}

impl Counter {
    /// Takes a frame's number, which begins anew after `wraps` frames, where it does.
    pub fn push(&mut self, number: u64, wraps: Option<u64>) -> Step {
        let Some(last) = self.last else {
            self.last = Some(number);
            return Step::Next(0);
        };
        let ahead = match wraps {
            Some(wraps) => (number % wraps + wraps - last % wraps) % wraps,
            None => number.wrapping_sub(last),
        };
        // Half a turn: at least as much as frames may overtake each other.
        let half = wraps.map_or(u64::MAX / 2, |wraps| wraps / 2);
        let behind = wraps.map_or(last.wrapping_sub(number), |wraps| wraps - ahead);
        let step = match ahead {
            0 => Step::Repeated,
            _ if ahead <= half => Step::Next(ahead - 1),
            _ if behind <= OVERTAKEN && self.missing >> (behind - 1) & 1 == 1 => Step::Late,
            _ if behind <= OVERTAKEN => Step::Repeated,
            _ => Step::Reset,
        };
        match step {
            Step::Repeated => {}
            Step::Late => self.missing &= !(1 << (behind - 1)),
            Step::Reset => (self.last, self.missing) = (Some(number), 0),
            Step::Next(lost) => {
                let before = u32::try_from(lost + 1).ok().and_then(|ahead| self.missing.checked_shl(ahead));
                let skipped = u32::try_from(lost).ok().and_then(|lost| 1_u64.checked_shl(lost));
                self.missing = before.unwrap_or(0) | skipped.map_or(u64::MAX, |one| one - 1);
                self.last = Some(number);
            }
        }
        step
    }

    /// Forgets the last number: what comes next says nothing about what was before.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::{Counter, Step};

    #[test]
    fn losses_repeats_and_late_frames_are_told_apart_across_the_wrap() {
        let mut counter = Counter::default();
        let steps = [
            (253, Step::Next(0)),
            (254, Step::Next(0)),
            (254, Step::Repeated),
            (1, Step::Next(2)),
            (0, Step::Late),
            (0, Step::Repeated),
            (255, Step::Late),
            (254, Step::Repeated),
            (252, Step::Repeated),
            (2, Step::Next(0)),
            (100, Step::Next(97)),
            (10, Step::Reset),
            (11, Step::Next(0)),
        ];
        for (number, step) in steps {
            assert_eq!(counter.push(number, Some(256)), step, "{number}");
        }
        let mut endless = Counter::default();
        let steps = [(5, Step::Next(0)), (9, Step::Next(3)), (8, Step::Late), (9, Step::Repeated), (10, Step::Next(0))];
        for (number, step) in steps {
            assert_eq!(endless.push(number, None), step, "{number}");
        }
        // Sixty-four and more are missing: the newest of them may still come.
        assert_eq!(endless.push(75, None), Step::Next(64));
        let steps = [(11, Step::Late), (11, Step::Repeated), (74, Step::Late), (10, Step::Reset)];
        for (number, step) in steps {
            assert_eq!(endless.push(number, None), step, "{number}");
        }
        endless.push(1_000_000, None);
        assert_eq!(endless.push(3, None), Step::Reset);
    }
}
