//! Numbers of frames and stamps that begin anew after a while.

/// Frames that may overtake each other: a number that is older by no more is late, by more a device that began anew.
const OVERTAKEN: u64 = 64;

/// What a frame's number says about the frames before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// So many are missing before it.
    Next(u64),
    /// It was there before.
    Repeated,
    /// A newer one was there before.
    Late,
    /// The count began anew.
    Reset,
}

/// Follows the numbers of frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counter {
    last: Option<u64>,
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
            _ if behind <= OVERTAKEN => Step::Late,
            _ => Step::Reset,
        };
        if matches!(step, Step::Next(_) | Step::Reset) {
            self.last = Some(number);
        }
        step
    }

    /// Forgets the last number: what comes next says nothing about what was before.
    pub fn forget(&mut self) {
        self.last = None;
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
        endless.push(1_000_000, None);
        assert_eq!(endless.push(3, None), Step::Reset);
    }
}
