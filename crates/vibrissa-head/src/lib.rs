//! The sensor head of a whisker: what runs beside the magnet, and what it sends.
//!
//! A head samples a magnetometer at an even rate, carries counts on over the wraps of the chip's registers, turns flux into
//! moments by a calibration that it was sent, and sends each reading with its number, its time and a checksum. What it
//! cannot read leaves a gap in the numbers, so that whoever listens can count every loss. Nothing allocates.
//!
//! | module | what it knows |
//! | --- | --- |
//! | [`frame`] | what is sent, and its bytes: postcard, CRC-32, COBS |
//! | [`command`] | what is received: identity, zero, rate, calibration |
//! | [`calibration`] | flux to moments, with the arithmetic of the host |
//! | [`bus`] | a locked I2C bus, freed by nine clocks |
//! | [`chip`] | drivers of the MLX90393 and the TLE493D over `embedded-hal` |
//! | [`head`] | all of it in one slot of the sampling clock |
//! | `simulated` | chips byte by byte, with the faults of a bus (feature `simulated`) |
//!
//! Flux is along the chip's axes (T), moments are about the whisker's base (N m), times are microseconds of the device.

#![no_std]

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("vibrissa-head needs square roots and roundings: switch on the feature `std` or `libm`");

pub mod bus;
pub mod calibration;
pub mod chip;
pub mod command;
pub mod frame;
pub mod head;
mod packet;
#[cfg(feature = "simulated")]
pub mod simulated;
mod unwrap;

pub use packet::{Damage, LONGEST};
