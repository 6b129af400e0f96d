//! Drivers of magnetometers, written from their data sheets.
//!
//! A driver never waits for a conversion: it begins one, and collects it a slot later. No call takes longer than its bytes on the
//! bus, but for [`Magnetometer::set_up`], which waits for the chip's own start.

mod mlx90393;
mod tle493d;

pub use mlx90393::MlxDriver;
pub use tle493d::TleDriver;

use crate::frame::ChipName;
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{Error, ErrorKind, I2c};
use vibrissa_beam::sensing::Chip;

/// Why there is no reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault<E> {
    /// The bus: no acknowledgement, arbitration lost, a line held down.
    Bus(E),
    /// The conversion is not over, or its result was read before.
    NotReady,
    /// The chip refused a command or found an error in itself; its status byte.
    Chip(u8),
    /// The chip was switched off and on, and has lost its settings.
    Reset,
}

/// A three-axis magnetometer on an I2C bus.
pub trait Magnetometer {
    /// Which it is.
    fn name(&self) -> ChipName;

    /// What its counts mean.
    fn chip(&self) -> Chip;

    /// How long a conversion takes (µs), with the tolerance of its clock.
    fn conversion_us(&self) -> u32;

    /// Resets the chip and writes its settings; takes some milliseconds.
    ///
    /// # Errors
    ///
    /// Faults of the bus, settings that do not read back.
    fn set_up<B: I2c, D: DelayNs>(&mut self, bus: &mut B, delay: &mut D) -> Result<(), Fault<B::Error>>;

    /// Begins a conversion of all axes.
    ///
    /// # Errors
    ///
    /// As [`Fault`] says.
    fn begin<B: I2c>(&mut self, bus: &mut B) -> Result<(), Fault<B::Error>>;

    /// The registers of the conversion that was begun.
    ///
    /// # Errors
    ///
    /// As [`Fault`] says.
    fn collect<B: I2c>(&mut self, bus: &mut B) -> Result<[i32; 3], Fault<B::Error>>;
}

/// The address at which a chip takes a transfer: its own, or one of those that others of its kind have. The fault of its own where none does.
fn answering<E: Error>(own: u8, others: &[u8], mut transfer: impl FnMut(u8) -> Result<(), E>) -> Result<u8, E> {
    let fault = match transfer(own) {
        Ok(()) => return Ok(own),
        Err(fault) => fault,
    };
    // A bus that is held down is so for all of them.
    let is_absent = matches!(fault.kind(), ErrorKind::NoAcknowledge(_) | ErrorKind::Other);
    let found = others.iter().copied().filter(|_| is_absent).find(|address| transfer(*address).is_ok());
    found.ok_or(fault)
}
