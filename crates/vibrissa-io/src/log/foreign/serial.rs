//! The paper's own sensor over a serial line: `x,y,z` in µT, no time.

use super::lines::{lines, numbers};
use super::{Format, Recording};
use crate::config::limits::MOST_LOG_ROWS;

/// Readings a second of one sensor \[routray, section "Whisker Contact and Obstacle Shape Analysis"\] (Hz).
const RATE: f64 = 300.0;
/// Readings a second of each of two sensors that take turns (Hz).
const RATE_OF_TWO: f64 = 150.0;
/// One microtesla (T).
const MICRO: f64 = 1e-6;
/// End of the sensor's widest range, \[routray, section "Sensor Fabrication"\] (T).
const RANGE: f64 = 50e-3;

/// One sensor.
pub(super) fn read_one(bytes: &[u8]) -> Recording {
    let mut recording = Recording::new(Format::Serial, &[("bx", "T"), ("by", "T"), ("bz", "T")]);
    let mut slots = Vec::new();
    for (slot, (number, flux)) in slotted(bytes, &mut recording).into_iter().enumerate() {
        if let Some(flux) = flux {
            recording.push(number, flux);
            slots.push(slot);
        }
    }
    stamp(&mut recording, &slots, RATE);
    recording
}

/// Two sensors, `1` and `2`, whose lines take turns.
pub(super) fn read_two(bytes: &[u8]) -> Recording {
    let columns = ["1.bx", "1.by", "1.bz", "2.bx", "2.by", "2.bz"].map(|name| (name, "T"));
    let mut recording = Recording::new(Format::Serial2, &columns);
    let (mut turns, mut slots) = (TakingTurns::default(), Vec::new());
    for (slot, (number, flux)) in slotted(bytes, &mut recording).into_iter().enumerate() {
        if let Some(pair) = turns.push(flux) {
            recording.push(number, pair);
            slots.push(slot / 2);
        }
    }
    recording.repairs.order_restored = turns.restored;
    slots.dedup();
    // Two pairs never share a slot unless lines were lost in between; then the later one waits for its turn.
    let slots: Vec<usize> =
        if slots.len() == recording.lines.len() { slots } else { (0..recording.lines.len()).collect() };
    stamp(&mut recording, &slots, RATE_OF_TWO);
    recording
}

/// Two sensors whose lines take turns.
///
/// A line lost between them would swap the two from there on; after a line without a reading the sensor is therefore the
/// one whose last reading is nearer.
#[derive(Clone, Debug, Default)]
pub struct TakingTurns {
    last: [Option<[f64; 3]>; 2],
    turn: usize,
    lost: bool,
    fresh: [bool; 2],
    /// Times the order was found again after a lost line.
    pub restored: usize,
}

impl TakingTurns {
    /// Takes the flux densities of one line (T), none for a line that could not be read; those of both sensors where both are new.
    pub fn push(&mut self, flux: Option<[f64; 3]>) -> Option<[f64; 6]> {
        let Some(flux) = flux else {
            (self.lost, self.turn) = (true, 1 - self.turn);
            return None;
        };
        if let (true, [Some(first), Some(second)]) = (self.lost, self.last) {
            let nearer = usize::from(distance(flux, second) < distance(flux, first));
            self.restored += usize::from(nearer != self.turn);
            if nearer != self.turn {
                self.fresh = [false; 2];
            }
            self.turn = nearer;
        }
        self.lost = false;
        (self.last[self.turn], self.fresh[self.turn]) = (Some(flux), true);
        self.turn = 1 - self.turn;
        let ([true, true], [Some([a, b, c]), Some([d, e, f])]) = (self.fresh, self.last) else { return None };
        self.fresh = [false; 2];
        Some([a, b, c, d, e, f])
    }
}

/// The flux density (T) of one line `x,y,z` in µT.
#[must_use]
pub fn flux_line(text: &str) -> Option<[f64; 3]> {
    numbers::<3>(text).map(|b| b.map(|v| v * MICRO))
}

/// Whether a flux density (T) is at the end of the sensor's range.
#[must_use]
pub fn is_saturated(flux: f64) -> bool {
    flux.abs() >= RANGE
}

/// A line that took the place of a reading, with the reading if it is one; the banner before the first is no such line.
fn slotted(bytes: &[u8], recording: &mut Recording) -> Vec<(usize, Option<[f64; 3]>)> {
    let mut slots = Vec::new();
    for line in lines(bytes) {
        if line.text.is_empty() {
            continue;
        }
        let flux = flux_line(line.text);
        match flux {
            Some(flux) => recording.repairs.saturated += flux.iter().filter(|b| is_saturated(**b)).count(),
            None => recording.repairs.drop_line(&line),
        }
        // Two lines make a row at most; further ones are beyond what a recording may hold.
        if slots.len() > 2 * (MOST_LOG_ROWS + 1) {
            break;
        }
        if flux.is_some() || !slots.is_empty() {
            slots.push((line.number, flux));
        }
    }
    slots
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Time by place: each slot is one period, whether its line could be read or not.
fn stamp(recording: &mut Recording, slots: &[usize], rate: f64) {
    recording.t = slots.iter().map(|&slot| slot as f64 / rate).collect();
    recording.repairs.stamps_made = recording.t.len();
}
