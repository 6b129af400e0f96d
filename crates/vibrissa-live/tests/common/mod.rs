//! What the tests of live runs share.
#![allow(dead_code, reason = "each test program uses its part")]

use std::path::{Path, PathBuf};
use vibrissa::Map;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::tasks::demo;

/// Numbers that are the same in every run.
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// An empty folder of its own for a test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The demo's map and sweep.
pub(crate) fn demo_world() -> (Map, SensorLog) {
    (demo::arena().unwrap(), demo::sweep(1).unwrap().log)
}

/// A line with its checksum and its end.
pub(crate) fn checked(body: &str) -> String {
    format!("{body}*{:04X}\r\n", vibrissa_live::decode::crc16(body.as_bytes()))
}
