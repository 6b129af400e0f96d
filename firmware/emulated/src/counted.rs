//! Instructions, counted by the system timer: with `-icount shift=0` an instruction takes a nanosecond and the timer ticks at 25 MHz.

use core::hint::black_box;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::heprintln;
use vibrissa_beam::sensing::SensingChain;
use vibrissa_head::LONGEST;
use vibrissa_head::frame::{Message, Reading};
use vibrissa_head::simulated::{Rehearsal, calibration};

/// Instructions of a tick.
const PER_TICK: u32 = 40;
/// How often each piece runs.
const TIMES: u32 = 1000;
/// Where the timer begins anew.
const LAST: u32 = 0x00ff_ffff;

/// Tells how many instructions a slot takes, with the simulated chip and its bus, and two pieces of it alone.
pub(crate) fn tell(mut timer: SYST, rate: u16, largest: f64) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(LAST);
    timer.clear_current();
    timer.enable_counter();

    let mut rehearsal = Rehearsal::new(rate, largest);
    let mut slot = 0;
    let slots = count(|| {
        black_box(rehearsal.slot(slot, black_box(3e-3), false));
        slot += 1;
    });
    let chain = SensingChain::default();
    let (held, flux) = (calibration(&chain, largest), chain.flux(3e-3));
    let moments = count(|| {
        black_box(held.moments(black_box(flux)));
    });
    let message =
        Message::Reading(Reading { number: 70_000, stamp_us: 1 << 31, moment: Some(3e-3), ..Reading::default() });
    let mut packet = [0; LONGEST];
    let frames = count(|| {
        black_box(black_box(&message).write(&mut packet));
    });
    heprintln!("instructions slot_with_simulated_chip {} moment {} frame {}", slots, moments, frames);
}

/// Instructions of one run of a piece, with those of the loop around it.
fn count(mut piece: impl FnMut()) -> u32 {
    let before = SYST::get_current();
    for _ in 0..TIMES {
        piece();
    }
    // The timer counts down.
    let ticks = before.wrapping_sub(SYST::get_current()) & LAST;
    ticks * PER_TICK / TIMES
}
