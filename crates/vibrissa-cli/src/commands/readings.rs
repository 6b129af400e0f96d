//! Readings of virtual sensors and the whisker they belong to, as options of several commands.

use crate::quantity::of_option as quantity;
use std::path::PathBuf;
use vibrissa::beam::Load;
use vibrissa::figure::numbers::fixed;
use vibrissa::flow::contact_set::{ContactModel, Limits, MomentRegime, Reading, VirtualSensor};
use vibrissa::io::Dimension;
use vibrissa::plane::Pose2;
use vibrissa::sets::Interval;
use vibrissa::world::{MountedWhisker, Robot};
use vibrissa::{Error, Result};

/// What was read, and by which whisker.
#[derive(Debug, clap::Args)]
pub(crate) struct ReadingArgs {
    /// The sensor that read: load, strip, slope or moment; give several pairs of --sensor and --value to combine them
    #[arg(long, value_name = "SENSOR", required = true)]
    sensor: Vec<String>,
    /// What it read, SI or with unit: "0.1 N", "30 mm", "20 deg", "5 mN m"; an interval as "28 mm..32 mm"
    #[arg(long, value_name = "VALUE", required = true, allow_hyphen_values = true)]
    value: Vec<String>,
    /// Bound on each reading's error, as the readings: once for all that are numbers, or "5 %" of each
    #[arg(long, value_name = "VALUE")]
    tolerance: Option<String>,
    /// The whisker of each reading, by name, when the robot has several [default: the first]
    #[arg(long, value_name = "NAME")]
    whisker: Vec<String>,
    /// Direction of the force: `normal` to the whisker or `vertical` (the paper's shape equations)
    #[arg(long, default_value = "normal", value_parser = ["normal", "vertical"])]
    load: String,
    /// How moments are read: `auto` takes the small-angle model where no contact moves the tip by a tenth of the length
    #[arg(long, default_value = "auto", value_parser = ["auto", "small", "large"])]
    regime: String,
    /// Largest force that the whisker bears (N) [default: no limit]
    #[arg(long, value_name = "FORCE")]
    max_force: Option<String>,
    /// Largest moment that the whisker bears (N m) [default: no limit]
    #[arg(long, value_name = "MOMENT")]
    max_moment: Option<String>,
    /// Largest slope at the contact (rad) [default: no limit but the first mode, half a turn]
    #[arg(long, value_name = "ANGLE")]
    max_slope: Option<String>,
    /// The robot (.toml) [default: the paper's whisker]
    #[arg(long, value_name = "ROBOT")]
    robot: Option<PathBuf>,
}

/// The readings of one whisker.
#[derive(Clone, Debug)]
pub(crate) struct WhiskerReadings {
    pub(crate) name: String,
    pub(crate) model: ContactModel,
    pub(crate) robot_from_whisker: Pose2,
    pub(crate) readings: Vec<Reading>,
}

impl ReadingArgs {
    /// The robot of the file, or the paper's.
    pub(crate) fn robot(&self) -> Result<Robot> {
        self.robot.as_deref().map_or_else(|| Ok(Robot::default()), vibrissa::read_robot)
    }

    /// The readings, whisker by whisker in the robot's order; those without any are left out.
    pub(crate) fn read(&self) -> Result<Vec<WhiskerReadings>> {
        let robot = self.robot()?;
        if self.sensor.len() != self.value.len() {
            return Err(Error::usage("each --sensor needs one --value")
                .value(format!("{} sensors and {} values", self.sensor.len(), self.value.len()))
                .remedy("repeat them in pairs: --sensor load --value \"0.1 N\" --sensor strip --value \"60 mm\""));
        }
        if !self.whisker.is_empty() && self.whisker.len() != self.sensor.len() {
            return Err(Error::usage("--whisker must be given for each reading or for none").value(format!(
                "{} whiskers and {} readings",
                self.whisker.len(),
                self.sensor.len()
            )));
        }
        let mut owners: Vec<(usize, Reading)> = Vec::new();
        for (i, (sensor, value)) in self.sensor.iter().zip(&self.value).enumerate() {
            owners.push((self.owner(&robot, i)?, self.reading(sensor, value)?));
        }
        let of_whisker = |(index, mounted): (usize, &MountedWhisker)| {
            let readings: Vec<Reading> = owners.iter().filter(|(w, _)| *w == index).map(|(_, r)| *r).collect();
            (!readings.is_empty()).then(|| self.whisker_readings(mounted, readings))
        };
        robot.whiskers.iter().enumerate().filter_map(of_whisker).collect()
    }

    fn owner(&self, robot: &Robot, reading: usize) -> Result<usize> {
        let Some(name) = self.whisker.get(reading) else { return Ok(0) };
        robot.whiskers.iter().position(|w| w.name == *name).ok_or_else(|| {
            let names: Vec<&str> = robot.whiskers.iter().map(|w| w.name.as_str()).collect();
            Error::usage("--whisker").value(name).allowed(names.join(", "))
        })
    }

    fn whisker_readings(&self, mounted: &MountedWhisker, readings: Vec<Reading>) -> Result<WhiskerReadings> {
        let load = if self.load == "vertical" { Load::Vertical } else { Load::Normal };
        let limit = |name: &str, dimension: Dimension, text: &Option<String>| match text {
            Some(text) => quantity(name, text, dimension),
            None => Ok(f64::INFINITY),
        };
        let limits = Limits {
            force: limit("--max-force", Dimension::Force, &self.max_force)?,
            moment: limit("--max-moment", Dimension::Moment, &self.max_moment)?,
            slope: limit("--max-slope", Dimension::Angle, &self.max_slope)?,
        };
        Ok(WhiskerReadings {
            name: mounted.name.clone(),
            model: ContactModel::new(&mounted.beam, load)?.with_limits(limits)?,
            robot_from_whisker: mounted.robot_from_whisker,
            readings,
        })
    }

    fn reading(&self, sensor: &str, value: &str) -> Result<Reading> {
        let mut sensor = VirtualSensor::from_word(sensor)?;
        if let VirtualSensor::Moment(regime) = &mut sensor {
            *regime = match self.regime.as_str() {
                "small" => MomentRegime::SmallAngle,
                "large" => MomentRegime::LargeAngle,
                _ => MomentRegime::Auto,
            };
        }
        let dimension = Dimension::from(sensor);
        let number = |text: &str| quantity("--value", text, dimension);
        let value = match value.split_once("..") {
            Some((lo, hi)) => {
                let (lo, hi) = (number(lo)?, number(hi)?);
                if lo > hi {
                    return Err(Error::usage("--value")
                        .value(value)
                        .allowed("an interval lo..hi with lo not above hi"));
                }
                Interval::new(lo, hi)
            }
            None => {
                let middle = number(value)?;
                let error = self.error_of(middle, dimension)?;
                Interval::new(middle - error, middle + error)
            }
        };
        let reading = Reading { sensor, value };
        reading.check()?;
        Ok(reading)
    }

    /// The bound on the error of a reading of `value`.
    fn error_of(&self, value: f64, dimension: Dimension) -> Result<f64> {
        let Some(text) = &self.tolerance else { return Ok(0.0) };
        let error = if text.trim_end().ends_with('%') {
            value.abs() * quantity("--tolerance", text, Dimension::Ratio)?
        } else {
            quantity("--tolerance", text, dimension)?
        };
        if error >= 0.0 && error.is_finite() {
            return Ok(error);
        }
        Err(Error::usage("--tolerance").value(text).allowed("a finite number, not negative"))
    }
}

/// A reading that is smaller in its unit is told in a smaller one.
const LEAST_TOLD: f64 = 1e-3;

/// A number with four decimals, or with four digits where these are more; without zeros at its end.
fn short(value: f64) -> String {
    // What is left of a zero by rounding is zero.
    let size = if value.abs() < 1e-12 { 0.0 } else { value.abs() };
    if size > 0.0 && size < 1e-6 {
        return format!("{value:.3e}");
    }
    let digits = if size > 0.0 { (3.0 - size.log10().floor()).clamp(4.0, 9.0) } else { 4.0 };
    let text = fixed(value, digits as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A reading for people.
pub(crate) fn words(reading: &Reading) -> String {
    let units: &[(f64, &str)] = match reading.sensor {
        VirtualSensor::Load => &[(1.0, "N"), (1e3, "mN"), (1e6, "uN"), (1e9, "nN")],
        VirtualSensor::Strip => &[(1e3, "mm"), (1e6, "um"), (1e9, "nm")],
        VirtualSensor::Slope => &[(1f64.to_degrees(), "deg")],
        VirtualSensor::Moment(_) => &[(1e3, "mN m"), (1e6, "uN m"), (1e9, "nN m")],
    };
    let size = reading.value.lo().abs().max(reading.value.hi().abs());
    let told = units.iter().find(|(scale, _)| size == 0.0 || size * scale >= LEAST_TOLD).or(units.last());
    let (scale, unit) = told.copied().unwrap_or((1.0, ""));
    let short = |v: f64| short(v * scale);
    let value = if reading.value.width() > 0.0 {
        format!("{} to {}", short(reading.value.lo()), short(reading.value.hi()))
    } else {
        short(reading.value.lo())
    };
    format!("{} {value} {unit}", reading.sensor.word())
}

#[cfg(test)]
mod tests {
    use super::{Interval, MomentRegime, Reading, VirtualSensor, words};
    use crate::quantity::quantity;
    use vibrissa::io::Dimension;

    #[test]
    fn readings_of_any_size_keep_their_digits_and_are_read_back() {
        let exact = |sensor, value: f64| words(&Reading { sensor, value: Interval::new(value, value) });
        let load = VirtualSensor::Load;
        let cases = [(0.0, "0 N"), (0.1, "0.1 N"), (0.012_345_6, "0.01235 N"), (4e-4, "0.4 mN"), (1e-7, "0.1 uN")];
        for (value, told) in cases {
            assert_eq!(exact(load, value), format!("load {told}"));
            assert!((quantity(told, Dimension::Force).unwrap() - value).abs() <= 1e-3 * value);
        }
        assert_eq!(exact(load, 100.0), "load 100 N");
        assert_eq!(exact(load, 1e-20), "load 1.000e-11 nN");
        assert_eq!(exact(VirtualSensor::Strip, 0.06), "strip 60 mm");
        let moment = |lo, hi| {
            words(&Reading { sensor: VirtualSensor::Moment(MomentRegime::LargeAngle), value: Interval::new(lo, hi) })
        };
        assert_eq!(moment(4.75e-3, 5.25e-3), "moment 4.75 to 5.25 mN m");
        assert_eq!(moment(0.95e-7, 1.05e-7), "moment 0.095 to 0.105 uN m");
        assert_eq!(moment(-1e-9, 1e-9), "moment -0.001 to 0.001 uN m");
    }
}
