//! The rows of both tables: what befalls a sweep without errors, and what is declared of it.

use crate::random::Random;
use crate::worlds::{ROOMS, World, room};
use std::path::Path;
use vibrissa::Result;
use vibrissa::flow::pose::StampedPose;
use vibrissa::flow::sensor_log::SensorLog;
use vibrissa::io::{format_tum, log::to_csv, map::to_geojson, robot::to_toml};
use vibrissa::plane::Pose2;
use vibrissa::sim::SweepNoise;
use vibrissa::sim::recorder::{NoiseLaw, OdometryErrors, Recorder, Slip, TrueErrors};
use vibrissa::world::{Map, Robot};

/// One row of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    /// The word for `--laws` and `--errors`.
    pub(crate) word: &'static str,
    pub(crate) text: &'static str,
    pub(crate) spoiling: Spoiling,
}

/// What befalls the sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Spoiling {
    /// A law within the declared bound.
    Law(NoiseLaw),
    /// Odometry counts this much too far in the first half and too little in the second, as declared.
    OdometryHalves(f64),
    /// Something that nobody declared.
    Undeclared(TrueErrors),
    /// A zero that drifts to this (N m) by the last row.
    ZeroDriftsTo(f64),
    /// Whiskers longer than declared by this share.
    Longer(f64),
    /// The robot slides back by this much half way (m).
    Slip(f64),
    /// The map of another room.
    WrongMap,
}

const fn law(word: &'static str, text: &'static str, law: NoiseLaw) -> Cell {
    Cell { word, text, spoiling: Spoiling::Law(law) }
}

const NO_ERRORS: TrueErrors = TrueErrors {
    zero: 0.0,
    zero_drift: 0.0,
    mount: [0.0; 3],
    length: 0.0,
    rigidity: 0.0,
    gain: 0.0,
    delay: 0.0,
    odometry_translation: 0.0,
    odometry_rotation: 0.0,
    map_scale: 0.0,
    heading: 0.0,
};

const fn undeclared(word: &'static str, text: &'static str, errors: TrueErrors) -> Cell {
    Cell { word, text, spoiling: Spoiling::Undeclared(errors) }
}

const fn degrees(angle: f64) -> f64 {
    angle * core::f64::consts::PI / 180.0
}

const fn mount(angle: f64) -> TrueErrors {
    TrueErrors { mount: [0.0, 0.0, degrees(angle)], ..NO_ERRORS }
}

/// Errors within the declared bound.
pub(crate) const LAWS: [Cell; 14] = [
    law("none", "none", NoiseLaw::Exact),
    law("constant", "constant, upper end", NoiseLaw::Constant),
    law("two_point", "two-point, independent", NoiseLaw::TwoPoint),
    law("uniform", "uniform, independent", NoiseLaw::Uniform),
    law("ar1_0.1", "AR(1), 0.1 s", NoiseLaw::Autoregressive { time_constant: 0.1 }),
    law("ar1_0.5", "AR(1), 0.5 s", NoiseLaw::Autoregressive { time_constant: 0.5 }),
    law("sine", "sine, two periods a sweep", NoiseLaw::Sine { periods: 2.0 }),
    law("step", "+ in the first half, - in the second", NoiseLaw::Step),
    law("hysteresis", "+ rising, - falling (hysteresis)", NoiseLaw::Hysteresis),
    law("absolute", "+ absolute bound all along", NoiseLaw::Offset),
    Cell { word: "odometry", text: "odometry +1 %, then -1 %, declared", spoiling: Spoiling::OdometryHalves(0.01) },
    law("drift", "from - bound to + bound", NoiseLaw::Drift),
    law("quantised", "8 bits of full scale", NoiseLaw::Quantised { bits: 8 }),
    law("dead_zone", "dead band of the absolute bound", NoiseLaw::DeadZone),
];

/// Errors that nobody declared.
pub(crate) const ERRORS: [Cell; 19] = [
    undeclared("none", "none", NO_ERRORS),
    undeclared("gain_8", "gain +8 %", TrueErrors { gain: 0.08, ..NO_ERRORS }),
    undeclared("gain_20", "gain +20 %", TrueErrors { gain: 0.20, ..NO_ERRORS }),
    Cell { word: "length", text: "whisker 5 % longer", spoiling: Spoiling::Longer(0.05) },
    undeclared("zero_0.2", "zero off by 0.2 mN m", TrueErrors { zero: 2e-4, ..NO_ERRORS }),
    undeclared("zero_0.3", "zero off by 0.3 mN m", TrueErrors { zero: 3e-4, ..NO_ERRORS }),
    Cell { word: "zero_drift", text: "zero drifts to 0.2 mN m", spoiling: Spoiling::ZeroDriftsTo(2e-4) },
    undeclared("mount_1", "mount 1 deg off", mount(1.0)),
    undeclared("mount_2", "mount 2 deg off", mount(2.0)),
    undeclared("mount_5", "mount 5 deg off", mount(5.0)),
    undeclared(
        "odometry",
        "odometry +5 %",
        TrueErrors { odometry_translation: 0.05, odometry_rotation: 0.05, ..NO_ERRORS },
    ),
    undeclared("map_3", "map 3 % too large", TrueErrors { map_scale: 1.0 / 1.03 - 1.0, ..NO_ERRORS }),
    undeclared("map_10", "map 10 % too small", TrueErrors { map_scale: 1.0 / 0.9 - 1.0, ..NO_ERRORS }),
    undeclared("late_20", "readings 20 ms late", TrueErrors { delay: -0.02, ..NO_ERRORS }),
    undeclared("late_50", "readings 50 ms late", TrueErrors { delay: -0.05, ..NO_ERRORS }),
    Cell { word: "slip", text: "slip of 8 mm half way", spoiling: Spoiling::Slip(8e-3) },
    Cell { word: "wrong_map", text: "wrong map", spoiling: Spoiling::WrongMap },
    undeclared("heading", "heading column off by 0.35 rad", TrueErrors { heading: 0.35, ..NO_ERRORS }),
    undeclared("heading_0", "heading column, right", NO_ERRORS),
];

/// What a localizer gets, and what it should find.
pub(crate) struct Trial {
    pub(crate) log: SensorLog,
    pub(crate) robot: Robot,
    pub(crate) map: Map,
    /// The robot at the last row, frame of the declared map; none where the map is another room's.
    pub(crate) truth: Option<Pose2>,
}

impl Trial {
    /// Writes what a localizer gets, and the true pose at the last row, for `vibrissa localize`.
    pub(crate) fn write(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("log.csv"), to_csv(&self.log))?;
        std::fs::write(folder.join("map.geojson"), to_geojson(&self.map))?;
        std::fs::write(folder.join("robot.toml"), to_toml(&self.robot))?;
        let Some((truth, last)) = self.truth.zip(self.log.rows.last()) else { return Ok(()) };
        let last = StampedPose { t: last.t, map_from_robot: truth };
        std::fs::write(folder.join("truth.tum"), format_tum(&[last]))
    }
}

impl Cell {
    /// The law within the bound, if this is one.
    pub(crate) fn law(&self) -> Option<NoiseLaw> {
        match self.spoiling {
            Spoiling::Law(law) => Some(law),
            _ => None,
        }
    }

    /// The trial of a world; `background` is the law of the readings' errors beside what nobody declared.
    pub(crate) fn trial(&self, world: &World, seed: u64, background: NoiseLaw) -> Result<Trial> {
        let rows = &world.sweep.truth;
        let (start, end) = (rows[0].t, rows[rows.len() - 1].t);
        let half = 0.5 * (start + end);
        let mut robot = world.robot.clone();
        let mut recorder = Recorder {
            noise: SweepNoise::seeded(seed),
            law: background,
            heading_noise: self.word.starts_with("heading").then_some(0.0),
            ..Recorder::default()
        };
        match self.spoiling {
            Spoiling::Law(law) => recorder.law = law,
            Spoiling::OdometryHalves(share) => {
                recorder.law = NoiseLaw::Exact;
                let slips = [(start - 1.0, share), (half, -share)];
                let slips =
                    slips.map(|(t, share)| Slip { t, duration: if t < half { half - t } else { f64::MAX }, share });
                recorder.odometry = OdometryErrors { slips: slips.to_vec(), ..OdometryErrors::default() };
                robot.odometry.translation_relative = share.abs();
                robot.odometry.rotation_relative = share.abs();
            }
            Spoiling::Undeclared(errors) => recorder.truth = errors,
            Spoiling::ZeroDriftsTo(zero) => {
                recorder.truth = TrueErrors { zero_drift: zero / (end - start), ..NO_ERRORS };
            }
            Spoiling::Longer(share) => {
                let length = robot.whiskers[0].beam.length;
                recorder.truth = TrueErrors { length: length - length / (1.0 + share), ..NO_ERRORS };
            }
            Spoiling::Slip(by) => recorder.odometry = slip(world, half, by),
            Spoiling::WrongMap => {}
        }
        let recording = recorder.record(&robot, &world.sweep)?;
        let truth = rows[rows.len() - 1].map_from_robot;
        let (map, truth) = if self.spoiling == Spoiling::WrongMap {
            let kind = ROOMS.iter().position(|name| *name == world.room).unwrap_or(0);
            // Only rooms that are drawn can be others of their kind.
            let kind = if kind == 2 { 0 } else { kind };
            (room(kind, &mut Random(seed.wrapping_mul(0xd134_2543_de82_ef95)))?, None)
        } else {
            (recorder.truth.declared_map(&world.map)?, Some(recorder.truth.on_declared_map(truth)))
        };
        Ok(Trial { log: recording.log, robot: recorder.truth.declared_robot(&robot)?, map, truth })
    }
}

/// The wheels turn by this much more than the robot goes, within a tenth of a second from this time on.
fn slip(world: &World, t: f64, by: f64) -> OdometryErrors {
    const DURATION: f64 = 0.1;
    let gone: f64 = world
        .sweep
        .truth
        .windows(2)
        .filter(|w| (t..t + DURATION).contains(&(0.5 * (w[0].t + w[1].t))))
        .map(|w| w[0].map_from_robot.position().distance(w[1].map_from_robot.position()))
        .sum();
    let share = if gone > 0.0 { by / gone } else { 0.0 };
    OdometryErrors { slips: vec![Slip { t, duration: DURATION, share }], ..OdometryErrors::default() }
}
