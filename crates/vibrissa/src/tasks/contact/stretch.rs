//! The log's stretches of contact, thinned.

use super::fixed_point::Touch;
use super::free::FreeLevel;
use super::reading::ContactReading;
use crate::Result;
use crate::beam::deflection_per_force;
use crate::flow::sensor_log::{LogRow, SensorLog, one_owner_each};
use crate::plane::Pose2;
use crate::world::{MountedWhisker, Robot};

/// Rows without contact that end a stretch: fewer are noise.
const PATIENCE: usize = 3;

/// Rows before the first that is felt that tell when a contact began: earlier ones tell nothing more.
const FREE: usize = 4;

/// Smallest standard deviation of a touch (m): odometry is no better.
const LEAST_STD: f64 = 3e-6;

/// One whisker in contact, its readings of one sign.
#[derive(Clone, Debug)]
pub(super) struct ContactStretch {
    /// Index of the whisker.
    pub(super) whisker: usize,
    /// The base when the whisker was last free (odometry frame); none when the log begins in contact.
    pub(super) onset: Option<Pose2>,
    /// Readings, neighbours merged while the base all but stands.
    pub(super) readings: Vec<ContactReading>,
    /// The same, one by one.
    pub(super) single: Vec<ContactReading>,
    /// The last readings before, of the whisker while it was free or all but free.
    pub(super) free: Vec<ContactReading>,
    /// When the whisker was free again (s); none when the log ends in contact.
    pub(super) lift_off: Option<f64>,
}

impl ContactStretch {
    /// The single readings of a part.
    pub(super) fn single(&self, from: usize, to: usize) -> &[ContactReading] {
        let count = |readings: &[ContactReading]| readings.iter().map(|r| r.count).sum::<usize>();
        let first = count(&self.readings[..from]);
        &self.single[first..first + count(&self.readings[from..to])]
    }
}

/// The stretches of every whisker that the log holds moments of, in order of time; `spacings` (m) are how far the base
/// moves between two of their readings, for uniform whiskers and for others.
///
/// # Errors
///
/// A robot's whisker without a moment column, a column that may be of several, a row that is not in numbers.
pub(super) fn stretches(log: &SensorLog, robot: &Robot, spacings: [f64; 2]) -> Result<Vec<ContactStretch>> {
    one_owner_each(robot, &log.channels)?;
    robot.require_level("the search for contacts")?;
    let mut all = Vec::new();
    for (index, whisker) in robot.whiskers.iter().enumerate() {
        let channel = log.moment_channel(&whisker.name)?;
        log.rows.iter().try_for_each(|row| row.check([channel]))?;
        let spacing = spacings[usize::from(!whisker.beam.is_uniform())];
        all.extend(of_whisker(&log.rows, index, whisker, channel, spacing));
    }
    let start = |s: &ContactStretch| s.readings.first().map_or(f64::NEG_INFINITY, |r| r.t);
    all.sort_by(|a, b| start(a).total_cmp(&start(b)));
    Ok(all)
}

/// When a contact began, as well as it is known: between the last free row and the first that was felt, or a little earlier,
/// as long as the moment was lost in the noise.
pub(super) fn touch(onset: Pose2, first: &ContactReading) -> Option<Touch> {
    let (length, absolute) = (first.whisker.length, first.noise.moment_absolute);
    let way = travel(&ContactReading { odom_from_whisker: onset, ..*first }, first);
    let unfelt = absolute * deflection_per_force(&first.whisker, length).ok()? / length;
    let step = onset.between(first.odom_from_whisker);
    let middle = onset.compose(Pose2::new(0.5 * step.x, 0.5 * step.y, 0.5 * step.theta));
    let std = (way * way / 12.0 + unfelt * unfelt / 3.0).sqrt().max(LEAST_STD);
    Some(Touch { odom_from_whisker: middle, std })
}

fn of_whisker(
    rows: &[LogRow],
    index: usize,
    whisker: &MountedWhisker,
    channel: usize,
    spacing: f64,
) -> Vec<ContactStretch> {
    let mut found: Vec<ContactStretch> = Vec::new();
    let (mut open, mut quiet): (Option<ContactStretch>, usize) = (None, 0);
    let mut free: Vec<ContactReading> = Vec::new();
    let mut level = FreeLevel::new(whisker);
    for row in rows {
        let (read, base) = (row.readings[channel], row.odom_from_robot.compose(whisker.robot_from_whisker));
        let touches = level.is_contact(row.t, read);
        let moment = level.moment(read);
        let turned = |s: &ContactStretch| s.readings.last().is_some_and(|r| (r.moment > 0.0) != (moment > 0.0));
        let was_free = quiet > 0;
        quiet = if touches { 0 } else { quiet + 1 };
        if quiet >= PATIENCE || (touches && open.as_ref().is_some_and(turned)) {
            found.extend(open.take().map(|s| ContactStretch { lift_off: Some(row.t), ..s }));
        }
        let reading = ContactReading {
            t: row.t,
            whisker: whisker.beam,
            odom_from_whisker: base,
            moment,
            noise: whisker.noise,
            count: 1,
        };
        if touches {
            let stretch = open.get_or_insert_with(|| ContactStretch {
                whisker: index,
                onset: free.last().map(|r| r.odom_from_whisker),
                free: if was_free { free.clone() } else { Vec::new() },
                readings: Vec::new(),
                single: Vec::new(),
                lift_off: None,
            });
            stretch.single.push(reading);
            add(&mut stretch.readings, reading, spacing);
        } else {
            free.drain(..(free.len() + 1).saturating_sub(FREE));
            free.push(reading);
        }
    }
    found.extend(open);
    found
}

/// Adds a reading, or merges it into the last one while the base has not moved on.
fn add(readings: &mut Vec<ContactReading>, new: ContactReading, spacing: f64) {
    let near = |last: &&mut ContactReading| travel(last, &new) < spacing;
    let Some(last) = readings.last_mut().filter(near) else { return readings.push(new) };
    let share = 1.0 / (last.count + 1) as f64;
    let step = last.odom_from_whisker.between(new.odom_from_whisker);
    last.odom_from_whisker =
        last.odom_from_whisker.compose(Pose2::new(share * step.x, share * step.y, share * step.theta));
    last.moment += share * (new.moment - last.moment);
    last.t += share * (new.t - last.t);
    last.count += 1;
}

/// How far the base moved between two readings: a turn counts at the whisker's tip (m).
pub(super) fn travel(a: &ContactReading, b: &ContactReading) -> f64 {
    let step = a.odom_from_whisker.between(b.odom_from_whisker);
    step.position().norm() + b.whisker.length * step.theta.abs()
}
