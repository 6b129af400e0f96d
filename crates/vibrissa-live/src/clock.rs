//! One clock: device times to host times by the lower hull of the arrivals \[moon1999clock\].
//!
//! A frame arrives at `a = d (1 + drift) + offset + wait`, where `d` is the device's time and `wait` is at least 0: scheduling,
//! buffers and USB only ever delay. The line below all points `(d, a - d)` that is nearest to them in the mean is an edge of
//! their lower convex hull, the one around the middle of the stretch; its slope is the drift.

use crate::config::{CLOCK_BIN, CLOCK_JUMP, CLOCK_SPAN};
use std::collections::VecDeque;

/// Shortest stretch that tells a drift (s): a millisecond's jitter at its ends is then 5e-4.
pub(crate) const DRIFT_SPAN: f64 = 2.0;
/// Bins in which all arrivals are beyond the line before it is given up.
const JUMP_BINS: usize = 10;

/// Host times of a device's times.
#[derive(Clone, Debug)]
pub struct DeviceClock {
    largest_drift: f64,
    /// The least delayed arrival of each bin: device time, arrival less device time (s).
    bins: VecDeque<(f64, f64)>,
    /// When the bin of the last entry began (device time).
    bin: f64,
    /// Offset of the line at device time `origin`, and its slope.
    origin: f64,
    offset: f64,
    drift: f64,
    /// Bins on end that are too late altogether.
    beyond: usize,
    /// Times the device's time was set anew.
    resets: u64,
}

impl DeviceClock {
    /// A clock whose rate is wrong by no more than this share.
    #[must_use]
    pub fn new(largest_drift: f64) -> Self {
        Self {
            largest_drift,
            bins: VecDeque::new(),
            bin: 0.0,
            origin: 0.0,
            offset: 0.0,
            drift: 0.0,
            beyond: 0,
            resets: 0,
        }
    }

    /// Takes the arrival (host, s) of what the device did at its own time (s).
    pub fn push(&mut self, device: f64, arrival: f64) {
        let late = arrival - device;
        if self.bins.is_empty() {
            self.start(device, late);
            return;
        }
        if late < self.line(device) - CLOCK_JUMP || device < self.bin - CLOCK_JUMP {
            self.resets += 1;
            self.start(device, late);
            return;
        }
        if device >= self.bin + CLOCK_BIN {
            self.close_bin();
            if self.beyond >= JUMP_BINS {
                self.resets += 1;
                self.start(device, late);
                return;
            }
            self.bin = device;
            self.bins.push_back((device, late));
            while self.bins.front().is_some_and(|first| first.0 < device - CLOCK_SPAN) {
                self.bins.pop_front();
            }
        } else if let Some(last) = self.bins.back_mut().filter(|last| late < last.1) {
            *last = (device, late);
        }
        if late < self.line(device) {
            self.fit();
        }
    }

    /// The host time (s) of a device time (s).
    #[must_use]
    pub fn host(&self, device: f64) -> f64 {
        device + self.line(device)
    }

    /// How much later than the line even the least delayed arrival of the last `bins` bins is (s).
    #[must_use]
    pub fn excess(&self, bins: usize) -> f64 {
        let recent = self.bins.iter().rev().take(bins);
        recent.map(|&(device, late)| late - self.line(device)).fold(f64::INFINITY, f64::min)
    }

    /// How long the stretch is that the line rests on (device time, s).
    #[must_use]
    pub fn span(&self) -> f64 {
        match (self.bins.front(), self.bins.back()) {
            (Some(first), Some(last)) => last.0 - first.0,
            _ => 0.0,
        }
    }

    /// How many bins there are.
    #[must_use]
    pub fn bins(&self) -> usize {
        self.bins.len()
    }

    /// By what share the device's seconds are longer than the host's.
    #[must_use]
    pub fn drift(&self) -> f64 {
        self.drift
    }

    /// Times the device's time was set anew.
    #[must_use]
    pub fn resets(&self) -> u64 {
        self.resets
    }

    /// Forgets the arrivals of the last `bins` bins: their device times were told wrong.
    pub fn forget(&mut self, bins: usize) {
        self.bins.truncate(self.bins.len().saturating_sub(bins).max(1));
    }

    fn start(&mut self, device: f64, late: f64) {
        self.bins.clear();
        self.bins.push_back((device, late));
        (self.bin, self.origin, self.offset, self.drift, self.beyond) = (device, device, late, 0.0, 0);
    }

    fn line(&self, device: f64) -> f64 {
        self.offset + self.drift * (device - self.origin)
    }

    fn close_bin(&mut self) {
        let Some(&(device, late)) = self.bins.back() else { return };
        self.beyond = if late > self.line(device) + CLOCK_JUMP { self.beyond + 1 } else { 0 };
        if self.beyond == 0 {
            self.fit();
        }
    }

    /// The line below all points, by their lower hull.
    fn fit(&mut self) {
        let Some(&(first, level)) = self.bins.front() else { return };
        // Relative to the first point, so that no digits are lost.
        let points: Vec<(f64, f64)> = self.bins.iter().map(|&(device, late)| (device - first, late - level)).collect();
        let slope = if self.span() < DRIFT_SPAN { 0.0 } else { edge_slope(&points) };
        self.drift = slope.clamp(-self.largest_drift, self.largest_drift);
        let lowest = points.iter().map(|&(x, y)| y - self.drift * x).fold(f64::INFINITY, f64::min);
        (self.origin, self.offset) = (first, level + lowest);
    }
}

/// The slope of the edge of the lower hull that lies over the mean of the points.
fn edge_slope(points: &[(f64, f64)]) -> f64 {
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for &(x, y) in points {
        while let [.., (ax, ay), (bx, by)] = hull[..] {
            if (bx - ax) * (y - ay) > (by - ay) * (x - ax) {
                break;
            }
            hull.pop();
        }
        hull.push((x, y));
    }
    let mean = points.iter().map(|point| point.0).sum::<f64>() / points.len() as f64;
    let after = hull.partition_point(|point| point.0 < mean).clamp(1, hull.len().max(2) - 1);
    match (hull.get(after - 1), hull.get(after)) {
        (Some(a), Some(b)) if b.0 > a.0 => (b.1 - a.1) / (b.0 - a.0),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::DeviceClock;
    use crate::config::{LARGEST_DRIFT, LARGEST_RATE_ERROR};

    /// Numbers from 0 to 1, the same in every run.
    fn dice(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Arrivals of a device at 500 Hz whose seconds are too long by `drift`; they wait in buffers and come in bursts.
    fn run(drift: f64, largest: f64, offset: f64) -> (DeviceClock, f64) {
        let (mut clock, mut state, mut worst) = (DeviceClock::new(largest), 7, 0.0_f64);
        for i in 0..15_000 {
            let device = f64::from(i) / 500.0;
            let true_host = 100.0 + offset + device * (1.0 + drift);
            let wait = 2e-4 * dice(&mut state) + 0.02 * dice(&mut state).powi(8);
            // A USB adapter hands over each 3.7 ms.
            let arrival = ((true_host + wait) / 0.0037).ceil() * 0.0037;
            clock.push(device, arrival);
            if i > 3000 {
                worst = worst.max((clock.host(device) - true_host).abs());
            }
        }
        (clock, worst)
    }

    #[test]
    fn drift_and_offset_are_found_below_jitter_and_bursts() {
        for drift in [0.0, 5e-5, -3e-4] {
            let (clock, worst) = run(drift, LARGEST_DRIFT, -1e6);
            assert!((clock.drift() - drift).abs() < 2e-4, "{drift}: {}", clock.drift());
            assert!(worst < 1.5e-3, "{drift}: off by {worst} s");
        }
        let (clock, worst) = run(0.02, LARGEST_RATE_ERROR, 3.0);
        assert!((clock.drift() - 0.02).abs() < 3e-4 && worst < 2e-3, "{} {worst}", clock.drift());
    }

    #[test]
    fn a_device_that_is_set_anew_is_followed_and_a_backlog_is_not_believed() {
        let (mut clock, _) = run(0.0, LARGEST_DRIFT, 0.0);
        // The host slept for three seconds; what piled up arrives at once and on time from then on.
        for i in 0..200 {
            let device = 30.0 + f64::from(i) / 500.0;
            clock.push(device, 133.0 + 1e-4);
        }
        assert!((clock.host(30.3) - 130.3).abs() < 5e-3 && clock.resets() == 0);
        // The device was set back by an hour.
        for i in 0..1000 {
            let device = -3600.0 + f64::from(i) / 500.0;
            clock.push(device, 133.0 + f64::from(i) / 500.0 + 1e-4);
        }
        assert!((clock.host(-3599.0) - 134.0).abs() < 5e-3, "{}", clock.host(-3599.0));
    }
}
