//! A locked I2C bus: a chip that was cut off in the middle of a byte holds the data line until it has seen the clocks that it waits for.
//!
//! What a controller makes of a line that is held down differs: some tell that they lost the arbitration, some wait for ever. So nobody begins a
//! transfer on such lines: [`Bus::is_idle`] looks at the pins first.

use embedded_hal::i2c::{Error, ErrorKind, ErrorType, I2c, Operation};

/// Clocks that free any chip: eight bits of a byte and its acknowledgement.
pub const CLOCKS: u8 = 9;

/// The two lines of a bus as open-drain pins: high is let go.
pub trait Lines {
    /// Pulls the clock down or lets it go.
    fn clock(&mut self, high: bool);
    /// Pulls the data line down or lets it go.
    fn data(&mut self, high: bool);
    /// Whether the clock is high.
    fn clock_is_high(&mut self) -> bool;
    /// Whether the data line is high.
    fn data_is_high(&mut self) -> bool;
    /// Waits half a clock: 5 µs for 100 kHz.
    fn wait(&mut self);
}

/// A bus that can be freed.
pub trait Bus: I2c {
    /// Whether both lines are high, as they are between two transfers unless a chip holds one down.
    fn is_idle(&mut self) -> bool;

    /// Frees the bus; whether it is free. Firmware takes the pins for [`free`] and gives them back.
    fn free(&mut self) -> bool;
}

impl<B: Bus + ?Sized> Bus for &mut B {
    fn is_idle(&mut self) -> bool {
        (**self).is_idle()
    }

    fn free(&mut self) -> bool {
        (**self).free()
    }
}

/// Why a transfer came to nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransferError<E> {
    /// A chip holds a line down: nothing was sent.
    Held,
    /// What the controller says.
    Controller(E),
}

impl<E: Error> Error for TransferError<E> {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Held => ErrorKind::Bus,
            Self::Controller(error) => error.kind(),
        }
    }
}

/// A bus that begins no transfer while a chip holds a line down.
#[derive(Debug)]
pub(crate) struct Guarded<'a, B>(pub(crate) &'a mut B);

impl<B: Bus> ErrorType for Guarded<'_, B> {
    type Error = TransferError<B::Error>;
}

impl<B: Bus> I2c for Guarded<'_, B> {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Self::Error> {
        if !self.0.is_idle() {
            return Err(TransferError::Held);
        }
        self.0.transaction(address, operations).map_err(TransferError::Controller)
    }
}

/// Clocks until the data line is let go, nine times at most, then a stop condition; how many clocks it took, none where the line stays
/// down, and where a chip holds the clock, against which no master can do anything.
pub fn free(lines: &mut impl Lines) -> Option<u8> {
    lines.data(true);
    lines.clock(true);
    lines.wait();
    if !lines.clock_is_high() {
        return None;
    }
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
