//! Contacts in space, from the moments about both transverse axes: along the whisker, away from its axis, around it.

mod report;
mod still;

use crate::beam::{BendingPlane, Load, SpatialContact, Whisker, moment_mode_in_space};
use crate::plane::Pose2;
use core::f64::consts::PI;
use vibrissa_core::math;

pub use report::{SpaceReport, SpaceStep, contact_in_space};

/// A number with the least and the largest one that the readings' declared errors allow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The number.
    pub value: f64,
    /// The least.
    pub lo: f64,
    /// The largest.
    pub hi: f64,
}

impl Band {
    fn around(value: f64, half: f64) -> Self {
        Self { value, lo: value - half, hi: value + half }
    }

    /// Whether a number is within.
    #[must_use]
    pub fn holds(&self, value: f64) -> bool {
        (self.lo..=self.hi).contains(&value)
    }
}

/// A contact in cylinder coordinates about the undeflected whisker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacePoint {
    /// Along the undeflected whisker (m).
    pub x: Band,
    /// Distance from its axis (m).
    pub r: Band,
    /// Angle about it (rad), from +y towards +z; its value is in (-π, π], its ends may lie beyond.
    pub angle: Band,
}

impl SpacePoint {
    /// The contact in the whisker frame (m): x along the undeflected whisker, y left, z up.
    #[must_use]
    pub fn position(&self) -> [f64; 3] {
        let (sin, cos) = math::sin_cos(self.angle.value);
        [self.x.value, self.r.value * cos, self.r.value * sin]
    }
}

/// One step of a log: the base, and what was read on average while it all but stood there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Reading {
    t: f64,
    odom_from_whisker: Pose2,
    /// In the whisker's x-y plane and across it (N m).
    moments: [f64; 2],
    /// By how much each of them may be wrong (N m).
    errors: [f64; 2],
    count: usize,
}

/// How many moments of a band are tried: the distance from the axis is not monotone where a whisker bends strongly.
const TRIED: i32 = 4;

/// The contact of the tip that explains two moments, with bands from their errors; none where no tip does.
fn tip(whisker: &Whisker, reading: &Reading) -> Option<SpacePoint> {
    let plane = BendingPlane::of(reading.moments);
    let [moment, turn] = plane.bands(reading.errors);
    let at = |size: f64| -> Option<SpatialContact> {
        let found = moment_mode_in_space(whisker, [size, 0.0], whisker.length, Load::Normal).ok()?;
        found.into_iter().next()
    };
    let told = at(plane.moment)?;
    let mut point = SpacePoint {
        x: Band::around(told.x, 0.0),
        r: Band::around(told.r, 0.0),
        angle: Band::around(plane.angle, turn.min(PI)),
    };
    let mut widest = |contact: SpatialContact| {
        (point.x.lo, point.x.hi) = (point.x.lo.min(contact.x), point.x.hi.max(contact.x));
        (point.r.lo, point.r.hi) = (point.r.lo.min(contact.r), point.r.hi.max(contact.r));
    };
    for k in -TRIED..=TRIED {
        let size = (plane.moment + moment * f64::from(k) / f64::from(TRIED)).max(0.0);
        match at(size) {
            Some(contact) => widest(contact),
            // Beyond the largest moment of a tip: up to that one.
            None => widest(largest(&at, plane.moment, size)?),
        }
    }
    Some(point)
}

/// The contact of the largest moment between one that has a contact and one that has none.
fn largest(at: &impl Fn(f64) -> Option<SpatialContact>, mut some: f64, mut none: f64) -> Option<SpatialContact> {
    for _ in 0..30 {
        let middle = 0.5 * (some + none);
        if at(middle).is_some() { some = middle } else { none = middle }
    }
    at(some)
}
