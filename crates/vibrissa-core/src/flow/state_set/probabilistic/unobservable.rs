//! The unobservable direction of a place as a curve, traced by predictor and corrector \[allgower2003introduction, ch. 2\]:
//! states that fit equally well where the readings leave one direction open.
//!
//! From the best hypothesis the curve is walked both ways along the direction of least curvature. Each vertex is a fit
//! of its own: Gauss-Newton steps over the whole history, across the curve only.

use super::admission::Admits;
use super::information::Information;
use super::optimisation::{Mode, Rerun};
use super::state::{difference, moved};
use crate::linear_algebra::{Cholesky, Square, dot, inverse, times};
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
const MOST_VERTICES: usize = 1000;
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
    pub(super) rerun: &'a Rerun<'a>,
    pub(super) metric: Metric,
    pub(super) admits: &'a Admits<'a>,
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
    Fits(Box<Mode>, f64),
    Bent,
    PieceStarts,
}

impl CurveTracer<'_> {
    /// The curve of a place, its hypotheses the best first, each with its covariance about the pivot: poses of the odometry
    /// frame in order; none where it is not long. A place on the curve of another carries that one on.
    pub(super) async fn trace(&mut self, members: &[(&Mode, &Square<3>)]) -> Vec<Pose2> {
        let Some((first, _)) = members.first().filter(|_| self.is_long(members)) else { return Vec::new() };
        let known = self.known.iter().find(|line| self.metric.lies_on(line, first.state.frame));
        let mut line = known.cloned().unwrap_or_default();
        let most = first.cost(self.rerun.model) + REGION;
        for (h, _) in members {
            if h.cost(self.rerun.model) > most || self.metric.lies_on(&line, h.state.frame) {
                continue;
            }
            let more = self.walk(h, most, &line).await;
            line = self.metric.joined(line, more);
        }
        if self.metric.length(&line) < LONG {
            return Vec::new();
        }
        self.known.push(line.clone());
        line
    }

    /// Whether the region of a place, or the way from its best hypothesis to another, is long.
    fn is_long(&self, members: &[(&Mode, &Square<3>)]) -> bool {
        let long = |(h, own): &(&Mode, &Square<3>)| {
            let Some(along) = self.metric.direction(&h.marginal(self.rerun.model), None) else { return false };
            let by = self.metric.scaled(along);
            let apart = self.metric.distance(members[0].0.state.frame, h.state.frame);
            apart + 2.0 * HALF_WIDTH * dot(times(own, by), by).max(0.0).sqrt() >= LONG
        };
        members.iter().any(long)
    }

    /// The curve through a hypothesis, up to the curve so far.
    async fn walk(&mut self, h: &Mode, most: f64, known: &[Pose2]) -> Vec<Pose2> {
        let room = MOST_VERTICES.saturating_sub(known.len());
        if room == 0 || self.left < self.rerun.rows.len() || !(self.admits)(h.state.frame) {
            return Vec::new();
        }
        let mut start = h.clone();
        if !self.run(&mut start, h.state.frame, most).await || start.cost(self.rerun.model) > most {
            return Vec::new();
        }
        let Some(along) = self.metric.direction(&start.marginal(self.rerun.model), None) else {
            return Vec::new();
        };
        let (mut line, closed) = self.trace_one_way(&start, along.map(|v| -v), most, known, (room - 1) / 2).await;
        line.reverse();
        line.push(start.state.frame);
        if closed {
            return line;
        }
        let (more, closed) = self.trace_one_way(&start, along, most, known, room - line.len()).await;
        if closed {
            line.drain(..line.len() - 1);
        }
        line.extend(more);
        line
    }

    /// The vertices from a hypothesis on in one direction, and whether they come back to it.
    async fn trace_one_way(
        &mut self,
        start: &Mode,
        mut along: [f64; 3],
        most: f64,
        known: &[Pose2],
        vertices: usize,
    ) -> (Vec<Pose2>, bool) {
        let mut at = start.clone();
        let (mut gone, mut bend) = (0.0, [0.0; 3]);
        // The way from the vertex before.
        let mut came = along;
        let mut line = Vec::new();
        let mut step = FIRST_STEP;
        // How far it is to where a step has failed.
        let mut failed: Option<f64> = None;
        while line.len() < vertices && self.left >= self.rerun.rows.len() {
            let length = match failed {
                Some(rest) if rest > END => step.min(0.5 * rest),
                Some(rest) => rest,
                None => step,
            };
            let toward = unit([0, 1, 2].map(|i| along[i] + 0.5 * length * bend[i]));
            match self.step(&at, toward, length, most).await {
                TraceStep::Fits(next, aside) => {
                    if self.metric.lies_on(known, next.state.frame) {
                        break;
                    }
                    gone += length;
                    if gone > LONG && self.metric.distance(next.state.frame, start.state.frame) <= length {
                        line.push(start.state.frame);
                        return (line, true);
                    }
                    failed = failed.map(|rest| rest - length).filter(|&rest| rest > 0.0);
                    came = unit(self.metric.scaled(self.metric.between(at.state.frame, next.state.frame)));
                    at = *next;
                    line.push(at.state.frame);
                    let ahead = self.metric.direction(&at.marginal(self.rerun.model), Some(along));
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
    async fn step(&mut self, from: &Mode, along: [f64; 3], length: f64, most: f64) -> TraceStep {
        let to = |d: [f64; 3]| moved(from.state.frame, self.rerun.model.pivot(), d);
        let mut end = along.map(|v| v * length);
        let mut next = from.clone();
        let mut frame = to(self.metric.unscaled(end));
        for round in 0..=ROUNDS {
            if !self.run(&mut next, frame, most).await {
                return TraceStep::PieceStarts;
            }
            let (gain, across) = self.metric.across(&next.marginal(self.rerun.model), along);
            if round == ROUNDS || gain < SETTLED {
                break;
            }
            end = [0, 1, 2].map(|i| end[i] + across[i]);
            if aside(end, along, length) > ASIDE {
                return TraceStep::Bent;
            }
            frame = to(self.metric.unscaled(end));
        }
        let stays = next.cost(self.rerun.model) <= most && (self.admits)(frame);
        if stays { TraceStep::Fits(Box::new(next), aside(end, along, length)) } else { TraceStep::PieceStarts }
    }

    /// Runs a mode at a frame; whether it costs no more than one that is to be fitted may.
    async fn run(&mut self, h: &mut Mode, frame: Pose2, most: f64) -> bool {
        self.left = self.left.saturating_sub(self.rerun.rows.len());
        *h = self.rerun.at(h, frame).await;
        h.cost(self.rerun.model) <= most + UNFITTED
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
    pub(super) fn direction(&self, told: &Information<3>, before: Option<[f64; 3]>) -> Option<[f64; 3]> {
        let mut curvature = self.metric(&told.matrix);
        let largest = (0..3).map(|i| curvature[i][i]).fold(0.0, f64::max);
        (0..3).for_each(|i| curvature[i][i] += STIFF * largest);
        let open = inverse(&curvature)?;
        let widest = (0..3).max_by(|&i, &j| open[i][i].total_cmp(&open[j][j]))?;
        let found = (0..POWERS).fold(before.unwrap_or(open[widest]), |v, _| unit(times(&open, v)));
        found.iter().all(|v| v.is_finite()).then_some(found)
    }

    /// A curvature over moves as one over vectors of the metric.
    fn metric(&self, curvature: &Square<3>) -> Square<3> {
        let mut out = curvature.map(|row| self.unscaled(row));
        out[2] = out[2].map(|v| v / self.lever);
        out
    }

    /// A move as a vector of the metric.
    fn scaled(&self, d: [f64; 3]) -> [f64; 3] {
        [d[0], d[1], d[2] * self.lever]
    }

    /// The reverse; gradients go the same way.
    pub(super) fn unscaled(&self, u: [f64; 3]) -> [f64; 3] {
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
