//! Every point that explains readings with bounded errors.

use super::reading::ContactReading;
use crate::beam::normal::{Branch, by_point, largest_angle};
use crate::plane::{Pose2, Vec2};
use crate::sets::Interval;

/// Most boxes that are split before the search ends with coarser ones.
const MOST_BOXES: usize = 60_000;

/// A length that any shape of a contact 1 m away fits in (m).
const LONG: f64 = 100.0;
/// Nearer to the base no contact is looked for (m): all curves of a turning whisker meet there.
const BASE: f64 = 1e-3;

/// A set of boxes that holds every fixed side contact that explains the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRegion {
    /// The boxes: x and y, odometry frame (m).
    pub boxes: Vec<[Interval; 2]>,
    /// Side of the smallest box (m).
    pub resolution: f64,
}

impl ContactRegion {
    /// Whether a point (odometry frame, m) is in one of the boxes.
    #[must_use]
    pub fn contains(&self, point: Vec2) -> bool {
        self.boxes.iter().any(|[x, y]| x.contains(point.x) && y.contains(point.y))
    }

    /// The distances of the region from a base (m); empty when the region is.
    #[must_use]
    pub fn distances(&self, odom_from_whisker: Pose2) -> Interval {
        let one = |&[x, y]: &[Interval; 2]| polar(odom_from_whisker, x, y).map_or(Interval::EMPTY, |(r, _)| r);
        self.boxes
            .iter()
            .map(one)
            .fold(Interval::EMPTY, |all, next| Interval::new(all.lo().min(next.lo()), all.hi().max(next.hi())))
    }

    /// The area (m²).
    #[must_use]
    pub fn area(&self) -> f64 {
        self.boxes.iter().map(|[x, y]| x.width() * y.width()).sum()
    }
}

/// Every fixed point at which side contact explains every reading within its bound, as boxes down to `resolution` (m);
/// `None` for whiskers that are not uniform.
///
/// Sound for the less bent branch: if the declared bounds hold and the contact stands still, it is inside. A moment is
/// `EI mu(angle) / distance`, with `mu` growing with the polar angle, so that every box has exact bounds.
#[must_use]
pub fn contact_region(readings: &[ContactReading], resolution: f64) -> Option<ContactRegion> {
    let first = readings.first()?;
    if readings.iter().any(|reading| !reading.whisker.is_uniform()) {
        return None;
    }
    let (base, reach) = (first.odom_from_whisker.position(), first.whisker.length);
    let around = |c: f64| Interval::new(c - reach, c + reach);
    let mut open = vec![[around(base.x), around(base.y)]];
    let mut region = ContactRegion { boxes: Vec::new(), resolution };
    let mut split = 0;
    while let Some([x, y]) = open.pop() {
        if !readings.iter().all(|reading| possible(reading, x, y)) {
            continue;
        }
        if x.width().max(y.width()) <= resolution || split >= MOST_BOXES {
            region.boxes.push([x, y]);
            continue;
        }
        split += 1;
        open.extend(quarters(x, y));
    }
    Some(region)
}

fn quarters(x: Interval, y: Interval) -> [[Interval; 2]; 4] {
    let halves = |i: Interval| {
        let middle = 0.5 * (i.lo() + i.hi());
        [Interval::new(i.lo(), middle), Interval::new(middle, i.hi())]
    };
    let ([a, b], [c, d]) = (halves(x), halves(y));
    [[a, c], [b, c], [a, d], [b, d]]
}

/// Whether a point of the box may explain the reading.
fn possible(reading: &ContactReading, x: Interval, y: Interval) -> bool {
    let Some((distance, angle)) = polar(reading.odom_from_whisker, x, y) else {
        return x.width().hypot(y.width()) > BASE;
    };
    let behind = angle.lo() > largest_angle() || angle.hi() < -largest_angle();
    if behind || distance.lo() > reading.whisker.length || distance.hi() < BASE {
        return false;
    }
    let (lo, hi) = (moment(reading, angle.lo(), distance), moment(reading, angle.hi(), distance));
    // For a mean of several readings the bound of one still holds.
    let bound = reading.bound(reading.moment);
    let (Some(lo), Some(hi)) = (lo, hi) else { return true };
    lo.0 <= reading.moment + bound && hi.1 >= reading.moment - bound
}

/// Bounds of the moment at one polar angle over the distances.
fn moment(reading: &ContactReading, angle: f64, distance: Interval) -> Option<(f64, f64)> {
    let angle = angle.clamp(-largest_angle() * 0.9999, largest_angle() * 0.9999);
    let unit = by_point(reading.whisker.flexural_rigidity, LONG, Vec2::from_angle(angle), Branch::Least)?;
    let ends = [unit.moment / distance.lo(), unit.moment / distance.hi()];
    Some((ends[0].min(ends[1]), ends[0].max(ends[1])))
}

/// Distances and polar angles of a box seen from a base; none when the base is in it or behind it.
fn polar(odom_from_whisker: Pose2, x: Interval, y: Interval) -> Option<(Interval, Interval)> {
    let centre = Vec2::new(0.5 * (x.lo() + x.hi()), 0.5 * (y.lo() + y.hi()));
    let radius = 0.5 * x.width().hypot(y.width());
    // The disc around the box: bounds a little wide, never narrow.
    let seen = odom_from_whisker.inverse_transform_point(centre);
    let far = seen.norm();
    if far <= radius * 1.001 {
        return None;
    }
    let (angle, half) = (seen.angle(), (radius / far).asin());
    if angle.abs() + half >= core::f64::consts::PI {
        return None;
    }
    Some((Interval::new(far - radius, far + radius), Interval::new(angle - half, angle + half)))
}
