//! Temporal filtering: the contacts that explain several readings of a whisker while its base moves and the contact stands still.
//!
//! Each reading leaves a set of contacts open; moved along with the base, those of several readings are intersected
//! \[routray, eq. "getContactPointTemporal"\]. Contact force, end slope, contact strip and moment are taken, whichever the log has.

use crate::beam::Load;
use crate::flow::contact_set::{ContactModel, ContactRegion, MomentRegime, Reading, Resolution, VirtualSensor};
use crate::flow::sensor_log::{LogRow, Quantity, SensorLog};
use crate::io::calibrated;
use crate::plane::{Pose2, Vec2};
use crate::sets::Interval;
use crate::world::{MountedWhisker, ReadingNoise, Robot};
use crate::{Error, Result};
use std::collections::VecDeque;

/// What temporal filtering can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemporalFilterOptions {
    /// How many readings are intersected, at least 1.
    pub readings: usize,
    /// How far the base moves between two of them (m), a turn counted at the tip.
    pub spacing: f64,
    /// Size of the cells that cover contacts.
    pub resolution: Resolution,
}

impl Default for TemporalFilterOptions {
    /// Three readings 3 mm apart: the paper's figure has two and three.
    fn default() -> Self {
        Self { readings: 3, spacing: 3e-3, resolution: Resolution { rim: 0.5e-3, ..Resolution::default() } }
    }
}

/// The contacts that explain a reading and those before it.
#[derive(Clone, Debug, PartialEq)]
pub struct FilteredContact {
    /// When (s).
    pub t: f64,
    /// Index of the whisker.
    pub whisker: usize,
    /// The whisker's base, odometry frame.
    pub odom_from_whisker: Pose2,
    /// How many readings were intersected; 1 where the contact has moved since the last one.
    pub readings: usize,
    /// How many separate pieces the set has.
    pub components: usize,
    /// Area of the set (m²).
    pub area: f64,
    /// Least and largest x and y of the set, whisker frame (m).
    pub extent: [Interval; 2],
    /// The middle of the extent, whisker frame (m).
    pub contact: Vec2,
}

impl FilteredContact {
    /// The contact, odometry frame (m).
    #[must_use]
    pub fn position(&self) -> Vec2 {
        self.odom_from_whisker.transform_point(self.contact)
    }
}

/// Intersects the contact sets of readings along a log, whisker by whisker.
///
/// If the declared bounds hold, the contact is with the side and stands still over the readings that were intersected, it is
/// in the set. Where nothing is left the contact has moved, and the filter begins anew.
///
/// # Errors
///
/// Options out of range; a log without force, slope, strip or moment of any whisker; a reading that is not finite.
pub fn temporal_filter(
    log: &SensorLog,
    robot: &Robot,
    options: &TemporalFilterOptions,
) -> Result<Vec<FilteredContact>> {
    if options.readings == 0 || !(options.spacing > 0.0 && options.spacing.is_finite()) {
        return Err(Error::usage("temporal filtering")
            .value(format!("{} readings, {} m apart", options.readings, options.spacing))
            .allowed("1 reading or more, more than 0 m apart"));
    }
    let (log, robot) = calibrated(log, robot)?;
    robot.require_level("temporal filtering")?;
    let mut found = Vec::new();
    let mut any = false;
    for (index, whisker) in robot.whiskers.iter().enumerate() {
        let columns = Columns::of(&log, whisker);
        if columns.are_there() {
            any = true;
            filter(&log.rows, (index, whisker), &columns, options, &mut found)?;
        }
    }
    if !any {
        return Err(Error::data("the log has no readings of a whisker")
            .allowed("force, slope, strip_lo and strip_hi, or moment; NAME.force of several whiskers"));
    }
    found.sort_by(|a, b| a.t.total_cmp(&b.t));
    Ok(found)
}

/// Where a whisker's readings stand in a row.
struct Columns {
    force: Option<usize>,
    slope: Option<usize>,
    strip: Option<[usize; 2]>,
    moment: Option<usize>,
}

impl Columns {
    fn of(log: &SensorLog, whisker: &MountedWhisker) -> Self {
        let of = |quantity| log.channel(&whisker.name, quantity);
        Self {
            force: of(Quantity::Force),
            slope: of(Quantity::Slope),
            strip: of(Quantity::StripLo).zip(of(Quantity::StripHi)).map(|(lo, hi)| [lo, hi]),
            moment: of(Quantity::Moment),
        }
    }

    fn are_there(&self) -> bool {
        self.force.is_some() || self.slope.is_some() || self.strip.is_some() || self.moment.is_some()
    }

    /// The readings of a row with their bounds; none where the whisker may be free.
    fn readings(&self, row: &LogRow, whisker: &MountedWhisker) -> Vec<Reading> {
        let moment = VirtualSensor::Moment(MomentRegime::Auto);
        let scalars = [
            (self.force, VirtualSensor::Load, whisker.force_noise),
            (self.slope, VirtualSensor::Slope, whisker.slope_noise),
            (self.moment, moment, ReadingNoise::from(whisker.noise)),
        ];
        let mut readings = Vec::new();
        for (column, sensor, noise) in scalars {
            let Some(value) = column.and_then(|column| row.readings.get(column)) else { continue };
            let bound = noise.relative * value.abs() + noise.absolute;
            if value.abs() <= bound {
                return Vec::new();
            }
            readings.push(Reading { sensor, value: Interval::new(value - bound, value + bound) });
        }
        if let Some([lo, hi]) = self.strip {
            let (lo, hi) = (row.readings[lo], row.readings[hi]);
            if !(hi > 0.0 && lo <= hi) {
                return Vec::new();
            }
            readings.push(Reading { sensor: VirtualSensor::Strip, value: Interval::new(lo, hi) });
        }
        readings
    }
}

fn filter(
    rows: &[LogRow],
    (index, whisker): (usize, &MountedWhisker),
    columns: &Columns,
    options: &TemporalFilterOptions,
    found: &mut Vec<FilteredContact>,
) -> Result<()> {
    let model = ContactModel::new(&whisker.beam, Load::Normal)?;
    let mut before: VecDeque<(Pose2, ContactRegion)> = VecDeque::new();
    for row in rows {
        let readings = columns.readings(row, whisker);
        if readings.is_empty() {
            before.clear();
            continue;
        }
        let base = row.odom_from_robot.compose(whisker.robot_from_whisker);
        if before.back().is_some_and(|(last, _)| travel(*last, base, whisker.beam.length) < options.spacing) {
            continue;
        }
        let alone = ContactRegion::new(&model, &readings, &options.resolution)?;
        let mut shared = alone.clone();
        let mut used = 1;
        for (earlier, region) in before.iter().rev() {
            let less = shared.shared_with(region, base.between(*earlier));
            if less.is_empty() {
                // The contact has moved since.
                before.clear();
                break;
            }
            shared = less;
            used += 1;
        }
        if used == 1 {
            shared = alone.clone();
        }
        before.push_back((base, alone));
        while before.len() >= options.readings.max(1) {
            before.pop_front();
        }
        found.extend(told(row.t, index, base, used, &shared));
    }
    Ok(())
}

/// How far the base moved: a turn counts at the whisker's tip (m).
fn travel(from: Pose2, to: Pose2, length: f64) -> f64 {
    let step = from.between(to);
    step.position().norm() + length * step.theta.abs()
}

fn told(t: f64, whisker: usize, base: Pose2, readings: usize, region: &ContactRegion) -> Option<FilteredContact> {
    let bounds = region.cells.iter().map(|cell| cell.cover.bounds()).reduce(|a, b| a.hull(b))?;
    Some(FilteredContact {
        t,
        whisker,
        odom_from_whisker: base,
        readings,
        components: region.components().len(),
        area: region.area(),
        extent: [Interval::new(bounds.min.x, bounds.max.x), Interval::new(bounds.min.y, bounds.max.y)],
        contact: (bounds.min + bounds.max) * 0.5,
    })
}
