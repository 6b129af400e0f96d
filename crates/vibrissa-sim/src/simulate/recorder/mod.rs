//! From an exact sweep to what would be recorded: disturbed moments, what a chip says of them, odometry that errs.
//!
//! Every disturbance draws from a random stream of its own, so that switching one on leaves the others as they are.

mod disturb;
mod law;
mod odometry;
mod senses;
mod serial;
mod stamps;
mod truth;

pub use disturb::Disturbances;
pub use law::NoiseLaw;
pub use odometry::{OdometryErrors, Slip};
pub use serial::{SerialLayout, serial_text};
pub use stamps::Stamps;
pub use truth::TrueErrors;

use super::{Sweep, SweepNoise};
use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use crate::plane::wrap_angle;
use crate::sensing::{SensingChain, Vec3};
use crate::world::Robot;
use crate::{Error, Result};
use chacha20::ChaCha8Rng;
use disturb::Distorted;
use rand::{RngExt, SeedableRng};
use senses::Senses;

/// Length of a contact strip's cell where nothing is said (m).
pub const STRIP_CELL: f64 = 2e-3;

/// What a log holds of each whisker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// `moment` (N m).
    Moment,
    /// `bx,by,bz` (T), as a driver makes them from the counts.
    Flux,
    /// `ax,ay,az`, the chip's registers.
    Counts,
    /// `force` (N), with the errors that the whisker declares of it.
    Force,
    /// `slope` (rad) at the contact, likewise.
    Slope,
    /// `strip_lo,strip_hi` (m): the cells of a contact strip that are touched.
    Strip,
}

impl Columns {
    /// The columns of a log.
    fn quantities(self) -> &'static [Quantity] {
        match self {
            Self::Moment => &[Quantity::Moment],
            Self::Flux => &[Quantity::FluxX, Quantity::FluxY, Quantity::FluxZ],
            Self::Counts => &[Quantity::CountX, Quantity::CountY, Quantity::CountZ],
            Self::Force => &[Quantity::Force],
            Self::Slope => &[Quantity::Slope],
            Self::Strip => &[Quantity::StripLo, Quantity::StripHi],
        }
    }
}

/// A magnetometer at the base of every whisker, and the noise of its converter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Magnetometer {
    /// From moments to counts.
    pub chain: SensingChain,
    /// Standard deviation of the field's noise on each axis (T), at least 0.
    pub flux_noise: f64,
}

/// How a sweep is recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorder {
    /// Bounded noise, and the seed of everything random.
    pub noise: SweepNoise,
    /// How the moments' errors behave within those bounds.
    pub law: NoiseLaw,
    /// How readings, odometry and headings differ from what is declared.
    pub truth: TrueErrors,
    /// What else befalls the moments.
    pub disturbances: Disturbances,
    /// What else befalls the odometry.
    pub odometry: OdometryErrors,
    /// Which rows get lost or come late.
    pub stamps: Stamps,
    /// The magnetometer that flux and counts come from.
    pub magnetometer: Magnetometer,
    /// What the log holds, in this order.
    pub columns: Vec<Columns>,
    /// Length of a contact strip's cell (m), above 0.
    pub strip_cell: f64,
    /// Standard deviation of an absolute heading that is logged too (rad), at least 0; none logs none.
    pub heading_noise: Option<f64>,
}

impl Default for Recorder {
    /// Moments with the noise that the whiskers declare, exact odometry.
    fn default() -> Self {
        Self {
            noise: SweepNoise::default(),
            law: NoiseLaw::default(),
            truth: TrueErrors::default(),
            disturbances: Disturbances::default(),
            odometry: OdometryErrors::default(),
            stamps: Stamps::default(),
            magnetometer: Magnetometer::default(),
            columns: vec![Columns::Moment],
            strip_cell: STRIP_CELL,
            heading_noise: None,
        }
    }
}

/// A recorded sweep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// The log.
    pub log: SensorLog,
    /// For each row of the log the index of the sweep's row that it records.
    pub rows: Vec<usize>,
    /// For each row of the log and each whisker the flux that a driver reads (T).
    pub flux: Vec<Vec<Vec3>>,
}

impl Recorder {
    /// Records `sweep`; the same seed gives the same recording, and without disturbances the sweep's own log.
    ///
    /// # Errors
    ///
    /// Usage: an option that is out of range.
    pub fn record(&self, robot: &Robot, sweep: &Sweep) -> Result<Recording> {
        self.check()?;
        let seed = self.noise.seed;
        let mut dice = self.noise.dice();
        let felt = self.odometry.felt_path(seed, &sweep.truth, &self.truth);
        let odometry = dice.odometry(felt.into_iter());
        let mut distorted: Vec<Distorted> =
            (0..robot.whiskers.len()).map(|w| Distorted::new(&self.disturbances, seed, w)).collect();
        let moments = self.moments(robot, sweep, &mut distorted);
        let mut converter: Vec<ChaCha8Rng> =
            (0..robot.whiskers.len()).map(|w| stream(seed, Stream::Converter, w)).collect();
        let mut recording = Recording { log: self.empty_log(robot), ..Recording::default() };
        let mut beyond = vec![0usize; robot.whiskers.len()];
        let kept = self.stamps.kept(seed, &sweep.truth);
        let mut next = kept.iter().peekable();
        let mut senses = Senses::of(robot, sweep, self.strip_cell, seed);
        let mut compass = stream(seed, Stream::Heading, 0);
        for (index, pose) in sweep.truth.iter().enumerate() {
            let (mut readings, mut fluxes) = (Vec::new(), Vec::new());
            for (w, whisker) in robot.whiskers.iter().enumerate() {
                let moment = match self.law {
                    NoiseLaw::Uniform => dice.reading(moments[w][index], &whisker.noise),
                    _ => moments[w][index],
                };
                let moment = distorted[w].after_noise(moment);
                let (counts, flux) = self.convert(moment, &mut converter[w], &mut beyond[w]);
                for column in &self.columns {
                    match column {
                        Columns::Moment => readings.push(moment),
                        Columns::Flux => readings.extend(flux),
                        Columns::Counts => readings.extend(counts.map(f64::from)),
                        Columns::Force | Columns::Slope | Columns::Strip => {
                            readings.extend(senses[w].read(*column, index));
                        }
                    }
                }
                fluxes.push(flux);
            }
            let heading = self
                .heading_noise
                .map(|noise| wrap_angle(pose.map_from_robot.theta + self.truth.heading + noise * normal(&mut compass)));
            if let Some((_, stamp)) = next.next_if(|(row, _)| *row == index) {
                let row = LogRow { t: *stamp, odom_from_robot: odometry[index], readings, heading, line: 0 };
                recording.log.rows.push(row);
                recording.rows.push(index);
                recording.flux.push(fluxes);
            }
        }
        recording.log.warnings = self.beyond_range(robot, &beyond);
        Ok(recording)
    }

    /// The moments of each whisker, row by row: as its sensor feels them, and with their errors by any law but the uniform one, whose
    /// draws go from row to row.
    fn moments(&self, robot: &Robot, sweep: &Sweep, distorted: &mut [Distorted]) -> Vec<Vec<f64>> {
        let times: Vec<f64> = sweep.truth.iter().map(|pose| pose.t).collect();
        let start = times.first().copied().unwrap_or(0.0);
        let of = |(w, (whisker, distorted)): (usize, (&crate::world::MountedWhisker, &mut Distorted))| {
            let exact: Vec<f64> = sweep.exact_moments.iter().map(|row| row[w]).collect();
            let felt = truth::delayed(&times, &exact, self.truth.delay).into_iter().zip(&times);
            let felt = felt.map(|(h, t)| distorted.before_noise(*t, self.truth.read(t - start, h)));
            let felt: Vec<f64> = felt.collect();
            if self.law == NoiseLaw::Uniform {
                return felt;
            }
            let bound = self.noise.moment.unwrap_or(whisker.noise);
            self.law.readings(&times, &felt, &bound, &mut stream(self.noise.seed, Stream::Law, w))
        };
        robot.whiskers.iter().zip(distorted).enumerate().map(of).collect()
    }

    fn check(&self) -> Result<()> {
        self.noise.check()?;
        self.law.check()?;
        self.truth.check()?;
        self.disturbances.check()?;
        self.odometry.check()?;
        self.stamps.check()?;
        in_range("heading_noise", self.heading_noise.unwrap_or(0.0), f64::INFINITY)?;
        in_range("flux_noise", self.magnetometer.flux_noise, f64::INFINITY)?;
        if !(self.strip_cell > 0.0 && self.strip_cell.is_finite()) {
            return Err(Error::usage("the length of a strip's cell").value(self.strip_cell).allowed("above 0 m"));
        }
        let stiffness = self.magnetometer.chain.stiffness;
        if !(stiffness > 0.0 && stiffness.is_finite()) {
            return Err(Error::usage("the compliant element's stiffness").value(stiffness).allowed("above 0 N m/rad"));
        }
        Ok(())
    }

    /// What the chip makes of a moment (N m); counts the readings outside its range.
    fn convert(&self, moment: f64, rng: &mut ChaCha8Rng, beyond: &mut usize) -> ([i32; 3], Vec3) {
        let Magnetometer { chain, flux_noise } = &self.magnetometer;
        let field = chain.flux(moment).map(|b| if *flux_noise > 0.0 { b + flux_noise * normal(rng) } else { b });
        let range = chain.chip.range();
        *beyond += usize::from((0..3).any(|k| field[k].abs() > range[k]));
        let counts = chain.chip.counts(field);
        (counts, chain.chip.flux(counts))
    }

    fn empty_log(&self, robot: &Robot) -> SensorLog {
        let alone = robot.whiskers.len() == 1;
        let quantities: Vec<Quantity> = self.columns.iter().flat_map(|column| column.quantities()).copied().collect();
        let name = |name: &String| if alone { String::new() } else { name.clone() };
        let of = |w: &crate::world::MountedWhisker| {
            let whisker = name(&w.name);
            quantities.iter().map(move |&quantity| Channel { whisker: whisker.clone(), quantity }).collect::<Vec<_>>()
        };
        SensorLog { channels: robot.whiskers.iter().flat_map(of).collect(), ..SensorLog::default() }
    }

    fn beyond_range(&self, robot: &Robot, beyond: &[usize]) -> Vec<String> {
        if !self.columns.iter().any(|column| matches!(column, Columns::Flux | Columns::Counts)) {
            return Vec::new();
        }
        let range = self.magnetometer.chain.chip.range().map(|b| format!("{:.2}", b * 1e3)).join(", ");
        let warn = |(whisker, &count): (&crate::world::MountedWhisker, &usize)| {
            (count > 0).then(|| {
                format!(
                    "{count} readings of {} are beyond the chip's range of ±{range} mT: they wrap or saturate",
                    whisker.name
                )
            })
        };
        robot.whiskers.iter().zip(beyond).filter_map(warn).collect()
    }
}

/// The random streams, each for one purpose; stream 0 is the bounded noise's.
#[derive(Clone, Copy, Debug)]
enum Stream {
    Gain = 1,
    Gaussian,
    Outliers,
    Converter,
    Odometry,
    Dropped,
    Late,
    Heading,
    Law,
    Senses,
}

/// The stream of one purpose for one whisker.
fn stream(seed: u64, purpose: Stream, whisker: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((purpose as u64) << 32) + whisker as u64);
    rng
}

/// Uniform in [-1, 1].
fn signed(rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(-1.0..=1.0)
}

/// Uniform in [0, 1).
fn unit(rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(0.0..1.0)
}

/// Normal with mean 0 and standard deviation 1, by the Box-Muller transform.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (radius, angle) = (1.0 - unit(rng), unit(rng));
    (-2.0 * radius.ln()).sqrt() * (core::f64::consts::TAU * angle).cos()
}

/// Checks that an option is at least 0 and below a limit.
fn in_range(name: &str, value: f64, below: f64) -> Result<()> {
    if value >= 0.0 && value < below {
        return Ok(());
    }
    Err(Error::usage(format!("the recorder's {name}")).value(value).allowed(format!("at least 0 and below {below}")))
}
