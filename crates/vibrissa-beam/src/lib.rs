//! Whisker mechanics: how a thin beam bends under a contact, and the planar geometry that it needs.
//!
//! A whisker is an elastic rod, clamped or sprung at its base, with one contact. [`beam`] answers each of the questions
//! "which force, which moment, which contact point, which shape" from any of the others, with every branch of the
//! solution \[routray, section "Brief Review of Beam Theory"\]; [`sensing`] is the magnet and the chip that measure the
//! moment; [`plane`] and [`sets`] are vectors, poses, curves, intervals.
//!
//! The crate needs no operating system: `no_std` with `alloc`. Sines, exponentials and the like are those of [`math`], with the
//! same bits everywhere; either feature gives it square roots and roundings.
//!
//! | feature | gives |
//! | --- | --- |
//! | `std` (default) | square roots of the platform; file names in errors; vector instructions found at run time |
//! | `libm` | square roots in Rust, for firmware |
//!
//! SI everywhere: m, rad, N, N m. The undeflected whisker points along +x of its own frame, y is on its left, and a push
//! towards +y is a positive moment.

#![no_std]

extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("vibrissa-beam needs elementary functions: switch on the feature `std` or `libm`");

pub mod beam;
pub mod config;
pub mod error;
pub mod linear_algebra;
pub mod math;
pub mod plane;
mod platform;
pub mod sensing;
pub mod sets;

pub use error::{Error, Result};
