//! What a head is told.

use crate::calibration::Calibration;
use crate::packet::{self, Damage, LONGEST};
use serde::{Deserialize, Serialize};

/// Least and most readings a second (Hz).
pub const RATES: core::ops::RangeInclusive<u16> = 10..=1000;

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "nothing may allocate, and there is one at a time")]
pub enum Command {
    /// Say who you are.
    Identify,
    /// The whisker is free: the mean of the next so many readings is the flux at rest, 1 or more.
    Tare(u16),
    /// So many readings a second, of [`RATES`].
    Rate(u16),
    /// Moments by this calibration from now on; what was tared before is forgotten.
    Load(Calibration),
    /// No moments any more.
    Unload,
}

/// Why a command is not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// A number is out of its range or not finite.
    Range,
    /// There is no calibration whose rest could be set.
    Uncalibrated,
    /// The chip does not convert so fast.
    TooFast,
    /// The bytes were no command.
    Damaged,
}

impl Command {
    /// Writes the packet with the zero at its end; how many bytes, or none where `out` is too short.
    pub fn write(&self, out: &mut [u8]) -> Option<usize> {
        packet::write(self, out)
    }

    /// Reads a packet: the bytes between two zeros.
    ///
    /// # Errors
    ///
    /// What is wrong with the bytes.
    pub fn read(packet: &[u8]) -> Result<Self, Damage> {
        packet::read(packet)
    }
}

/// Commands out of bytes that come in pieces.
#[derive(Clone, Debug)]
pub struct Inbox {
    bytes: [u8; LONGEST],
    length: usize,
}

impl Default for Inbox {
    fn default() -> Self {
        Self { bytes: [0; LONGEST], length: 0 }
    }
}

impl Inbox {
    /// Takes a byte; a command where it was the last one of a packet. A packet that is too long is damaged.
    pub fn push(&mut self, byte: u8) -> Option<Result<Command, Damage>> {
        if byte != 0 {
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = byte;
            }
            self.length = (self.length + 1).min(LONGEST + 1);
            return None;
        }
        let length = core::mem::take(&mut self.length);
        match self.bytes.get(..length) {
            Some([]) => None,
            Some(packet) => Some(Command::read(packet)),
            None => Some(Err(Damage::Long)),
        }
    }
}
