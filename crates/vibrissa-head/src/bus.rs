//! A locked I2C bus: a chip that was cut off in the middle of a byte holds the data line until it has seen the clocks that it waits for.

use embedded_hal::i2c::I2c;

/// Clocks that free any chip: eight bits of a byte and its acknowledgement.
pub const CLOCKS: u8 = 9;

/// The two lines of a bus as open-drain pins: high is let go.
pub trait Lines {
    /// Pulls the clock down or lets it go.
    fn clock(&mut self, high: bool);
    /// Pulls the data line down or lets it go.
    fn data(&mut self, high: bool);
    /// Whether the data line is high.
    fn data_is_high(&mut self) -> bool;
    /// Waits half a clock: 5 µs for 100 kHz.
    fn wait(&mut self);
}

/// A bus that can be freed.
pub trait Bus: I2c {
    /// Frees the bus; whether it is free. Firmware takes the pins for [`free`] and gives them back.
    fn free(&mut self) -> bool;
}

impl<B: Bus + ?Sized> Bus for &mut B {
    fn free(&mut self) -> bool {
        (**self).free()
    }
}

/// Clocks until the data line is let go, nine times at most, then a stop condition; how many clocks it took, none where the line stays
/// down.
pub fn free(lines: &mut impl Lines) -> Option<u8> {
    lines.data(true);
    lines.clock(true);
    lines.wait();
    let mut clocks = 0;
    while !lines.data_is_high() && clocks < CLOCKS {
        lines.clock(false);
        lines.wait();
        lines.clock(true);
        lines.wait();
        clocks += 1;
    }
    if !lines.data_is_high() {
        return None;
    }
    // A stop: the data line rises while the clock is high.
    lines.clock(false);
    lines.wait();
    lines.data(false);
    lines.wait();
    lines.clock(true);
    lines.wait();
    lines.data(true);
    lines.wait();
    Some(clocks)
}
