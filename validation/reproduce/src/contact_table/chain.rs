//! The chain from the peg to the distance: stage, whisker, sensor, calibration, `contacts`.

use chacha20::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use vibrissa::Result;
use vibrissa::beam::{Load, SmallAngle, Whisker, point_mode};
use vibrissa::config::{ContactOptions, CurveOptions};
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::plane::{Pose2, Vec2};
use vibrissa::tasks::batch;
use vibrissa::tasks::calibrate::{Explained, Labelled, fit_moment_curve};
use vibrissa::tasks::contact::{ContactKind, ContactReading, contacts, fixed_point};
use vibrissa::world::calibration::MomentCurve;
use vibrissa::world::{MomentNoise, MountedWhisker, Robot};

/// Errors of a reading: 5 % and 2 µN m, independent from row to row.
pub(super) const NOISE: MomentNoise = MomentNoise { moment_relative: 0.05, moment_absolute: 2e-6 };
/// Rows a second of the sensor (Hz), speed of the stage (m/s), base step (m), resolution of the stage (m).
pub(super) const RATE: f64 = 300.0;
pub(super) const SPEED: f64 = 5e-3;
pub(super) const STEP: f64 = 1e-3;
const STAGE: f64 = 10e-6;
/// Rows at rest before the touch.
const REST: i32 = 30;
/// Contacts of the calibration.
const LABELS: usize = 1000;
/// Flux by moment (T / (N m)) of a magnet on a soft base, and the moment at which its bend is felt (N m).
const FLUX: f64 = 0.5;
const BEND: f64 = 0.03;

/// What is known of the gain of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gain {
    /// Off by a factor within this of one, another one in each trial.
    Within(f64),
    /// As a calibration with labelled contacts leaves it.
    Calibrated,
}

/// How errors are distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Uniform in the bound: the simulator's law.
    Uniform,
    /// Normal, of the same mean and variance.
    Normal,
}

/// What is simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Base motion in steps of 1 mm.
    pub steps: usize,
    /// What is known of the gain.
    pub gain: Gain,
    /// How a reading's error is distributed.
    pub law: Law,
}

/// One trial: distances of the peg over the true one, less one; infinite where none was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// By the closed form, from the last reading alone.
    pub closed_form: f64,
    /// By least squares alone.
    pub least_squares: f64,
    /// By [`contacts`], as `vibrissa contact` tells it.
    pub contact: f64,
    /// The standard deviation that it told, over the true distance.
    pub std: f64,
}

/// One sensor for each seed, calibrated with labelled contacts of its own.
#[derive(Clone, Debug)]
pub struct Chain {
    curves: Vec<MomentCurve>,
}

fn flux(moment: f64) -> f64 {
    FLUX * moment * (1.0 - (moment / BEND).powi(2))
}

/// A reading of a true value with errors in its bound, as `vibrissa simulate` draws them.
fn read(exact: f64, unit: f64, law: Law, dice: &mut ChaCha8Rng) -> f64 {
    let [low, high] = MomentNoise { moment_absolute: NOISE.moment_absolute * unit, ..NOISE }.readings(exact);
    let error = match law {
        Law::Uniform => dice.random_range(-1.0..=1.0),
        // Box and Muller.
        Law::Normal => {
            let (u, v): (f64, f64) = (dice.random_range(1e-300..=1.0), dice.random_range(0.0..=1.0));
            (-2.0 * u.ln()).sqrt() * (2.0 * core::f64::consts::PI * v).cos() / 3f64.sqrt()
        }
    };
    0.5 * (low + high) + 0.5 * (high - low) * error
}

fn moment(point: Vec2) -> Option<f64> {
    point_mode(&Whisker::default(), point, Load::Normal).unwrap_or_default().first().map(|bend| bend.moment)
}

impl Chain {
    /// Calibrates as many sensors: contacts all over the whisker, each label as good as the stage, each reading with its error.
    ///
    /// # Errors
    ///
    /// A calibration that fails.
    pub fn new(sensors: usize, threads: usize) -> Result<Self> {
        let mut dice = ChaCha8Rng::seed_from_u64(77);
        let mut labels = Labelled {
            source: "simulated".to_owned(),
            contacts: Vec::new(),
            inputs: vec!["bx".to_owned()],
            readings: Vec::new(),
            angles: Vec::new(),
            moments: None,
        };
        while labels.contacts.len() < LABELS {
            let point = Vec2::new(dice.random_range(0.03..=0.072), dice.random_range(-6e-3..=6e-3));
            if point.norm() < 0.074 && moment(point).is_some() {
                labels.contacts.push(point);
            }
        }
        let explained = labels.explain(&Whisker::default())?;
        let seeds: Vec<u64> = (0..sensors.max(1) as u64).collect();
        let curves = batch::map(&seeds, threads, |seed| calibrate(labels.clone(), &explained, *seed));
        Ok(Self { curves: curves.into_iter().collect::<Result<_>>()? })
    }

    /// How far the calibrations are off, in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let gain = |curve: &MomentCurve, moment: f64| {
            let at = |m: f64| curve.moment(&[flux(m)]).unwrap_or(f64::NAN);
            100.0 * ((at(moment) - at(0.0)) / moment - 1.0)
        };
        let spread = |moment: f64| {
            let mut sizes: Vec<f64> = self.curves.iter().map(|curve| gain(curve, moment).abs()).collect();
            sizes.sort_by(f64::total_cmp);
            format!("{:.2} / {:.2} %", sizes[sizes.len() / 2], sizes[sizes.len() - 1])
        };
        let degree = self.curves.iter().map(|curve| curve.coefficients.len() - 1).max().unwrap_or(0);
        format!(
            "{} calibrations with {LABELS} contacts, degree up to {degree}: moments above rest are off by (median / largest) {} at \
             0.2 mN m, {} at 0.6 mN m",
            self.curves.len(),
            spread(0.2e-3),
            spread(0.6e-3)
        )
    }

    /// One peg at a distance (m), felt once, by the sensor of that number.
    #[must_use]
    pub fn trial(&self, experiment: Experiment, distance: f64, seed: u64, sensor: usize) -> Outcome {
        let mut dice = ChaCha8Rng::seed_from_u64(seed);
        let Experiment { steps, gain, law } = experiment;
        let (factor, allowance) = match gain {
            Gain::Within(gain) => (1.0 + gain * dice.random_range(-1.0..=1.0), gain),
            Gain::Calibrated => (1.0, 0.01),
        };
        let curve = &self.curves[sensor % self.curves.len()];
        let rows = (steps as f64 * STEP / SPEED * RATE).round() as i32;
        let (mut log, mut level) = (Vec::new(), 0.0);
        for i in 1 - REST..=rows {
            let base = Pose2::new(0.0, -SPEED / RATE * f64::from(i), 0.0);
            let told = Pose2::new(0.0, (base.y / STAGE).round() * STAGE, 0.0);
            let peg = base.inverse_transform_point(Vec2::new(distance, 0.0));
            let exact = factor * if i > 0 { moment(peg).unwrap_or(f64::NAN) } else { 0.0 };
            let reading = match gain {
                Gain::Within(_) => read(exact, 1.0, law, &mut dice),
                Gain::Calibrated => curve.moment(&[read(flux(exact), FLUX, law, &mut dice)]).unwrap_or(f64::NAN),
            };
            // The table's moments are increments: the level at rest is taken away.
            level += if i <= 0 { reading / f64::from(REST) } else { 0.0 };
            log.push((told, reading));
        }
        log.iter_mut().for_each(|row| row.1 -= level);
        let relative = NOISE.moment_relative + allowance;
        let noise = MomentNoise { moment_relative: relative, moment_absolute: 1.25 * NOISE.moment_absolute };
        judge(&log, noise, distance, steps)
    }
}

/// Adds a seed's readings to the labels and fits the curve.
fn calibrate(mut labels: Labelled, explained: &[Explained], seed: u64) -> Result<MomentCurve> {
    let mut dice = ChaCha8Rng::seed_from_u64(500_000 + seed);
    let half = 0.5 * STAGE;
    let contacts = labels.contacts.clone();
    let reading = |label: &Vec2| {
        let true_point = *label + Vec2::new(dice.random_range(-half..=half), dice.random_range(-half..=half));
        vec![read(flux(moment(true_point).unwrap_or(f64::NAN)), FLUX, Law::Uniform, &mut dice)]
    };
    labels.readings = contacts.iter().map(reading).collect();
    fit_moment_curve(&labels, explained, &CurveOptions::default())
}

/// The three answers to one log.
fn judge(rows: &[(Pose2, f64)], noise: MomentNoise, distance: f64, steps: usize) -> Outcome {
    let whisker = Whisker::default();
    let row = |(i, (pose, moment)): (usize, &(Pose2, f64))| LogRow {
        t: i as f64 / RATE,
        odom_from_robot: *pose,
        readings: vec![*moment],
        heading: None,
        line: i + 2,
    };
    let log = SensorLog {
        channels: vec![Channel { whisker: String::new(), quantity: Quantity::Moment }],
        rows: rows.iter().enumerate().map(row).collect(),
        ..SensorLog::default()
    };
    let robot = Robot { whiskers: vec![MountedWhisker { noise, ..MountedWhisker::default() }], ..Robot::default() };
    let report = contacts(&log, &robot, &ContactOptions::default()).unwrap_or_default();
    let found = report.steps.iter().rev().find(|step| step.kind == ContactKind::Side);
    let error = |d: Option<f64>| d.map_or(f64::INFINITY, |d| d / distance - 1.0);
    let felt = rows.iter().skip(REST as usize).map(|(base, moment)| ContactReading {
        t: 0.0,
        whisker,
        odom_from_whisker: *base,
        moment: *moment,
        noise,
        count: 1,
    });
    let felt: Vec<ContactReading> = felt.collect();
    let last = rows.last().map_or(0.0, |row| row.1);
    let closed = SmallAngle::from_moment_and_deflection(whisker.flexural_rigidity, last, steps as f64 * STEP);
    Outcome {
        closed_form: error(closed.map(|bend| bend.s_a)),
        least_squares: error(fixed_point(&felt, Vec2::new(0.05, 0.0)).map(|point| point.position.x)),
        contact: error(found.and_then(|step| step.position()).map(|position| position.x)),
        std: found.and_then(|step| step.std).map_or(f64::INFINITY, |std| std / distance),
    }
}
