//! One reading with its base and its error.

use crate::beam::normal::{Branch, by_point};
use crate::beam::rod::Status;
use crate::beam::{Bend, Load, Whisker, point_mode};
use crate::plane::{Pose2, Vec2};
use crate::world::MomentNoise;

/// How much longer than it is a whisker is taken to be when a point is tried: so that a tip shows as a tip.
const REACH: f64 = 1.5;
/// A shape explains a reading if it is within so many standard deviations.
const EXPLAINED: f64 = 3.0;

/// A moment that was read at a known place of the base; or the mean of neighbouring ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactReading {
    /// When (s).
    pub t: f64,
    /// The beam.
    pub whisker: Whisker,
    /// The whisker's base, odometry frame.
    pub odom_from_whisker: Pose2,
    /// The moment (N m).
    pub moment: f64,
    /// Bound on the error of a single reading.
    pub noise: MomentNoise,
    /// How many readings it is the mean of, at least 1.
    pub count: usize,
}

/// What a reading would be if the side of the whisker were touched at a point.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SideReading {
    /// Moment (N m).
    pub(super) moment: f64,
    /// Arc length of the contact (m); beyond the whisker's length where the whisker is too short.
    pub(super) s_a: f64,
    /// The shape of a whisker that is integrated, from which shapes near by are found.
    bend: Option<Bend>,
}

impl SideReading {
    fn of(bend: Bend) -> Self {
        Self { moment: bend.moment, s_a: bend.s_a, bend: Some(bend) }
    }
}

impl ContactReading {
    /// Bound on the error of one reading of a true moment (N m).
    #[must_use]
    pub fn bound(&self, moment: f64) -> f64 {
        self.noise.moment_relative * moment.abs() + self.noise.moment_absolute
    }

    /// Standard deviation of the reading when the true moment is this (N m): independent errors, uniform in the bound.
    #[must_use]
    pub fn std(&self, moment: f64) -> f64 {
        (self.bound(moment) / 3f64.sqrt()).max(1e-12) / (self.count.max(1) as f64).sqrt()
    }

    /// The side contact at a point of the odometry frame: of all shapes the one nearest to the reading.
    pub(super) fn touched(&self, point: Vec2) -> Option<SideReading> {
        let local = self.odom_from_whisker.inverse_transform_point(point);
        let near = |a: &SideReading, b: &SideReading| {
            (a.moment - self.moment).abs().total_cmp(&(b.moment - self.moment).abs())
        };
        if self.whisker.is_uniform() {
            let (rigidity, length) = (self.whisker.flexural_rigidity, REACH * self.whisker.length);
            let shapes = [Branch::Least, Branch::Curled].map(|branch| by_point(rigidity, length, local, branch));
            return shapes
                .into_iter()
                .flatten()
                .map(|b| SideReading { moment: b.moment, s_a: b.s_a, bend: None })
                .min_by(near);
        }
        let bends = point_mode(&self.whisker, local, Load::Normal).unwrap_or_default();
        bends.into_iter().map(SideReading::of).min_by(near)
    }

    /// As [`touched`](Self::touched), by a shape of a point near by: of a whisker that is integrated the shape on the same branch,
    /// which takes a few marches where the search for all shapes takes thousands; none where the branch does not reach the point.
    pub(super) fn touched_from(&self, point: Vec2, near: &SideReading) -> Option<SideReading> {
        if near.bend.is_some() { self.followed(point, near) } else { self.touched(point) }
    }

    /// As [`touched`](Self::touched), by a shape that the same whisker had at another reading or another point: the shape on that
    /// branch if it explains the reading; otherwise of all shapes the nearest to it.
    pub(super) fn touched_beside(&self, point: Vec2, near: &SideReading) -> Option<SideReading> {
        let explains = |found: &SideReading| (found.moment - self.moment).abs() <= EXPLAINED * self.std(found.moment);
        self.followed(point, near).filter(explains).or_else(|| self.touched(point))
    }

    /// The shape at a point that is on the same branch as another one; none of a whisker that is solved in closed form.
    fn followed(&self, point: Vec2, near: &SideReading) -> Option<SideReading> {
        let bend = near.bend.as_ref()?;
        let local = self.odom_from_whisker.inverse_transform_point(point);
        let found = self.whisker.rod().ok()?.point_from(local, Load::Normal, bend).ok()?;
        found.bend.filter(|_| found.status == Status::Converged).map(SideReading::of)
    }
}
