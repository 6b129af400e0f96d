//! The I2C bus of the board, whose pins are taken for clocks when a chip holds it.

use bsp::board;
use bsp::hal::gpio::{Output, Port};
use bsp::hal::iomuxc::{self, ErasedPad, lpi2c};
use bsp::hal::lpi2c::{ClockSpeed, Lpi2c, Timing};
use bsp::pins::common::{P16, P17};
use bsp::ral;
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};
use teensy4_bsp as bsp;
use vibrissa_head::bus::{self, Bus, Lines};

/// The driver of the chip on this board.
#[cfg(not(feature = "tle493d"))]
pub(crate) type Chip = vibrissa_head::chip::MlxDriver;

/// The driver of the chip on this board.
#[cfg(feature = "tle493d")]
pub(crate) type Chip = vibrissa_head::chip::TleDriver;

/// The driver of the chip on this board.
#[cfg(not(feature = "tle493d"))]
pub(crate) fn chip() -> Chip {
    Chip::new(0x0c, vibrissa_beam::sensing::Mlx90393::default())
}

/// The driver of the chip on this board.
#[cfg(feature = "tle493d")]
pub(crate) fn chip() -> Chip {
    Chip::new(0x35, vibrissa_beam::sensing::Tle493d::default())
}

/// Timing of the bus: both chips take 400 kHz.
const TIMING: Timing = Timing::ideal(board::LPI2C_FREQUENCY, ClockSpeed::KHz400);
/// Functions of the two pads: the bus, and plain pins.
const AS_BUS: u32 = 1;
const AS_PIN: u32 = 5;
/// Pins 16 and 17 at the first port.
const CLOCK_BIT: u32 = 23;
const DATA_BIT: u32 = 22;
/// Half a clock while a bus is freed (ns).
const HALF: u32 = 5000;

/// Waits by cycles of the processor.
pub(crate) struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        let cycles = u64::from(ns) * u64::from(board::ARM_FREQUENCY / 1_000_000) / 1000;
        cortex_m::asm::delay(cycles as u32 + 1);
    }
}

/// The bus.
pub(crate) struct Wires {
    controller: Lpi2c,
    pads: [ErasedPad; 2],
    clock: Output,
    data: Output,
}

impl Wires {
    pub(crate) fn new(block: ral::lpi2c::LPI2C3, mut clock: P16, mut data: P17, mut port: Port) -> Self {
        lpi2c::prepare(&mut clock);
        lpi2c::prepare(&mut data);
        let (clock_pin, data_pin) =
            (Output::without_pin(&mut port, CLOCK_BIT), Output::without_pin(&mut port, DATA_BIT));
        clock_pin.set();
        data_pin.set();
        Self {
            controller: Lpi2c::without_pins(block, &TIMING),
            pads: [clock.erase(), data.erase()],
            clock: clock_pin,
            data: data_pin,
        }
    }

    fn connect(&mut self, function: u32) {
        for pad in &mut self.pads {
            iomuxc::alternate(pad, function);
        }
    }
}

impl ErrorType for Wires {
    type Error = ErrorKind;
}

impl I2c for Wires {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        self.controller.transaction(address, operations).map_err(|error| embedded_hal::i2c::Error::kind(&error))
    }
}

impl Bus for Wires {
    /// The pads' inputs stay on while the bus has them.
    fn is_idle(&mut self) -> bool {
        self.clock.is_pad_high() && self.data.is_pad_high()
    }

    fn free(&mut self) -> bool {
        self.connect(AS_PIN);
        let is_free = bus::free(self).is_some();
        self.connect(AS_BUS);
        self.controller.reset_controller();
        self.controller.disabled(|controller| controller.set_timings(&TIMING));
        self.controller.set_controller_enable(true);
        is_free
    }
}

/// Lets a line go or pulls it down; the pads are open drains.
fn set(pin: &Output, high: bool) {
    if high { pin.set() } else { pin.clear() }
}

impl Lines for Wires {
    fn clock(&mut self, high: bool) {
        set(&self.clock, high);
    }

    fn data(&mut self, high: bool) {
        set(&self.data, high);
    }

    fn clock_is_high(&mut self) -> bool {
        self.clock.is_pad_high()
    }

    fn data_is_high(&mut self) -> bool {
        self.data.is_pad_high()
    }

    fn wait(&mut self) {
        Delay.delay_ns(HALF);
    }
}
