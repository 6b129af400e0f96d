//! Raw 16-bit counts of three axes beside the pose of the rig.

use super::lines::{lines, numbers};
use super::ratatouille::LARGEST_COUNT;
use super::{Format, Recording};

/// Counts in one turn of a 16-bit number.
const TURN: f64 = 65_536.0;
/// One millimetre (m).
const MILLI: f64 = 1e-3;

/// `timestamp,ss.x,ss.y,ss.z,Dist,Bend`: host time in s, counts, distance from the tip and lateral travel in mm.
///
/// The counts are carried on when they wrap, so that they may be below 0 or above 65535; `dist` and `bend` are in m.
pub(super) fn read(bytes: &[u8]) -> Recording {
    let columns = [("ax", "counts"), ("ay", "counts"), ("az", "counts"), ("dist", "m"), ("bend", "m")];
    let mut recording = Recording::new(Format::Openwhisker, &columns);
    let (mut turns, mut before, mut start) = ([0.0; 3], None::<[f64; 3]>, None::<f64>);
    for line in lines(bytes) {
        if line.text.is_empty() || (line.number == 1 && line.text.starts_with("timestamp")) {
            continue;
        }
        let Some([stamp, x, y, z, dist, bend]) = numbers::<6>(line.text).filter(|_| line.ended) else {
            recording.repairs.drop_line(&line);
            continue;
        };
        let counts = [x, y, z];
        if counts.iter().any(|c| !(0.0..=LARGEST_COUNT).contains(c)) {
            recording.repairs.drop_line(&line);
            continue;
        }
        let t = stamp - *start.get_or_insert(stamp);
        if recording.t.last().is_some_and(|last| t <= *last) {
            recording.repairs.out_of_order += 1;
            continue;
        }
        for axis in 0..3 {
            let step = before.map_or(0.0, |before| counts[axis] - before[axis]);
            let wrapped = f64::from(i8::from(step < -0.5 * TURN) - i8::from(step > 0.5 * TURN));
            turns[axis] += wrapped;
            recording.repairs.unwrapped += usize::from(wrapped.abs() > 0.0);
        }
        before = Some(counts);
        recording.t.push(t);
        let carried = [0, 1, 2].map(|axis| counts[axis] + TURN * turns[axis]);
        recording.push(line.number, carried.into_iter().chain([dist * MILLI, bend * MILLI]));
    }
    recording
}
