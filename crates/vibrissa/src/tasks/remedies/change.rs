//! The single changes that are tried.

use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, Robot};

/// Rows of a stretch whose readings are compared for how quiet they are.
const STRETCH: usize = 15;
/// Of that many of the quietest stretches the median reading is taken for the zero.
const QUIETEST: usize = 9;
/// A free whisker reads less than this share of the largest reading.
const FREE: f64 = 0.3;

/// No robot gets further from where it starts than so many times across its map.
const TOO_FAR: f64 = 3.0;

/// One change.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Change {
    /// The readings of a channel have the other sign.
    Sign(usize, String),
    /// The odometry's columns are otherwise: what is done to x, y (m), theta (rad).
    Odometry(Axes),
    /// The readings of two channels are each other's.
    Swapped([usize; 2], [String; 2]),
    /// All moments are so many times as large, since their unit is another.
    Unit(f64, &'static str),
    /// All whiskers are longer by this share.
    Length(f64),
    /// The zeros of these channels are other than 0 (N m).
    Zero(Vec<(usize, String, f64)>),
    /// All readings are so many times as large.
    Gain(f64),
    /// Readings come this much too late (s): a row's own stands so much later in the log.
    Delay(f64),
    /// The absolute heading is left out.
    NoHeading,
    /// What the robot file does not bound is taken for exact, as it is in all trials.
    Exact,
}

/// What is wrong with the odometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axes {
    /// x is y and y is x.
    Swapped,
    /// y goes to the right, and turns are clockwise.
    Mirrored,
    /// Turns are clockwise.
    Clockwise,
    /// y goes to the right.
    Right,
    /// Headings are in degrees.
    Degrees,
    /// Lengths are in millimetres.
    Millimetres,
}

/// All changes of a log and a robot, the likeliest first; where the odometry goes ways that the map has no room for, its unit alone.
pub(super) fn candidates(log: &SensorLog, robot: &Robot, map: &Map) -> Vec<Change> {
    let place = |row: &LogRow| row.odom_from_robot.position();
    let farthest = log.rows.iter().map(|row| place(row).distance(place(&log.rows[0]))).fold(0.0, f64::max);
    if farthest > TOO_FAR * map.bounds().size().norm() {
        return vec![Change::Odometry(Axes::Millimetres)];
    }
    let moments: Vec<(usize, &Channel)> =
        log.channels.iter().enumerate().filter(|(_, channel)| channel.quantity == Quantity::Moment).collect();
    let name = |channel: &Channel| {
        let alone = robot.whiskers.first().map_or("w0", |whisker| whisker.name.as_str());
        if channel.whisker.is_empty() { alone.to_owned() } else { channel.whisker.clone() }
    };
    let mut changes: Vec<Change> = moments.iter().map(|(index, c)| Change::Sign(*index, name(c))).collect();
    if log.rows.iter().any(|row| row.heading.is_some()) {
        changes.push(Change::NoHeading);
    }
    let zeros: Vec<(usize, String, f64)> =
        moments.iter().filter_map(|(index, c)| Some((*index, name(c), quiet(log, *index)?))).collect();
    if zeros.iter().any(|zero| zero.2.abs() > 0.0) {
        changes.push(Change::Zero(zeros));
    }
    changes.extend(
        [Axes::Mirrored, Axes::Swapped, Axes::Clockwise, Axes::Right, Axes::Degrees, Axes::Millimetres]
            .map(Change::Odometry),
    );
    for (k, (i, a)) in moments.iter().enumerate() {
        changes.extend(moments[k + 1..].iter().map(|(j, b)| Change::Swapped([*i, *j], [name(a), name(b)])));
    }
    changes.extend([0.02, -0.02, 0.05, -0.05].map(Change::Delay));
    changes.extend([1.0 / 1.1, 1.0 / 0.9, 1.0 / 1.2, 1.0 / 0.8].map(Change::Gain));
    changes.extend([0.05, -0.05, 0.1, -0.1].map(Change::Length));
    changes.extend([(1e-3, "thousand times smaller"), (1e3, "thousand times larger")].map(|(f, w)| Change::Unit(f, w)));
    changes
}

/// What a channel reads while its whisker is free: the median of the quietest stretches of small readings.
fn quiet(log: &SensorLog, channel: usize) -> Option<f64> {
    let reading = |row: &LogRow| row.readings[channel];
    let largest = log.rows.iter().map(|row| reading(row).abs()).fold(0.0, f64::max);
    let mut stretches: Vec<(f64, f64)> = log
        .rows
        .chunks_exact(STRETCH)
        .map(|rows| {
            let mean = rows.iter().map(reading).sum::<f64>() / STRETCH as f64;
            (rows.iter().map(|row| (reading(row) - mean).powi(2)).sum::<f64>(), mean)
        })
        .filter(|(_, mean)| mean.abs() < FREE * largest)
        .collect();
    stretches.sort_by(|a, b| a.0.total_cmp(&b.0));
    stretches.truncate(QUIETEST);
    stretches.sort_by(|a, b| a.1.total_cmp(&b.1));
    stretches.get(stretches.len() / 2).map(|stretch| stretch.1)
}

impl Change {
    /// Log and robot with the change.
    pub(super) fn made(&self, log: &SensorLog, robot: &Robot) -> (SensorLog, Robot) {
        let (mut log, mut robot) = (log.clone(), robot.clone());
        match self {
            Self::Sign(channel, _) => each(&mut log, |row| row.readings[*channel] = -row.readings[*channel]),
            Self::Odometry(axes) => {
                let headings = unwrapped_headings(&log);
                for (row, theta) in log.rows.iter_mut().zip(headings) {
                    row.odom_from_robot = axes.righted(row.odom_from_robot.position(), theta);
                }
            }
            Self::Swapped([a, b], _) => each(&mut log, |row| row.readings.swap(*a, *b)),
            Self::Unit(factor, _) | Self::Gain(factor) => {
                for channel in channels(&log) {
                    each(&mut log, |row| row.readings[channel] *= factor);
                }
            }
            Self::Length(share) => {
                for whisker in &mut robot.whiskers {
                    // Whiskers of several wires keep theirs.
                    whisker.beam.length *= 1.0 + share;
                }
            }
            Self::Zero(zeros) => {
                for (channel, _, zero) in zeros {
                    each(&mut log, |row| row.readings[*channel] -= zero);
                }
            }
            Self::Delay(later) => delayed(&mut log, *later),
            Self::NoHeading => each(&mut log, |row| row.heading = None),
            Self::Exact => {}
        }
        (log, robot)
    }

    /// The change in words: what is wrong.
    pub(super) fn words(&self) -> String {
        match self {
            Self::Sign(_, name) => format!("the sign of {name}.moment is the other way round"),
            Self::Odometry(axes) => axes.words().into(),
            Self::Swapped(_, [a, b]) => format!("{a} and {b} are swapped"),
            Self::Unit(_, words) => format!("the moments are in another unit: {words} in N m"),
            Self::Length(share) => format!("the whisker is {:.0} % {}", 100.0 * share.abs(), longer(*share)),
            Self::Zero(zeros) => {
                let one = |(_, name, zero): &(usize, String, f64)| format!("that of {name} is {:+.3} mN m", 1e3 * zero);
                format!("zeros are off: {}", zeros.iter().map(one).collect::<Vec<_>>().join(", "))
            }
            Self::Gain(factor) => {
                let off = 1.0 / factor - 1.0;
                format!("readings are {:.0} % too {}", 100.0 * off.abs(), if off > 0.0 { "large" } else { "small" })
            }
            Self::Delay(later) => {
                let (by, when) = (1e3 * later.abs(), if *later > 0.0 { "late" } else { "early" });
                format!("readings come {by:.0} ms {when}")
            }
            Self::NoHeading => "the column heading is wrong".into(),
            Self::Exact => "what the robot file does not bound is exact, as with `--undeclared none`".into(),
        }
    }
}

fn longer(share: f64) -> &'static str {
    if share > 0.0 { "longer" } else { "shorter" }
}

fn channels(log: &SensorLog) -> Vec<usize> {
    (0..log.channels.len()).filter(|&index| log.channels[index].quantity == Quantity::Moment).collect()
}

fn each(log: &mut SensorLog, change: impl FnMut(&mut LogRow)) {
    log.rows.iter_mut().for_each(change);
}

/// The readings of a log so much later (s), linear between rows.
fn delayed(log: &mut SensorLog, later: f64) {
    let times: Vec<f64> = log.rows.iter().map(|row| row.t).collect();
    if times.len() < 2 {
        return;
    }
    let before: Vec<Vec<f64>> = log.rows.iter().map(|row| row.readings.clone()).collect();
    for row in &mut log.rows {
        let t = row.t + later;
        let next = times.partition_point(|&other| other < t).clamp(1, times.len() - 1);
        let share = ((t - times[next - 1]) / (times[next] - times[next - 1])).clamp(0.0, 1.0);
        let pairs = before[next - 1].iter().zip(&before[next]);
        row.readings = pairs.map(|(a, b)| a + share * (b - a)).collect();
    }
}

/// The headings of a log without jumps by whole turns, from the first row's on (rad): those in degrees leave a turn soon.
fn unwrapped_headings(log: &SensorLog) -> Vec<f64> {
    let headings: Vec<f64> = log.rows.iter().map(|row| row.odom_from_robot.theta).collect();
    let turns = headings.windows(2).map(|pair| wrap_angle(pair[1] - pair[0]));
    let mut theta = headings.first().copied().unwrap_or_default();
    core::iter::once(0.0)
        .chain(turns)
        .map(|turn| {
            theta += turn;
            theta
        })
        .collect()
}

impl Axes {
    /// A pose as it should have been written, of its place (m) and its heading without jumps (rad).
    fn righted(self, Vec2 { x, y }: Vec2, theta: f64) -> Pose2 {
        let (x, y, theta) = match self {
            Self::Swapped => (y, x, theta),
            Self::Mirrored => (x, -y, -theta),
            Self::Clockwise => (x, y, -theta),
            Self::Right => (x, -y, theta),
            Self::Degrees => (x, y, theta.to_radians()),
            Self::Millimetres => (1e-3 * x, 1e-3 * y, theta),
        };
        Pose2::new(x, y, theta)
    }

    fn words(self) -> &'static str {
        match self {
            Self::Swapped => "the columns x and y are swapped",
            Self::Mirrored => "the odometry is mirrored: y points to the right, theta is clockwise",
            Self::Clockwise => "theta is clockwise",
            Self::Right => "y points to the right",
            Self::Degrees => "theta is in degrees",
            Self::Millimetres => "x and y are in millimetres",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Axes, Change, candidates, quiet};
    use crate::flow::sensor_log::{Channel, LogRow, Quantity, SensorLog};
    use crate::plane::Pose2;
    use crate::tasks::demo;
    use crate::world::Robot;

    /// Two channels: one free at an offset, then rising; one that falls. The robot goes 1 mm a row.
    fn log() -> SensorLog {
        let channel = |whisker: &str| Channel { whisker: whisker.into(), quantity: Quantity::Moment };
        let row = |k: usize| {
            let jitter = 1e-6 * ((k * 7919) % 13) as f64;
            let z = if k < 300 { 3e-4 + jitter } else { 3e-4 + 1e-5 * (k - 300) as f64 };
            LogRow {
                t: k as f64 / 100.0,
                odom_from_robot: Pose2::new(1e-3 * k as f64, 0.0, 0.0),
                readings: vec![z, -1e-6 * k as f64],
                heading: None,
                line: 0,
            }
        };
        SensorLog {
            channels: vec![channel("a"), channel("b")],
            rows: (0..600).map(row).collect(),
            ..SensorLog::default()
        }
    }

    #[test]
    fn the_zero_is_what_is_read_in_the_air() {
        let zero = quiet(&log(), 0).unwrap();
        assert!((zero - 3.06e-4).abs() < 5e-6, "{zero}");
    }

    #[test]
    fn a_change_undoes_what_it_is_told_for() {
        let (log, robot) = (log(), Robot::default());
        let made = |change: Change| change.made(&log, &robot).0.rows;
        let late = made(Change::Delay(0.05));
        assert!((late[100].readings[1] - log.rows[105].readings[1]).abs() < 1e-15);
        assert!((made(Change::Sign(1, "b".into()))[9].readings[1] - 9e-6).abs() < 1e-18);
        let swapped = made(Change::Swapped([0, 1], ["a".into(), "b".into()]));
        assert!((swapped[9].readings[0] - log.rows[9].readings[1]).abs() < 1e-18);
        assert!((made(Change::Odometry(Axes::Swapped))[9].odom_from_robot.y - 9e-3).abs() < 1e-15);
        assert!((made(Change::Gain(0.5))[400].readings[0] - 0.5 * log.rows[400].readings[0]).abs() < 1e-15);
        let longer = Change::Length(0.1).made(&log, &robot).1;
        assert!((longer.whiskers[0].beam.length / robot.whiskers[0].beam.length - 1.1).abs() < 1e-12);
        assert_eq!(Change::Delay(0.05).words(), "readings come 50 ms late");
        assert_eq!(Change::Gain(1.0 / 1.2).words(), "readings are 20 % too large");
        assert_eq!(Change::Length(-0.05).words(), "the whisker is 5 % shorter");
    }

    #[test]
    fn every_change_is_there_once_and_too_long_a_way_has_one() {
        let (mut log, map) = (log(), demo::arena().unwrap());
        let changes = candidates(&log, &Robot::default(), &map);
        assert!(changes.iter().enumerate().all(|(k, change)| !changes[..k].contains(change)));
        assert!(changes.contains(&Change::Swapped([0, 1], ["a".into(), "b".into()])) && changes.len() <= 32);
        log.rows.iter_mut().for_each(|row| row.odom_from_robot.x *= 1e3);
        assert_eq!(candidates(&log, &Robot::default(), &map), [Change::Odometry(Axes::Millimetres)]);
    }
}
