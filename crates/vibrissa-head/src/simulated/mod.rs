//! Chips on a bus that are simulated byte by byte from their data sheets, with the faults of a bus. They share no code with the drivers.

mod lines;
mod mlx90393;
mod noise;
mod rehearsal;
mod tle493d;

pub use lines::HeldLines;
pub use mlx90393::MlxRegisters;
pub use noise::FluxNoise;
pub use rehearsal::{NOISE, Rehearsal, calibration};
pub use tle493d::TleRegisters;

use crate::bus::{self, Bus};
use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};

/// A chip as the bus sees it.
pub trait Device {
    /// Whether it answers to this address.
    fn answers(&self, address: u8) -> bool;
    /// The master has written these bytes.
    fn written(&mut self, bytes: &[u8], now_us: u64);
    /// The master reads.
    fn read(&mut self, bytes: &mut [u8], now_us: u64);
    /// A start condition.
    fn start(&mut self, address: u8, reads: bool);
    /// The supply fails and comes back.
    fn power_cycle(&mut self);
}

/// A bus with one chip.
#[derive(Clone, Debug)]
pub struct SimulatedBus<D> {
    /// The chip.
    pub device: D,
    /// The time (µs), which the caller moves on.
    pub now_us: u64,
    /// Transfers that are not acknowledged from now on.
    pub unacknowledged: u32,
    /// Clocks that the chip waits for while it holds the data line; more than nine for a line that stays down.
    pub held_for: u8,
    /// The chip holds the clock down.
    pub clock_held: bool,
    /// The next transfer breaks off in the middle of a byte, after which the chip holds the data line for so many clocks.
    pub cut_off: Option<u8>,
    /// As some controllers are: transfers without a byte are refused.
    pub refuses_empty: bool,
    /// Transfers that were begun on lines that the chip holds down: a controller may wait there for ever.
    pub hung: u32,
    /// Transfers so far.
    pub transfers: u64,
}

impl<D: Device> SimulatedBus<D> {
    /// A bus without faults at time 0.
    pub fn new(device: D) -> Self {
        Self {
            device,
            now_us: 0,
            unacknowledged: 0,
            held_for: 0,
            clock_held: false,
            cut_off: None,
            refuses_empty: false,
            hung: 0,
            transfers: 0,
        }
    }
}

impl<D> ErrorType for SimulatedBus<D> {
    type Error = ErrorKind;
}

impl<D: Device> I2c for SimulatedBus<D> {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        self.transfers += 1;
        if self.held_for > 0 || self.clock_held {
            self.hung += 1;
            return Err(ErrorKind::ArbitrationLoss);
        }
        if let Some(clocks) = self.cut_off.take() {
            self.held_for = clocks;
            return Err(ErrorKind::ArbitrationLoss);
        }
        let is_empty = |operation: &Operation<'_>| match operation {
            Operation::Write(bytes) => bytes.is_empty(),
            Operation::Read(bytes) => bytes.is_empty(),
        };
        if self.refuses_empty && operations.iter().any(is_empty) {
            return Err(ErrorKind::Other);
        }
        if self.unacknowledged > 0 {
            self.unacknowledged -= 1;
            return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        }
        for operation in operations {
            self.device.start(address, matches!(operation, Operation::Read(_)));
            if !self.device.answers(address) {
                return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
            }
            match operation {
                Operation::Write(bytes) => self.device.written(bytes, self.now_us),
                Operation::Read(bytes) => self.device.read(bytes, self.now_us),
            }
        }
        Ok(())
    }
}

impl<D: Device> Bus for SimulatedBus<D> {
    fn is_idle(&mut self) -> bool {
        self.held_for == 0 && !self.clock_held
    }

    fn free(&mut self) -> bool {
        let mut lines = HeldLines::new(self.held_for).with_clock_held(self.clock_held);
        let clocks = bus::free(&mut lines);
        self.held_for = lines.held_for();
        clocks.is_some()
    }
}
