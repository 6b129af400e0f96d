//! The parts of a stretch during which the contact stood still.

use super::fixed_point::{FixedPoint, fixed_point_until, fixed_points_until};
use super::reading::ContactReading;
use super::stretch::travel;
use crate::Stop;
use crate::plane::{Pose2, Vec2};

/// Travel of the base over which a fixed point is first tried (m).
const FIRST: f64 = 3e-3;
/// Travel of the base over which a fixed point must explain the readings before it is believed (m): a sliding tip can look
/// like one for a while.
const CLEAR: f64 = 6e-3;
/// Largest standard deviation of a fixed point's distance that is a find (m).
const VAGUE: f64 = 3e-3;
/// How far off the straight whisker a point may have been when the contact began (m), beside its uncertainty.
const OFF_AXIS: f64 = 1e-3;
/// A break is found at most so many readings early.
const LATE: usize = 4;
/// Fewest readings of a window.
const FEWEST: usize = 4;

/// A part of a stretch: readings `from..to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReadingRange {
    pub(super) from: usize,
    pub(super) to: usize,
    /// The contact on the whisker's side that stood still; none where the tip slid or nothing fits.
    pub(super) still: Option<FixedPoint>,
}

/// The contact with the side that stood still from reading `from` on; `onset` is the base when the whisker was last free.
pub(super) fn still_from(
    readings: &[ContactReading],
    from: usize,
    onset: Option<Pose2>,
    stop: &Stop,
) -> Option<ReadingRange> {
    let along = cumulated(readings);
    let reach = |from: usize, far: f64| along.partition_point(|s| *s < along[from] + far).clamp(from + 1, along.len());
    let begun = |point: &FixedPoint| from > 0 || onset.is_none_or(|onset| on_axis(point, onset, &readings[0]));
    let (to, point) = longest(readings, from, &reach, stop)?;
    let whole = from == 0 && to == readings.len();
    let clear = (whole || along[to - 1] - along[from] >= CLEAR) && begun(&point) && off_tip(&point, &readings[from]);
    // What slides once is left to the traces: amid a slide, many a stretch looks like a fixed point and is none.
    clear.then_some(ReadingRange { from, to, still: Some(point) })
}

/// The contact with the side that begins at reading `from` or just after it, where a sliding tip broke off; none where no
/// point explains the readings over a clear way.
pub(super) fn side_from(readings: &[ContactReading], from: usize, stop: &Stop) -> Option<ReadingRange> {
    let along = cumulated(readings);
    let reach = |from: usize, far: f64| along.partition_point(|s| *s < along[from] + far).clamp(from + 1, along.len());
    let begins = |from: usize| {
        let (to, point) = longest(readings, from, &reach, stop)?;
        let clear = along[to - 1] - along[from] >= CLEAR && off_tip(&point, &readings[from]);
        clear.then_some(ReadingRange { from, to, still: Some(point) })
    };
    (from..(from + LATE).min(readings.len())).find_map(begins)
}

fn cumulated(readings: &[ContactReading]) -> Vec<f64> {
    let mut along = vec![0.0; readings.len()];
    for (i, pair) in readings.windows(2).enumerate() {
        along[i + 1] = along[i] + travel(&pair[0], &pair[1]);
    }
    along
}

/// The longest window from `from` on in which one point explains all; none when not even the first one is explained.
fn longest(
    readings: &[ContactReading],
    from: usize,
    reach: &impl Fn(usize, f64) -> usize,
    stop: &Stop,
) -> Option<(usize, FixedPoint)> {
    let mut far = FIRST;
    let mut to = reach(from, far).max(from + FEWEST).min(readings.len());
    if to < from + FEWEST {
        return None;
    }
    let fixed_point = |readings: &[ContactReading], start: Vec2| fixed_point_until(readings, None, start, stop);
    let mut point = fixed_points_until(&readings[from..to], stop).into_iter().find(|p| on_side(p, &readings[from]))?;
    let mut fails = readings.len() + 1;
    while to < readings.len() && to + 1 < fails {
        far *= 1.5;
        let next = reach(from, far).max(to + 1).min(fails - 1);
        match fixed_point(&readings[from..next], point.position).filter(|p| on_side(p, &readings[from])) {
            Some(longer) => (to, point) = (next, longer),
            None => {
                fails = next;
                far = 0.0;
                let middle = usize::midpoint(to, fails);
                if middle == to {
                    break;
                }
                match fixed_point(&readings[from..middle], point.position).filter(|p| on_side(p, &readings[from])) {
                    Some(longer) => (to, point) = (middle, longer),
                    None => fails = middle,
                }
            }
        }
    }
    Some((to, point))
}

/// Whether the point was on the straight whisker when the contact began.
fn on_axis(point: &FixedPoint, onset: Pose2, first: &ContactReading) -> bool {
    let local = onset.inverse_transform_point(point.position);
    let std = point.std_along(Vec2::from_angle(onset.theta).perp());
    local.y.abs() <= OFF_AXIS + travel_between(onset, first) + 3.0 * std
}

fn travel_between(onset: Pose2, first: &ContactReading) -> f64 {
    travel(&ContactReading { odom_from_whisker: onset, ..*first }, first)
}

/// Whether the point is well known, and on the whisker's side rather than at its tip.
fn off_tip(point: &FixedPoint, reading: &ContactReading) -> bool {
    let away = point.position - reading.odom_from_whisker.position();
    let std = point.std_along(away * (1.0 / away.norm().max(1e-12)));
    std <= VAGUE && point.s_a.iter().all(|s_a| s_a + 2.0 * std < reading.whisker.length)
}

/// Whether the point explains the readings, on the whisker.
fn on_side(point: &FixedPoint, reading: &ContactReading) -> bool {
    point.fits() && point.s_a.iter().all(|s_a| *s_a < reading.whisker.length)
}
