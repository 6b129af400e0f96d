//! The I2C bus of the board, whose pins are taken for clocks when a chip holds it.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};
use hal::clocks::{Clock, SystemClock};
use hal::fugit::RateExtU32;
use hal::gpio::bank0::{Gpio4, Gpio5};
use hal::gpio::{FunctionI2C, FunctionNull, InOutPin, Pin, PullDown, PullUp};
use hal::pac::{I2C0, RESETS};
use rp2040_hal as hal;
use vibrissa_head::bus::{self, Bus, Lines};

type Data<F> = Pin<Gpio4, F, PullUp>;
type Wire<F> = Pin<Gpio5, F, PullUp>;
type Controller = hal::I2C<I2C0, (Data<FunctionI2C>, Wire<FunctionI2C>)>;

/// Clock of the bus (Hz): both chips take it.
const SPEED: u32 = 400_000;
/// The two pins among those of the bank.
const LINES: u32 = 1 << 4 | 1 << 5;
/// Half a clock while a bus is freed (µs).
const HALF: u32 = 5;

/// The driver of the chip on this board.
#[cfg(not(feature = "tle493d"))]
pub(crate) fn chip() -> vibrissa_head::chip::MlxDriver {
    vibrissa_head::chip::MlxDriver::new(0x0c, vibrissa_beam::sensing::Mlx90393::default())
}

/// The driver of the chip on this board.
#[cfg(feature = "tle493d")]
pub(crate) fn chip() -> vibrissa_head::chip::TleDriver {
    vibrissa_head::chip::TleDriver::new(0x35, vibrissa_beam::sensing::Tle493d::default())
}

/// The bus.
pub(crate) struct Wires {
    /// None only while it is freed.
    controller: Option<Controller>,
    resets: RESETS,
    clock: SystemClock,
    timer: hal::Timer,
}

impl Wires {
    pub(crate) fn new(
        block: I2C0,
        data: Pin<Gpio4, FunctionNull, PullDown>,
        wire: Pin<Gpio5, FunctionNull, PullDown>,
        mut resets: RESETS,
        clock: SystemClock,
        timer: hal::Timer,
    ) -> Self {
        let (data, wire) = (data.reconfigure(), wire.reconfigure());
        let controller = hal::I2C::i2c0(block, data, wire, SPEED.Hz(), &mut resets, clock.freq());
        Self { controller: Some(controller), resets, clock, timer }
    }
}

impl ErrorType for Wires {
    type Error = ErrorKind;
}

impl I2c for Wires {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        let Some(controller) = &mut self.controller else { return Err(ErrorKind::Bus) };
        controller.transaction(address, operations).map_err(|error| embedded_hal::i2c::Error::kind(&error))
    }
}

impl Bus for Wires {
    fn is_idle(&mut self) -> bool {
        hal::Sio::read_bank0() & LINES == LINES
    }

    fn free(&mut self) -> bool {
        let Some(controller) = self.controller.take() else { return false };
        let (block, (data, wire)) = controller.free(&mut self.resets);
        let mut lines = Open { data: InOutPin::new(data), wire: InOutPin::new(wire), timer: self.timer };
        let is_free = bus::free(&mut lines).is_some();
        let (data, wire) = (lines.data.release(), lines.wire.release());
        self.controller = Some(hal::I2C::i2c0(block, data, wire, SPEED.Hz(), &mut self.resets, self.clock.freq()));
        is_free
    }
}

/// The pins as open-drain lines.
struct Open {
    data: InOutPin<Data<FunctionI2C>>,
    wire: InOutPin<Wire<FunctionI2C>>,
    timer: hal::Timer,
}

/// Pulls a line down or lets it go; pins of this board cannot fail.
fn set(line: &mut impl OutputPin, high: bool) {
    let _ = if high { line.set_high() } else { line.set_low() };
}

impl Lines for Open {
    fn clock(&mut self, high: bool) {
        set(&mut self.wire, high);
    }

    fn data(&mut self, high: bool) {
        set(&mut self.data, high);
    }

    fn clock_is_high(&mut self) -> bool {
        self.wire.is_high().unwrap_or(false)
    }

    fn data_is_high(&mut self) -> bool {
        self.data.is_high().unwrap_or(false)
    }

    fn wait(&mut self) {
        self.timer.delay_us(HALF);
    }
}
