//! The TLE493D-W2B6 as its data sheet describes it: registers, reads that begin conversions, parities \[infineon2019tle493d\].

use super::Device;
use vibrissa_beam::sensing::{Chip, Tle493d, Vec3};

/// Addresses of the types A0 to A3, by the two bits of mode 1.
const ADDRESSES: [u8; 4] = [0x35, 0x22, 0x78, 0x44];
/// How long three axes take (µs).
const CONVERSION: u64 = 170;

/// The registers and the state of the chip.
#[derive(Clone, Debug)]
pub struct TleRegisters {
    /// The flux along its axes (T), which the caller sets.
    pub flux: Vec3,
    address: u8,
    registers: [u8; 0x17],
    pointer: usize,
    /// When the conversion ends (µs), and what it gives.
    conversion: Option<(u64, [i32; 3])>,
    /// Starts of the reset sequence so far.
    sequence: u8,
}

impl TleRegisters {
    /// A chip that was just switched on.
    #[must_use]
    pub fn new(address: u8) -> Self {
        let mut chip =
            Self { flux: [0.0; 3], address, registers: [0; 0x17], pointer: 0, conversion: None, sequence: 0 };
        chip.power_cycle();
        chip
    }

    /// Whether the parity of the configuration is that of the data sheet: odd with the thresholds of the wake-up function.
    #[must_use]
    pub fn is_configuration_right(&self) -> bool {
        let mut ones = 0;
        for (register, byte) in self.registers.iter().enumerate().take(0x11).skip(7) {
            let state = [(0x0d, 0x80), (0x0e, 0xc0), (0x0f, 0xc0)];
            let mask = state.into_iter().find(|(at, _)| *at == register).map_or(0, |(_, mask)| mask);
            ones += (byte & !mask).count_ones();
        }
        ones % 2 == 1
    }

    /// Whether the parity of the first mode register is right: odd with the period of the low-power modes.
    #[must_use]
    pub fn is_mode_right(&self) -> bool {
        (self.registers[0x11].count_ones() + (self.registers[0x13] & 0xe0).count_ones()) % 2 == 1
    }

    fn reads_from_zero(&self) -> bool {
        self.registers[0x11] & 0x10 != 0
    }

    fn finish(&mut self, now_us: u64) {
        let Some((_, counts)) = self.conversion.take_if(|(end, _)| *end <= now_us) else { return };
        let bits = counts.map(|count| (count as u16) & 0xfff);
        for (register, value) in bits.into_iter().enumerate() {
            self.registers[register] = (value >> 4) as u8;
        }
        self.registers[4] = ((bits[0] & 0xf) << 4 | bits[1] & 0xf) as u8;
        self.registers[5] = self.registers[5] & 0xf0 | (bits[2] & 0xf) as u8;
        let frame = (self.registers[6] + 1) & 3;
        self.registers[6] = self.registers[6] & 0xf0 | 0b1100 | frame;
    }
}

impl Device for TleRegisters {
    fn answers(&self, address: u8) -> bool {
        address == ADDRESSES[usize::from(self.registers[0x11] >> 5 & 3)]
    }

    fn start(&mut self, address: u8, reads: bool) {
        // Two reads of 0xff, then two writes of 0x00.
        self.sequence = match (self.sequence, address, reads) {
            (0 | 1, 0x7f, true) | (2 | 3, 0, false) => self.sequence + 1,
            (_, 0x7f, true) => 1,
            _ => 0,
        };
        if self.sequence == 4 {
            self.power_cycle();
        }
    }

    fn written(&mut self, bytes: &[u8], _: u64) {
        let Some((first, values)) = bytes.split_first() else { return };
        self.pointer = usize::from(first & 0x1f);
        for (value, register) in values.iter().zip(self.pointer..) {
            if let Some(place) = self.registers.get_mut(register).filter(|_| register >= 7) {
                *place = *value;
            }
        }
    }

    fn read(&mut self, bytes: &mut [u8], now_us: u64) {
        self.finish(now_us);
        let first = if self.reads_from_zero() { 0 } else { self.pointer };
        for (byte, register) in bytes.iter_mut().zip(first..) {
            *byte = self.registers.get(register).copied().unwrap_or(0xff);
        }
        let by_read = self.registers[0x10] & 0x30 == 0x10 && self.registers[0x11] & 3 == 1;
        if by_read && first == 0 && self.conversion.is_none() {
            let chip = Chip::Tle493d(Tle493d { short_range: self.registers[0x10] & 8 != 0 });
            self.conversion = Some((now_us + CONVERSION, chip.counts(self.flux)));
        }
    }

    fn power_cycle(&mut self) {
        self.registers = [0; 0x17];
        for axis in [7, 9, 11] {
            (self.registers[axis], self.registers[axis + 1]) = (0x80, 0x7f);
        }
        for register in [0x0d, 0x0e, 0x0f] {
            self.registers[register] = 0x38;
        }
        self.registers[0x10] = 0x01;
        let kind = ADDRESSES.iter().position(|address| *address == self.address).unwrap_or(0);
        self.registers[0x11] = 0x80 | (kind as u8) << 5;
        // Fuses are right, nothing is converted.
        self.registers[6] = 0x60;
        (self.conversion, self.sequence, self.pointer) = (None, 0, 0);
    }
}
