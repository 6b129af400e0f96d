//! Laws that a reading's error follows within its declared bound.

use super::{normal, signed, unit};
use crate::world::MomentNoise;
use crate::{Error, Result};
use chacha20::ChaCha8Rng;
use core::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// How the error of a reading behaves within its bound `|h - z| <= relative |z| + absolute`.
///
/// The error is a share `u` of the bound, from -1 to 1: the reading of the moment `h` is `z = (h + u a) / (1 - u r)`. The relative
/// part makes a reading larger or smaller, the absolute part shifts it. Laws over time begin and end with the touching rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum NoiseLaw {
    /// Anywhere in the bound, each row anew.
    #[default]
    Uniform,
    /// No error.
    Exact,
    /// The relative part at its upper end all along: a gain.
    Constant,
    /// At either end of the bound, each row anew.
    TwoPoint,
    /// Anywhere in the bound, alike for this long (s): a first-order autoregressive process.
    Autoregressive {
        /// After how long the correlation has fallen to 1/e (s), above 0.
        time_constant: f64,
    },
    /// A sine as high as the bound.
    Sine {
        /// Periods from the first touching row to the last, above 0.
        periods: f64,
    },
    /// The relative part at its upper end in the first half, at its lower end in the second.
    Step,
    /// The relative part at its upper end while the moment grows in size, at its lower end while it shrinks.
    Hysteresis,
    /// The absolute part at its upper end all along: a shifted zero.
    Offset,
    /// From the lower to the upper end of the bound, linearly.
    Drift,
    /// Rounded to so many bits of twice the largest moment, and not beyond the bound.
    Quantised {
        /// Bits, 2 to 24.
        bits: u32,
    },
    /// Shrunk towards zero by the absolute part.
    DeadZone,
}

/// Errors at the end of a bound stay within it by this much of it, for rounding.
const INSIDE: f64 = 1.0 - 1e-6;

impl NoiseLaw {
    /// The words that name the laws in files.
    pub const WORDS: [&'static str; 12] = [
        "uniform",
        "none",
        "constant",
        "two_point",
        "ar1",
        "sine",
        "step",
        "hysteresis",
        "absolute",
        "drift",
        "quantised",
        "dead_zone",
    ];
    /// After how long an autoregressive error is another (s), where nothing is said.
    pub const TIME_CONSTANT: f64 = 0.5;
    /// Periods of a sine, where nothing is said.
    pub const PERIODS: f64 = 2.0;
    /// Bits of a quantised reading, where nothing is said.
    pub const BITS: u32 = 8;

    /// The law with this name, with the parameter that it has where nothing is said; none for another word.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        let laws = [
            Self::Uniform,
            Self::Exact,
            Self::Constant,
            Self::TwoPoint,
            Self::Autoregressive { time_constant: Self::TIME_CONSTANT },
            Self::Sine { periods: Self::PERIODS },
            Self::Step,
            Self::Hysteresis,
            Self::Offset,
            Self::Drift,
            Self::Quantised { bits: Self::BITS },
            Self::DeadZone,
        ];
        Self::WORDS.iter().position(|&other| other == word).map(|index| laws[index])
    }

    /// The standard deviation of the error over its bound, and the correlation of two errors this far apart in time (s); none for laws
    /// that are not stationary random processes.
    #[must_use]
    pub fn moments(&self, apart: f64) -> Option<(f64, f64)> {
        let same = if apart.abs() > 0.0 { 0.0 } else { 1.0 };
        match self {
            Self::Uniform => Some((1.0 / 3.0_f64.sqrt(), same)),
            Self::TwoPoint => Some((1.0, same)),
            Self::Autoregressive { time_constant } => {
                // Of two uniform variables made of normal ones with this correlation.
                let normal = (-apart.abs() / time_constant).exp();
                Some((1.0 / 3.0_f64.sqrt(), 6.0 / PI * (0.5 * normal).asin()))
            }
            _ => None,
        }
    }

    pub(super) fn check(&self) -> Result<()> {
        let positive = |name: &str, value: f64| {
            if value > 0.0 && value.is_finite() {
                return Ok(());
            }
            Err(Error::usage(format!("the noise law's {name}")).value(value).allowed("above 0"))
        };
        match *self {
            Self::Autoregressive { time_constant } => positive("time_constant", time_constant),
            Self::Sine { periods } => positive("periods", periods),
            Self::Quantised { bits } if !(2..=24).contains(&bits) => {
                Err(Error::usage("the noise law's bits").value(bits).allowed("2 to 24"))
            }
            _ => Ok(()),
        }
    }

    /// The readings (N m) of these moments at these times (s).
    pub(super) fn readings(
        &self,
        times: &[f64],
        moments: &[f64],
        bound: &MomentNoise,
        rng: &mut ChaCha8Rng,
    ) -> Vec<f64> {
        let MomentNoise { moment_relative: relative, moment_absolute: absolute } = *bound;
        let of = |h: f64, r: f64, a: f64| (h + a * absolute * INSIDE) / (1.0 - r * relative * INSIDE);
        let largest = moments.iter().fold(0.0_f64, |most, h| most.max(h.abs()));
        let time = Span::of(times, moments);
        let mut state = Memory::default();
        let mut reading = |k: usize| {
            let (h, share) = (moments[k], time.share(times[k]));
            match *self {
                Self::Exact => h,
                Self::Uniform => {
                    let u = signed(rng);
                    of(h, u, u)
                }
                Self::Constant => of(h, 1.0, 0.0),
                Self::TwoPoint => {
                    let u = if unit(rng) < 0.5 { -1.0 } else { 1.0 };
                    of(h, u, u)
                }
                Self::Autoregressive { time_constant } => {
                    let u = state.next(times[k], time_constant, normal(rng));
                    of(h, u, u)
                }
                Self::Sine { periods } => {
                    let u = (TAU * periods * share).sin();
                    of(h, u, u)
                }
                Self::Step => of(h, if share < 0.5 { 1.0 } else { -1.0 }, 0.0),
                Self::Hysteresis => of(h, state.way(h), 0.0),
                Self::Offset => of(h, 0.0, 1.0),
                Self::Drift => of(h, 2.0 * share - 1.0, 2.0 * share - 1.0),
                Self::Quantised { bits } => {
                    let step = 2.0 * largest / f64::from(1_u32 << bits);
                    let ends = [of(h, -h.signum(), -1.0), of(h, h.signum(), 1.0)];
                    let rounded = if step > 0.0 { step * (h / step).round() } else { h };
                    rounded.clamp(ends[0].min(ends[1]), ends[0].max(ends[1]))
                }
                Self::DeadZone => h.signum() * (h.abs() - absolute).max(0.0),
            }
        };
        (0..moments.len()).map(&mut reading).collect()
    }
}

/// From the first touching row to the last (s).
struct Span {
    from: f64,
    to: f64,
}

impl Span {
    fn of(times: &[f64], moments: &[f64]) -> Self {
        let touching = |k: &usize| moments[*k].abs() > 0.0;
        let first = (0..moments.len()).find(touching).unwrap_or(0);
        let last = (0..moments.len()).rfind(touching).unwrap_or(0);
        let time = |k: usize| times.get(k).copied().unwrap_or(0.0);
        Self { from: time(first), to: time(last) }
    }

    /// From 0 at the first touching row to 1 at the last.
    fn share(&self, t: f64) -> f64 {
        let length = self.to - self.from;
        if length > 0.0 { ((t - self.from) / length).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// What a law remembers from row to row.
#[derive(Default)]
struct Memory {
    /// Time (s) and value of an autoregressive process, normal.
    process: Option<(f64, f64)>,
    /// Size of the last moment (N m), and whether it grew.
    size: f64,
    shrinks: bool,
}

impl Memory {
    /// The share of the bound of an autoregressive error, uniform in [-1, 1].
    fn next(&mut self, t: f64, time_constant: f64, draw: f64) -> f64 {
        let value = match self.process {
            Some((before, value)) => {
                let kept = (-(t - before).abs() / time_constant).exp();
                kept * value + (1.0 - kept * kept).sqrt() * draw
            }
            None => draw,
        };
        self.process = Some((t, value));
        erf(value * FRAC_1_SQRT_2)
    }

    /// 1 while the moment grows in size, -1 while it shrinks.
    fn way(&mut self, moment: f64) -> f64 {
        let size = moment.abs();
        if (size - self.size).abs() > 0.0 {
            self.shrinks = size < self.size;
        }
        self.size = size;
        if self.shrinks { -1.0 } else { 1.0 }
    }
}

/// The error function, to 1.5e-7 \[abramowitz1964handbook, eq. (7.1.26)\].
fn erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let sum = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592]
        .into_iter()
        .fold(0.0, |sum, term| (sum + term) * t);
    x.signum() * (1.0 - sum * (-x * x).exp()).clamp(0.0, 1.0)
}
