//! Counts carried on over the ends of 16-bit registers.

/// Carries three counts on; between two readings a count may move by less than half of the register's range.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Unwrap {
    last: Option<[i32; 3]>,
    turns: [i32; 3],
}

impl Unwrap {
    /// The counts carried on, and whether one of them ran over since the reading before.
    pub(crate) fn push(&mut self, counts: [i32; 3], wraps: Option<i32>) -> ([i32; 3], bool) {
        let Some(wraps) = wraps else { return (counts, false) };
        let mut ran_over = false;
        for (axis, before) in self.last.unwrap_or(counts).into_iter().enumerate() {
            let step = counts[axis] - before;
            let turn = i32::from(step < -wraps / 2) - i32::from(step > wraps / 2);
            // A converter has 19 bits: more turns than these are noise.
            self.turns[axis] = (self.turns[axis] + turn).clamp(-8, 8);
            ran_over |= turn != 0;
        }
        self.last = Some(counts);
        ([0, 1, 2].map(|axis| counts[axis] + self.turns[axis] * wraps), ran_over)
    }

    /// Forgets what was before: counts are taken as they come.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::Unwrap;

    #[test]
    fn counts_go_on_over_either_end_and_back() {
        let mut unwrap = Unwrap::default();
        let mut worst = 0;
        let mut ran_over = 0;
        for k in 0..4000 {
            let truth = (60_000.0 * (f64::from(k) * 2e-3).sin()) as i32;
            let register = i32::from(truth as i16);
            let (carried, over) = unwrap.push([register, -register, 7], Some(1 << 16));
            worst = worst.max((carried[0] - truth).abs()).max(carried[2] - 7);
            ran_over += u32::from(over);
        }
        assert_eq!(worst, 0);
        assert!(ran_over >= 4);
        unwrap.forget();
        assert_eq!(unwrap.push([-3, 4, 5], Some(1 << 16)), ([-3, 4, 5], false));
    }
}
