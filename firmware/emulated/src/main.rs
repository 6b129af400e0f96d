//! The sensor head on an emulated Cortex-M7 (QEMU's mps2-an500): frames of a simulated chip with faults on standard output, counted
//! instructions on standard error.
//!
//! The allocator has no memory and the stack ends where the machine has none, so that an allocation or a deep call stops the run.

#![no_std]
#![no_main]

mod counted;

use cortex_m_rt::entry;
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::{heprintln, hio};
use embedded_alloc::LlffHeap;
use vibrissa_head::LONGEST;
use vibrissa_head::simulated::Rehearsal;

#[global_allocator]
static NOTHING: LlffHeap = LlffHeap::empty();

/// What the whisker feels (nN m), one slot a line.
const MOMENTS: &str = include_str!("../../moments.txt");
/// Readings a second (Hz), and the largest moment of the calibration (N m): those of the host's run.
const RATE: u16 = 300;
const LARGEST: f64 = 0.006;

#[entry]
fn main() -> ! {
    let sent = cortex_m::Peripherals::take().and_then(|peripherals| {
        counted::tell(peripherals.SYST, RATE, LARGEST);
        send()
    });
    debug::exit(if sent.is_some() { EXIT_SUCCESS } else { EXIT_FAILURE });
    loop {}
}

/// Sends the frames of all moments; how many.
fn send() -> Option<usize> {
    let mut out = hio::hstdout().ok()?;
    let mut rehearsal = Rehearsal::new(RATE, LARGEST);
    let mut count = 0;
    for (slot, line) in MOMENTS.lines().enumerate() {
        let moment: i32 = line.parse().ok()?;
        let Some(message) = rehearsal.slot(slot, f64::from(moment) * 1e-9, true) else { continue };
        let mut packet = [0; LONGEST];
        let length = message.write(&mut packet)?;
        out.write_all(packet.get(..length)?).ok()?;
        count += 1;
    }
    let health = rehearsal.head().health();
    heprintln!("frames {} missed {} freed {} stuck {}", count, health.missed, health.freed, health.stuck);
    // On a board such a transfer might never have ended.
    (rehearsal.bus().hung == 0).then_some(count)
}

#[panic_handler]
fn stop(_: &core::panic::PanicInfo<'_>) -> ! {
    debug::exit(EXIT_FAILURE);
    loop {}
}
