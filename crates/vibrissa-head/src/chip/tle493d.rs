//! Infineon TLE493D-W2B6, asked by the master \[infineon2019tle493d\].
//!
//! A read from register 0 begins the next conversion before its first byte and gives the result of the one before. Collision avoidance, which
//! holds the clock down, is off, and so is the interrupt: a conversion is over long before the next slot.

use super::{Fault, Magnetometer, answering};
use crate::frame::ChipName;
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;
use vibrissa_beam::sensing::{Chip, Tle493d};

/// Addresses of the types A0 to A3.
const ADDRESSES: [u8; 4] = [0x35, 0x22, 0x78, 0x44];
/// Registers.
const FIRST: u8 = 0x00;
const DIAGNOSIS: u8 = 0x06;
const THRESHOLDS: core::ops::Range<usize> = 0x07..0x10;
const CONFIG: u8 = 0x10;
const MODE_1: u8 = 0x11;
/// Config: no temperature, a conversion with each read, twice the sensitivity.
const NO_TEMPERATURE: u8 = 1 << 7;
const TRIGGER_BY_READ: u8 = 0b01 << 4;
const SHORT_RANGE: u8 = 1 << 3;
const MODE_2: u8 = 0x13;
/// Mode 1: reads begin at register 0, no collision avoidance, no interrupt, asked by the master; the bits of the chip's address, and the
/// parity, which counts the period of the low-power modes in mode 2, too.
const MODE_1_SETTINGS: u8 = 0b0001_1101;
const MODE_1_ADDRESS: u8 = 0b0110_0000;
const MODE_1_PARITY: u8 = 1 << 7;
const MODE_2_PERIOD: u8 = 0b1110_0000;
/// Diagnosis in register 6: fuses are right, the test mode is on, all three axes and the first of them are converted, counter.
const FUSES: u8 = 1 << 6;
const TEST: u8 = 1 << 4;
const CONVERTED: u8 = 0b11 << 2;
const COUNTER: u8 = 0b11;
/// What the wake-up registers 0x07 to 0x0f share with the parity of the configuration: all thresholds, no state.
const PARITY_MASKS: [u8; 9] = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f, 0x3f, 0x3f];
/// Three axes, converted one after the other, with the tolerance of the chip's clock (µs).
const CONVERSION: u32 = 250;
/// Addresses of the reset sequence, and the wait after it (µs).
const RECOVERY: u8 = 0x7f;
const GENERAL_CALL: u8 = 0x00;
const AFTER_RESET: u32 = 60;

/// The driver.
#[derive(Clone, Copy, Debug)]
pub struct TleDriver {
    address: u8,
    settings: Tle493d,
    /// The counter of conversions at the last read.
    counter: Option<u8>,
}

impl TleDriver {
    /// A driver of the chip at this address: 0x35 of the type A0, 0x22, 0x78 and 0x44 of A1 to A3. A chip of another type is found, too.
    #[must_use]
    pub fn new(address: u8, settings: Tle493d) -> Self {
        Self { address, settings, counter: None }
    }

    /// The configuration with its parity, which counts the thresholds of the wake-up function, too.
    fn configuration(&self, thresholds: &[u8]) -> u8 {
        let range = if self.settings.short_range { SHORT_RANGE } else { 0 };
        let config = NO_TEMPERATURE | TRIGGER_BY_READ | range;
        let others: u32 = thresholds.iter().zip(PARITY_MASKS).map(|(byte, mask)| (byte & mask).count_ones()).sum();
        config | u8::from((config.count_ones() + others).is_multiple_of(2))
    }
}

/// What belongs into mode 1, of which the chip's address stays as it is.
fn mode(before: u8, mode_2: u8) -> u8 {
    let mode = before & MODE_1_ADDRESS | MODE_1_SETTINGS;
    let ones = mode.count_ones() + (mode_2 & MODE_2_PERIOD).count_ones();
    mode | if ones.is_multiple_of(2) { MODE_1_PARITY } else { 0 }
}

impl Magnetometer for TleDriver {
    fn name(&self) -> ChipName {
        ChipName::Tle493d
    }

    fn chip(&self) -> Chip {
        Chip::Tle493d(self.settings)
    }

    fn conversion_us(&self) -> u32 {
        CONVERSION
    }

    fn set_up<B: I2c, D: DelayNs>(&mut self, bus: &mut B, delay: &mut D) -> Result<(), Fault<B::Error>> {
        // Nobody acknowledges the reset, and some controllers send no transfer without a byte: what follows needs no reset.
        for _ in 0..2 {
            let _ = bus.read(RECOVERY, &mut [0]);
        }
        for _ in 0..2 {
            let _ = bus.write(GENERAL_CALL, &[]);
        }
        delay.delay_us(AFTER_RESET);
        // Whether reads begin at the register that was named or at 0, which the settings before say: at 0.
        let mut registers = [0; 20];
        let read = |address| bus.write_read(address, &[FIRST], &mut registers);
        self.address = answering(self.address, &ADDRESSES, read).map_err(Fault::Bus)?;
        let config = self.configuration(&registers[THRESHOLDS]);
        let mode = mode(registers[usize::from(MODE_1)], registers[usize::from(MODE_2)]);
        bus.write(self.address, &[CONFIG, config, mode]).map_err(Fault::Bus)?;
        // From here on reads begin at register 0.
        bus.read(self.address, &mut registers).map_err(Fault::Bus)?;
        let [diagnosis, read_config, read_mode] = [DIAGNOSIS, CONFIG, MODE_1].map(|at| registers[usize::from(at)]);
        if read_config != config || read_mode & !MODE_1_PARITY != mode & !MODE_1_PARITY || diagnosis & FUSES == 0 {
            return Err(Fault::Chip(diagnosis));
        }
        self.counter = None;
        Ok(())
    }

    /// The read that collects has begun it, but for the first one.
    fn begin<B: I2c>(&mut self, bus: &mut B) -> Result<(), Fault<B::Error>> {
        if self.counter.is_some() {
            return Ok(());
        }
        match self.collect(bus) {
            Ok(_) | Err(Fault::NotReady) => Ok(()),
            Err(fault) => Err(fault),
        }
    }

    fn collect<B: I2c>(&mut self, bus: &mut B) -> Result<[i32; 3], Fault<B::Error>> {
        let mut registers = [0; 7];
        bus.read(self.address, &mut registers).map_err(Fault::Bus)?;
        let [x, y, z, _, low_xy, low_z, diagnosis] = registers;
        if diagnosis & TEST != 0 || diagnosis & FUSES == 0 {
            return Err(Fault::Chip(diagnosis));
        }
        let before = self.counter.replace(diagnosis & COUNTER);
        if diagnosis & CONVERTED != CONVERTED || before == Some(diagnosis & COUNTER) {
            return Err(Fault::NotReady);
        }
        // Twelve bits, eight of them first.
        let value = |high: u8, low: u8| i32::from(i16::from_be_bytes([high, low << 4]) >> 4);
        Ok([value(x, low_xy >> 4), value(y, low_xy & 0xf), value(z, low_z & 0xf)])
    }
}
