//! The unobservable direction of a place as a curve, traced by predictor and corrector \[allgower2003introduction, ch. 2\]:
//! states that fit equally well where the readings leave one direction open.
//!
//! From the best hypothesis the curve is walked both ways along the direction of least curvature. Each vertex is a fit
//! of its own: Gauss-Newton steps over the whole history, across the curve only.

use super::hypothesis::{CostLimits, GaussianHypothesis, MeasurementModel, difference, moved};
use super::information::Information;
use super::odometry_calibration::Matrix;
use crate::linear_algebra::{Cholesky, dot, inverse, times};
use crate::plane::{Pose2, Vec2};

/// A place shorter than this (m) has no curve.
const LONG: f64 = 4e-3;
/// Half the width of the region that holds 95 % of a Gaussian in three dimensions (standard deviations), and what its border
/// costs more than its middle (nats).
const HALF_WIDTH: f64 = 2.795;
const REGION: f64 = 3.907;
/// The first step, the longest, and how exactly the ends are found (m).
const FIRST_STEP: f64 = 1e-3;
const LONGEST_STEP: f64 = 25e-3;
const END: f64 = 0.5e-3;
/// Rounds of fitting a vertex, the gain (nats) below which it is done, and what it may cost before (nats).
const ROUNDS: usize = 3;
const SETTLED: f64 = 0.02;
const UNFITTED: f64 = 20.0;
/// A vertex further aside than this (m) from where its step went is one of too long a step; one nearer than the other makes
/// the next one longer.
const ASIDE: f64 = 0.5e-3;
const STRAIGHT: f64 = 0.2e-3;
/// The line between two vertices is to be no further from the curve than this (m): a quarter of it makes the next step longer.
const ARCH: f64 = 0.2e-3;
/// What lies so near to the curve (m, rad) is on it.
const ON: [f64; 2] = [1e-3, 8.7e-3];
/// Most vertices of a curve.
const MOST_VERTICES: usize = 400;
/// Inverse variance that keeps a fit across the curve finite (5 mm), and the share of the largest curvature that keeps the
/// search for the least one so.
const DAMPING: f64 = 4e4;
const STIFF: f64 = 1e-8;
/// Directions whose unit vectors have a larger product are one.
const STRAIGHT_ON: f64 = 0.9999;
/// Rounds of that search.
const POWERS: usize = 24;

/// Walks along the curves of one answer's places.
pub(super) struct CurveTracer<'a> {
    pub(super) model: &'a MeasurementModel<'a>,
    pub(super) rows: &'a [usize],
    pub(super) metric: Metric,
    pub(super) admits: &'a dyn Fn(Pose2) -> bool,
    /// Readings that may still be run.
    pub(super) left: usize,
    /// The curves so far.
    pub(super) known: Vec<Vec<Pose2>>,
}

/// What makes shifts and turns comparable: a move about the pivot as a vector, its turn as a length.
#[derive(Clone, Copy)]
pub(super) struct Metric {
    pub(super) pivot: Vec2,
    /// The length that a turn by one radian counts for (m).
    pub(super) lever: f64,
}

/// What a step has come to.
enum TraceStep {
    /// A vertex, and how far aside of the step's end (m).
    Fits(Box<GaussianHypothesis>, f64),
    Bent,
    PieceStarts,
}

/// What limits one curve.
struct TraceLimits {
    /// What the best hypothesis costs after each row.
    reference_costs: Vec<f64>,
    /// The most that a vertex may cost (nats).
    most: f64,
}

impl CurveTracer<'_> {
    /// The curve of a place, its hypotheses the best first, each with its covariance about the pivot: poses of the odometry
    /// frame in order; none where it is not long. A place on the curve of another carries that one on.
    pub(super) fn trace(&mut self, members: &[(&GaussianHypothesis, &Matrix)]) -> Vec<Pose2> {
        let Some((first, _)) = members.first().filter(|_| self.is_long(members)) else { return Vec::new() };
        let known = self.known.iter().find(|line| self.metric.lies_on(line, first.map_from_odom));
        let mut line = known.cloned().unwrap_or_default();
        let mut border = TraceLimits { reference_costs: Vec::new(), most: first.cost(self.model.shared) + REGION };
        for (h, _) in members {
            if h.cost(self.model.shared) > border.most || self.metric.lies_on(&line, h.map_from_odom) {
                continue;
            }
            if border.reference_costs.is_empty() {
                border.reference_costs = self.costs(first);
            }
            let more = self.walk(h, &border, &line);
            line = self.metric.joined(line, more);
        }
        if self.metric.length(&line) < LONG {
            return Vec::new();
        }
        self.known.push(line.clone());
        line
    }

    /// What the best hypothesis of a place costs after each row.
    fn costs(&mut self, first: &GaussianHypothesis) -> Vec<f64> {
        self.left = self.left.saturating_sub(self.rows.len());
        first.costs(self.model, self.rows)
    }

    /// Whether the region of a place, or the way from its best hypothesis to another, is long.
    fn is_long(&self, members: &[(&GaussianHypothesis, &Matrix)]) -> bool {
        let long = |(h, own): &(&GaussianHypothesis, &Matrix)| {
            let Some(along) = self.metric.direction(&h.marginal(self.model.shared), None) else { return false };
            let by = self.metric.scaled(along);
            let apart = self.metric.distance(members[0].0.map_from_odom, h.map_from_odom);
            apart + 2.0 * HALF_WIDTH * dot(times(own, by), by).max(0.0).sqrt() >= LONG
        };
        members.iter().any(long)
    }

    /// The curve through a hypothesis, up to the curve so far.
    fn walk(&mut self, h: &GaussianHypothesis, border: &TraceLimits, known: &[Pose2]) -> Vec<Pose2> {
        let room = MOST_VERTICES.saturating_sub(known.len());
        if room == 0 || self.left < self.rows.len() || !(self.admits)(h.map_from_odom) {
            return Vec::new();
        }
        let mut start = h.clone();
        if !self.run(&mut start, h.map_from_odom, border) || start.cost(self.model.shared) > border.most {
            return Vec::new();
        }
        let Some(along) = self.metric.direction(&start.marginal(self.model.shared), None) else {
            return Vec::new();
        };
        let (mut line, closed) = self.trace_one_way(&start, along.map(|v| -v), border, known, (room - 1) / 2);
        line.reverse();
        line.push(start.map_from_odom);
        if closed {
            return line;
        }
        let (more, closed) = self.trace_one_way(&start, along, border, known, room - line.len());
        if closed {
            line.drain(..line.len() - 1);
        }
        line.extend(more);
        line
    }

    /// The vertices from a hypothesis on in one direction, and whether they come back to it.
    fn trace_one_way(
        &mut self,
        start: &GaussianHypothesis,
        mut along: [f64; 3],
        border: &TraceLimits,
        known: &[Pose2],
        most: usize,
    ) -> (Vec<Pose2>, bool) {
        let mut at = start.clone();
        let (mut gone, mut bend) = (0.0, [0.0; 3]);
        // The way from the vertex before.
        let mut came = along;
        let mut line = Vec::new();
        let mut step = FIRST_STEP;
        // How far it is to where a step has failed.
        let mut failed: Option<f64> = None;
        while line.len() < most && self.left >= self.rows.len() {
            let length = match failed {
                Some(rest) if rest > END => step.min(0.5 * rest),
                Some(rest) => rest,
                None => step,
            };
            let toward = unit([0, 1, 2].map(|i| along[i] + 0.5 * length * bend[i]));
            match self.step(&at, toward, length, border) {
                TraceStep::Fits(next, aside) => {
                    if self.metric.lies_on(known, next.map_from_odom) {
                        break;
                    }
                    gone += length;
                    if gone > LONG && self.metric.distance(next.map_from_odom, start.map_from_odom) <= length {
                        line.push(start.map_from_odom);
                        return (line, true);
                    }
                    failed = failed.map(|rest| rest - length).filter(|&rest| rest > 0.0);
                    came = unit(self.metric.scaled(self.metric.between(at.map_from_odom, next.map_from_odom)));
                    at = *next;
                    line.push(at.map_from_odom);
                    let ahead = self.metric.direction(&at.marginal(self.model.shared), Some(along));
                    let Some(ahead) = ahead else { break };
                    let turned = [0, 1, 2].map(|i| ahead[i] - along[i]);
                    // Over less than a facet of the map a turn says nothing.
                    bend = if length < FIRST_STEP { [0.0; 3] } else { turned.map(|v| v / length) };
                    along = ahead;
                    let arch = 0.125 * norm(turned) * length;
                    if arch > ARCH {
                        step = 0.5 * length;
                    } else if aside < STRAIGHT && arch < 0.25 * ARCH {
                        step = (2.0 * length).min(LONGEST_STEP);
                    }
                }
                TraceStep::Bent if length > END => (step, bend) = (0.5 * length, [0.0; 3]),
                TraceStep::PieceStarts if length > END => (failed, bend) = (Some(length), [0.0; 3]),
                // On a map of facets one vertex may not tell the direction.
                TraceStep::Bent | TraceStep::PieceStarts if dot(along, came) < STRAIGHT_ON => {
                    (along, step, failed) = (came, FIRST_STEP, None);
                }
                TraceStep::Bent | TraceStep::PieceStarts => break,
            }
        }
        (line, false)
    }

    /// A step along a direction and the fit across it.
    fn step(&mut self, from: &GaussianHypothesis, along: [f64; 3], length: f64, border: &TraceLimits) -> TraceStep {
        let to = |d: [f64; 3]| moved(from.map_from_odom, self.model.pivot, d);
        let mut end = along.map(|v| v * length);
        let mut next = from.clone();
        let mut frame = to(self.metric.unscaled(end));
        for round in 0..=ROUNDS {
            if !self.run(&mut next, frame, border) {
                return TraceStep::PieceStarts;
            }
            let (gain, across) = self.metric.across(&next.marginal(self.model.shared), along);
            if round == ROUNDS || gain < SETTLED {
                break;
            }
            end = [0, 1, 2].map(|i| end[i] + across[i]);
            if aside(end, along, length) > ASIDE {
                return TraceStep::Bent;
            }
            frame = to(self.metric.unscaled(end));
        }
        let stays = next.cost(self.model.shared) <= border.most && (self.admits)(frame);
        if stays { TraceStep::Fits(Box::new(next), aside(end, along, length)) } else { TraceStep::PieceStarts }
    }

    /// Runs a hypothesis at a frame; whether it costs no more than one that is to be fitted may.
    fn run(&mut self, h: &mut GaussianHypothesis, frame: Pose2, border: &TraceLimits) -> bool {
        let limits = CostLimits { reference_costs: &border.reference_costs, more: REGION + UNFITTED };
        let below = h.relinearise_below(self.model, frame, self.rows, limits);
        self.left = self.left.saturating_sub(self.rows.partition_point(|&row| row <= h.row));
        below
    }
}

impl Metric {
    /// The step to the least cost across a direction, as a vector of the metric, and what it gains (nats).
    fn across(&self, told: &Information<3>, along: [f64; 3]) -> (f64, [f64; 3]) {
        let curvature = self.metric(&told.matrix);
        let vector = self.unscaled(told.vector);
        let (a, b) = square_to(along);
        let (ca, cb) = (times(&curvature, a), times(&curvature, b));
        let (ab, vector) = (dot(ca, b), [dot(vector, a), dot(vector, b)]);
        let across = Cholesky::new(&[[dot(ca, a) + DAMPING, ab], [ab, dot(cb, b) + DAMPING]]);
        let [da, db] = across.map_or([0.0; 2], |across| across.solve(&vector));
        (0.5 * dot(vector, [da, db]), [0, 1, 2].map(|i| da * a[i] + db * b[i]))
    }

    /// The direction of least curvature, on the side of the one before: a unit vector of the metric.
    fn direction(&self, told: &Information<3>, before: Option<[f64; 3]>) -> Option<[f64; 3]> {
        let mut curvature = self.metric(&told.matrix);
        let largest = (0..3).map(|i| curvature[i][i]).fold(0.0, f64::max);
        (0..3).for_each(|i| curvature[i][i] += STIFF * largest);
        let open = inverse(&curvature)?;
        let widest = (0..3).max_by(|&i, &j| open[i][i].total_cmp(&open[j][j]))?;
        let found = (0..POWERS).fold(before.unwrap_or(open[widest]), |v, _| unit(times(&open, v)));
        found.iter().all(|v| v.is_finite()).then_some(found)
    }

    /// A curvature over moves as one over vectors of the metric.
    fn metric(&self, curvature: &Matrix) -> Matrix {
        let mut out = curvature.map(|row| self.unscaled(row));
        out[2] = out[2].map(|v| v / self.lever);
        out
    }

    /// A move as a vector of the metric.
    fn scaled(&self, d: [f64; 3]) -> [f64; 3] {
        [d[0], d[1], d[2] * self.lever]
    }

    /// The reverse; gradients go the same way.
    fn unscaled(&self, u: [f64; 3]) -> [f64; 3] {
        [u[0], u[1], u[2] / self.lever]
    }

    fn between(&self, from: Pose2, to: Pose2) -> [f64; 3] {
        difference(from, to, self.pivot)
    }

    fn distance(&self, from: Pose2, to: Pose2) -> f64 {
        norm(self.scaled(self.between(from, to)))
    }

    fn length(&self, line: &[Pose2]) -> f64 {
        line.windows(2).map(|w| self.distance(w[0], w[1])).sum()
    }

    /// Whether a frame lies on a curve.
    fn lies_on(&self, line: &[Pose2], frame: Pose2) -> bool {
        let ends = line.iter().skip(1).chain(line.last());
        line.iter().zip(ends).any(|(&from, &to)| {
            let (d, way) = (self.between(from, frame), self.between(from, to));
            let (u, v) = (self.scaled(d), self.scaled(way));
            let share = (dot(u, v) / dot(v, v).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let off = [0, 1, 2].map(|i| d[i] - share * way[i]);
            off[0].hypot(off[1]) <= ON[0] && off[2].abs() <= ON[1]
        })
    }

    /// Two curves as one, put together where their ends are nearest; the longer one where these are too far apart for one step.
    fn joined(&self, mut line: Vec<Pose2>, mut more: Vec<Pose2>) -> Vec<Pose2> {
        let (Some(&a), Some(&b), Some(&c), Some(&d)) = (line.first(), line.last(), more.first(), more.last()) else {
            line.append(&mut more);
            return line;
        };
        let gap = |from: Pose2, to: Pose2| self.distance(from, to);
        let (head, tail) = (gap(a, c).min(gap(a, d)), gap(b, c).min(gap(b, d)));
        if head.min(tail) > LONGEST_STEP {
            return if self.length(&more) > self.length(&line) { more } else { line };
        }
        if head < tail {
            line.reverse();
        }
        let end = if head < tail { a } else { b };
        if gap(end, d) < gap(end, c) {
            more.reverse();
        }
        line.append(&mut more);
        line
    }
}

/// How far a move ends aside of a step.
fn aside(end: [f64; 3], along: [f64; 3], length: f64) -> f64 {
    norm([0, 1, 2].map(|i| end[i] - length * along[i]))
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    v.map(|x| x / norm(v))
}

fn norm(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// Two unit vectors square to a unit vector and to each other.
fn square_to(along: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let least = (0..3).min_by(|&i, &j| along[i].abs().total_cmp(&along[j].abs())).unwrap_or(0);
    let a: [f64; 3] = [0, 1, 2].map(|i| f64::from(u8::from(i == least)) - along[least] * along[i]);
    let a = a.map(|v| v / norm(a));
    let b = [0, 1, 2].map(|i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        along[j] * a[k] - along[k] * a[j]
    });
    (a, b)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;

    const METRIC: Metric = Metric { pivot: Vec2 { x: 0.1, y: -0.2 }, lever: 0.075 };

    /// Readings that leave one direction open: the last of these, by hand square to the others in the metric.
    fn valley() -> (Information<3>, [f64; 3]) {
        let mut told = Information::default();
        told.add(&[4e3, 0.0, 75.0], 0.3, 1.0);
        told.add(&[0.0, 3e3, 0.0], -0.2, 1.0);
        // A turn by -4e3/75 of the shift leaves both readings as they are.
        let open = [1.0, 0.0, -4e3 / 75.0 * 0.075];
        (told, open.map(|v| v / norm(open)))
    }

    #[test]
    fn the_open_direction_is_found_and_kept() {
        let (told, open) = valley();
        for sign in [1.0, -1.0] {
            let found = METRIC.direction(&told, Some([sign, 0.3, 0.0])).unwrap();
            assert!((0..3).all(|i| (found[i] - sign * open[i]).abs() < 1e-6), "{found:?} {open:?}");
        }
        assert!(dot(METRIC.direction(&told, None).unwrap(), open).abs() > 1.0 - 1e-9);
        assert!(METRIC.direction(&Information::default(), None).is_none());
    }

    #[test]
    fn a_fit_across_goes_to_the_least_cost_and_not_along() {
        let (told, open) = valley();
        let (gain, step) = METRIC.across(&told, open);
        assert!(dot(step, open).abs() < 1e-12);
        let there = told.shifted(METRIC.unscaled(step));
        let left = METRIC.unscaled(there.vector);
        // Half of each squared residual goes, but for what keeps the step finite.
        assert!((gain - 0.5 * (0.3_f64.powi(2) + 0.2_f64.powi(2))).abs() < 1e-3, "{gain}");
        assert!(norm(left) < 0.02 * norm(METRIC.unscaled(told.vector)), "{left:?}");
    }

    #[test]
    fn curves_are_put_together_end_to_end() {
        let line = |from: i32, to: i32| -> Vec<Pose2> {
            let step = (to - from).signum();
            (0..=(to - from).abs()).map(|k| Pose2::new(1e-3 * f64::from(from + step * k), 0.0, 0.0)).collect()
        };
        for (a, b) in [((0, 5), (6, 9)), ((0, 5), (9, 6)), ((5, 0), (6, 9)), ((5, 0), (9, 6))] {
            let joined = METRIC.joined(line(a.0, a.1), line(b.0, b.1));
            assert_eq!(joined.len(), 10);
            assert!((METRIC.length(&joined) - 9e-3).abs() < 1e-12, "{joined:?}");
        }
        // What lies further apart than a step goes is not one curve.
        assert_eq!(METRIC.joined(line(0, 5), line(40, 50)), line(40, 50));
        assert_eq!(METRIC.joined(line(0, 5), line(-32, -30)), line(0, 5));
        assert_eq!(METRIC.joined(Vec::new(), line(0, 3)), line(0, 3));
        assert_eq!(METRIC.joined(line(0, 3), Vec::new()), line(0, 3));
    }

    #[test]
    fn what_is_near_in_place_and_heading_lies_on_a_curve() {
        let line = [Pose2::new(0.0, 0.0, 3.1), Pose2::new(0.02, 0.0, 3.1)];
        let aside = |y: f64, turn: f64| moved(Pose2::new(0.013, 0.0, 3.1), METRIC.pivot, [0.0, y, turn]);
        assert!(METRIC.lies_on(&line, aside(0.9e-3, 0.008)) && METRIC.lies_on(&line, aside(-0.9e-3, -0.008)));
        assert!(!METRIC.lies_on(&line, aside(1.1e-3, 0.0)) && !METRIC.lies_on(&line, aside(0.0, 0.01)));
        // Headings go the shorter way.
        let over = [line[0], moved(line[0], METRIC.pivot, [0.0, 0.0, 0.2])];
        assert!(METRIC.lies_on(&over, moved(line[0], METRIC.pivot, [0.0, 0.0, 0.1])));
        assert!(!METRIC.lies_on(&[], line[0]) && METRIC.lies_on(&line[..1], line[0]));
    }
}
