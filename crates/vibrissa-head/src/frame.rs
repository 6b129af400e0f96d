//! What a head sends.

use crate::command::Refusal;
use crate::packet::{self, Damage};
use serde::{Deserialize, Serialize};

/// The version of the messages: another one is not understood.
pub const VERSION: u8 = 1;

/// One reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// The number of its slot; slots in which nothing could be read leave a gap. Begins anew after 2³².
    pub number: u32,
    /// The device's time at which its conversion began (µs), which begins anew after 2³².
    pub stamp_us: u32,
    /// The flux along the chip's axes (T).
    pub flux: [f32; 3],
    /// The moment in the whisker's plane (N m), of the flux as it is sent; none without a calibration, beyond its range, and where the
    /// chip saturates.
    pub moment: Option<f64>,
    /// The moment about the other transverse axis (N m), where the calibration has two axes.
    pub across: Option<f64>,
    /// What is to know of it.
    pub state: State,
}

/// What is to know of a reading, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct State(pub u8);

impl State {
    /// An axis is at the end of the converter.
    pub const SATURATED: u8 = 1;
    /// A register ran over since the reading before, and was carried on.
    pub const WRAPPED: u8 = 2;
    /// The flux is beyond the calibrated range.
    pub const BEYOND: u8 = 4;
    /// The bus was freed or the chip set up anew since the reading before: wraps in between would not be seen.
    pub const RECOVERED: u8 = 8;

    /// Whether this bit is set.
    #[must_use]
    pub fn has(self, bit: u8) -> bool {
        self.0 & bit != 0
    }
}

/// The magnetometer of a head.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ChipName {
    /// Melexis MLX90393.
    Mlx90393,
    /// Infineon TLE493D-W2B6.
    Tle493d,
}

/// Who sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// The version of the messages.
    pub version: u8,
    /// The magnetometer.
    pub chip: ChipName,
    /// Readings a second (Hz).
    pub rate: u16,
    /// How many axes its calibration has: 0 without one.
    pub calibrated_axes: u8,
}

/// What went wrong since the head was switched on, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Slots of the sampling clock.
    pub slots: u32,
    /// Slots without a reading.
    pub missed: u32,
    /// Faults of the bus.
    pub bus_faults: u32,
    /// Faults that the chip reported, and readings that were not ready.
    pub chip_faults: u32,
    /// Times the bus was freed by clocks.
    pub freed: u32,
    /// Times the bus stayed locked in spite of them.
    pub stuck: u32,
    /// Commands that could not be read.
    pub damaged_commands: u32,
}

/// A message from the head.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// A reading.
    Reading(Reading),
    /// What went wrong, once a second.
    Health(Health),
    /// Who sends.
    Identity(Identity),
    /// A command was done.
    Done,
    /// A command was refused.
    Refused(Refusal),
}

impl Message {
    /// Writes the packet with the zero at its end; how many bytes, or none where `out` is too short ([`crate::LONGEST`] never is).
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
