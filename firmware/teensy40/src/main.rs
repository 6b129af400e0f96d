//! The sensor head on the paper's Teensy 4.0: the chip's clock on pin 16, its data line on pin 17, packets over USB.
//!
//! Not tried on a board: it is built and linked.

#![no_std]
#![no_main]

mod wires;

use embedded_alloc::LlffHeap;

#[global_allocator]
static NOTHING: LlffHeap = LlffHeap::empty();

#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

#[rtic::app(device = teensy4_bsp, peripherals = true)]
mod app {
    use crate::wires::{self, Wires};
    use bsp::board;
    use bsp::hal::gpt::{ClockSource, Gpt};
    use bsp::hal::pit::{Channel, Pit};
    use bsp::usbd::{BusAdapter, EndpointMemory, EndpointState, Speed};
    use core::sync::atomic::{AtomicU32, Ordering};
    use cortex_m::peripheral::SCB;
    use cortex_m::peripheral::syst::SystClkSource;
    use teensy4_bsp as bsp;
    use usb_device::bus::UsbBusAllocator;
    use usb_device::device::{StringDescriptors, UsbDevice, UsbDeviceBuilder, UsbDeviceState, UsbVidPid};
    use usbd_serial::{SerialPort, USB_CLASS_CDC};
    use vibrissa_head::LONGEST;
    use vibrissa_head::frame::Message;
    use vibrissa_head::head::Head;

    /// Readings a second until a command says otherwise (Hz): the paper's rate.
    const RATE: u16 = 300;
    /// Looks of the guard a second.
    const LOOKS: u32 = 50;
    /// So many looks without a slot in between, and the board starts anew: half a second, five slots of the slowest rate.
    const PATIENCE: u32 = 25;
    /// A free identity for serial ports of the USB community.
    const IDENTITY: UsbVidPid = UsbVidPid(0x16c0, 0x27dd);
    /// Ticks of the counter in a microsecond.
    const TICKS: u32 = board::PERCLK_FREQUENCY / 1_000_000;

    /// Looks of the guard since the last slot.
    static WAITED: AtomicU32 = AtomicU32::new(0);

    #[shared]
    struct Shared {
        head: Head<wires::Chip>,
        port: SerialPort<'static, BusAdapter>,
    }

    #[local]
    struct Local {
        usb: UsbDevice<'static, BusAdapter>,
        is_configured: bool,
        wires: Wires,
        pit: Pit,
        counter: Gpt,
        /// The counter at the last slot, and the time (µs).
        last: (u32, u32),
        rate: u16,
    }

    #[init(local = [
        memory: EndpointMemory<2048> = EndpointMemory::new(),
        state: EndpointState = EndpointState::max_endpoints(),
        allocator: Option<UsbBusAllocator<BusAdapter>> = None,
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let board::Resources { usb, pins, gpio1, lpi2c3, mut pit, mut gpt1, .. } = board::t40(cx.device);
        let adapter = BusAdapter::with_speed(usb, cx.local.memory, cx.local.state, Speed::LowFull);
        adapter.set_interrupts(true);
        let allocator = cx.local.allocator.insert(UsbBusAllocator::new(adapter));
        let port = SerialPort::new(allocator);
        let words = [StringDescriptors::default().manufacturer("vibrissa").product("whisker sensor head")];
        let builder = UsbDeviceBuilder::new(allocator, IDENTITY).device_class(USB_CLASS_CDC);
        // Without its names a device is a serial port all the same.
        let usb = match builder.strings(&words) {
            Ok(named) => named.build(),
            Err(_) => UsbDeviceBuilder::new(allocator, IDENTITY).device_class(USB_CLASS_CDC).build(),
        };

        let mut guard = cx.core.SYST;
        guard.set_clock_source(SystClkSource::Core);
        guard.set_reload(board::ARM_FREQUENCY / LOOKS - 1);
        guard.clear_current();
        guard.enable_counter();
        guard.enable_interrupt();

        gpt1.set_clock_source(ClockSource::PeripheralClock);
        gpt1.set_divider(1);
        gpt1.enable();
        pit.set_interrupt_enable(Channel::Chan0, true);
        pit.set_load_timer_value(Channel::Chan0, board::PERCLK_FREQUENCY / u32::from(RATE));
        pit.enable(Channel::Chan0);

        let wires = Wires::new(lpi2c3, pins.p16, pins.p17, gpio1);
        let shared = Shared { head: Head::new(wires::chip(), RATE), port };
        (shared, Local { usb, is_configured: false, wires, pit, counter: gpt1, last: (0, 0), rate: RATE })
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// Starts the board anew where a slot does not end: a transfer waits for ever for a chip that holds the clock down.
    #[task(binds = SysTick, priority = 2)]
    fn guard(_: guard::Context) {
        if WAITED.fetch_add(1, Ordering::Relaxed) >= PATIENCE {
            SCB::sys_reset();
        }
    }

    /// A slot of the sampling clock.
    #[task(binds = PIT, shared = [head, port], local = [wires, pit, counter, last, rate], priority = 1)]
    fn slot(mut cx: slot::Context) {
        let slot::LocalResources { wires, pit, counter, last, rate, .. } = cx.local;
        while pit.is_elapsed(Channel::Chan0) {
            pit.clear_elapsed(Channel::Chan0);
        }
        // The counter has 32 bits of ticks, which are not those of microseconds.
        let count = counter.count();
        let passed = count.wrapping_sub(last.0) / TICKS;
        *last = (last.0.wrapping_add(passed * TICKS), last.1.wrapping_add(passed));
        let now_us = last.1;
        let (reading, health) = cx.shared.head.lock(|head| {
            let reading = head.slot(wires, &mut wires::Delay, now_us);
            if head.rate() != *rate {
                *rate = head.rate();
                pit.disable(Channel::Chan0);
                pit.set_load_timer_value(Channel::Chan0, board::PERCLK_FREQUENCY / u32::from(*rate));
                pit.enable(Channel::Chan0);
            }
            (reading, head.once_a_second())
        });
        cx.shared.port.lock(|port| {
            for message in reading.map(Message::Reading).into_iter().chain(health) {
                send(port, &message);
            }
        });
        WAITED.store(0, Ordering::Relaxed);
    }

    /// The host has something to say, or takes what was sent.
    #[task(binds = USB_OTG1, shared = [head, port], local = [usb, is_configured], priority = 1)]
    fn usb(mut cx: usb::Context) {
        let usb::LocalResources { usb, is_configured, .. } = cx.local;
        let mut bytes = [0; 64];
        let count =
            cx.shared.port.lock(|port| if usb.poll(&mut [port]) { port.read(&mut bytes).unwrap_or(0) } else { 0 });
        if usb.state() == UsbDeviceState::Configured {
            if !*is_configured {
                usb.bus().configure();
            }
            *is_configured = true;
        } else {
            *is_configured = false;
        }
        for byte in &bytes[..count] {
            if let Some(answer) = cx.shared.head.lock(|head| head.receive(*byte)) {
                cx.shared.port.lock(|port| send(port, &answer));
            }
        }
    }

    /// Sends a packet; where nobody listens it is lost, and its number is missing.
    fn send(port: &mut SerialPort<'static, BusAdapter>, message: &Message) {
        let mut packet = [0; LONGEST];
        let length = message.write(&mut packet).unwrap_or(0);
        let _ = port.write(&packet[..length]);
    }
}
