//! Whisker mechanics and the calibration of a sensor for programs in C.
//!
//! `include/vibrissa.h` is made from this crate by cbindgen ([`cbindgen.toml`](https://github.com/mozilla/cbindgen)); `examples/press.c` uses
//! it. No function allocates, keeps anything, or stops the program. All numbers are SI.

#![cfg_attr(not(feature = "std"), no_std)]

pub mod abi;
