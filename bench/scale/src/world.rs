//! A map of any size, a whisker or several dragged along its wall, and a log of any length.

use crate::Case;
use core::f64::consts::{FRAC_PI_4, TAU};
use core::fmt::Write;
use vibrissa::config::Region;
use vibrissa::flow::sensor_log::{Channel, LogRow};
use vibrissa::plane::Pose2;
use vibrissa::sim::{Pace, SimulateOptions, SweepNoise, path_through, simulate};
use vibrissa::world::{Map, MountedWhisker, Robot};
use vibrissa::{Result, io};

/// How far the whiskers lean from the wall's normal (rad).
const LEAN: f64 = FRAC_PI_4;
/// Distance between the whiskers along the wall (m).
const BESIDE: f64 = 8e-3;
/// Poses of the way along the wall, and their distance (m).
const STEPS: usize = 24;
const STEP: f64 = 0.01;
/// Speed (m/s) and rows a second.
const SPEED: f64 = 0.3;
const RATE: f64 = 300.0;
/// Half the sides of the region for the first pose (m, m, rad).
const REGION: [f64; 3] = [0.010, 0.015, 0.15];

/// Uniform random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A closed outline: a circle with waves of 60 to 200 mm on it.
struct Outline {
    radius: f64,
    /// Count around, height (m) and phase (rad) of each wave.
    waves: Vec<[f64; 3]>,
}

impl Outline {
    fn new(length: f64) -> Self {
        let mut draw = Random(7);
        let wave = |_| {
            let count = (length / draw.within(0.06, 0.2)).round().max(2.0);
            [count, draw.within(0.5e-3, 2.5e-3), draw.within(0.0, TAU)]
        };
        Self { radius: length / TAU, waves: (0..6).map(wave).collect() }
    }

    fn at(&self, angle: f64) -> [f64; 2] {
        let waves: f64 = self.waves.iter().map(|[count, height, phase]| height * (count * angle + phase).sin()).sum();
        let radius = self.radius + waves;
        [radius * angle.cos(), radius * angle.sin()]
    }

    fn geojson(&self, vertices: usize) -> String {
        let mut text = String::from(
            "{\"type\":\"Feature\",\"properties\":{\"role\":\"arena\"},\"geometry\":{\"type\":\"Polygon\",\"coordinates\":[[",
        );
        for k in 0..=vertices {
            let [x, y] = self.at(TAU * (k % vertices) as f64 / vertices as f64);
            let comma = if k == 0 { "" } else { "," };
            // Writing into a string cannot fail.
            let _ = write!(text, "{comma}[{x:.9},{y:.9}]");
        }
        text + "]]}}"
    }

    /// Along the wall, the whiskers pressed by 8 to 12 mm and dragged behind; from free space on.
    fn way(&self, reach: f64) -> Vec<Pose2> {
        let pose = |k: usize| {
            let angle = STEP * k as f64 / self.radius;
            let depth = if k > 1 { reach * LEAN.cos() - 0.010 + 0.002 * (0.9 * k as f64).sin() } else { reach };
            let radius = self.radius - depth;
            Pose2::new(radius * angle.cos(), radius * angle.sin(), angle - LEAN)
        };
        (0..STEPS).map(pose).collect()
    }
}

/// What is to be localized.
pub(crate) struct World {
    pub(crate) geojson: String,
    pub(crate) robot: Robot,
    pub(crate) channels: Vec<Channel>,
    /// Exact readings of the way there; a long log goes to and fro.
    sweep: Vec<LogRow>,
    first: Pose2,
    last: Pose2,
}

impl World {
    /// The world of a case.
    ///
    /// # Errors
    ///
    /// A map that cannot be read, or a way that cannot be simulated.
    pub(crate) fn new(case: &Case) -> Result<Self> {
        let outline = Outline::new(case.outline);
        let geojson = outline.geojson(case.vertices);
        let map = io::map::from_bytes(geojson.clone().into_bytes(), "map.geojson")?;
        let direction = FRAC_PI_4 + core::f64::consts::FRAC_PI_2;
        let whisker = |i: usize| {
            let aside = BESIDE * i as f64;
            MountedWhisker {
                name: format!("w{i}"),
                robot_from_whisker: Pose2::new(aside * direction.cos(), aside * direction.sin(), 0.0),
                ..MountedWhisker::default()
            }
        };
        let robot = Robot { whiskers: (0..case.whiskers).map(whisker).collect(), ..Robot::default() };
        let reach = robot.whiskers.first().map_or(0.0, |whisker| whisker.beam.length);
        let path = path_through(&outline.way(reach), &Pace { speed: SPEED, turn_rate: 1.0, rate: RATE })?;
        let sweep = simulate(&map, &robot, &path, &SweepNoise::none(), &SimulateOptions::default())?;
        let there = case.rows.saturating_sub(1) % (2 * sweep.truth.len() - 2);
        let end = there.min(2 * sweep.truth.len() - 2 - there);
        Ok(Self {
            geojson,
            robot,
            channels: sweep.log.channels,
            first: sweep.truth[0].map_from_robot,
            last: sweep.truth[end].map_from_robot,
            sweep: sweep.log.rows,
        })
    }

    /// The rows, to and fro along the way, with noise as the robot declares it.
    pub(crate) fn rows(&self, count: usize) -> impl Iterator<Item = LogRow> + '_ {
        let mut draw = Random(11);
        let noise = self.robot.whiskers.first().map(|whisker| whisker.noise).unwrap_or_default();
        let period = 2 * self.sweep.len() - 2;
        (0..count).map(move |number| {
            let place = number % period;
            let row = &self.sweep[if place < self.sweep.len() { place } else { period - place }];
            let read = |h: &f64| {
                h * (1.0 + 0.95 * draw.within(-noise.moment_relative, noise.moment_relative))
                    + 0.95 * draw.within(-noise.moment_absolute, noise.moment_absolute)
            };
            let readings = row.readings.iter().map(read).collect();
            LogRow { t: number as f64 / RATE, readings, line: number + 1, ..row.clone() }
        })
    }

    /// Where the robot is at the first row, give or take a centimetre.
    pub(crate) fn region(&self) -> Region {
        let around = |value: f64, half: f64| [value - half, value + half];
        let Pose2 { x, y, theta } = self.first;
        [around(x, REGION[0]), around(y, REGION[1]), around(theta, REGION[2])]
    }

    /// Where the robot is at the last row.
    pub(crate) fn last(&self) -> Pose2 {
        self.last
    }

    /// The map, read anew.
    ///
    /// # Errors
    ///
    /// As the reader.
    pub(crate) fn map(&self) -> Result<Map> {
        io::map::from_bytes(self.geojson.clone().into_bytes(), "map.geojson")
    }
}
