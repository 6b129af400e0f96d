//! The C interface of the page: calls in any order, with any numbers and files.
//!
//! An input is a script, a call a line: `read KIND NAME CONTENT` and the like; in contents `~` ends a line. Damage changes numbers,
//! words, and the order of calls.

use super::{LONGEST_MESSAGE, Verdict, clean, mark, promise, read, size};
use vibrissa::error::is_steering;
use vibrissa_wasm::{abi, native};

/// Names of calls and of methods.
pub(crate) const WORDS: &[&str] = &[
    "read 0 ",
    "read 1 ",
    "read 2 ",
    "read 3 ",
    "read 4 ",
    "bend ",
    "contact_set ",
    "preimage ",
    "headings ",
    "drive 0 ",
    "drive 1 ",
    "localize 0 ",
    "localize 1 ",
    "localize 2 ",
    "localize 3 ",
    "estimate ",
    "whiskers 0 0 0 0\n",
    "write ",
    "possibilistic",
    "deterministic",
    "probabilistic",
    "room.geojson",
    "a.svg",
    "b.dxf",
    "c.yaml",
    "d.mcap",
    "log.csv",
    "robot.toml",
];

/// Most calls of a script,
const MOST_CALLS: usize = 24;
/// most rows that one call takes, and finest grids: a finer one takes longer than a try may.
const MOST_ROWS: f64 = 40.0;
const MOST_HEADINGS: f64 = 90.0;
const FINEST_CELL: f64 = 2e-3;

/// Runs a script on a fresh instance.
pub(crate) fn calls(bytes: &[u8]) -> Verdict {
    native::reset();
    let script = String::from_utf8_lossy(bytes);
    let (mut done, mut refused, mut told) = (0, 0, 0_u64);
    for line in script.lines().take(MOST_CALLS) {
        let Some(code) = called(line) else { continue };
        let (text, numbers) = (native::text(), native::numbers());
        if code == 0 {
            done += 1;
            let steers = text.chars().any(|c| is_steering(c) && !matches!(c, '\n' | '\t' | '\r'));
            promise(!steers, || format!("characters that steer a viewer in the words of {line:?}"))?;
        } else {
            refused += 1;
            clean(&text)?;
            promise(numbers.is_empty(), || format!("numbers beside the error of {line:?}"))?;
            told = told.rotate_left(5) ^ mark(&super::words(&text));
        }
        promise(code <= 1, || format!("the code {code} of {line:?}"))?;
        promise(text.len() < 64 * LONGEST_MESSAGE, || format!("{} bytes of words of {line:?}", text.len()))?;
    }
    read((size(done), size(refused), told))
}

/// Does the call of a line; its code, or none where the line is no call.
fn called(line: &str) -> Option<u32> {
    let (name, rest) = line.split_once(' ').unwrap_or((line, ""));
    // A number that is none is what a page's mistake is.
    let numbers: Vec<f64> = rest.split(' ').map(|word| word.parse().unwrap_or(f64::NAN)).collect();
    let number = |k: usize| numbers.get(k).copied().unwrap_or(f64::NAN);
    // As JavaScript hands numbers to an unsigned parameter: saturated, what is none as 0.
    let whole = |k: usize| number(k) as u32;
    let as_bytes =
        |from: usize| -> Vec<u8> { numbers.iter().skip(from).flat_map(|value| value.to_le_bytes()).collect() };
    Some(match name {
        "read" => {
            let mut words = rest.splitn(3, ' ');
            let kind = words.next().and_then(|word| word.parse().ok()).unwrap_or(u32::MAX);
            let (file, content) = (words.next().unwrap_or(""), words.next().unwrap_or("").replace('~', "\n"));
            native::give(&[file.as_bytes(), b"\0", content.as_bytes()].concat());
            abi::read(kind)
        }
        "bend" => abi::bend(whole(0), number(1), number(2), whole(3), number(4)),
        "contact_set" => abi::contact_set(whole(0), number(1), number(2), whole(3)),
        "preimage" => {
            let cell = if number(3).abs() < FINEST_CELL { FINEST_CELL } else { number(3) };
            abi::preimage(whole(0), number(1), number(2), cell, number(4).min(MOST_HEADINGS) as u32)
        }
        "headings" => abi::headings(number(0), number(1)),
        "drive" => {
            native::give(&as_bytes(1));
            abi::drive(whole(0))
        }
        "localize" if whole(0) == 0 => {
            native::give(rest.split_once(' ').map_or("", |(_, method)| method).as_bytes());
            abi::localize(0, 0)
        }
        "localize" => {
            native::give(&as_bytes(1));
            abi::localize(whole(0), number(1).min(MOST_ROWS) as u32)
        }
        "estimate" => abi::estimate(whole(0)),
        "whiskers" => abi::whiskers(whole(0), number(1), number(2), number(3)),
        "write" => {
            native::give(rest.as_bytes());
            abi::write(whole(0))
        }
        _ => return None,
    })
}
