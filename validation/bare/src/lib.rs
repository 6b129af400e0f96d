//! A part of a firmware: the contact that a moment means, without an operating system.
//!
//! `cargo check -p vibrissa-bare --features handler` fails as soon as a dependency brings the standard library along, on
//! any target: two panic handlers cannot be in one program.

#![no_std]

extern crate alloc;

use alloc::vec::Vec;
use vibrissa_beam::beam::{Bend, Load, Whisker, moment_mode};
use vibrissa_beam::plane::Vec2;

/// The points (m, whisker frame) at which a contact at the tip explains a moment (N m); empty where none does.
#[must_use]
pub fn tip_contacts(whisker: &Whisker, moment: f64) -> Vec<Vec2> {
    let bends: Vec<Bend> = moment_mode(whisker, moment, whisker.length, Load::Normal).unwrap_or_default();
    bends.iter().map(|bend| bend.contact).collect()
}

#[cfg(feature = "handler")]
#[panic_handler]
fn halt(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
