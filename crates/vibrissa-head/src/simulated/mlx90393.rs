//! The MLX90393 as its data sheet describes it: commands, status byte, registers \[melexis2020mlx90393\].

use super::Device;
use vibrissa_beam::sensing::{Chip, Mlx90393, Vec3};

/// The registers and the state of the chip.
#[derive(Clone, Debug)]
pub struct MlxRegisters {
    /// The flux along its axes (T), which the caller sets.
    pub flux: Vec3,
    address: u8,
    registers: [u16; 64],
    /// Its memory corrects a bit: it says so in every status, and works.
    pub corrects_a_bit: bool,
    /// The chip was reset, and nobody was told.
    reset: bool,
    /// When the conversion ends (µs), and what it gives.
    conversion: Option<(u64, [i32; 3])>,
    answer: [u8; 9],
}

impl MlxRegisters {
    /// A chip that was just switched on.
    #[must_use]
    pub fn new(address: u8) -> Self {
        let mut chip = Self {
            flux: [0.0; 3],
            address,
            registers: [0; 64],
            corrects_a_bit: false,
            reset: true,
            conversion: None,
            answer: [0; 9],
        };
        chip.power_cycle();
        chip
    }

    /// The settings that its registers hold.
    #[must_use]
    pub fn settings(&self) -> Mlx90393 {
        let [first, _, third] = [self.registers[0], self.registers[1], self.registers[2]];
        Mlx90393 {
            gain: (first >> 4 & 7) as u8,
            resolution: (third >> 5 & 3) as u8,
            oversampling: (third & 3) as u8,
            filter: (third >> 2 & 7) as u8,
        }
    }

    fn status(&mut self, error: bool) -> u8 {
        let single = u8::from(self.conversion.is_some()) << 5;
        let corrected = u8::from(self.corrects_a_bit) << 3;
        single | u8::from(error) << 4 | corrected | u8::from(core::mem::take(&mut self.reset)) << 2
    }

    fn answer(&mut self, error: bool, bytes: &[u8]) {
        self.answer = [0; 9];
        self.answer[0] = self.status(error);
        self.answer[1..=bytes.len()].copy_from_slice(bytes);
    }
}

impl Device for MlxRegisters {
    fn answers(&self, address: u8) -> bool {
        address == self.address
    }

    fn start(&mut self, _: u8, _: bool) {}

    fn written(&mut self, bytes: &[u8], now_us: u64) {
        match *bytes {
            // SM, all axes.
            [0x3e] => {
                let error = self.conversion.is_some_and(|(end, _)| end > now_us);
                if !error {
                    let chip = Chip::Mlx90393(self.settings());
                    let time = chip.conversion_time().unwrap_or_default();
                    self.conversion = Some((now_us + (time * 1e6) as u64, chip.counts(self.flux)));
                }
                self.answer(error, &[]);
            }
            // RM, all axes.
            [0x4e] => match self.conversion {
                Some((end, counts)) if end <= now_us => {
                    self.conversion = None;
                    let mut bytes = [0; 6];
                    for (pair, count) in bytes.chunks_exact_mut(2).zip(counts) {
                        pair.copy_from_slice(&(count as u16).to_be_bytes());
                    }
                    self.answer(false, &bytes);
                }
                _ => self.answer(true, &[]),
            },
            [0x50, register] => {
                let value = self.registers[usize::from(register >> 2)].to_be_bytes();
                self.answer(false, &value);
            }
            [0x60, high, low, register] => {
                self.registers[usize::from(register >> 2)] = u16::from_be_bytes([high, low]);
                self.answer(false, &[]);
            }
            [0x80] => {
                self.conversion = None;
                self.answer(false, &[]);
            }
            [0xf0] => {
                self.power_cycle();
                self.answer(false, &[]);
            }
            _ => self.answer(true, &[]),
        }
    }

    fn read(&mut self, bytes: &mut [u8], _: u64) {
        // Beyond what it has to say the line stays high.
        bytes.fill(0xff);
        let length = bytes.len().min(self.answer.len());
        bytes[..length].copy_from_slice(&self.answer[..length]);
    }

    fn power_cycle(&mut self) {
        self.registers = [0; 64];
        // What the volatile registers are loaded with from the factory: gain 7, HALLCONF 0xc.
        self.registers[0] = 0x007c;
        self.conversion = None;
        self.reset = true;
    }
}
