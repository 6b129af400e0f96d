//! Taps: short contacts of a whisker that turns against a peg, and how fast the reading rises at their onset.
//!
//! While the base turns at a constant rate the reading climbs along a straight ramp, over which the shaft rings. The ramp's
//! slope is taken with a weight that falls to zero at both ends, so that ringing of any phase all but cancels, and
//! averaged over several lengths, so that no single ripple and no early end of the ramp decides. The onset is where the
//! ramp meets the level of rest before it; weights and onset are found together.

use crate::config::TapOptions;

/// One tap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tap {
    /// When the ramp leaves the level of rest (s).
    pub t: f64,
    /// Slope of the ramp (units of the reading per s), signed.
    pub slope: f64,
    /// How much the slope differs between the lengths over which it is taken (same unit, standard deviation).
    pub spread: f64,
    /// The level of rest before the tap (units of the reading).
    pub rest: f64,
    /// The reading farthest from it (units of the reading).
    pub peak: f64,
}

/// Every tap in a reading over evenly spaced times (s), of either sign, in time order.
///
/// A tap stands out from the noise by [`TapOptions::prominence`] and reaches [`TapOptions::threshold`] of the largest
/// excursion. Taps that begin before there is a level of rest, or whose ramp is cut off by the end, are left out.
#[must_use]
pub fn taps(t: &[f64], reading: &[f64], options: &TapOptions) -> Vec<Tap> {
    let n = t.len().min(reading.len());
    let (t, reading) = (&t[..n], &reading[..n]);
    let mut sorted = reading.to_vec();
    let level = median(&mut sorted);
    let mut deviations: Vec<f64> = reading.iter().map(|y| (y - level).abs()).collect();
    // What is not held for a few samples is a glitch.
    let held = deviations.windows(HELD).map(|w| w.iter().copied().fold(f64::INFINITY, f64::min));
    let largest = held.fold(0.0, f64::max);
    let noise = 1.4826 * median(&mut deviations);
    // Written so that readings that are no numbers have no taps.
    if largest.is_infinite() || noise.is_nan() || largest <= options.prominence * noise {
        return Vec::new();
    }
    let threshold = (options.threshold * largest).max(options.prominence * noise);
    let mut found: Vec<Tap> = Vec::new();
    let mut index = 0;
    while index < n {
        let deviation = reading[index] - level;
        if deviation.abs() < threshold {
            index += 1;
            continue;
        }
        let end = event_end(t, reading, index, level, 0.5 * threshold, options.settle);
        found.extend(tap(t, reading, index..end, deviation.signum(), threshold, options));
        index = end;
    }
    found
}

/// Samples over which a tap is held.
const HELD: usize = 5;

/// The first sample after `start` from which on the reading stays within `limit` of `level` for the time `settle` (s).
fn event_end(t: &[f64], reading: &[f64], start: usize, level: f64, limit: f64, settle: f64) -> usize {
    let mut outside = start;
    for index in start..t.len() {
        if (reading[index] - level).abs() >= limit {
            outside = index;
        } else if t[index] - t[outside] >= settle {
            break;
        }
    }
    outside + 1
}

/// The tap that crosses the threshold at the beginning of `event`.
fn tap(
    t: &[f64],
    reading: &[f64],
    event: core::ops::Range<usize>,
    sign: f64,
    threshold: f64,
    options: &TapOptions,
) -> Option<Tap> {
    let crossing = t[event.start];
    let before = between(t, crossing - options.rest_from, crossing - options.rest_until);
    if t[before.start] > crossing - 0.8 * options.rest_from || before.len() < 5 {
        return None;
    }
    let rest = median(&mut reading[before].to_vec());
    let foot = (0..=event.start).rev().find(|&i| sign * (reading[i] - rest) < 0.5 * threshold)?;
    let ramps: Vec<Ramp> =
        options.ramps().filter_map(|length| Ramp::settle(t, reading, t[foot], rest, sign, length)).collect();
    if ramps.len() < options.ramp_lengths {
        return None;
    }
    let count = ramps.len() as f64;
    let slope = ramps.iter().map(|r| r.slope).sum::<f64>() / count;
    let onset = ramps.iter().map(|r| r.onset).sum::<f64>() / count;
    let spread = (ramps.iter().map(|r| (r.slope - slope).powi(2)).sum::<f64>() / count).sqrt();
    if spread > options.most_spread * slope.abs() {
        return None;
    }
    let peak = reading[event].iter().copied().max_by(|a, b| (sign * a).total_cmp(&(sign * b)))?;
    Some(Tap { t: onset, slope, spread, rest, peak })
}

/// A straight ramp that leaves the level of rest at `onset`.
struct Ramp {
    onset: f64,
    slope: f64,
}

impl Ramp {
    /// The ramp over `length` (s) from its own onset on; none when it leaves the recording or does not settle.
    fn settle(t: &[f64], reading: &[f64], start: f64, rest: f64, sign: f64, length: f64) -> Option<Self> {
        let mut ramp = Self { onset: start, slope: 0.0 };
        for _ in 0..STEPS {
            let window = between(t, ramp.onset, ramp.onset + length);
            if window.len() < 4 || window.end >= t.len() {
                return None;
            }
            let (offset, slope) = weighted_line(&t[window.clone()], &reading[window], ramp.onset, length)?;
            if sign * slope <= 0.0 {
                return None;
            }
            ramp.slope = slope;
            // Half steps: the window moves with the onset, and full ones may swing back and forth.
            ramp.onset += 0.5 * (rest - offset) / slope;
            if (ramp.onset - start).abs() > length {
                return None;
            }
        }
        Some(ramp)
    }
}

/// Half steps after which an onset has settled to a thousandth of its first error.
const STEPS: usize = 10;

/// Value at `onset` and slope of the line through the readings, weighted by a parabola over the window.
fn weighted_line(t: &[f64], reading: &[f64], onset: f64, length: f64) -> Option<(f64, f64)> {
    let weight = |t: f64| {
        let u = 2.0 * (t - onset) / length - 1.0;
        (1.0 - u * u).max(0.0)
    };
    let total: f64 = t.iter().map(|&t| weight(t)).sum();
    let mean = |value: &dyn Fn(usize) -> f64| (0..t.len()).map(|i| weight(t[i]) * value(i)).sum::<f64>() / total;
    let (mean_t, mean_y) = (mean(&|i| t[i] - onset), mean(&|i| reading[i]));
    let spread = mean(&|i| (t[i] - onset - mean_t).powi(2));
    let slope = mean(&|i| (t[i] - onset - mean_t) * (reading[i] - mean_y)) / spread;
    (slope.is_finite()).then_some((mean_y - slope * mean_t, slope))
}

/// The samples with times from `from` to `until`.
fn between(t: &[f64], from: f64, until: f64) -> core::ops::Range<usize> {
    let start = t.partition_point(|&t| t < from).min(t.len().saturating_sub(1));
    start..t.partition_point(|&t| t <= until).max(start)
}

/// The middle value; 0 of none. Reorders the values.
fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
