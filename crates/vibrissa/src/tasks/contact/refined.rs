//! A contact that stood still once more: from its single readings, from when it began, on a base that moved steadily.

use super::fixed_point::{FixedPoint, fixed_point_until};
use super::reading::ContactReading;
use super::segment::ReadingRange;
use super::sharpened::sharpened;
use super::stretch::{ContactStretch, touch};
use crate::Stop;
use crate::config::ContactOptions;
use crate::plane::Pose2;

/// By how much the beginning of a contact may add to the squares of its readings: three standard deviations.
const ASTRAY: f64 = 9.0;
/// Fewest rows from which a steady motion is told.
const FEWEST: usize = 20;
/// Largest deviation of rounded places from the straight line through them, in units of what they are rounded to: a half, and
/// what the line itself gives way.
const ROUNDED: f64 = 0.6;

/// The fixed point of a part once more.
pub(super) fn refined(
    stretch: &ContactStretch,
    part: ReadingRange,
    point: FixedPoint,
    options: &ContactOptions,
    stop: &Stop,
) -> FixedPoint {
    let uniform = stretch.readings[part.from].whisker.is_uniform();
    if !uniform {
        let readings = &stretch.readings[part.from..part.to];
        return since(stretch.onset, readings, part, point, stop).map_or(point, |known| known.1);
    }
    let free: &[ContactReading] = if part.from == 0 { &stretch.free } else { &[] };
    let single = stretch.single(part.from, part.to);
    let all: Vec<ContactReading> = free.iter().chain(single).copied().collect();
    let all = steady(&all, options.odometry_resolution).unwrap_or(all);
    let (free, readings) = all.split_at(free.len());
    let onset = free.last().map(|r| r.odom_from_whisker);
    let Some((begun, found)) = since(onset, readings, part, point, stop) else { return point };
    // What was touched first need not be what stood still afterwards.
    let free = if begun { free } else { &[] };
    sharpened(free, readings, found)
}

/// The point by least squares, and whether the beginning of the contact is known and agrees.
fn since(
    onset: Option<Pose2>,
    readings: &[ContactReading],
    part: ReadingRange,
    point: FixedPoint,
    stop: &Stop,
) -> Option<(bool, FixedPoint)> {
    let alone = fixed_point_until(readings, None, point.position, stop)?;
    let touch = onset.filter(|_| part.from == 0).and_then(|onset| touch(onset, readings.first()?));
    let since = touch.and_then(|touch| fixed_point_until(readings, Some(touch), alone.position, stop));
    let since = since.filter(|since| since.chi2 <= alone.chi2 + ASTRAY);
    Some((since.is_some(), since.unwrap_or(alone)))
}

/// The readings on the straight and even way that their bases lie on within what places are rounded to (m); none where the base
/// did not move so.
///
/// Rounding is an error of the place that may be larger, in moments, than that of a weak reading; a stage that moves evenly
/// tells its place better than each of its rows does.
fn steady(readings: &[ContactReading], resolution: f64) -> Option<Vec<ContactReading>> {
    let (first, last) = (readings.first()?, readings.last()?);
    if readings.len() < FEWEST || last.t <= first.t || resolution <= 0.0 {
        return None;
    }
    let (x, y) = (line(readings, |r| r.odom_from_whisker.x), line(readings, |r| r.odom_from_whisker.y));
    let theta = line(readings, |r| r.odom_from_whisker.theta);
    let told = |r: &ContactReading| {
        let pose = Pose2::new(x(r.t), y(r.t), theta(r.t));
        let off = pose.between(r.odom_from_whisker);
        let near = off.x.abs().max(off.y.abs()).max(off.theta.abs() * r.whisker.length) <= ROUNDED * resolution;
        near.then_some(ContactReading { odom_from_whisker: pose, ..*r })
    };
    readings.iter().map(told).collect()
}

/// The straight line through a coordinate over time.
fn line(readings: &[ContactReading], coordinate: impl Fn(&ContactReading) -> f64) -> impl Fn(f64) -> f64 {
    let count = readings.len() as f64;
    let mean = |value: &dyn Fn(&ContactReading) -> f64| readings.iter().map(value).sum::<f64>() / count;
    let (t, at) = (mean(&|r| r.t), mean(&coordinate));
    let slope = mean(&|r| (r.t - t) * (coordinate(r) - at)) / mean(&|r| (r.t - t).powi(2));
    move |time| at + slope * (time - t)
}
