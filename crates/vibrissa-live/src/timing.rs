//! When a frame was measured: from stamps that may wrap, from a count at a nominal rate, or from its arrival.

use crate::clock::DeviceClock;
use crate::config::{COUNT_PAUSE, LARGEST_DRIFT, LARGEST_RATE_ERROR, WARM_UP};
use crate::counts::Counts;
use crate::decode::{Counter, Frame, Step};

/// How far back a stamp may lie and still be late (s); farther back the device began anew.
const OVERTAKEN: f64 = 0.5;
/// Least distance of two times of a stream (s).
const TICK: f64 = 1e-6;
/// Bins of a clock in which every arrival is late by a period or more before frames are taken for lost,
const LOST_BINS: usize = 10;
/// Stretch that tells the rate well enough for that (s),
const LOST_SPAN: f64 = 3.0;
/// and by how many periods.
const LOST_SHARE: f64 = 0.75;

/// What the times of a stream are made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeBase {
    /// Stamps of the device, mapped to the host's time.
    Stamps,
    /// A count at this nominal rate (Hz), fitted to the arrivals.
    Counted(f64),
    /// The time of arrival.
    Arrival,
    /// Stamps as they are: those of all sources are of one clock.
    Own,
}

/// A frame that waits for the clock to be believed: device time and arrival.
type Waiting = (f64, f64, Frame);

/// The times of one stream.
#[derive(Clone, Debug)]
pub struct Timing {
    base: TimeBase,
    delay: f64,
    stamp_wraps: Option<f64>,
    number_wraps: Option<u64>,
    counter: Counter,
    /// The last stamp as it came, and what was added for wraps.
    last_stamp: Option<(f64, f64)>,
    /// Frames counted so far, lost ones too.
    slots: f64,
    clock: DeviceClock,
    warm: bool,
    waiting: Vec<Waiting>,
    /// The last time that was told, and the last arrival.
    last: f64,
    last_arrival: f64,
}

impl Timing {
    /// Times of a stream by a base; its frames were measured so much (s) before their stamps or arrivals say.
    #[must_use]
    pub fn new(base: TimeBase, delay: f64) -> Self {
        let drift = if matches!(base, TimeBase::Counted(_)) { LARGEST_RATE_ERROR } else { LARGEST_DRIFT };
        Self {
            base,
            delay,
            stamp_wraps: None,
            number_wraps: None,
            counter: Counter::default(),
            last_stamp: None,
            slots: 0.0,
            clock: DeviceClock::new(drift),
            warm: false,
            waiting: Vec::new(),
            last: f64::NEG_INFINITY,
            last_arrival: f64::NEG_INFINITY,
        }
    }

    /// Sets after how much stamps (s) and numbers begin anew.
    pub fn set_wraps(&mut self, stamps: Option<f64>, numbers: Option<u64>) {
        (self.stamp_wraps, self.number_wraps) = (stamps, numbers);
    }

    /// The clock, for words about it.
    #[must_use]
    pub fn clock(&self) -> &DeviceClock {
        &self.clock
    }

    /// A line took the place of a frame.
    pub fn lost_slot(&mut self) {
        if self.last_arrival.is_finite() {
            self.slots += 1.0;
        }
    }

    /// The stream broke off: numbers say nothing about what was before, and counts begin anew.
    pub fn break_off(&mut self) {
        self.counter.forget();
        if matches!(self.base, TimeBase::Counted(_)) {
            self.begin_anew();
        }
    }

    /// Takes a frame that arrived (host, s), and calls `told` with the time (s) of each frame that now has one.
    pub fn push(&mut self, frame: Frame, arrival: f64, counts: &mut Counts, told: &mut dyn FnMut(f64, Frame)) {
        if let Some(number) = frame.number {
            match self.counter.push(number, self.number_wraps) {
                Step::Next(lost) => counts.lost += lost,
                Step::Repeated => {
                    counts.repeated += 1;
                    return;
                }
                Step::Late => {
                    // It was missing until now.
                    counts.late += 1;
                    counts.lost = counts.lost.saturating_sub(1);
                    return;
                }
                Step::Reset => counts.resets += 1,
            }
        }
        match self.base {
            TimeBase::Arrival => self.tell(arrival, frame, told),
            TimeBase::Own => {
                let Some(stamp) = frame.stamp else { return counts.damaged += 1 };
                if let Some(t) = self.unwrapped(stamp, frame.number.is_some(), counts) {
                    self.tell(t, frame, told);
                }
            }
            TimeBase::Stamps => {
                let Some(stamp) = frame.stamp else { return counts.damaged += 1 };
                if let Some(device) = self.unwrapped(stamp, frame.number.is_some(), counts) {
                    self.mapped(device, arrival, frame, told);
                }
            }
            TimeBase::Counted(rate) => {
                if arrival > self.last_arrival + COUNT_PAUSE && self.last_arrival.is_finite() {
                    // How many were lost in the pause nobody knows.
                    counts.resets += 1;
                    self.flush(told);
                    self.begin_anew();
                }
                let device = self.slots / rate;
                self.slots += 1.0;
                self.mapped(device, arrival, frame, told);
                self.count_lost(rate, counts);
            }
        }
        self.last_arrival = arrival;
    }

    /// Tells what still waits.
    pub fn flush(&mut self, told: &mut dyn FnMut(f64, Frame)) {
        for (device, _, frame) in core::mem::take(&mut self.waiting) {
            self.tell(self.clock.host(device), frame, told);
        }
    }

    fn begin_anew(&mut self) {
        self.clock = DeviceClock::new(LARGEST_RATE_ERROR);
        (self.warm, self.slots) = (false, 0.0);
    }

    /// The stamp carried on over its wraps; none for frames that came again or late.
    fn unwrapped(&mut self, stamp: f64, numbered: bool, counts: &mut Counts) -> Option<f64> {
        let Some((before, added)) = self.last_stamp else {
            self.last_stamp = Some((stamp, 0.0));
            return Some(stamp);
        };
        let step = stamp - before;
        let mut added = added;
        if let Some(wraps) = self.stamp_wraps.filter(|wraps| step < -0.5 * wraps) {
            added += wraps;
            counts.wrapped += 1;
        } else if step == 0.0 {
            // Stamps of milliseconds repeat where frames have numbers.
            if !numbered {
                counts.repeated += 1;
                return None;
            }
        } else if step < 0.0 && step > -OVERTAKEN {
            counts.late += 1;
            return None;
        } else if step < 0.0 {
            // The device was switched off and on: its time goes on where it was.
            counts.resets += 1;
            if self.base == TimeBase::Own {
                added += before - stamp + TICK;
            }
        }
        self.last_stamp = Some((stamp, added));
        Some(stamp + added)
    }

    fn mapped(&mut self, device: f64, arrival: f64, frame: Frame, told: &mut dyn FnMut(f64, Frame)) {
        self.clock.push(device, arrival);
        if self.warm {
            return self.tell(self.clock.host(device), frame, told);
        }
        self.waiting.push((device, arrival, frame));
        let begun = self.waiting.first().map_or(arrival, |first| first.1);
        if arrival - begun >= WARM_UP {
            self.warm = true;
            self.flush(told);
        }
    }

    /// Frames that are missing in a count show as arrivals that are all late; those of the last bins were counted too early.
    fn count_lost(&mut self, rate: f64, counts: &mut Counts) {
        if !self.warm || self.clock.span() < LOST_SPAN {
            return;
        }
        let missing = (self.clock.excess(LOST_BINS) * rate).min(rate);
        if missing >= LOST_SHARE {
            let lost = missing.round();
            counts.lost += lost as u64;
            self.slots += lost;
            self.clock.forget(LOST_BINS);
        }
    }

    fn tell(&mut self, t: f64, frame: Frame, told: &mut dyn FnMut(f64, Frame)) {
        let t = (t - self.delay).max(self.last + TICK);
        self.last = t;
        told(t, frame);
    }
}

#[cfg(test)]
mod tests {
    use super::{TimeBase, Timing};
    use crate::counts::Counts;
    use crate::decode::Frame;

    fn times(timing: &mut Timing, frames: &[(f64, Frame)], counts: &mut Counts) -> Vec<f64> {
        let mut told = Vec::new();
        for (arrival, frame) in frames {
            timing.push(frame.clone(), *arrival, counts, &mut |t, _| told.push(t));
        }
        timing.flush(&mut |t, _| told.push(t));
        told
    }

    fn stamped(stamp: f64) -> Frame {
        Frame { stamp: Some(stamp), ..Frame::default() }
    }

    #[test]
    fn microseconds_of_32_bits_go_on_over_their_end() {
        let mut timing = Timing::new(TimeBase::Stamps, 0.0);
        timing.set_wraps(Some(4_294.967_296), None);
        let frames: Vec<(f64, Frame)> = (0..4000)
            .map(|i| {
                let t = 4290.0 + f64::from(i) / 400.0;
                (1000.0 + t + 1e-3, stamped(t % 4_294.967_296))
            })
            .collect();
        let mut counts = Counts::default();
        let told = times(&mut timing, &frames, &mut counts);
        assert_eq!((told.len(), counts.wrapped, counts.late, counts.resets), (4000, 1, 0, 0));
        for (t, (arrival, _)) in told.iter().zip(&frames) {
            assert!((t - arrival).abs() < 1e-4, "{t} {arrival}");
        }
    }

    #[test]
    fn repeated_late_and_restarted_stamps_are_told_apart() {
        let mut timing = Timing::new(TimeBase::Own, 0.5);
        let mut counts = Counts::default();
        let stamps = [1.0, 1.1, 1.1, 1.2, 1.15, 1.3, 0.1, 0.2];
        let frames: Vec<(f64, Frame)> = stamps.iter().map(|&s| (9.0, stamped(s))).collect();
        let told = times(&mut timing, &frames, &mut counts);
        assert_eq!((counts.repeated, counts.late, counts.resets), (1, 1, 1));
        assert!(told.windows(2).all(|w| w[1] > w[0]) && (told[0] - 0.5).abs() < 1e-12, "{told:?}");
    }

    /// 300 Hz by name, 297 Hz in truth, a line in 900 lost without a trace.
    #[test]
    fn counted_frames_find_their_rate_and_what_is_lost() {
        let mut timing = Timing::new(TimeBase::Counted(300.0), 0.0);
        let (mut counts, mut worst, mut lost) = (Counts::default(), 0.0_f64, 0);
        for i in 0..18_000 {
            let truth = 50.0 + f64::from(i) / 297.0;
            if i % 900 == 899 {
                lost += 1;
                continue;
            }
            // Bytes are handed over each 2 ms.
            let arrival = (truth / 0.002).ceil() * 0.002;
            timing.push(Frame::default(), arrival, &mut counts, &mut |t, _| {
                if truth > 60.0 {
                    worst = worst.max((t - truth).abs());
                }
            });
        }
        assert!(counts.lost.abs_diff(lost) <= 3, "{} of {lost} found", counts.lost);
        assert!(worst < 8e-3, "off by {worst} s");
    }
}
