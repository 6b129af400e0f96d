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
    let (mut carried, mut start) = (CarriedCounts::default(), None::<f64>);
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
        recording.t.push(t);
        let counts = carried.push(counts);
        recording.push(line.number, counts.into_iter().chain([dist * MILLI, bend * MILLI]));
    }
    recording.repairs.unwrapped = carried.wrapped;
    recording
}

/// Counts of 16 bits, carried on when they run over.
#[derive(Clone, Debug, Default)]
pub struct CarriedCounts {
    turns: [f64; 3],
    before: Option<[f64; 3]>,
    /// Times a count ran over.
    pub wrapped: usize,
}

impl CarriedCounts {
    /// The counts that these stand for.
    pub fn push(&mut self, counts: [f64; 3]) -> [f64; 3] {
        for axis in 0..3 {
            let step = self.before.map_or(0.0, |before| counts[axis] - before[axis]);
            let wrapped = f64::from(i8::from(step < -0.5 * TURN) - i8::from(step > 0.5 * TURN));
            self.turns[axis] += wrapped;
            self.wrapped += usize::from(wrapped.abs() > 0.0);
        }
        self.before = Some(counts);
        [0, 1, 2].map(|axis| counts[axis] + TURN * self.turns[axis])
    }
}
