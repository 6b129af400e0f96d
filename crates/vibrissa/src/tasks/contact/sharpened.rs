//! A contact that stood still from errors that fill a bound: sharper than least squares.
//!
//! The mean of *n* independent errors falls with the root of *n*. Errors that fill a bound say more: a point is out as soon as
//! one reading is farther from it than the bound, and what is left shrinks with *n* itself. Whether errors are of that kind
//! the readings tell: for each of the two laws the likelihood with the best size of the errors is compared.

use super::fixed_point::{FixedPoint, slope};
use super::reading::ContactReading;
use crate::plane::Vec2;

/// Fewest readings that tell the law of their errors.
const FEWEST: usize = 20;
/// Points of the grid from the middle to one side, and how far that is in standard deviations.
const HALF: i32 = 14;
const REACH: f64 = 4.0;
/// Grids, each around the mean and with the spread of the one before.
const GRIDS: usize = 4;

/// A reading about the least-squares point: what would be read there (N m), and how that changes with the point.
struct LinearReading {
    read: f64,
    moment: f64,
    slope: Vec2,
    /// The side to which the whisker is bent: before the touch it is not, and nothing is felt.
    side: f64,
    relative: f64,
    absolute: f64,
}

impl LinearReading {
    /// The moment where the point is moved by `d` (N m).
    fn moment(&self, d: Vec2) -> f64 {
        self.side * (self.side * (self.moment + self.slope.dot(d))).max(0.0)
    }

    /// The bound there (N m).
    fn bound(&self, d: Vec2) -> f64 {
        (self.relative * self.moment(d).abs() + self.absolute).max(1e-15)
    }

    /// The error there, as a share of its bound.
    fn share(&self, d: Vec2) -> f64 {
        (self.read - self.moment(d)) / self.bound(d)
    }
}

/// What a grid says: mean, covariance (xx, xy, yy), the best logarithm of the likelihood, and the largest share there.
struct Posterior {
    mean: Vec2,
    covariance: [f64; 3],
    best: f64,
    share: f64,
}

/// `point`, the least-squares point of these single readings, moved to the mean of what uniform errors of unknown size leave
/// possible where the errors look uniform; and with an honest covariance.
///
/// `free` are the readings before the contact was felt: they bound when it began.
///
/// What the independent errors leave of the declared relative bound may be an error that all readings share, such as the
/// calibration's: the covariance holds it, since no number of readings tells it.
pub(super) fn sharpened(free: &[ContactReading], readings: &[ContactReading], point: FixedPoint) -> FixedPoint {
    let side = readings.iter().map(|r| r.moment).sum::<f64>().signum();
    let line = |r: &ContactReading| {
        let touched = r.touched(point.position)?;
        Some(LinearReading {
            read: r.moment,
            moment: touched.moment,
            slope: slope(r, point.position, &touched)?,
            side,
            relative: r.noise.moment_relative,
            absolute: r.noise.moment_absolute,
        })
    };
    let all = free.iter().chain(readings);
    let lines: Option<Vec<LinearReading>> = all.map(line).collect();
    let known = lines.zip(factor(point.covariance));
    let Some((lines, root)) = known.filter(|(lines, _)| lines.len() >= FEWEST) else { return point };
    let count = lines.len() as f64;
    let mean_square = lines.iter().map(|l| l.share(Vec2::ZERO).powi(2)).sum::<f64>() / count;
    let normal = -0.5 * count * ((2.0 * core::f64::consts::PI * mean_square).ln() + 1.0);
    let uniform = posterior(&lines, root);
    let is_uniform = uniform.as_ref().is_some_and(|p| p.best - count * 2f64.ln() > normal);
    let (moved, covariance, share) = match uniform.filter(|_| is_uniform) {
        Some(p) => (p.mean, p.covariance, p.share),
        None => (Vec2::ZERO, point.covariance, (3.0 * mean_square).sqrt()),
    };
    let position = point.position + moved;
    let common = common(&lines, point.covariance, share);
    let covariance =
        [covariance[0] + common.x * common.x, covariance[1] + common.x * common.y, covariance[2] + common.y * common.y];
    let s_a = |r: Option<&ContactReading>| r.and_then(|r| r.touched(position)).map(|t| t.s_a);
    let ends = s_a(readings.first()).zip(s_a(readings.last()));
    FixedPoint { position, covariance, s_a: ends.map_or(point.s_a, |(a, b)| [a, b]), ..point }
}

/// The lower Cholesky factor of a covariance, as columns.
fn factor([xx, xy, yy]: [f64; 3]) -> Option<[Vec2; 2]> {
    let first = xx.sqrt();
    let second = (yy - xy * xy / xx).sqrt();
    (first.is_finite() && second.is_finite() && first > 0.0 && second > 0.0)
        .then(|| [Vec2::new(first, xy / first), Vec2::new(0.0, second)])
}

/// The posterior of uniform errors whose size is not known, by grids.
fn posterior(lines: &[LinearReading], root: [Vec2; 2]) -> Option<Posterior> {
    let (mut root, mut found) = (root, None);
    let mut middle = Vec2::ZERO;
    for _ in 0..GRIDS {
        let posterior = grid(lines, middle, root);
        root = factor(posterior.covariance)?;
        middle = posterior.mean;
        found = Some(posterior);
    }
    found
}

/// The logarithm of one and a small change, without the cost of one for each reading and point.
fn range(change: f64) -> f64 {
    change * (1.0 - 0.5 * change)
}

fn grid(lines: &[LinearReading], middle: Vec2, root: [Vec2; 2]) -> Posterior {
    let spacing = REACH / f64::from(HALF);
    let mut points: Vec<(Vec2, f64, f64)> = Vec::new();
    for i in -HALF..=HALF {
        for j in -HALF..=HALF {
            let d = middle + root[0] * (spacing * f64::from(i)) + root[1] * (spacing * f64::from(j));
            // The errors' size integrated out: the power of the largest share; and each error's own range.
            let share = lines.iter().map(|l| l.share(d).abs()).fold(1e-12, f64::max);
            let ranges: f64 = lines.iter().map(|l| range(l.bound(d) / l.bound(Vec2::ZERO) - 1.0)).sum();
            points.push((d, -(lines.len() as f64) * share.ln() - ranges, share));
        }
    }
    let (best, share) = points.iter().fold((f64::NEG_INFINITY, 0.0), |b, p| if p.1 > b.0 { (p.1, p.2) } else { b });
    let total: f64 = points.iter().map(|p| (p.1 - best).exp()).sum();
    let weights: Vec<f64> = points.iter().map(|p| (p.1 - best).exp() / total).collect();
    let mean = points.iter().zip(&weights).fold(Vec2::ZERO, |sum, (p, w)| sum + p.0 * *w);
    // A cell's own spread keeps the grid from closing on one point.
    let cell = spacing * spacing / 12.0;
    let square = |a: Vec2, w: f64| [w * a.x * a.x, w * a.x * a.y, w * a.y * a.y];
    let add = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let floor = add(square(root[0], cell), square(root[1], cell));
    let covariance = points.iter().zip(&weights).fold(floor, |sum, (p, w)| add(sum, square(p.0 - mean, *w)));
    Posterior { mean, covariance, best, share }
}

/// How far the point moves by one standard deviation of the relative error that all readings may share (m).
///
/// At least the square of the relative bound: by so much errors that are centred on the moment differ from those that are centred
/// in the bound.
fn common(lines: &[LinearReading], [xx, xy, yy]: [f64; 3], share: f64) -> Vec2 {
    let std = |l: &LinearReading| l.bound(Vec2::ZERO) / 3f64.sqrt();
    let gradient = lines.iter().fold(Vec2::ZERO, |sum, l| sum + l.slope * (l.moment(Vec2::ZERO) / std(l).powi(2)));
    let relative = lines.iter().map(|l| l.relative).sum::<f64>() / lines.len() as f64;
    let size = ((1.0 - share).max(0.0) / 3f64.sqrt()).max(relative) * relative;
    Vec2::new(xx * gradient.x + xy * gradient.y, xy * gradient.x + yy * gradient.y) * size
}
