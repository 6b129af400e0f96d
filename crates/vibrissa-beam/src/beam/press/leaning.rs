//! The same table for a uniform whisker that leans out of the horizontal, against upright walls without friction.
//!
//! A wall pushes along its normal `n`, which is horizontal. A straight round whisker bends in the plane of its axis `a` and the force, where it
//! meets a wall whose normal stands at the angle `psi` to the axis: the contacts of [`PressTable`] in a turned plane. The map sees their
//! horizontal part, and the sensor the share of the moment in its own plane. With `e` the elevation of the axis, `r` the sensor's roll from
//! left towards up, and `delta` the direction of `n` from the axis, seen from above:
//!
//! | quantity | value |
//! | --- | --- |
//! | angle between axis and normal | `cos psi = cos e cos delta`, `sin psi = sqrt(sin² e + cos² e sin² delta)` |
//! | along the axis, from above | `(cos e, 0)` |
//! | across the axis in the plane, from above | `(cos delta sin² e, sin delta) / sin psi` |
//! | share of the moment that is read | `(cos r sin delta - sin r sin e cos delta) / sin psi` |
//!
//! The share's derivative by `delta` is `sin e (cos r sin e cos delta + sin r sin delta) / sin³ psi`. A whisker bends towards the force, or, curled, away from it, as the wall of the direction `2 pi - psi` does in the mirror image. Where the
//! share vanishes any moment may be behind a reading of zero.

use super::slice::{PressEntry, PressSlice};
use super::{PressTable, ROUNDING, SAFETY};
use crate::math;
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Moments are looked up in ranges of no more than this, dimensionless: over more the contacts are no line.
const WIDEST: f64 = 0.25;
/// Where a bucket of directions is wider than this share of the sine of `psi`, plane and direction do not go along a line.
const STEEP: f64 = 0.5;
/// Ends of a bucket are looked at so far inside (rad): along the axis itself no plane is told.
const INSIDE: f64 = 1e-9;

/// A leaning whisker's contacts with upright walls of every direction.
#[derive(Clone, Debug)]
pub struct LeaningPressTable {
    table: PressTable,
    elevation: (f64, f64),
    roll: (f64, f64),
    /// Over a whole turn.
    buckets: usize,
    largest_of_tips: f64,
}

/// A bucket of directions, within a quarter turn from one along or across the axis.
#[derive(Clone, Copy, Debug)]
struct Bucket {
    from: f64,
    to: f64,
    /// The least sine of `psi`.
    sine: f64,
    share: (f64, f64),
}

/// How a contact of the plane is seen from above: towards the force (1) or away from it (-1).
type Towards = f64;

impl LeaningPressTable {
    /// The contacts of a whisker with this elevation of its axis and this roll of its sensor (rad), from those in the plane, in so many buckets
    /// of directions for each quarter turn. The table is one without friction.
    #[must_use]
    pub fn new(table: PressTable, elevation: f64, roll: f64, buckets: usize) -> Self {
        // A little more, so that no tip is among what lies beyond.
        let largest_of_tips = table.largest_of_tips() + 1e-6;
        let buckets = 4 * buckets.max(1);
        Self { table, elevation: math::sin_cos(elevation), roll: math::sin_cos(roll), buckets, largest_of_tips }
    }

    /// The contacts that cause a dimensionless reading between `lo` and `hi`: all of them as those of the side 1, the other has none.
    #[must_use]
    pub fn slice(&self, side: f64, lo: f64, hi: f64) -> PressSlice {
        let contacts = |index: usize| if side > 0.0 { self.bucket(index, (lo, hi)) } else { Vec::new() };
        PressSlice::of_buckets(self.buckets, (0..self.buckets).map(|index| contacts(index).into_iter()))
    }

    /// The contacts of a bucket.
    fn bucket(&self, index: usize, (lo, hi): (f64, f64)) -> Vec<PressEntry> {
        let width = TAU / self.buckets as f64;
        let (from, to) = (index as f64 * width, (index + 1) as f64 * width);
        let (first, last) = (from + INSIDE, to - INSIDE);
        let sine = self.sine(first).min(self.sine(last)).max(0.0);
        let bucket = Bucket { from, to, sine, share: self.shares(from, to, sine) };
        let ends = [self.psi(first), self.psi(last)];
        let slack = 2.0 * INSIDE;
        let (least, most) = (ends[0].min(ends[1]) - slack, ends[0].max(ends[1]) + slack);
        let (mut entries, mut found) = (Vec::new(), Vec::new());
        for (towards, share, psi) in
            [(1.0, bucket.share, (least, most)), (-1.0, (-bucket.share.1, -bucket.share.0), (TAU - most, TAU - least))]
        {
            found.clear();
            let columns = self.table.columns(psi.0, psi.1);
            for_each_moment((lo, hi), share, self.largest_of_tips, |moments| {
                columns.clone().for_each(|column| self.table.contacts_of(column, moments, &mut found));
            });
            entries.extend(found.iter().filter_map(|entry| self.seen(entry, &bucket, psi, towards)));
        }
        entries
    }

    /// The sine of the angle between the axis and a direction, and the angle itself (rad).
    fn sine(&self, delta: f64) -> f64 {
        let (sin, cos) = self.elevation;
        math::hypot(sin, cos * math::sin(delta))
    }

    fn psi(&self, delta: f64) -> f64 {
        math::atan2(self.sine(delta), self.elevation.1 * math::cos(delta))
    }

    /// The shares of the moment that are read over a bucket of directions, in which the sine of `psi` is no less than `sine`.
    fn shares(&self, from: f64, to: f64, sine: f64) -> (f64, f64) {
        let (sin_e, (sin_r, cos_r)) = (self.elevation.0, self.roll);
        let (first, last) = (from + INSIDE, to - INSIDE);
        let part = |along: f64, across: f64, delta: f64| along * math::cos(delta) + across * math::sin(delta);
        let read = |delta: f64| part(-sin_r * sin_e, cos_r, delta);
        if sine < 1e-6 {
            // Along the axis of a level whisker the plane turns at once: only the sign may be known.
            let (low, high) = (read(from).min(read(to)), read(from).max(read(to)));
            return (if low >= -1e-9 { 0.0 } else { -1.0 }, if high <= 1e-9 { 0.0 } else { 1.0 });
        }
        let [a, b] = [first, last].map(|delta| read(delta) / self.sine(delta));
        let (low, high) = (a.min(b) - 1e-6, a.max(b) + 1e-6);
        // The derivative is this times the sine of the elevation over the cube of that of psi; where it changes its sign all is read.
        let rises = |delta: f64| part(cos_r * sin_e, sin_r, delta) * sin_e;
        match (rises(from) >= 0.0) == (rises(to) >= 0.0) {
            true => (low.max(-1.0), high.min(1.0)),
            false if a + b > 0.0 => (low.max(-1.0), 1.0),
            false => (-1.0, high.min(1.0)),
        }
    }

    /// Across the axis in the plane of a direction, from above.
    fn across(&self, delta: f64) -> Vec2 {
        let (sin, cos) = math::sin_cos(delta);
        Vec2::new(cos * self.elevation.0 * self.elevation.0, sin) * (1.0 / self.sine(delta))
    }

    /// The direction in a bucket at which the axis and the normal make an angle (rad).
    fn delta(&self, psi: f64, bucket: &Bucket) -> f64 {
        let cosine = (math::cos(psi) / self.elevation.1).clamp(-1.0, 1.0);
        let delta = math::atan2((1.0 - cosine * cosine).max(0.0).sqrt(), cosine);
        let delta = if bucket.from < PI - INSIDE { delta } else { TAU - delta };
        delta.clamp(bucket.from + INSIDE, bucket.to - INSIDE)
    }

    /// A contact of the plane, in walls of the angles `psi` (rad), as the map sees it; none where it is of other walls.
    fn seen(&self, entry: &PressEntry, bucket: &Bucket, psi: (f64, f64), towards: Towards) -> Option<PressEntry> {
        let (first, last) = ((entry.middle - entry.half).max(psi.0), (entry.middle + entry.half).min(psi.1));
        if first > last {
            return None;
        }
        let unturned = |psi: f64| if towards > 0.0 { psi } else { TAU - psi };
        let ends = [first, last].map(|psi| self.delta(unturned(psi), bucket));
        let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from) + 2.0 * INSIDE);
        let point = |delta: f64| {
            let psi = unturned(self.psi(delta)).clamp(first, last);
            entry.center + entry.by_direction * (psi - entry.middle)
        };
        let from_above = |p: Vec2, across: Vec2| Vec2::new(p.x * self.elevation.1, 0.0) + across * (towards * p.y);
        let at = |delta: f64| from_above(point(delta), self.across(delta));
        let flat = from_above(entry.by_moment, self.across(middle));
        let thick = entry.by_moment.y.abs() * SAFETY * self.across(from).distance(self.across(to));
        let shape = PressEntry { middle, half, by_moment: flat, ..*entry };
        if half > STEEP * bucket.sine {
            // Any plane of the bucket, and any direction.
            let (a, b) = (point(from), point(to));
            let (center, wide) = ((a + b) * 0.5, (b - a).norm() * 0.5);
            let tall = center.y.abs() + wide + entry.by_moment.y.abs();
            return Some(PressEntry {
                center: Vec2::new(center.x * self.elevation.1, 0.0),
                by_direction: Vec2::ZERO,
                by_moment: Vec2::new(entry.by_moment.x * self.elevation.1, 0.0),
                radius: entry.radius + wide + tall + ROUNDING,
                ..shape
            });
        }
        let (a, b) = (at(from), at(to));
        let by_direction = if to > from { (b - a) * (1.0 / (to - from)) } else { Vec2::ZERO };
        let center = (a + b) * 0.5;
        let off = |share: f64| {
            let delta = from + share * (to - from);
            (at(delta) - center - by_direction * (delta - middle)).norm()
        };
        let bent = [0.25, 0.5, 0.75].map(off).into_iter().fold(0.0, f64::max);
        Some(PressEntry { center, by_direction, radius: entry.radius + SAFETY * bent + thick + ROUNDING, ..shape })
    }
}

/// The moments of which a share in a range is a reading between `lo` and `hi`, in ranges that are not too wide; beyond `most` there are contacts of
/// the side alone.
fn for_each_moment((lo, hi): (f64, f64), share: (f64, f64), most: f64, mut visit: impl FnMut((f64, f64))) {
    for (least, largest) in quotients((lo, hi), share).into_iter().flatten() {
        // From the middle outwards: beyond the tips' moments in one piece on either side.
        if least < -most {
            visit((least, largest.min(-most)));
        }
        let (from, to) = (least.max(-most), largest.min(most));
        if from <= to {
            let pieces = ((to - from) / WIDEST).ceil().max(1.0);
            for k in 0..pieces as usize {
                let edge = |k: usize| if k as f64 >= pieces { to } else { from + (to - from) * k as f64 / pieces };
                visit((edge(k), edge(k + 1)));
            }
        }
        if largest > most {
            visit((least.max(most), largest));
        }
    }
}

/// All `m` with `m s` between `lo` and `hi` for some `s` in a range.
fn quotients((lo, hi): (f64, f64), (low, high): (f64, f64)) -> [Option<(f64, f64)>; 2] {
    if low > 0.0 || high < 0.0 {
        let all = [lo / low, lo / high, hi / low, hi / high];
        let fold = |pick: fn(f64, f64) -> f64| all.into_iter().reduce(pick).unwrap_or(0.0);
        return [Some((fold(f64::min), fold(f64::max))), None];
    }
    if lo <= 0.0 && hi >= 0.0 {
        return [Some((f64::NEG_INFINITY, f64::INFINITY)), None];
    }
    // The reading nearest to zero, by the largest share of either sign.
    let near = if lo > 0.0 { lo } else { hi };
    let over = |share: f64| (share.abs() > 0.0).then(|| near / share);
    let beyond = |m: f64| if m > 0.0 { (m, f64::INFINITY) } else { (f64::NEG_INFINITY, m) };
    [over(low).map(beyond), over(high).map(beyond)]
}
