//! The exported functions. Lengths count bytes of [`input`] unless they say otherwise.
//!
//! This is the only file that says `unsafe`: a name is exported without mangling. No pointer is read here: the page writes into
//! a buffer that belongs to the host, and reads buffers that the host keeps until the next call.
//!
//! Plain names are those of the module in a browser alone: in a native program `read` and `write` would take the place of the C library's.
#![allow(unsafe_code, reason = "a C ABI exports plain names")]

use crate::host::{Host, with};
use crate::{bend as bending, contacts, driving, files, localizing, whiskers as bent};
use vibrissa::plane::Pose2;

/// Makes room for `len` bytes and tells where; the page writes them before the next call.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn input(len: usize) -> *mut u8 {
    with(|host| {
        host.input.clear();
        host.input.resize(len, 0);
        host.input.as_mut_ptr()
    })
}

/// Where the numbers of the last call are.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn numbers() -> *const f64 {
    with(|host| host.numbers.as_ptr())
}

/// How many numbers there are.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn numbers_len() -> usize {
    with(|host| host.numbers.len())
}

/// Where the words of the last call are (UTF-8).
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn text() -> *const u8 {
    with(|host| host.text.as_ptr())
}

/// How many bytes of words there are.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn text_len() -> usize {
    with(|host| host.text.len())
}

/// Reads a file: the input is its name, a zero byte and its bytes; `kind` 0 map, 1 robot, 2 log, 3 true trajectory, 4 the image that
/// the next map names.
///
/// Numbers of a map: outlines; each role (0 arena, 1 obstacle, 2 wall), closed (0, 1), points, then x, y of each. Of a robot:
/// whiskers; each length, mount x, y, theta. Of a log: rows, columns; each row t, x, y, theta and a reading for each column. Of a
/// trajectory: poses; each t, x, y, theta. Of an image none. The words are warnings by lines, for a log after a line of its columns' names.
/// A robot without name and bytes is the paper's.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn read(kind: u32) -> u32 {
    call(|host| files::read(host, kind))
}

/// Bends the robot's first whisker: `given` 0 force and arc length, 1 contact point, 2 moment and arc length, 3 tip (SI, `a` and `b`
/// in this order); `load` 0 normal, 1 vertical, 2 tilted, 3 directed by `angle`.
///
/// Numbers: equilibria, points of a shape; each force, `s_a`, `phi_a`, beta, x, y, moment, force's x, y, energy, tip's x, y, largest
/// strain and where it is (NaN where unknown), then the shape's x, y.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn bend(given: u32, a: f64, b: f64, load: u32, angle: f64) -> u32 {
    call(|host| bending::solve(host, given, a, b, load, angle))
}

/// The contacts of the robot's first whisker that explain a reading between `lo` and `hi` of `sensor`: 0 load, 1 strip, 2 slope,
/// 3 moment.
///
/// Numbers: curves, tolerance (m); each curve its contacts: x, y, `s_a`, `phi_a`, force, moment, after their count; then area (m²),
/// components and cells of the region, each cell the count of its corners and their x, y. An exact reading has curves, another
/// those of its middle. `shapes`: so many whiskers along the curves follow, each the count of its points and their x, y.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn contact_set(sensor: u32, lo: f64, hi: f64, shapes: u32) -> u32 {
    call(|host| contacts::contact_set(host, sensor, lo, hi, shapes))
}

/// The robot states that explain a reading on the map, by cells of `cell` (m) and so many `headings`.
///
/// Numbers: 1 where none does, area, sampled area (m²), volume (m² rad), deviation (m); the grid's corner x, y, cell (m), columns,
/// rows; for each cell, row by row from below, the share of its headings.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn preimage(sensor: u32, lo: f64, hi: f64, cell: f64, headings: u32) -> u32 {
    call(|host| contacts::preimage(host, sensor, lo, hi, cell, headings))
}

/// The headings that explain the reading of the last [`preimage`] at a place: runs, each first and last angle (rad).
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn headings(x: f64, y: f64) -> u32 {
    call(|host| contacts::headings(host, x, y))
}

/// Steers the robot over the map. `op` 0 starts: the input holds t, x, y, theta, seed, and 1 for noise as the robot declares it. `op` 1
/// moves it on: poses of t, x, y, theta, zero (N m), gain (relative), slip (share); numbers are f64, little-endian.
///
/// Numbers: rows, whiskers; each row t, odometry x, y, theta, the readings, the exact moments; then touches, each whisker, x, y, force's
/// x, y, 0 for the tip or 1 for the side; then each whisker's points and their x, y. Words: events by lines of time, kind, detail.
/// The rows also make a log, which [`write()`] gives.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn drive(op: u32) -> u32 {
    call(|host| driving::drive(host, op))
}

/// Localizes the robot on the map. `op` 0 begins, by the method whose name is the input, for the columns of the log, or of a steered
/// robot where there is none; 1 adds rows: t, x, y, theta and readings each; 2 takes up to `n` rows; 3 ends and chooses;
/// 4 goes on for `n` units of work, at most to the end of a row; 5 ends the rows, so that 4 does the work of the end before 3.
///
/// Numbers: rows taken, rows there are, 1 where no work is left; after the end those of [`estimate`], then poses of the trajectory, each t, x, y, theta. Words at
/// the end: events, remedies and consistency as JSON.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn localize(op: u32, n: u32) -> u32 {
    call(|host| localizing::localize(host, op, n))
}

/// What can be said now, with up to `most` of the states that explain the rows so far.
///
/// Numbers: verdict (0 localized, 1 ambiguous, 2 inconsistent, 3 no contact), rows, places, states; each place x, y, theta, weight,
/// least and largest x, y, theta, root mean square errors of position (m) and heading (rad) or NaN; each state x, y, theta.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn estimate(most: u32) -> u32 {
    call(|host| localizing::estimate(host, most))
}

/// The whiskers at a row of the log, with the robot at this pose on the map: followed along the odometry of the rows before.
///
/// Numbers: whiskers; each 2 where the map bends it, 1 where its reading alone does, 0 at rest; where it is held x, y (m, NaN where
/// that is not known), the moment that it should read (N m, NaN where unknown), then its points and their x, y, on the map.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn whiskers(row: u32, x: f64, y: f64, theta: f64) -> u32 {
    call(|host| bent::bent(host, row as usize, Pose2::new(x, y, theta)))
}

/// Writes a file into the words: `kind` 0 the log (CSV), 1 the robot (TOML), 2 the answer's figure (SVG; the input is its title),
/// 3 the answer's trajectory (TUM), 4 the map (GeoJSON, as polylines).
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
#[must_use]
pub extern "C" fn write(kind: u32) -> u32 {
    call(|host| files::write(host, kind))
}

/// One call: fresh numbers and words, those of the error where there is one.
fn call(work: impl FnOnce(&mut Host) -> vibrissa::Result<()>) -> u32 {
    with(|host| {
        host.numbers.clear();
        host.text.clear();
        match work(host) {
            Ok(()) => 0,
            Err(error) => {
                host.numbers.clear();
                host.text = host.words_of(error);
                1
            }
        }
    })
}
