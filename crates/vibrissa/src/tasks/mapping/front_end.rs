//! The front end: rows in, stretches of felt wall out, each rigid on a key pose \[grisetti2010tutorial\].
//!
//! A log is cut where the robot has come far enough. Each cut is traced as `contact` traces a sweep, with the last of the one before for a
//! start. What is kept is what traces know well: tips that slide, not bent beyond where the moment alone leads to other shapes, and
//! long enough to have shown themselves.

use super::odometry::Leg;
use super::passed_cells::PassedCells;
use crate::config::{ContactOptions, MappingOptions};
use crate::flow::sensor_log::{LogRow, SensorLog};
use crate::plane::{Pose2, Vec2};
use crate::tasks::contact::{ContactKind, ContactStep, contacts_until};
use crate::world::{MountedWhisker, Robot};
use crate::{Result, Stop};

/// Points along a whisker by which the space that it passes is known.
const BODY: usize = 90;
/// A whisker that has moved by less than this share of a cell passes the same space.
const SAME_SPACE: f64 = 0.35;

/// A felt point of a wall, in the frame of its key pose.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StretchPoint {
    pub(super) position: Vec2,
    pub(super) normal: Vec2,
    pub(super) std: f64,
}

/// A part of one trace that belongs to one key pose.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stretch {
    pub(super) key: usize,
    pub(super) points: Vec<StretchPoint>,
}

/// A key pose: its odometry, the leg to it from the one before, and what whiskers passed until the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Key {
    /// Which of the logs it belongs to.
    pub(super) visit: usize,
    pub(super) t: f64,
    pub(super) odom_from_key: Pose2,
    pub(super) leg: Leg,
    /// Places that whiskers and robot have been at, in the key's frame.
    pub(super) passed: PassedCells,
    /// Where its origin was, in the key's frame, at places so far apart as contacts are thinned to (m).
    pub(super) stands: Vec<Vec2>,
}

/// Stretches in the making.
#[derive(Clone)]
pub(super) struct FrontEnd {
    robot: Robot,
    contact: ContactOptions,
    options: MappingOptions,
    log: SensorLog,
    /// How many of the log's rows were told before.
    told: usize,
    way: f64,
    since_key: Leg,
    last: Option<Pose2>,
    visit: usize,
    /// The key pose with which the log under way begins.
    first: usize,
    /// Where the robot was last noted to pass space, and which whiskers were free.
    passed: Option<(Pose2, Vec<bool>)>,
    pub(super) keys: Vec<Key>,
    pub(super) stretches: Vec<Stretch>,
}

impl FrontEnd {
    pub(super) fn new(robot: &Robot, log: &SensorLog, options: MappingOptions) -> Self {
        let contact = ContactOptions { curled: false, spacing: options.spacing, ..ContactOptions::default() };
        let log = SensorLog { channels: log.channels.clone(), source: log.source.clone(), ..SensorLog::default() };
        Self {
            robot: robot.clone(),
            contact,
            options,
            log,
            told: 0,
            way: 0.0,
            since_key: Leg::default(),
            last: None,
            visit: 0,
            first: 0,
            passed: None,
            keys: Vec::new(),
            stretches: Vec::new(),
        }
    }

    /// The next rows are those of another log with these channels.
    pub(super) fn begin(&mut self, log: &SensorLog, stop: &Stop) -> Result<()> {
        self.cut(stop)?;
        self.log = SensorLog { channels: log.channels.clone(), source: log.source.clone(), ..SensorLog::default() };
        (self.told, self.since_key, self.last, self.passed) = (0, Leg::default(), None, None);
        (self.visit, self.first) = (self.visit + 1, self.keys.len());
        Ok(())
    }

    /// Takes a row.
    pub(super) fn push(&mut self, row: &LogRow, stop: &Stop) -> Result<()> {
        let step = self.last.map_or(Pose2::IDENTITY, |last| last.between(row.odom_from_robot));
        self.last = Some(row.odom_from_robot);
        self.since_key.add(step);
        let (far, turned) = (self.options.key_spacing, self.options.key_turn);
        if self.keys.len() == self.first || self.since_key.way >= far || self.since_key.turned >= turned {
            let leg = core::mem::take(&mut self.since_key);
            self.keys.push(Key {
                visit: self.visit,
                t: row.t,
                odom_from_key: row.odom_from_robot,
                leg,
                ..Key::default()
            });
        }
        self.way += step.position().norm() + self.options.turn_arm * step.theta.abs();
        self.log.rows.push(row.clone());
        if self.way >= self.options.cut { self.cut(stop) } else { Ok(()) }
    }

    /// Traces the rows that have come since the last cut.
    pub(super) fn cut(&mut self, stop: &Stop) -> Result<()> {
        self.way = 0.0;
        if self.log.rows.is_empty() {
            return Ok(());
        }
        let from = self.log.rows.get(self.told).map_or(f64::INFINITY, |row| row.t);
        let report = contacts_until(&self.log, &self.robot, &self.contact, stop, &mut |_, _| {})?;
        let mut steps: Vec<&ContactStep> = report.steps.iter().collect();
        steps.sort_by_key(|step| step.piece);
        for piece in steps.chunk_by(|a, b| a.piece == b.piece) {
            self.keep(piece, from);
        }
        self.pass_free(from);
        // The last of these rows begin the next cut.
        let mut warm = self.log.rows.len();
        let mut back = 0.0;
        while warm > 1 && back < self.options.warm_up {
            warm -= 1;
            let pair = [&self.log.rows[warm - 1], &self.log.rows[warm]];
            back += pair[0].odom_from_robot.position().distance(pair[1].odom_from_robot.position());
        }
        self.log.rows.drain(..warm);
        self.told = self.log.rows.len();
        Ok(())
    }

    /// The first and the last key pose within this way of another (m).
    pub(super) fn within(&self, middle: usize, reach: f64) -> (usize, usize) {
        let (mut first, mut last, mut way) = (middle, middle, 0.0);
        let is_same = |key: usize| self.keys[key].visit == self.keys[middle].visit;
        while first > 0 && is_same(first - 1) && way < reach {
            way += self.keys[first].leg.way;
            first -= 1;
        }
        way = 0.0;
        while last + 1 < self.keys.len() && is_same(last + 1) && way < reach {
            last += 1;
            way += self.keys[last].leg.way;
        }
        (first, last)
    }

    /// The key poses of a log.
    pub(super) fn visit(&self, visit: usize) -> core::ops::Range<usize> {
        self.keys.partition_point(|key| key.visit < visit)..self.keys.partition_point(|key| key.visit <= visit)
    }

    /// The key pose to which a time of the log under way belongs.
    fn key_at(&self, t: f64) -> usize {
        self.first + self.keys[self.first..].partition_point(|key| key.t <= t).saturating_sub(1)
    }

    /// Keeps what a trace knows well from a time on.
    fn keep(&mut self, piece: &[&ContactStep], from: f64) {
        let known: Vec<(&ContactStep, StretchPoint)> = piece
            .iter()
            .filter(|step| step.kind == ContactKind::Tip)
            .filter(|step| step.bend.as_ref().is_some_and(|bend| bend.phi_a.abs() <= self.options.largest_slope))
            .filter_map(|step| {
                let std = step.std.filter(|std| *std <= self.options.largest_std)?;
                Some((*step, StretchPoint { position: step.position()?, normal: Vec2::from_angle(step.normal?), std }))
            })
            .collect();
        let mut along = vec![0.0; known.len()];
        for (k, pair) in known.windows(2).enumerate() {
            along[k + 1] = along[k] + pair[0].1.position.distance(pair[1].1.position);
        }
        let length = along.last().copied().unwrap_or(0.0);
        // A trace that goes over many places must have gone over each of them.
        if length < self.options.shortest || known.len() < self.options.fewest {
            return;
        }
        let range = self.options.trim_start..=length - self.options.trim_end;
        let inside = known.iter().zip(&along).filter(|(_, s)| range.contains(*s)).map(|(one, _)| one);
        let (mut last, mut before): (Option<usize>, Vec<Vec2>) = (None, Vec::new());
        for (step, point) in inside.filter(|(step, _)| step.t >= from) {
            let key = self.key_at(step.t);
            let to_key = self.keys[key].odom_from_key.inverse();
            let here = StretchPoint {
                position: to_key.transform_point(point.position),
                normal: point.normal.rotated(to_key.theta),
                std: point.std,
            };
            match self.stretches.last_mut().filter(|_| last == Some(key)) {
                Some(stretch) => stretch.points.push(here),
                None => self.stretches.push(Stretch { key, points: vec![here] }),
            }
            last = Some(key);
            if let Some(bend) = &step.bend {
                let place = |p: &Vec2| step.odom_from_whisker.transform_point(*p);
                let body: Vec<Vec2> = bend.shape(bend.s_a, BODY).iter().map(place).collect();
                self.pass(key, to_key, &before, &body);
                before = body;
            }
        }
    }

    /// Notes the space between one shape of a whisker and the next (odometry frame), as finely as it is kept.
    fn pass(&mut self, key: usize, to_key: Pose2, before: &[Vec2], now: &[Vec2]) {
        let farthest = before.iter().zip(now).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        // Shapes that are far apart have nothing known between them.
        let steps = if before.len() == now.len() && farthest <= self.options.largest_gap {
            (farthest / (0.7 * self.options.cell)).ceil().max(1.0) as usize
        } else {
            1
        };
        for step in 1..=steps {
            let share = step as f64 / steps as f64;
            let between = |(k, b): (usize, &Vec2)| {
                let place = before.get(k).filter(|_| steps > 1).map_or(*b, |a| *a + (*b - *a) * share);
                to_key.transform_point(place)
            };
            let passed = &mut self.keys[key].passed;
            now.iter().enumerate().map(between).for_each(|place| passed.insert(place, self.options.cell));
        }
    }

    /// Whiskers that are free lie straight. Rows of a robot that rests are noted once.
    fn pass_free(&mut self, from: f64) {
        let first = self.log.rows.partition_point(|row| row.t < from);
        let channels: Vec<Option<usize>> =
            self.robot.whiskers.iter().map(|whisker| self.log.moment_channel(&whisker.name).ok()).collect();
        let lever = |whisker: &MountedWhisker| whisker.robot_from_whisker.position().norm() + whisker.beam.length;
        let lever = self.robot.whiskers.iter().map(lever).fold(0.0, f64::max);
        for row in first..self.log.rows.len() {
            let LogRow { t, odom_from_robot, ref readings, .. } = self.log.rows[row];
            let is_free = |(whisker, channel): (&MountedWhisker, &Option<usize>)| {
                let z = channel.and_then(|channel| readings.get(channel));
                z.is_some_and(|z| z.abs() * (1.0 - whisker.noise.moment_relative) <= whisker.noise.moment_absolute)
            };
            let free: Vec<bool> = self.robot.whiskers.iter().zip(&channels).map(is_free).collect();
            let is_same = self.passed.as_ref().is_some_and(|(before, were_free)| {
                let step = before.between(odom_from_robot);
                *were_free == free && step.position().norm() + lever * step.theta.abs() < SAME_SPACE * self.options.cell
            });
            if is_same {
                continue;
            }
            let key = self.key_at(t);
            let to_key = self.keys[key].odom_from_key.inverse().compose(odom_from_robot);
            let mut passed = vec![to_key.position()];
            for (whisker, is_free) in self.robot.whiskers.iter().zip(&free) {
                let base = to_key.compose(whisker.robot_from_whisker);
                passed.push(base.position());
                if *is_free {
                    let reach = (whisker.beam.length - self.options.free_tip).max(0.0);
                    let at = |k: usize| base.transform_point(Vec2::new(reach * k as f64 / BODY as f64, 0.0));
                    passed.extend((1..=BODY).map(at));
                }
            }
            let key = &mut self.keys[key];
            let (stand, apart) = (to_key.position(), self.options.contact_spacing);
            if key.stands.last().is_none_or(|last| last.distance(stand) >= apart) {
                key.stands.push(stand);
            }
            passed.into_iter().for_each(|place| key.passed.insert(place, self.options.cell));
            self.passed = Some((odom_from_robot, free));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::sensor_log::{Channel, Quantity};

    #[test]
    fn a_robot_that_rests_passes_no_more_space() {
        let channels = vec![Channel { whisker: String::new(), quantity: Quantity::Moment }];
        let log = SensorLog { channels, ..SensorLog::default() };
        let robot = Robot::default();
        let noted = |rows: usize| {
            let mut front = FrontEnd::new(&robot, &log, MappingOptions::default());
            for k in 0..rows {
                // It goes on at the end, and turns.
                let (gone, turned) = if k + 1 == rows { (1e-3, 0.1) } else { (0.0, 0.0) };
                let row = LogRow {
                    t: k as f64,
                    odom_from_robot: Pose2::new(gone, 0.0, turned),
                    readings: vec![0.0],
                    heading: None,
                    line: 0,
                };
                front.push(&row, &Stop::default()).unwrap_or_else(|error| panic!("{error}"));
            }
            front.cut(&Stop::default()).unwrap_or_else(|error| panic!("{error}"));
            front.keys[0].passed.count()
        };
        assert_eq!(noted(500), noted(2));
    }
}
