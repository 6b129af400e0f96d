//! Melexis MLX90393 in single measurements \[melexis2020mlx90393\].
//!
//! Burst mode has its own clock in steps of 20 ms; single measurements are begun by whoever counts time.

use super::{Fault, Magnetometer, answering};
use crate::frame::ChipName;
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;
use vibrissa_beam::sensing::{Chip, Mlx90393};

/// What is between the two ranges of addresses, 0x0c to 0x0f and 0x18 to 0x1b.
const OTHER_ADDRESS: u8 = 0x0c ^ 0x18;
/// Commands; the low bits of the first two choose z, y, x.
const SINGLE_MEASUREMENT: u8 = 0x30;
const READ_MEASUREMENT: u8 = 0x40;
const READ_REGISTER: u8 = 0x50;
const WRITE_REGISTER: u8 = 0x60;
const EXIT: u8 = 0x80;
const RESET: u8 = 0xf0;
/// All axes, without temperature.
const AXES: u8 = 0b1110;

/// Bits of the status byte. A corrected bit of the chip's memory, bit 3, is for information alone.
const STATUS_SINGLE: u8 = 1 << 5;
const STATUS_ERROR: u8 = 1 << 4;
const STATUS_RESET: u8 = 1 << 2;

/// Spinning rate of the Hall plates, as the sensitivity's table has it.
const HALLCONF: u16 = 0xc;
/// Only I2C, nothing on the trigger pin.
const COMMUNICATION: u16 = 0b11 << 13;
/// Waits after EX and RT (µs): the data sheet's 1 ms and 1.5 ms.
const AFTER_EXIT: u32 = 1000;
const AFTER_RESET: u32 = 1500;
/// Conversion times have 5 % tolerance: the chip's own clock.
const SLOWER: f64 = 1.05;

/// The driver.
#[derive(Clone, Copy, Debug)]
pub struct MlxDriver {
    address: u8,
    settings: Mlx90393,
}

impl MlxDriver {
    /// A driver of the chip at this address: 0x0c to 0x0f by the pins A0 and A1. There are chips of the same name at 0x18 to 0x1b, which are
    /// found, too.
    #[must_use]
    pub fn new(address: u8, settings: Mlx90393) -> Self {
        Self { address, settings }
    }

    /// Sends a command; the status byte.
    fn command<B: I2c>(&self, bus: &mut B, bytes: &[u8]) -> Result<u8, Fault<B::Error>> {
        let mut status = [0];
        bus.write_read(self.address, bytes, &mut status).map_err(Fault::Bus)?;
        if status[0] & STATUS_ERROR != 0 {
            return Err(Fault::Chip(status[0]));
        }
        Ok(status[0])
    }

    fn write<B: I2c>(&self, bus: &mut B, register: u8, value: u16) -> Result<(), Fault<B::Error>> {
        let [high, low] = value.to_be_bytes();
        self.command(bus, &[WRITE_REGISTER, high, low, register << 2])?;
        let mut answer = [0; 3];
        bus.write_read(self.address, &[READ_REGISTER, register << 2], &mut answer).map_err(Fault::Bus)?;
        if answer[1..] == [high, low] { Ok(()) } else { Err(Fault::Chip(answer[0])) }
    }

    /// The three registers of settings.
    fn registers(&self) -> [u16; 3] {
        let Mlx90393 { gain, resolution, oversampling, filter } = self.settings;
        let resolution = u16::from(resolution.min(3));
        [
            u16::from(gain.min(7)) << 4 | HALLCONF,
            COMMUNICATION,
            (resolution << 9 | resolution << 7 | resolution << 5)
                | u16::from(filter.min(7)) << 2
                | u16::from(oversampling.min(3)),
        ]
    }
}

impl Magnetometer for MlxDriver {
    fn name(&self) -> ChipName {
        ChipName::Mlx90393
    }

    fn chip(&self) -> Chip {
        Chip::Mlx90393(self.settings)
    }

    fn conversion_us(&self) -> u32 {
        (self.chip().conversion_time().unwrap_or_default() * SLOWER * 1e6) as u32 + 1
    }

    fn set_up<B: I2c, D: DelayNs>(&mut self, bus: &mut B, delay: &mut D) -> Result<(), Fault<B::Error>> {
        // A chip that measures refuses the reset; what it says to the exit is of no interest.
        let mut status = [0];
        let exit = |address| bus.write_read(address, &[EXIT], &mut status);
        self.address = answering(self.address, &[self.address ^ OTHER_ADDRESS], exit).map_err(Fault::Bus)?;
        delay.delay_us(AFTER_EXIT);
        bus.write_read(self.address, &[RESET], &mut status).map_err(Fault::Bus)?;
        delay.delay_us(AFTER_RESET);
        for (register, value) in (0..).zip(self.registers()) {
            self.write(bus, register, value)?;
        }
        Ok(())
    }

    fn begin<B: I2c>(&mut self, bus: &mut B) -> Result<(), Fault<B::Error>> {
        let status = self.command(bus, &[SINGLE_MEASUREMENT | AXES])?;
        if status & STATUS_RESET != 0 {
            return Err(Fault::Reset);
        }
        if status & STATUS_SINGLE == 0 {
            return Err(Fault::Chip(status));
        }
        Ok(())
    }

    fn collect<B: I2c>(&mut self, bus: &mut B) -> Result<[i32; 3], Fault<B::Error>> {
        let mut answer = [0; 7];
        bus.write_read(self.address, &[READ_MEASUREMENT | AXES], &mut answer).map_err(Fault::Bus)?;
        let [status, x1, x0, y1, y0, z1, z0] = answer;
        if status & STATUS_RESET != 0 {
            return Err(Fault::Reset);
        }
        // A conversion that goes on answers with the error bit.
        if status & STATUS_ERROR != 0 {
            return Err(Fault::NotReady);
        }
        let unsigned = self.settings.resolution >= 2;
        let value = |high, low| {
            let bits = u16::from_be_bytes([high, low]);
            if unsigned { i32::from(bits) } else { i32::from(bits.cast_signed()) }
        };
        Ok([value(x1, x0), value(y1, y0), value(z1, z0)])
    }
}
