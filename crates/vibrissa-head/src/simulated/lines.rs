//! The two lines of a bus of which a chip holds one down.

use crate::bus::Lines;

/// Lines that are let go after some clocks.
#[derive(Clone, Copy, Debug)]
pub struct HeldLines {
    held_for: u8,
    clock_held: bool,
    clock: bool,
    data: bool,
    stops: u32,
}

impl HeldLines {
    /// Lines whose data line is held for so many clocks.
    #[must_use]
    pub fn new(held_for: u8) -> Self {
        Self { held_for, clock_held: false, clock: true, data: true, stops: 0 }
    }

    /// The same lines with a clock that a chip holds down for ever, too.
    #[must_use]
    pub fn with_clock_held(self, clock_held: bool) -> Self {
        Self { clock_held, ..self }
    }

    /// Clocks that the chip still waits for.
    #[must_use]
    pub fn held_for(&self) -> u8 {
        self.held_for
    }

    /// Stop conditions so far.
    #[must_use]
    pub fn stops(&self) -> u32 {
        self.stops
    }
}

impl Lines for HeldLines {
    fn clock(&mut self, high: bool) {
        if high && !self.clock && !self.clock_held {
            self.held_for = self.held_for.saturating_sub(1);
        }
        self.clock = high;
    }

    fn data(&mut self, high: bool) {
        let rises = high && !self.data;
        self.stops += u32::from(rises && self.clock && self.held_for == 0);
        self.data = high;
    }

    fn clock_is_high(&mut self) -> bool {
        self.clock && !self.clock_held
    }

    fn data_is_high(&mut self) -> bool {
        self.data && self.held_for == 0
    }

    fn wait(&mut self) {}
}
