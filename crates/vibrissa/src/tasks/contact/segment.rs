//! The parts of a stretch during which the contact stood still.

use super::fixed_point::{FixedPoint, fixed_point, fixed_points};
use super::reading::ContactReading;
use super::stretch::travel;

/// Travel of the base over which a fixed point is first tried (m).
const FIRST: f64 = 3e-3;
/// Travel of the base over which a fixed point must explain the readings before it is believed (m): a sliding tip can look
/// like one for a while.
const CLEAR: f64 = 6e-3;
/// Travel of the base by which the search moves on when nothing stands still (m).
const STRIDE: f64 = 1e-3;
/// Fewest readings of a window.
const FEWEST: usize = 4;

/// A part of a stretch: readings `from..to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) from: usize,
    pub(super) to: usize,
    /// The contact on the whisker's side that stood still; none where the tip slid or nothing fits.
    pub(super) still: Option<FixedPoint>,
}

/// The parts of a stretch, in order, without gaps.
pub(super) fn parts(readings: &[ContactReading]) -> Vec<Part> {
    let along = cumulated(readings);
    let reach = |from: usize, far: f64| along.partition_point(|s| *s < along[from] + far).clamp(from + 1, along.len());
    let mut found: Vec<Part> = Vec::new();
    let mut from = 0;
    while from < readings.len() {
        let still = longest(readings, from, &reach);
        let whole = |to: usize| from == 0 && to == readings.len();
        let clear = still.filter(|&(to, _)| along[to - 1] - along[from] >= CLEAR || whole(to));
        if let Some((to, point)) = clear {
            found.push(Part { from, to, still: Some(point) });
            from = to;
            continue;
        }
        let to = reach(from, STRIDE);
        match found.last_mut() {
            Some(last) if last.still.is_none() => last.to = to,
            _ => found.push(Part { from, to, still: None }),
        }
        from = to;
    }
    found
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
) -> Option<(usize, FixedPoint)> {
    let mut far = FIRST;
    let mut to = reach(from, far).max(from + FEWEST).min(readings.len());
    if to < from + FEWEST {
        return None;
    }
    let mut point = fixed_points(&readings[from..to]).into_iter().find(|p| on_side(p, &readings[from]))?;
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

/// Whether the point explains the readings, on the whisker.
fn on_side(point: &FixedPoint, reading: &ContactReading) -> bool {
    point.fits() && point.s_a.iter().all(|s_a| *s_a < reading.whisker.length)
}
