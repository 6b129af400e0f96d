//! Logs of a whisker that is free, or touched now and then, by noise laws that fill the declared bound.

use super::random::Random;
use core::f64::consts::TAU;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::Pose2;
use vibrissa::world::Robot;

/// Rows a second.
pub(crate) const RATE: f64 = 300.0;
/// Rows of one log: ten minutes, so that hours take little memory.
pub(crate) const ROWS: usize = 180_000;
/// How far off a zero is declared to be (N m), and how fast it may drift (N m/s).
const ZERO: f64 = 2e-4;
const DRIFT: f64 = 1e-6;
/// After how long an autoregressive error is another, and the period of a sine (s).
const ALIKE: f64 = 0.5;
const PERIOD: f64 = 10.0;
/// Chance of a row that an error jumps to the other end of its bound.
const JUMP: f64 = 0.01;
/// Bits of a quantised reading, over twice the bound.
const BITS: u32 = 3;

/// How a reading errs within its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FreeLaw {
    /// Anywhere, each row anew.
    Uniform,
    /// At either end, each row anew.
    TwoPoint,
    /// At the upper end all along.
    Constant,
    /// A first-order autoregressive process.
    Alike,
    /// A sine as high as the bound.
    Sine,
    /// From one end to the other within each log.
    Ramp,
    /// At one end, then for a while at the other.
    Jumps,
    /// A slow sine, rounded to few bits.
    Quantised,
    /// Anywhere, around a zero that is off as far as declared.
    Zero,
    /// Anywhere, around a zero that drifts up and down as fast as declared.
    DriftingZero,
}

impl FreeLaw {
    pub(crate) const ALL: [Self; 10] = [
        Self::Uniform,
        Self::TwoPoint,
        Self::Constant,
        Self::Alike,
        Self::Sine,
        Self::Ramp,
        Self::Jumps,
        Self::Quantised,
        Self::Zero,
        Self::DriftingZero,
    ];

    /// The paper's robot with what this law needs to be declared.
    pub(crate) fn robot(self) -> Robot {
        let mut robot = Robot::default();
        let errors = &mut robot.whiskers[0].errors;
        if matches!(self, Self::Zero | Self::DriftingZero) {
            errors.zero = ZERO;
        }
        if self == Self::DriftingZero {
            errors.zero_drift = DRIFT;
        }
        robot
    }

    /// What a free whisker may read (N m), by what the robot declares.
    pub(crate) fn level(self) -> f64 {
        let robot = self.robot();
        let (noise, errors) = (robot.whiskers[0].noise, &robot.whiskers[0].errors);
        let free = noise.largest_free_reading();
        let followed = if errors.zero_drift > 0.0 { errors.zero.max(free) } else { errors.zero };
        free + followed * (1.0 + noise.moment_relative)
    }
}

/// The readings of one whisker, row by row.
pub(crate) struct FreeWhisker {
    law: FreeLaw,
    robot: Robot,
    random: Random,
    row: usize,
    /// What the law remembers: a normal value, or an end of the bound.
    state: f64,
}

impl FreeWhisker {
    pub(crate) fn new(law: FreeLaw, seed: u64) -> Self {
        Self { law, robot: law.robot(), random: Random(seed), row: 0, state: 1.0 }
    }

    /// A log of so many rows in which the whisker is free.
    pub(crate) fn free(&mut self, rows: usize) -> SensorLog {
        self.log(&vec![0.0; rows])
    }

    /// A log of so many rows in which the whisker is touched now and then, by twice to six times what a free one may read; and how often.
    pub(crate) fn touched(&mut self, rows: usize) -> (SensorLog, usize) {
        let (mut moments, mut touches, mut row) = (vec![0.0; rows], 0, 0);
        loop {
            row += (RATE * self.random.between(0.5, 3.0)) as usize;
            let long = 1 + (60.0 * self.random.unit()) as usize;
            if row + long + 10 > rows {
                return (self.log(&moments), touches);
            }
            let size = self.random.between(2.0 + 1e-9, 6.0) * self.law.level();
            moments[row..row + long].fill(size * self.random.sign());
            (row, touches) = (row + long, touches + 1);
        }
    }

    /// The log of these moments (N m).
    fn log(&mut self, moments: &[f64]) -> SensorLog {
        let rows = moments.iter().enumerate().map(|(k, &moment)| {
            let t = k as f64 / RATE;
            let odom_from_robot = Pose2::new(0.05 * (0.3 * t).sin(), 0.02 * (0.7 * t).cos(), 0.2 * (0.11 * t).sin());
            LogRow { line: k + 2, t, odom_from_robot, readings: vec![self.reading(t, moment)], heading: None }
        });
        let rows = rows.collect();
        let channels = vec![Channel { whisker: String::new(), quantity: Quantity::Moment }];
        SensorLog { channels, rows, ..SensorLog::default() }
    }

    fn reading(&mut self, t: f64, moment: f64) -> f64 {
        let [low, high] = self.robot.whiskers[0].noise.readings(moment);
        let share = 0.5 + 0.5 * self.share(t);
        self.row += 1;
        (low + share * (high - low)).clamp(low, high) + self.zero(t)
    }

    /// The error as a share of its bound, -1 to 1.
    fn share(&mut self, t: f64) -> f64 {
        let random = &mut self.random;
        match self.law {
            FreeLaw::Uniform | FreeLaw::Zero | FreeLaw::DriftingZero => random.signed(1.0),
            FreeLaw::TwoPoint => random.sign(),
            FreeLaw::Constant => 1.0,
            FreeLaw::Alike => {
                let kept = (-1.0 / (RATE * ALIKE)).exp();
                // The variance of a sum of twelve uniform numbers is 1.
                let draw: f64 = (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
                self.state = kept * self.state + (1.0 - kept * kept).sqrt() * draw;
                // Beyond a standard deviation it stays at the end of the bound.
                self.state.clamp(-1.0, 1.0)
            }
            FreeLaw::Sine => (TAU * t / PERIOD).sin(),
            FreeLaw::Ramp => 2.0 * t * RATE / ROWS as f64 - 1.0,
            FreeLaw::Jumps => {
                if random.unit() < JUMP {
                    self.state = -self.state;
                }
                self.state
            }
            FreeLaw::Quantised => {
                let step = 2.0 / f64::from(1_u32 << BITS);
                step * ((TAU * 0.1 * t / PERIOD).sin() / step).round()
            }
        }
    }

    /// How far off the zero is (N m).
    fn zero(&self, t: f64) -> f64 {
        match self.law {
            FreeLaw::Zero => ZERO,
            FreeLaw::DriftingZero => {
                // A triangle from the lower end to the upper one and back.
                let legs = DRIFT * t / (2.0 * ZERO);
                let share = legs.rem_euclid(2.0);
                ZERO * (2.0 * if share < 1.0 { share } else { 2.0 - share } - 1.0)
            }
            _ => 0.0,
        }
    }
}
