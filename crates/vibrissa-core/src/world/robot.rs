//! The robot: its whiskers, where they are mounted, and what their errors are bounded by.

use crate::beam::Whisker;
use crate::config::defaults;
use crate::plane::Pose2;
use crate::{Error, Result};
use std::path::PathBuf;

/// The bound on a moment reading `z` of a true moment `h`: `|h - z| <= relative |z| + absolute`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentNoise {
    /// Part relative to the reading, at least 0 and below 1.
    pub moment_relative: f64,
    /// Part that stays at zero moment (N m), at least 0.
    pub moment_absolute: f64,
}

/// The bound on a reading `z` of a true quantity `h`: `|h - z| <= relative |z| + absolute`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingNoise {
    /// Part relative to the reading, at least 0 and below 1.
    pub relative: f64,
    /// Part that stays at zero, in the quantity's unit, at least 0.
    pub absolute: f64,
}

impl MomentNoise {
    /// The largest reading of a whisker that is free (N m): of `h = 0` the bound allows `|z| <= absolute / (1 - relative)`.
    #[must_use]
    pub fn largest_free_reading(&self) -> f64 {
        self.moment_absolute / (1.0 - self.moment_relative)
    }

    /// The least and the largest reading of the true moment `h` (N m) that the bound allows.
    ///
    /// Their middle lies beyond `h`, by its size times the relative bound's square: the bound is relative to the reading.
    #[must_use]
    pub fn readings(&self, h: f64) -> [f64; 2] {
        let Self { moment_relative: relative, moment_absolute: absolute } = *self;
        let size = h.abs();
        // The largest z has z - h = relative z + absolute; the smallest may lie beyond zero, where |z| = -z.
        let high = (size + absolute) / (1.0 - relative);
        let least = size - absolute;
        let low = if least >= 0.0 { least / (1.0 + relative) } else { least / (1.0 - relative) };
        if h < 0.0 { [-high, -low] } else { [low, high] }
    }
}

impl From<MomentNoise> for ReadingNoise {
    fn from(noise: MomentNoise) -> Self {
        Self { relative: noise.moment_relative, absolute: noise.moment_absolute }
    }
}

impl Default for MomentNoise {
    fn default() -> Self {
        Self { moment_relative: defaults::MOMENT_RELATIVE, moment_absolute: defaults::MOMENT_ABSOLUTE }
    }
}

/// Bounds on what is not known exactly of a whisker, its mount and its readings: one error of each kind for the whole log, beside the
/// noise of single readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhiskerErrors {
    /// Moment that is read while the whisker is free (N m).
    pub zero: f64,
    /// How fast that may change (N m/s).
    pub zero_drift: f64,
    /// Base of the whisker on the robot: x, y (m), heading (rad).
    pub mount: [f64; 3],
    /// Length (m).
    pub length: f64,
    /// Flexural rigidity, relative to it.
    pub rigidity: f64,
    /// Gain of the readings, relative to it.
    pub gain: f64,
}

impl Default for WhiskerErrors {
    fn default() -> Self {
        Self {
            zero: defaults::ZERO_ERROR,
            zero_drift: defaults::ZERO_DRIFT_ERROR,
            mount: defaults::MOUNT_ERROR,
            length: defaults::LENGTH_ERROR,
            rigidity: defaults::STIFFNESS_ERROR,
            gain: defaults::GAIN_ERROR,
        }
    }
}

impl WhiskerErrors {
    /// The keys of the robot file whose bound is not zero.
    fn declared(&self) -> impl Iterator<Item = &'static str> {
        let mount = self.mount.iter().fold(0.0_f64, |most, bound| most.max(*bound));
        let all = [
            ("zero_error", self.zero),
            ("zero_drift_error", self.zero_drift),
            ("mount_error", mount),
            ("length_error", self.length),
            ("stiffness_error", self.rigidity),
            ("gain_error", self.gain),
        ];
        all.into_iter().filter(|&(_, bound)| bound > 0.0).map(|(key, _)| key)
    }
}

/// How a whisker leans out of the horizontal, in the map's frame: a robot on an even floor keeps it while it turns.
///
/// The whisker's frame has x along the horizontal part of its axis, y left, z up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lean {
    /// Angle of its axis above the horizontal (rad), between -π/2 and π/2.
    pub elevation: f64,
    /// Turn of its sensor about the axis (rad), from left towards up.
    pub roll: f64,
}

impl Lean {
    /// Whether axis and sensor are horizontal, so that everything is planar.
    #[must_use]
    pub fn is_level(&self) -> bool {
        self.elevation.abs() <= 0.0 && self.roll.abs() <= 0.0
    }
}

/// A whisker on a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct MountedWhisker {
    /// The name that prefixes the log's columns where there are several.
    pub name: String,
    /// The beam.
    pub beam: Whisker,
    /// Where the base sits and which way the undeflected whisker points.
    pub robot_from_whisker: Pose2,
    /// How it leans out of the horizontal.
    pub lean: Lean,
    /// Bound on the Coulomb coefficient at the contact.
    pub friction: f64,
    /// The calibration file that turns flux or counts into moments, for logs that hold those.
    pub calibration: Option<PathBuf>,
    /// Bound on the moment's error.
    pub noise: MomentNoise,
    /// Bound on the error of a contact force, where one is read (N).
    pub force_noise: ReadingNoise,
    /// Bound on the error of an end slope, where one is read (rad).
    pub slope_noise: ReadingNoise,
    /// Bounds on what is not known exactly of it.
    pub errors: WhiskerErrors,
}

impl Default for MountedWhisker {
    /// The paper's whisker at the robot's origin, pointing forward.
    fn default() -> Self {
        Self {
            name: "w0".into(),
            beam: Whisker::default(),
            robot_from_whisker: Pose2::IDENTITY,
            lean: Lean::default(),
            friction: defaults::FRICTION,
            calibration: None,
            noise: MomentNoise::default(),
            force_noise: ReadingNoise { relative: defaults::FORCE_RELATIVE, absolute: defaults::FORCE_ABSOLUTE },
            slope_noise: ReadingNoise { relative: defaults::SLOPE_RELATIVE, absolute: defaults::SLOPE_ABSOLUTE },
            errors: WhiskerErrors::default(),
        }
    }
}

/// Bounds on the odometry: each increment's error relative to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odometry {
    /// Bound for translations, at least 0 and below 1.
    pub translation_relative: f64,
    /// Bound for rotations, at least 0 and below 1.
    pub rotation_relative: f64,
    /// Bound on how much earlier or later than the odometry the readings were taken (s).
    pub delay: f64,
}

impl Default for Odometry {
    fn default() -> Self {
        let relative = defaults::ODOMETRY_RELATIVE;
        Self { translation_relative: relative, rotation_relative: relative, delay: defaults::DELAY_ERROR }
    }
}

impl MountedWhisker {
    /// Refuses a whisker that does not bend in the plane of its axis and the force: where it leans, the methods that take it ask for that.
    ///
    /// # Errors
    ///
    /// Data: what it is, and what to do.
    pub fn require_turned_plane(&self) -> Result<()> {
        if self.beam.is_uniform() {
            return Ok(());
        }
        let what = "leans out of the horizontal and is no uniform wire on a clamped base";
        Err(Error::data(format!("the whisker \"{}\" {what}", self.name))
            .remedy("give one wire without taper, or mount the whisker horizontally"))
    }
}

/// A robot: whiskers and odometry. The default is the paper's sensor on its stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// The whiskers, at least one.
    pub whiskers: Vec<MountedWhisker>,
    /// Bounds on the odometry's errors.
    pub odometry: Odometry,
    /// Bound on the error of the map's scale, relative to it.
    pub map_scale: f64,
}

impl Robot {
    /// Refuses whiskers that lean out of the horizontal, for what is planar; `who` does not take them.
    ///
    /// # Errors
    ///
    /// Data: names the first whisker that leans, and what takes it.
    pub fn require_level(&self, who: &str) -> Result<()> {
        let Some(whisker) = self.whiskers.iter().find(|whisker| !whisker.lean.is_level()) else { return Ok(()) };
        let Lean { elevation, roll } = whisker.lean;
        let degrees = |angle: f64| angle * 360.0 / core::f64::consts::TAU;
        Err(Error::data(format!(
            "the whisker \"{}\" leans out of the horizontal, and {who} bends whiskers in the map's plane alone",
            whisker.name
        ))
        .value(format!("elevation {:.3} deg, roll {:.3} deg", degrees(elevation), degrees(roll)))
        .allowed("0 deg and 0 deg, with the body's pitch and roll")
        .remedy("take `localize --method deterministic` or `possibilistic`, or mount the whisker horizontally"))
    }

    /// The keys of the robot file that bound what is not known exactly, each once: of whiskers, delay and map.
    #[must_use]
    pub fn declared_errors(&self) -> Vec<&'static str> {
        let mut keys: Vec<&str> = self.whiskers.iter().flat_map(|whisker| whisker.errors.declared()).collect();
        keys.extend((self.odometry.delay > 0.0).then_some("delay_error"));
        keys.extend((self.map_scale > 0.0).then_some("scale_error"));
        keys.sort_unstable();
        keys.dedup();
        keys
    }
}

impl Robot {
    /// The same robot where each kind of error that it does not bound has the bound of a typical one: zero, mount, length, gain, odometry and
    /// delay. `config::defaults` has the numbers.
    #[must_use]
    pub fn with_typical_errors(&self) -> Self {
        let mut robot = self.clone();
        let put = |bound: &mut f64, typical: f64| {
            if *bound <= 0.0 {
                *bound = typical;
            }
        };
        for whisker in &mut robot.whiskers {
            let (length, errors) = (whisker.beam.length, &mut whisker.errors);
            put(&mut errors.zero, defaults::TYPICAL_ZERO * whisker.beam.flexural_rigidity / length);
            if errors.mount.iter().all(|&bound| bound <= 0.0) {
                let [place, turn] = defaults::TYPICAL_MOUNT;
                errors.mount = [place * length, place * length, turn];
            }
            put(&mut errors.length, defaults::TYPICAL_LENGTH * length);
            if errors.rigidity <= 0.0 {
                put(&mut errors.gain, defaults::TYPICAL_GAIN);
            }
        }
        let odometry = &mut robot.odometry;
        if odometry.translation_relative <= 0.0 && odometry.rotation_relative <= 0.0 {
            (odometry.translation_relative, odometry.rotation_relative) =
                (defaults::TYPICAL_ODOMETRY, defaults::TYPICAL_ODOMETRY);
        }
        put(&mut odometry.delay, defaults::TYPICAL_DELAY);
        robot
    }
}

impl Default for Robot {
    fn default() -> Self {
        Self {
            whiskers: vec![MountedWhisker::default()],
            odometry: Odometry::default(),
            map_scale: defaults::MAP_SCALE_ERROR,
        }
    }
}
