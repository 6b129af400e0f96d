//! The sensor head on a Raspberry Pi Pico: the chip's data line on GPIO 4, its clock on GPIO 5, packets over USB.
//!
//! Not tried on a board: it is built and linked.

#![no_std]
#![no_main]

mod wires;

use embedded_alloc::LlffHeap;
use rp2040_hal as hal;
use usb_device::bus::UsbBusAllocator;
use usb_device::device::{StringDescriptors, UsbDeviceBuilder, UsbVidPid};
use usbd_serial::{SerialPort, USB_CLASS_CDC};
use vibrissa_head::LONGEST;
use vibrissa_head::frame::Message;
use vibrissa_head::head::Head;
use wires::{Wires, chip};

#[global_allocator]
static NOTHING: LlffHeap = LlffHeap::empty();

/// What the boot ROM starts: the flash of a Pico.
#[unsafe(link_section = ".boot2")]
#[used]
static BOOT_LOADER: [u8; 256] = rp2040_boot2::BOOT_LOADER_W25Q080;

/// The crystal (Hz).
const CRYSTAL: u32 = 12_000_000;
/// Readings a second until a command says otherwise (Hz).
const RATE: u16 = 300;
/// A chip that holds the clock down for ever stops the loop: after so long the board starts anew (µs).
const WATCHDOG: u32 = 200_000;
/// A free identity for serial ports of the USB community.
const IDENTITY: UsbVidPid = UsbVidPid(0x16c0, 0x27dd);

#[hal::entry]
fn main() -> ! {
    let _ = run();
    // Without a watchdog's food the board starts anew.
    loop {
        cortex_m::asm::wfi();
    }
}

/// Samples and sends; ends only where the board cannot start.
fn run() -> Option<()> {
    let mut parts = hal::pac::Peripherals::take()?;
    let mut watchdog = hal::Watchdog::new(parts.WATCHDOG);
    let clocks = hal::clocks::init_clocks_and_plls(
        CRYSTAL,
        parts.XOSC,
        parts.CLOCKS,
        parts.PLL_SYS,
        parts.PLL_USB,
        &mut parts.RESETS,
        &mut watchdog,
    )
    .ok()?;
    let timer = hal::Timer::new(parts.TIMER, &mut parts.RESETS, &clocks);
    let sio = hal::Sio::new(parts.SIO);
    let pins = hal::gpio::Pins::new(parts.IO_BANK0, parts.PADS_BANK0, sio.gpio_bank0, &mut parts.RESETS);
    let bus = hal::usb::UsbBus::new(parts.USBCTRL_REGS, parts.USBCTRL_DPRAM, clocks.usb_clock, true, &mut parts.RESETS);
    let allocator = UsbBusAllocator::new(bus);
    let mut port = SerialPort::new(&allocator);
    let words = StringDescriptors::default().manufacturer("vibrissa").product("whisker sensor head");
    let mut usb =
        UsbDeviceBuilder::new(&allocator, IDENTITY).strings(&[words]).ok()?.device_class(USB_CLASS_CDC).build();

    let mut wires = Wires::new(parts.I2C0, pins.gpio4, pins.gpio5, parts.RESETS, clocks.system_clock, timer);
    let mut head = Head::new(chip(), RATE);
    watchdog.start(hal::fugit::ExtU32::micros(WATCHDOG));
    let mut due = timer.get_counter().ticks();
    loop {
        watchdog.feed();
        if usb.poll(&mut [&mut port]) {
            let mut bytes = [0; 64];
            let count = port.read(&mut bytes).unwrap_or(0);
            for byte in &bytes[..count] {
                if let Some(answer) = head.receive(*byte) {
                    send(&mut port, &answer);
                }
            }
        }
        let now = timer.get_counter().ticks();
        if now < due {
            continue;
        }
        // A slot that is late by more than one is left out; the head counts it by the time.
        let period = u64::from(head.period_us());
        due += period * (1 + (now - due) / period);
        let mut delay = timer;
        if let Some(reading) = head.slot(&mut wires, &mut delay, now as u32) {
            send(&mut port, &Message::Reading(reading));
        }
        if let Some(health) = head.once_a_second() {
            send(&mut port, &health);
        }
    }
}

/// Sends a packet; where nobody listens it is lost, and its number is missing.
fn send<B: usb_device::bus::UsbBus>(port: &mut SerialPort<'_, B>, message: &Message) {
    let mut packet = [0; LONGEST];
    let length = message.write(&mut packet).unwrap_or(0);
    let _ = port.write(&packet[..length]);
}

#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
