//! Nuisance parameters beside the pose: what one log shares and nobody knows exactly, each with a Gaussian prior
//! \[barfoot2017state, sec. 3.3\].
//!
//! The state is the robot's pose at one row, then these. A quantity that is declared exact is none of them.

use crate::contact::SensedQuantity;
use crate::flow::pose::NuisanceQuantity;
use crate::world::{MountedWhisker, Robot};

/// Numbers of a pose.
pub(super) const POSE: usize = 3;
/// Share of the declared relative noise that all readings may have in common (standard deviation over bound): a bound is seldom noise
/// alone.
const SHARED_NOISE: f64 = 0.25;
const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unknown {
    pub(super) parameter: Parameter,
    /// Standard deviation before any reading, in its unit.
    pub(super) std: f64,
    /// What it is declared not to exceed.
    pub(super) bound: f64,
}

/// What it is; of which whisker or sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parameter {
    /// Share by which increments of the odometry are too short.
    OdometryScale,
    /// How far they go aside (rad).
    OdometryAside,
    /// Share by which they turn too little.
    OdometryTurn,
    /// How much later than the odometry the readings were taken (s).
    Delay,
    /// Share by which the map is too small.
    MapScale,
    /// Mount of a whisker: x, y (m), heading (rad).
    Mount(usize, usize),
    /// Share by which a whisker is longer.
    Length(usize),
    /// Relative error of a sensor.
    Gain(usize),
    /// Dimensionless reading of a sensor while its whisker is free.
    Zero(usize),
    /// How fast that changes (1/s).
    Drift(usize),
}

/// The nuisance parameters of a robot, and where each stands in the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Unknowns {
    all: Vec<Unknown>,
    /// Place of the first of the three of the odometry.
    pub(super) odometry: Option<usize>,
    pub(super) delay: Option<usize>,
    pub(super) map_scale: Option<usize>,
    /// For each whisker: of the first of the three of the mount, and of the length.
    pub(super) mount: Vec<Option<usize>>,
    pub(super) length: Vec<Option<usize>>,
    /// For each sensor.
    pub(super) gain: Vec<Option<usize>>,
    pub(super) zero: Vec<Option<usize>>,
    pub(super) drift: Vec<Option<usize>>,
}

/// One sense of a whisker, as its errors depend on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sense {
    pub(super) whisker: usize,
    pub(super) quantity: SensedQuantity,
    /// Dimensionless reading per N m, N or rad.
    pub(super) per_reading: f64,
}

impl Unknowns {
    /// Those that the robot declares; `gain` is a standard deviation of a relative error that all readings share, if it is told.
    pub(super) fn new(robot: &Robot, senses: &[Sense], gain: Option<f64>) -> Self {
        let mut own = Self::default();
        let bounds = &robot.odometry;
        // Errors spread evenly over a disc, and between two bounds.
        let way = [0.5 * bounds.translation_relative, bounds.rotation_relative / SQRT_3];
        if way.iter().any(|&std| std > 0.0) {
            let [place, turn] = way.map(|std| std.max(LEAST));
            let most = [bounds.translation_relative, bounds.rotation_relative].map(exact_or);
            own.odometry = Some(own.next());
            own.push(Parameter::OdometryScale, place, most[0]);
            own.push(Parameter::OdometryAside, place, most[0]);
            own.push(Parameter::OdometryTurn, turn, most[1]);
        }
        own.delay = own.even(Parameter::Delay, bounds.delay);
        own.map_scale = own.even(Parameter::MapScale, robot.map_scale);
        for (index, whisker) in robot.whiskers.iter().enumerate() {
            let errors = &whisker.errors;
            let mount = errors.mount.iter().any(|&bound| bound > 0.0).then(|| own.next());
            if mount.is_some() {
                errors.mount.iter().enumerate().for_each(|(axis, bound)| {
                    own.push(Parameter::Mount(index, axis), (bound / SQRT_3).max(LEAST), exact_or(*bound));
                });
            }
            own.mount.push(mount);
            let length = own.even(Parameter::Length(index), errors.length / whisker.beam.length);
            own.length.push(length);
        }
        for (index, sense) in senses.iter().enumerate() {
            let Some(whisker) = robot.whiskers.get(sense.whisker) else { continue };
            own.of_sensor(index, sense, whisker, gain);
        }
        own
    }

    fn of_sensor(&mut self, index: usize, sense: &Sense, whisker: &MountedWhisker, gain: Option<f64>) {
        let (errors, noise) = (&whisker.errors, sense.quantity.noise(whisker));
        let [rigidity, zero, drift] = match sense.quantity {
            SensedQuantity::Moment => [errors.rigidity, errors.zero, errors.zero_drift],
            SensedQuantity::Force => [errors.rigidity, 0.0, 0.0],
            SensedQuantity::Slope => [0.0; 3],
        };
        let even = |bound: f64| bound / SQRT_3;
        let shared = gain.unwrap_or(SHARED_NOISE * noise.relative);
        let most = errors.gain + rigidity + noise.relative.max(gain.unwrap_or(0.0) * SQRT_3);
        let gain = [shared, even(errors.gain), even(rigidity)].iter().map(|std| std * std).sum::<f64>().sqrt();
        let place = self.with(Parameter::Gain(index), gain, most);
        self.gain.push(place);
        let most = (zero + noise.absolute) * sense.per_reading;
        let zero = even(zero).hypot(SHARED_NOISE * noise.absolute) * sense.per_reading;
        let place = self.with(Parameter::Zero(index), zero, most);
        self.zero.push(place);
        let place = self.even(Parameter::Drift(index), drift * sense.per_reading);
        self.drift.push(place);
    }

    fn next(&self) -> usize {
        POSE + self.all.len()
    }

    fn push(&mut self, parameter: Parameter, std: f64, bound: f64) {
        self.all.push(Unknown { parameter, std, bound });
    }

    /// Adds one of this standard deviation, if that is not zero; gives its place.
    fn with(&mut self, parameter: Parameter, std: f64, bound: f64) -> Option<usize> {
        let place = (std > 0.0).then(|| self.next());
        if place.is_some() {
            self.push(parameter, std, bound);
        }
        place
    }

    /// Adds one that lies evenly within a bound.
    fn even(&mut self, parameter: Parameter, bound: f64) -> Option<usize> {
        self.with(parameter, bound / SQRT_3, bound)
    }

    /// Whether the robot bounds the zero of a whisker.
    pub(super) fn zero_is_declared(&self, robot: &Robot) -> bool {
        robot.whiskers.iter().any(|whisker| whisker.errors.zero > 0.0)
    }

    /// How often the largest of these values exceeds its bound.
    pub(super) fn most_of_bound(&self, values: &[f64]) -> f64 {
        self.all.iter().zip(values).map(|(unknown, value)| value.abs() / unknown.bound).fold(0.0, f64::max)
    }

    /// Numbers of the state.
    pub(super) fn size(&self) -> usize {
        self.next()
    }

    /// The nuisance parameters, in the order of the state after the pose.
    pub(super) fn all(&self) -> &[Unknown] {
        &self.all
    }
}

/// The value of one that may not be among them: 0.
pub(super) fn value(values: &[f64], place: Option<usize>) -> f64 {
    place.map_or(0.0, |at| values[at - POSE])
}

/// What is known exactly beside what is not: a micrometre in a metre.
const LEAST: f64 = 1e-6;

/// A bound; none where it is that of what is known exactly, which is never far from it.
fn exact_or(bound: f64) -> f64 {
    if bound > 0.0 { bound } else { f64::INFINITY }
}

impl Parameter {
    /// How it is told, with its whisker and its unit over that of the state; the odometry's are told elsewhere.
    pub(super) fn told(self, robot: &Robot, senses: &[Sense]) -> Option<(NuisanceQuantity, Option<usize>, f64, f64)> {
        let errors = |whisker: usize| robot.whiskers.get(whisker).map(|w| (w.errors, w.beam.length));
        let of =
            |sensor: usize| senses.get(sensor).and_then(|s| Some((s.whisker, s.per_reading, errors(s.whisker)?.0)));
        let told = match self {
            Self::OdometryScale | Self::OdometryAside | Self::OdometryTurn => return None,
            Self::Delay => (NuisanceQuantity::Delay, None, 1.0, robot.odometry.delay),
            Self::MapScale => (NuisanceQuantity::MapScale, None, 1.0, robot.map_scale),
            Self::Mount(whisker, axis) => {
                let quantity =
                    [NuisanceQuantity::MountX, NuisanceQuantity::MountY, NuisanceQuantity::MountHeading][axis];
                (quantity, Some(whisker), 1.0, errors(whisker)?.0.mount[axis])
            }
            Self::Length(whisker) => {
                let (own, length) = errors(whisker)?;
                (NuisanceQuantity::Length, Some(whisker), length, own.length)
            }
            Self::Gain(sensor) => {
                let (whisker, _, own) = of(sensor)?;
                (NuisanceQuantity::Gain, Some(whisker), 1.0, own.gain + own.rigidity)
            }
            Self::Zero(sensor) => {
                let (whisker, per, own) = of(sensor)?;
                (NuisanceQuantity::Zero, Some(whisker), 1.0 / per, own.zero)
            }
            Self::Drift(sensor) => {
                let (whisker, per, own) = of(sensor)?;
                (NuisanceQuantity::ZeroDrift, Some(whisker), 1.0 / per, own.zero_drift)
            }
        };
        Some(told)
    }
}
