//! vibrissa in the browser: what the studio's page asks of the library, as a C ABI for WebAssembly.
//!
//! The page writes bytes to [`abi::input`], calls a function, and reads numbers ([`abi::numbers`], f64) and words
//! ([`abi::text`], UTF-8). A function gives 0 where it did what it was asked; else the words are those of the error, the same
//! as the command's. All numbers are SI: m, rad, s, N, N m.
//!
//! | room | what it answers |
//! | --- | --- |
//! | [`abi`] | the exported functions: their arguments, the layout of their numbers |
//! | [`native`] | the same buffers for callers in Rust |
//! | `host` | what was read and what is going on; bytes in, numbers and words out |
//! | `bend` | a loaded whisker, every equilibrium |
//! | `contacts` | which contacts explain a reading; which robot states do, on a map |
//! | `driving` | a robot that is steered: what its whiskers read |
//! | `localizing` | where it is, row by row |
//! | `whiskers` | its whiskers at a row, as the map bends them |

pub mod abi;
mod bend;
mod contacts;
mod driving;
mod files;
mod host;
mod localizing;
pub mod native;
#[cfg(test)]
mod tests;
mod whiskers;
