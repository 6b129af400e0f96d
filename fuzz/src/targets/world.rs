//! Small worlds as text: a robot (TOML), a map (GeoJSON), options and rows, drawn so that whiskers touch, then damaged.
//!
//! The parts stand between lines `%%`. The last one has a line for each option (`set NAME VALUE`) and for each row
//! (`row T X Y HEADING COMPASS READING …`); its numbers are handed to the library as they are, whatever they are.

use crate::random::Random;
use core::f64::consts::{PI, TAU};
use core::fmt::Write;
use vibrissa::config::SettingValue;
use vibrissa::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use vibrissa::io::{map, robot};
use vibrissa::localizer::Method;
use vibrissa::plane::Pose2;
use vibrissa::sim::{Pace, SimulateOptions, SweepNoise, path_through, simulate};
use vibrissa::world::{Map, MomentNoise, MountedWhisker, Robot};
use vibrissa::{Error, Result};

/// The line between two parts.
const BETWEEN: &str = "\n%%\n";
/// Rows of a drawn log, and the most that are taken of any.
const ROWS: usize = 60;
const MOST_ROWS: usize = 100;
/// Longest boundary (m) and most whiskers: what is larger takes longer than a try may.
const LONGEST: f64 = 3.0;
const MOST_WHISKERS: usize = 4;

/// Words that stand in worlds.
pub(crate) const WORDS: &[&str] = &[
    "[[whisker]]\n",
    "[odometry]\n",
    "tip_ratio = 0.3\n",
    "curvature = [4.0]\n",
    "base_stiffness = 0.002\n",
    "friction = 0.5\n",
    "zero_error = 1e-4\n",
    "zero_drift_error = 1e-5\n",
    "mount_error = [1e-3, 1e-3, 0.02]\n",
    "length_error = 1e-3\n",
    "stiffness_error = 0.1\n",
    "gain_error = 0.1\n",
    "elevation = 0.5\n",
    "roll = 0.5\n",
    "delay = 0.05\n",
    "scale_error = 0.02\n",
    "\"role\":\"wall\"",
    "\"role\":\"obstacle\"",
    "set prior -1 1 -1 1 0 6.3\n",
    "set tolerate 2\n",
    "set two_contacts 0\n",
    "set largest_slope 3\n",
    "set missed_share 0.5\n",
    "set window 1\n",
    "set noise_model lasting\n",
    "set undeclared none\n",
    "set heading_error 0.1\n",
    "row 1 0 0 0 - 1e-3\n",
    "row nan nan nan nan nan nan\n",
    "row inf 1e300 -1e300 1e300 1e300 1e300\n",
];

/// What the text of a world says.
pub(crate) struct World {
    pub(crate) robot: Robot,
    pub(crate) map: Map,
    pub(crate) log: SensorLog,
    /// Options by name, as words.
    pub(crate) options: Vec<(String, String)>,
}

impl World {
    /// Reads the parts.
    ///
    /// # Errors
    ///
    /// As the readers of robots and maps; a world that is larger than a try has time for.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self> {
        let text = String::from_utf8_lossy(bytes);
        let mut parts = text.splitn(3, BETWEEN);
        let mut part = || parts.next().unwrap_or_default();
        let robot = robot::from_toml(part(), "robot.toml")?;
        let map = map::from_geojson(part(), "map.geojson")?;
        if robot.whiskers.len() > MOST_WHISKERS || map.total_length() > LONGEST {
            return Err(Error::data("a world that takes longer than a try may"));
        }
        let lines: Vec<&str> = part().lines().collect();
        let rows = lines.iter().filter_map(|line| line.strip_prefix("row ")).take(MOST_ROWS);
        let options = lines.iter().filter_map(|line| line.strip_prefix("set ")?.split_once(' '));
        let log = SensorLog {
            channels: channels(&robot),
            rows: rows.enumerate().map(|(index, line)| row(line, index + 1)).collect(),
            ..SensorLog::default()
        };
        let options = options.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
        Ok(Self { robot, map, log, options })
    }

    /// `method` with the options that it has among these, as far as they are of its kinds.
    pub(crate) fn with_options(&self, mut method: Method) -> Method {
        for (name, value) in &self.options {
            let numbers: Vec<f64> = value.split(' ').filter_map(|word| word.parse().ok()).collect();
            let mut given = vec![SettingValue::Choice(value.clone())];
            given.extend(numbers.first().map(|&number| SettingValue::Number(number)));
            given.extend(value.parse().ok().map(SettingValue::Count));
            if let [a, b, c, d, e, f] = numbers[..] {
                given.push(SettingValue::Region([[a, b], [c, d], [e, f]]));
            }
            for value in given {
                // A value of another kind, or for another method.
                let _ = method.set(name, value);
            }
        }
        method
    }
}

fn channels(robot: &Robot) -> Vec<Channel> {
    let channel = |w: &MountedWhisker| Channel { whisker: w.name.clone(), quantity: Quantity::Moment };
    robot.whiskers.iter().map(channel).collect()
}

/// A row; what is no number is NaN, what is missing 0.
fn row(line: &str, number: usize) -> LogRow {
    let words: Vec<&str> = line.split_whitespace().collect();
    let value = |k: usize| words.get(k).map_or(0.0, |word| word.parse().unwrap_or(f64::NAN));
    LogRow {
        t: value(0),
        odom_from_robot: Pose2 { x: value(1), y: value(2), theta: value(3) },
        heading: words.get(4).filter(|word| **word != "-").map(|_| value(4)),
        readings: (5..words.len()).map(value).collect(),
        line: number,
    }
}

/// Draws a world in which the robot comes near a wall and goes along it, with what the simulator says its whiskers read.
pub(crate) fn draw(random: &mut Random) -> Vec<u8> {
    let robot = draw_robot(random);
    let (geojson, radius) = draw_map(random);
    let mut text = robot::to_toml(&robot) + BETWEEN + &geojson + BETWEEN;
    for _ in 0..random.below(3) {
        text += random.pick(WORDS).filter(|word| word.starts_with("set ")).copied().unwrap_or_default();
    }
    for row in draw_rows(&robot, &geojson, radius, random) {
        let Pose2 { x, y, theta } = row.odom_from_robot;
        let compass = row.heading.map_or("-".into(), |heading| format!("{heading}"));
        let readings: Vec<String> = row.readings.iter().map(|z| format!("{z:e}")).collect();
        // Writing into a string cannot fail.
        let _ = writeln!(text, "row {} {x} {y} {theta} {compass} {}", row.t, readings.join(" "));
    }
    text.into_bytes()
}

/// One to three whiskers on a small robot: the paper's, longer or softer ones, now and then tapered or on a soft base, with errors.
fn draw_robot(random: &mut Random) -> Robot {
    let mut whiskers = Vec::new();
    let count = [1, 1, 1, 2, 3][random.below(5)];
    for index in 0..count {
        let mut whisker = MountedWhisker { name: format!("w{index}"), ..MountedWhisker::default() };
        let turn = random.signed();
        whisker.robot_from_whisker = Pose2::new(0.01 * index as f64, 0.02 * random.signed(), turn);
        whisker.beam.length *= 1.0 + 0.4 * random.signed();
        whisker.beam.flexural_rigidity *= 10f64.powf(random.signed());
        if random.one_in(12) {
            whisker.beam.tip_ratio = 0.55 + 0.4 * random.signed();
        }
        if random.one_in(12) {
            whisker.beam.base_stiffness = 10f64.powf(-2.0 + random.signed());
        }
        if random.one_in(3) {
            whisker.noise = MomentNoise { moment_relative: 0.1 * random.signed().abs(), moment_absolute: 1e-5 };
        }
        if random.one_in(4) {
            whisker.errors.zero = 1e-4 * random.signed().abs();
            whisker.errors.mount = [1e-3, 1e-3, 0.02].map(|most| most * random.signed().abs());
            whisker.errors.gain = 0.1 * random.signed().abs();
        }
        if random.one_in(6) {
            whisker.friction = 0.4 * random.signed().abs();
        }
        whiskers.push(whisker);
    }
    let mut robot = Robot { whiskers, ..Robot::default() };
    if random.one_in(3) {
        robot.odometry.translation_relative = 0.05 * random.signed().abs();
        robot.odometry.rotation_relative = 0.05 * random.signed().abs();
    }
    if random.one_in(8) {
        robot.odometry.delay = 0.05 * random.signed().abs();
    }
    robot
}

/// A star of few corners around the origin, sometimes with an obstacle or a thin wall in it, and its least radius (m).
fn draw_map(random: &mut Random) -> (String, f64) {
    let corners = 3 + random.below(9);
    let scale = 0.12 + 0.04 * random.signed();
    let uneven = if random.one_in(2) { 0.0 } else { 0.3 };
    let ring = |radius: f64, random: &mut Random| -> Vec<String> {
        let mut points: Vec<String> = (0..corners)
            .map(|k| {
                let (angle, r) = (TAU * k as f64 / corners as f64, radius * (1.0 + uneven * random.signed()));
                format!("[{:.6},{:.6}]", r * angle.cos(), r * angle.sin())
            })
            .collect();
        points.push(points[0].clone());
        points
    };
    let shape = |role: &str, kind: &str, points: &str| {
        format!(
            "{{\"type\":\"Feature\",\"properties\":{{\"role\":\"{role}\"}},\"geometry\":{{\"type\":\"{kind}\",\"coordinates\":{points}}}}}"
        )
    };
    let mut shapes = vec![shape("arena", "Polygon", &format!("[[{}]]", ring(scale, random).join(",")))];
    if random.one_in(4) {
        let points = ring(0.01, random).join(",");
        shapes.push(shape("obstacle", "Polygon", &format!("[[{points}]]")));
    }
    if random.one_in(4) {
        let (x, y) = (0.5 * scale * random.signed(), 0.5 * scale * random.signed());
        shapes.push(shape("wall", "LineString", &format!("[[{x:.6},{y:.6}],[{:.6},{y:.6}]]", x + 0.04)));
    }
    let text = format!("{{\"type\":\"FeatureCollection\",\"features\":[\n{}\n]}}", shapes.join(",\n"));
    // The middles of a star's sides are nearest.
    (text, scale * (1.0 - uneven) * (PI / corners as f64).cos())
}

/// What the simulator records on a way to a wall and along it, with noise; rows out of the air where it cannot follow.
fn draw_rows(robot: &Robot, geojson: &str, radius: f64, random: &mut Random) -> Vec<LogRow> {
    let reach = robot.whiskers.iter().map(|w| w.beam.length).fold(0.0, f64::max);
    let heading = PI * random.signed();
    let near = radius - reach * (0.9 - 0.25 * random.signed().abs());
    let at = |distance: f64, turn: f64| {
        let direction = heading + turn;
        Pose2::new(distance * direction.cos(), distance * direction.sin(), heading + 0.5 * turn)
    };
    let along = 0.25 * random.signed();
    let ways = [at(near - 0.02, 0.0), at(near, 0.0), at(near - 0.003, along), at(near, -along)];
    let mut swept = || {
        let map = map::from_geojson(geojson, "map.geojson")?;
        let length: f64 = ways.windows(2).map(|w| w[0].position().distance(w[1].position())).sum();
        let pace = Pace { speed: 0.05, turn_rate: 3.0, rate: 0.05 * (ROWS - 1) as f64 / length.max(1e-3) };
        let path = path_through(&ways, &pace)?;
        simulate(&map, robot, &path, &SweepNoise::seeded(random.bits()), &SimulateOptions::default())
    };
    match swept() {
        Ok(sweep) => sweep.log.rows,
        Err(_) => (0..ROWS).map(|k| any_row(k, robot.whiskers.len(), random)).collect(),
    }
}

fn any_row(k: usize, whiskers: usize, random: &mut Random) -> LogRow {
    LogRow {
        t: 0.01 * k as f64,
        odom_from_robot: Pose2::new(5e-4 * k as f64, 1e-4 * random.signed(), 0.02 * random.signed()),
        readings: (0..whiskers).map(|_| 1e-3 * random.signed()).collect(),
        heading: None,
        line: 0,
    }
}
