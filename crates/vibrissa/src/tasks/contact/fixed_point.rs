//! The one point that explains many readings, of one whisker over time or of several at once.

use super::meeting::{MeetingKind, meetings};
use super::reading::{ContactReading, Touched};
use crate::beam::{Load, Whisker, moment_mode};
use crate::plane::Vec2;

/// Arc lengths on the strongest reading's curve from which a search starts, as shares of the whisker.
const STARTS: [f64; 7] = [0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.99];
/// Two answers nearer than this are one (m).
const SAME: f64 = 2e-5;
/// Rounds of Levenberg and Marquardt, and rounds of new weights around them.
const ROUNDS: usize = 40;
const WEIGHTINGS: usize = 3;

/// A contact that stood still, by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedPoint {
    /// Where, odometry frame (m).
    pub position: Vec2,
    /// Covariance of the position: xx, xy, yy (m²); infinite where the readings leave a direction open.
    pub covariance: [f64; 3],
    /// Sum of the squared residuals, each in standard deviations.
    pub chi2: f64,
    /// Readings less unknowns.
    pub freedom: usize,
    /// Arc length of the contact at the first and at the last reading (m); beyond the whisker when it is too short.
    pub s_a: [f64; 2],
}

impl FixedPoint {
    /// Whether the residuals are as large as the errors explain, at four standard deviations of their sum.
    #[must_use]
    pub fn fits(&self) -> bool {
        let freedom = self.freedom.max(1) as f64;
        self.chi2 <= freedom + 4.0 * (2.0 * freedom).sqrt()
    }

    /// Standard deviation of the position along a unit vector of the odometry frame (m).
    #[must_use]
    pub fn std_along(&self, direction: Vec2) -> f64 {
        let [xx, xy, yy] = self.covariance;
        let Vec2 { x, y } = direction;
        (xx * x * x + 2.0 * xy * x * y + yy * y * y).max(0.0).sqrt()
    }
}

/// Every fixed point that explains the readings better than its neighbours do, the best first.
///
/// Readings of several whiskers may be mixed: this is temporal and spatial filtering at once. Empty with less than two
/// readings and where no shape reaches.
#[must_use]
pub fn fixed_points(readings: &[ContactReading]) -> Vec<FixedPoint> {
    let [first, .., last] = readings else { return Vec::new() };
    if readings.iter().any(|reading| !reading.whisker.is_uniform()) {
        return by_uniform(readings);
    }
    let mut starts: Vec<Vec2> = meetings(first, last)
        .into_iter()
        .filter(|meeting| meeting.kind == MeetingKind::Contact)
        .map(|meeting| meeting.position)
        .collect();
    let strongest = readings.iter().max_by(|a, b| a.moment.abs().total_cmp(&b.moment.abs())).unwrap_or(first);
    starts.extend(curve(strongest));
    distinct(readings, starts)
}

/// For whiskers that are integrated: from where uniform ones of the same stiffness at the base would be touched.
fn by_uniform(readings: &[ContactReading]) -> Vec<FixedPoint> {
    let plain = |r: &ContactReading| {
        let (length, flexural_rigidity) = (r.whisker.length, r.whisker.flexural_rigidity);
        ContactReading { whisker: Whisker { length, flexural_rigidity, ..Whisker::default() }, ..*r }
    };
    let uniform: Vec<ContactReading> = readings.iter().map(plain).collect();
    distinct(readings, fixed_points(&uniform).into_iter().take(2).map(|point| point.position).collect())
}

/// Where the search ends from each start, each place once, the best first.
fn distinct(readings: &[ContactReading], starts: Vec<Vec2>) -> Vec<FixedPoint> {
    let mut found: Vec<FixedPoint> = Vec::new();
    for start in starts {
        let Some(point) = fixed_point(readings, start) else { continue };
        if found.iter().all(|other| other.position.distance(point.position) > SAME) {
            found.push(point);
        }
    }
    found.sort_by(|a, b| a.chi2.total_cmp(&b.chi2));
    found
}

fn curve(reading: &ContactReading) -> Vec<Vec2> {
    let bends = |share: f64| {
        let s_a = share * reading.whisker.length;
        moment_mode(&reading.whisker, reading.moment, s_a, Load::Normal).unwrap_or_default()
    };
    let place = |contact: Vec2| reading.odom_from_whisker.transform_point(contact);
    STARTS.into_iter().flat_map(bends).map(|bend| place(bend.contact)).collect()
}

/// What the readings would be, and how that changes with the point.
struct Linear {
    touched: Vec<Touched>,
    slopes: Vec<Vec2>,
}

/// The fixed point next to `start` (odometry frame, m); none where no shape reaches it or nothing was read.
#[must_use]
pub fn fixed_point(readings: &[ContactReading], start: Vec2) -> Option<FixedPoint> {
    let all = |point: Vec2| readings.iter().map(|r| r.touched(point)).collect::<Option<Vec<Touched>>>();
    let cost = |touched: &[Touched], std: &[f64]| -> f64 {
        readings.iter().zip(touched).zip(std).map(|((r, t), s)| ((t.moment - r.moment) / s).powi(2)).sum()
    };
    let (mut point, mut touched) = (start, all(start)?);
    let mut std = Vec::new();
    for _ in 0..WEIGHTINGS {
        // The error belongs to the true moment: weights by the readings themselves would favour those that read low.
        std = readings.iter().zip(&touched).map(|(r, t)| r.std(t.moment)).collect();
        let (mut now, mut damping) = (cost(&touched, &std), 1e-4);
        for _ in 0..ROUNDS {
            let (square, gradient) = normal(readings, &linear(readings, point, &touched)?, &std);
            let step = solve(square, gradient, damping)?;
            let Some(moved) = all(point - step) else {
                damping *= 10.0;
                continue;
            };
            let new = cost(&moved, &std);
            if new > now {
                damping *= 10.0;
                if damping > 1e12 {
                    break;
                }
                continue;
            }
            (point, touched, damping) = (point - step, moved, damping * 0.1);
            let gain = now - new;
            now = new;
            if gain <= 1e-9 * now || step.norm() < 1e-12 {
                break;
            }
        }
    }
    let (square, _) = normal(readings, &linear(readings, point, &touched)?, &std);
    Some(FixedPoint {
        position: point,
        covariance: inverse(square),
        chi2: cost(&touched, &std),
        freedom: readings.len().saturating_sub(2),
        s_a: [touched.first()?.s_a, touched.last()?.s_a],
    })
}

fn linear(readings: &[ContactReading], point: Vec2, touched: &[Touched]) -> Option<Linear> {
    let step = 1e-7;
    let slope = |reading: &ContactReading| {
        let by =
            |d: Vec2| Some((reading.touched(point + d)?.moment - reading.touched(point - d)?.moment) / (2.0 * step));
        Some(Vec2::new(by(Vec2::new(step, 0.0))?, by(Vec2::new(0.0, step))?))
    };
    let slopes = readings.iter().map(slope).collect::<Option<Vec<Vec2>>>()?;
    Some(Linear { touched: touched.to_vec(), slopes })
}

/// The normal matrix (xx, xy, yy) and the gradient.
fn normal(readings: &[ContactReading], linear: &Linear, std: &[f64]) -> ([f64; 3], Vec2) {
    let (mut square, mut gradient) = ([0.0; 3], Vec2::ZERO);
    for (((reading, touched), slope), s) in readings.iter().zip(&linear.touched).zip(&linear.slopes).zip(std) {
        let (d, residual) = (*slope * (1.0 / s), (touched.moment - reading.moment) / s);
        square = [square[0] + d.x * d.x, square[1] + d.x * d.y, square[2] + d.y * d.y];
        gradient += d * residual;
    }
    (square, gradient)
}

fn solve([xx, xy, yy]: [f64; 3], gradient: Vec2, damping: f64) -> Option<Vec2> {
    let (xx, yy) = (xx * (1.0 + damping), yy * (1.0 + damping));
    let det = xx * yy - xy * xy;
    (det > 0.0).then(|| Vec2::new(yy * gradient.x - xy * gradient.y, xx * gradient.y - xy * gradient.x) * (1.0 / det))
}

fn inverse([xx, xy, yy]: [f64; 3]) -> [f64; 3] {
    let det = xx * yy - xy * xy;
    if det > 0.0 { [yy / det, -xy / det, xx / det] } else { [f64::INFINITY, 0.0, f64::INFINITY] }
}
