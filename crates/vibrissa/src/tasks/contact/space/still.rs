//! A contact in space that stands still while the base moves in the plane.

use super::{Band, Reading, SpacePoint};
use crate::beam::{BendingPlane, Load, Whisker, moment_mode_in_space, point_mode};
use crate::least_squares::{Scale, covariance, minimise};
use crate::plane::{Pose2, Vec2};
use core::f64::consts::{FRAC_PI_2, PI};
use vibrissa_core::math;

/// Least travel of the base over which a point has to explain the readings (m); a turn counts at the tip.
const LEAST_TRAVEL: f64 = 6e-3;
/// Least number of readings: each has two numbers for three unknowns.
const LEAST_READINGS: usize = 4;
/// Share of the whisker up to which a point that stands still is told from the tip.
const BEFORE_TIP: f64 = 0.99;
/// Places along the whisker where a search begins, as shares of its length.
const BEGINNINGS: [f64; 4] = [0.35, 0.55, 0.75, 0.93];
/// How far beyond its declared error a reading may be explained: of least squares, not of the truth.
const SLACK: f64 = 1.25;
/// Rounds in which the errors of the readings come from the moments that the point predicts.
const ROUNDS: usize = 2;
/// Step of differences (m).
const STEP: f64 = 1e-7;

/// A point that stands still, and for how long.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Still {
    /// The first reading after those that it explains.
    pub(super) to: usize,
    /// Odometry frame, z above the whisker's base (m).
    pub(super) point: [f64; 3],
    /// How each coordinate of it moves with the error of each reading, times the error's bound (m).
    moved: Vec<[f64; 3]>,
}

impl Still {
    /// The point in the frame of a whisker, with bands.
    pub(super) fn seen_from(&self, base: Pose2) -> SpacePoint {
        let [x, y, z] = seen(base, self.point);
        let (r, angle) = (math::hypot(y, z), math::atan2(z, y));
        let (sin, cos) = math::sin_cos(base.theta);
        let mut bands = [0.0_f64; 3];
        for [dx, dy, dz] in &self.moved {
            let (along, left) = (cos * dx + sin * dy, cos * dy - sin * dx);
            let by = [along, (y * left + z * dz) / r, (y * dz - z * left) / (r * r)];
            bands.iter_mut().zip(by).for_each(|(band, by)| *band += by.abs());
        }
        let turn = if bands[2].is_finite() { bands[2].min(PI) } else { PI };
        SpacePoint {
            x: Band::around(x, bands[0]),
            r: Band { value: r, lo: (r - bands[1]).max(0.0), hi: r + bands[1] },
            angle: Band::around(angle, turn),
        }
    }
}

/// A point of the odometry frame in the whisker's.
fn seen(base: Pose2, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let at = base.inverse().transform_point(Vec2::new(x, y));
    [at.x, at.y, z]
}

/// The moments (N m) of a whisker whose side is pushed to a point in its frame (m); none where it does not get there.
fn moments(whisker: &Whisker, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
    let r = math::hypot(y, z);
    let contact = Vec2::new(x, r);
    if r <= 0.0 {
        return Some([0.0; 2]);
    }
    if contact.norm() > whisker.length {
        return None;
    }
    let bends = point_mode(whisker, contact, Load::Normal).ok()?;
    let pushed = |bend: &&crate::beam::Bend| bend.force > 0.0 && bend.phi_a.abs() < FRAC_PI_2;
    let moment = bends.iter().find(pushed)?.moment;
    Some([moment * y / r, moment * z / r])
}

/// Where the contact stands still from a reading on, and until when; none where it slides, or has not been watched for long enough.
pub(super) fn still_from(
    whisker: &Whisker,
    readings: &[Reading],
    from: usize,
    errors: impl Fn([f64; 2]) -> [f64; 2] + Copy,
) -> Option<Still> {
    let rest = &readings[from..];
    let far = |reading: &Reading| travel(whisker, &rest[0], reading) >= LEAST_TRAVEL;
    let first = rest.iter().position(far)?.max(LEAST_READINGS - 1) + 1;
    let fitted = |to: usize| fit(whisker, rest.get(..to)?, errors).map(|still| Still { to: from + to, ..still });
    let (mut good, mut best) = (first, fitted(first)?);
    let mut bad = rest.len() + 1;
    // The whole rest first, then by halves.
    let mut tried = rest.len();
    while good + 1 < bad && tried > good {
        match fitted(tried) {
            Some(still) => (good, best) = (tried, still),
            None => bad = tried,
        }
        tried = good + (bad - good) / 2;
    }
    Some(best)
}

/// How far the base moved between two readings (m).
pub(super) fn travel(whisker: &Whisker, a: &Reading, b: &Reading) -> f64 {
    let step = a.odom_from_whisker.between(b.odom_from_whisker);
    step.position().norm() + whisker.length * step.theta.abs()
}

/// The point that explains all readings within their errors; none where no point does.
fn fit(whisker: &Whisker, readings: &[Reading], errors: impl Fn([f64; 2]) -> [f64; 2]) -> Option<Still> {
    let predicted = |point: &[f64]| -> Option<Vec<[f64; 2]>> {
        let point = [point[0], point[1], point[2]];
        readings.iter().map(|reading| moments(whisker, seen(reading.odom_from_whisker, point))).collect()
    };
    let mut bounds: Vec<[f64; 2]> = readings.iter().map(|reading| reading.errors).collect();
    let mut found: Option<Vec<f64>> = None;
    for _ in 0..ROUNDS {
        let residuals = |point: &[f64]| -> Option<Vec<f64>> {
            let told = predicted(point)?;
            let one = |i: usize, k: usize| (told[i][k] - readings[i].moments[k]) / bounds[i][k];
            Some((0..readings.len()).flat_map(|i| [one(i, 0), one(i, 1)]).collect())
        };
        let size = 0.01 * whisker.length;
        let descend = |start: Vec<f64>| {
            let minimum = minimise(residuals, &start, &[Scale::free(size); 3]).ok()?;
            let worst = minimum.residuals.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
            let cost = minimum.residuals.iter().map(|r| r * r).sum::<f64>();
            Some((cost, worst, minimum.parameters))
        };
        let starts = found.take().map_or_else(|| beginnings(whisker, readings), |point| vec![point]);
        let (_, worst, point) = starts.into_iter().filter_map(descend).min_by(|a, b| a.0.total_cmp(&b.0))?;
        if worst > SLACK {
            return None;
        }
        bounds = predicted(&point)?.into_iter().map(&errors).collect();
        found = Some(point);
    }
    let point = found?;
    let held = |reading: &Reading| arc_length(whisker, seen(reading.odom_from_whisker, [point[0], point[1], point[2]]));
    if !readings.iter().all(|reading| held(reading).is_some_and(|s_a| s_a < BEFORE_TIP * whisker.length)) {
        return None;
    }
    let mut columns = Vec::with_capacity(3);
    for axis in 0..3 {
        let moved = |by: f64| {
            let mut moved = point.clone();
            moved[axis] += by;
            predicted(&moved)
        };
        let (up, down) = (moved(STEP)?, moved(-STEP)?);
        let slope = |i: usize, k: usize| (up[i][k] - down[i][k]) / (2.0 * STEP * bounds[i][k]);
        columns.push((0..readings.len()).flat_map(|i| [slope(i, 0), slope(i, 1)]).collect::<Vec<f64>>());
    }
    let jacobian: Vec<Vec<f64>> = (0..columns[0].len()).map(|row| columns.iter().map(|c| c[row]).collect()).collect();
    let inverse = covariance(&jacobian, 1.0);
    if inverse.len() != 3 {
        return None;
    }
    let moved = |row: &Vec<f64>| [0, 1, 2].map(|k| (0..3).map(|j| inverse[k][j] * row[j]).sum());
    Some(Still { to: 0, point: [point[0], point[1], point[2]], moved: jacobian.iter().map(moved).collect() })
}

/// The arc length at which the whisker touches a point in its frame (m).
pub(super) fn arc_length(whisker: &Whisker, [x, y, z]: [f64; 3]) -> Option<f64> {
    let bends = point_mode(whisker, Vec2::new(x, math::hypot(y, z)), Load::Normal).ok()?;
    bends.iter().find(|bend| bend.force > 0.0).map(|bend| bend.s_a)
}

/// Points to begin with: where the strongest reading would be explained at some places along the whisker.
fn beginnings(whisker: &Whisker, readings: &[Reading]) -> Vec<Vec<f64>> {
    let size = |reading: &Reading| BendingPlane::of(reading.moments).moment;
    let strongest = readings.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    let Some(strongest) = strongest else { return Vec::new() };
    let at = |share: &f64| {
        let found = moment_mode_in_space(whisker, strongest.moments, share * whisker.length, Load::Normal).ok()?;
        let [x, y, z] = found.first()?.point();
        let at = strongest.odom_from_whisker.transform_point(Vec2::new(x, y));
        Some(vec![at.x, at.y, z])
    };
    BEGINNINGS.iter().filter_map(at).collect()
}
