//! The one point that explains many readings, of one whisker over time or of several at once.

use super::meeting::{MeetingKind, meetings};
use super::reading::{ContactReading, SideReading};
use crate::Stop;
use crate::beam::{Load, Whisker, moment_mode};
use crate::least_squares::{Normal, Rules, descend, unbounded};
use crate::linear_algebra::Cholesky;
use crate::plane::{Pose2, Vec2};

/// Arc lengths on the strongest reading's curve from which a search starts, as shares of the whisker.
const STARTS: [f64; 7] = [0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.99];
/// Two answers nearer than this are one (m).
const SAME: f64 = 2e-5;
/// How many standard deviations a sum of squares may be above its mean: 1 in 4300 is.
const CHANCE: f64 = 3.5;
/// Rounds of new weights.
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
    /// Whether the residuals are as large as the errors explain, but for a chance of 1 in 4300.
    ///
    /// The bound is Wilson's and Hilferty's: the cube root of a sum of squares is all but normal for few readings as well, where the
    /// sum itself is not.
    #[must_use]
    pub fn fits(&self) -> bool {
        let freedom = self.freedom.max(1) as f64;
        let variance = 2.0 / (9.0 * freedom);
        self.chi2 <= freedom * (1.0 - variance + CHANCE * variance.sqrt()).powi(3)
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
    fixed_points_until(readings, &Stop::default())
}

/// As [`fixed_points`]; what is found once the end is asked for is no answer.
pub(super) fn fixed_points_until(readings: &[ContactReading], stop: &Stop) -> Vec<FixedPoint> {
    let [first, .., last] = readings else { return Vec::new() };
    if readings.iter().any(|reading| !reading.whisker.is_uniform()) {
        return by_uniform(readings, stop);
    }
    let mut starts: Vec<Vec2> = meetings(first, last)
        .into_iter()
        .filter(|meeting| meeting.kind == MeetingKind::Contact)
        .map(|meeting| meeting.position)
        .collect();
    let strongest = readings.iter().max_by(|a, b| a.moment.abs().total_cmp(&b.moment.abs())).unwrap_or(first);
    starts.extend(curve(strongest));
    distinct(readings, starts, stop)
}

/// For whiskers that are integrated: from where uniform ones of the same stiffness at the base would be touched.
fn by_uniform(readings: &[ContactReading], stop: &Stop) -> Vec<FixedPoint> {
    let plain = |r: &ContactReading| {
        let (length, flexural_rigidity) = (r.whisker.length, r.whisker.flexural_rigidity);
        ContactReading { whisker: Whisker { length, flexural_rigidity, ..Whisker::default() }, ..*r }
    };
    let uniform: Vec<ContactReading> = readings.iter().map(plain).collect();
    let starts = fixed_points_until(&uniform, stop).into_iter().take(2).map(|point| point.position).collect();
    distinct(readings, starts, stop)
}

/// Where the search ends from each start, each place once, the best first.
fn distinct(readings: &[ContactReading], starts: Vec<Vec2>, stop: &Stop) -> Vec<FixedPoint> {
    let mut found: Vec<FixedPoint> = Vec::new();
    for start in starts {
        let Some(point) = fixed_point_until(readings, None, start, stop) else { continue };
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

/// What is known of a contact beside its readings: it was on the straight whisker when it began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The base at that instant, odometry frame.
    pub odom_from_whisker: Pose2,
    /// Standard deviation of the contact across the straight whisker then (m), positive.
    pub std: f64,
}

impl Touch {
    /// How far off the straight whisker a point is, in standard deviations.
    pub(super) fn residual(&self, point: Vec2) -> f64 {
        self.odom_from_whisker.inverse_transform_point(point).y / self.std
    }

    /// How that changes with the point.
    fn slope(&self) -> Vec2 {
        Vec2::from_angle(self.odom_from_whisker.theta).perp() * (1.0 / self.std)
    }
}

/// Rounds around one set of weights, and a gain that is none.
const RULES: Rules = Rules { rounds: 40, gain: 1e-9, damping: 1e-4 };

/// The fixed point next to `start` (odometry frame, m); none where no shape reaches it or nothing was read.
#[must_use]
pub fn fixed_point(readings: &[ContactReading], start: Vec2) -> Option<FixedPoint> {
    fixed_point_since(readings, None, start)
}

/// As [`fixed_point`], where it is known when the contact began.
///
/// Without it, where the touch was has to be told from the first readings, which are weak: over short ways it is worth more
/// than they are.
#[must_use]
pub fn fixed_point_since(readings: &[ContactReading], touch: Option<Touch>, start: Vec2) -> Option<FixedPoint> {
    fixed_point_until(readings, touch, start, &Stop::default())
}

/// As [`fixed_point_since`]; none once the end is asked for.
pub(super) fn fixed_point_until(
    readings: &[ContactReading],
    touch: Option<Touch>,
    start: Vec2,
    stop: &Stop,
) -> Option<FixedPoint> {
    let going_on = || (!stop.is_asked()).then_some(());
    let each = |shape: &dyn Fn(usize) -> Option<SideReading>| {
        (0..readings.len()).map(|k| going_on().and_then(|()| shape(k))).collect::<Option<Vec<SideReading>>>()
    };
    let (mut point, mut touched) = (start, Vec::<SideReading>::new());
    let (mut cost, mut square) = (0.0, [0.0; 3]);
    for _ in 0..WEIGHTINGS {
        // Of all shapes the nearest to each reading; then those are followed.
        touched = nearest_shapes(readings, point, &touched, stop)?;
        // The error belongs to the true moment: weights by the readings themselves would favour those that read low.
        let std: Vec<f64> = readings.iter().zip(&touched).map(|(r, t)| r.std(t.moment)).collect();
        let problem = WeightedProblem { readings, touch, std: &std, stop };
        let evaluate = |x: &[f64]| {
            let point = Vec2::new(x[0], x[1]);
            let found = each(&|k| readings[k].touched_from(point, &touched[k]))?;
            let cost = problem.cost(point, &found);
            Some((found, cost))
        };
        let normal = |x: &[f64], touched: &Vec<SideReading>| problem.normal(Vec2::new(x[0], x[1]), touched);
        let end = descend(vec![point.x, point.y], RULES, evaluate, normal, unbounded)?;
        point = Vec2::new(end.unknowns[0], end.unknowns[1]);
        (touched, cost) = (end.state, 2.0 * end.cost);
        square = problem.square(point, &touched)?;
    }
    Some(FixedPoint {
        position: point,
        covariance: covariance(square),
        chi2: cost,
        freedom: (readings.len() + usize::from(touch.is_some())).saturating_sub(2),
        s_a: [touched.first()?.s_a, touched.last()?.s_a],
    })
}

/// For each reading the shape that touches the point and is nearest to it, looked for beside the one that it had `before`, or the same whisker
/// at the reading before.
fn nearest_shapes(
    readings: &[ContactReading],
    point: Vec2,
    before: &[SideReading],
    stop: &Stop,
) -> Option<Vec<SideReading>> {
    let mut found: Vec<SideReading> = Vec::with_capacity(readings.len());
    for (k, reading) in readings.iter().enumerate() {
        if stop.is_asked() {
            return None;
        }
        let last = found.last().filter(|_| readings[k - 1].whisker == reading.whisker);
        let shape = match before.get(k).or(last) {
            Some(near) => reading.touched_beside(point, near),
            None => reading.touched(point),
        };
        found.push(shape?);
    }
    Some(found)
}

/// One set of weights.
struct WeightedProblem<'a> {
    readings: &'a [ContactReading],
    touch: Option<Touch>,
    std: &'a [f64],
    stop: &'a Stop,
}

impl WeightedProblem<'_> {
    /// Half the sum of the squares.
    fn cost(&self, point: Vec2, touched: &[SideReading]) -> f64 {
        let each = self.readings.iter().zip(touched).zip(self.std);
        let sum: f64 = each.map(|((r, t), s)| ((t.moment - r.moment) / s).powi(2)).sum();
        0.5 * (sum + self.touch.map_or(0.0, |touch| touch.residual(point).powi(2)))
    }

    /// The Jacobian, row by row.
    fn jacobian(&self, point: Vec2, touched: &[SideReading]) -> Option<Vec<Vec<f64>>> {
        let row = |((reading, at), s): ((&ContactReading, &SideReading), &f64)| {
            let slope = if self.stop.is_asked() { None } else { slope(reading, point, at) };
            slope.map(|d| vec![d.x / s, d.y / s])
        };
        let mut rows = self.readings.iter().zip(touched).zip(self.std).map(row).collect::<Option<Vec<_>>>()?;
        rows.extend(self.touch.map(|touch| vec![touch.slope().x, touch.slope().y]));
        Some(rows)
    }

    fn normal(&self, point: Vec2, touched: &[SideReading]) -> Option<Normal> {
        let each = self.readings.iter().zip(touched).zip(self.std);
        let mut residuals: Vec<f64> = each.map(|((r, t), s)| (t.moment - r.moment) / s).collect();
        residuals.extend(self.touch.map(|touch| touch.residual(point)));
        Some(Normal::of_rows(2, &self.jacobian(point, touched)?, &residuals))
    }

    /// The normal matrix: xx, xy, yy.
    fn square(&self, point: Vec2, touched: &[SideReading]) -> Option<[f64; 3]> {
        let add = |sum: [f64; 3], d: &Vec<f64>| [sum[0] + d[0] * d[0], sum[1] + d[0] * d[1], sum[2] + d[1] * d[1]];
        Some(self.jacobian(point, touched)?.iter().fold([0.0; 3], add))
    }
}

/// How the moment changes with the point (N m / m), where the side contact there is this.
pub(super) fn slope(reading: &ContactReading, point: Vec2, at: &SideReading) -> Option<Vec2> {
    let step = 1e-7;
    let moment = |point: Vec2| reading.touched_from(point, at).map(|near| near.moment);
    let by = |d: Vec2| Some((moment(point + d)? - moment(point - d)?) / (2.0 * step));
    Some(Vec2::new(by(Vec2::new(step, 0.0))?, by(Vec2::new(0.0, step))?))
}

/// The inverse of a normal matrix; infinite where the readings do not fix the point.
fn covariance([xx, xy, yy]: [f64; 3]) -> [f64; 3] {
    let inverse = Cholesky::new(&[[xx, xy], [xy, yy]]).map(|factor| factor.inverse());
    inverse.map_or([f64::INFINITY, 0.0, f64::INFINITY], |[[xx, xy], [_, yy]]| [xx, xy, yy])
}
