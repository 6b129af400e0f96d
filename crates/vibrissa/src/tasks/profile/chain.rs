//! A line through several runs.

use super::near_points::NearPoints;
use super::run::Sample;
use crate::plane::Vec2;

/// Shortest way around before a line may close (m).
const SHORTEST_RING: f64 = 20e-3;
/// Normals that face the same way differ by less (cosine): 60 degrees.
const SAME_WAY: f64 = 0.5;
/// So many points of a run beside a line make it one with it.
const FEWEST_BESIDE: usize = 3;

/// A line of samples, and the runs that lie along it.
#[derive(Clone, Debug)]
pub(super) struct Chain {
    pub(super) line: Vec<Sample>,
    pub(super) runs: Vec<Vec<Sample>>,
    pub(super) closed: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    First,
    Last,
}

/// A line in the making, with its points by where they are.
struct Line {
    samples: Vec<Sample>,
    near: NearPoints<usize>,
    reach: f64,
    closed: bool,
}

/// Lines through runs: runs that pass within `reach` (m) of a line with the same normal belong to it and extend it.
pub(super) fn chains(mut runs: Vec<Vec<Sample>>, reach: f64) -> Vec<Chain> {
    runs.sort_by_key(|run| core::cmp::Reverse(run.len()));
    let mut found: Vec<Chain> = Vec::new();
    while !runs.is_empty() {
        let first = runs.remove(0);
        let mut line = Line::new(first.clone(), reach);
        let mut own = vec![first];
        let mut from = 0;
        while let Some(next) = (from..runs.len()).find(|&k| line.touches(&runs[k])) {
            let run = runs.remove(next);
            // What did not touch the line before may touch it once it is longer.
            from = if line.extend(&run) { 0 } else { next };
            own.push(run);
        }
        found.push(Chain { line: line.samples, runs: own, closed: line.closed });
    }
    found
}

impl Line {
    fn new(samples: Vec<Sample>, reach: f64) -> Self {
        let mut line = Self { samples, near: NearPoints::new(reach, []), reach, closed: false };
        line.close();
        line
    }

    /// Cuts a line that comes back to its beginning, and finds its points anew.
    fn close(&mut self) {
        if let Some(back) = self.back() {
            self.samples.truncate(back + 1);
            self.closed = true;
        }
        let points = self.samples.iter().enumerate().map(|(k, sample)| (sample.position, k));
        self.near = NearPoints::new(self.reach, points);
    }

    /// The first point that is back at the beginning.
    fn back(&self) -> Option<usize> {
        let first = self.samples.first()?;
        let (mut along, mut last) = (0.0, first.position);
        self.samples.iter().position(|sample| {
            along += last.distance(sample.position);
            last = sample.position;
            along > SHORTEST_RING
                && sample.position.distance(first.position) < self.reach
                && sample.normal.dot(first.normal) > SAME_WAY
        })
    }

    /// Whether a run passes along the line: near it and facing the same way.
    fn touches(&self, run: &[Sample]) -> bool {
        let is_beside = |sample: &&Sample| {
            self.near.nearest(sample.position).is_some_and(|(distance, k)| {
                distance < self.reach && self.samples[k].normal.dot(sample.normal) > SAME_WAY
            })
        };
        run.iter().filter(is_beside).take(FEWEST_BESIDE).count() == FEWEST_BESIDE
    }

    /// Adds what of a run lies beyond the ends; whether there is any.
    fn extend(&mut self, run: &[Sample]) -> bool {
        if self.closed {
            return false;
        }
        let before = self.samples.len();
        for end in [End::Last, End::First] {
            let Some(edge) = self.edge(end) else { return false };
            let mut more: Vec<Sample> =
                run.iter().filter(|sample| self.beyond(sample.position) == Some(end)).copied().collect();
            let far = |s: Option<&Sample>| s.map_or(f64::INFINITY, |s| s.position.distance(edge.position));
            if far(more.last()) < far(more.first()) {
                more.reverse();
            }
            if far(more.first()) > self.reach {
                continue;
            }
            match end {
                End::Last => self.samples.extend(more),
                End::First => drop(self.samples.splice(0..0, more.into_iter().rev())),
            }
            self.close();
            if self.closed {
                break;
            }
        }
        self.samples.len() != before
    }

    fn edge(&self, end: End) -> Option<Sample> {
        match end {
            End::First => self.samples.first().copied(),
            End::Last => self.samples.last().copied(),
        }
    }

    /// Beyond which of its ends a point lies, if not beside the line.
    fn beyond(&self, point: Vec2) -> Option<End> {
        let distance = |k: &usize| self.samples[*k].position.distance(point);
        let far = || (0..self.samples.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let nearest = self.near.nearest(point).map(|(_, k)| k).or_else(far)?;
        let last = self.samples.len() - 1;
        let is_ahead = |a: usize, b: usize| {
            let [a, b] = [a, b].map(|k| self.samples[k].position);
            (point - a).dot(a - b) > 0.0
        };
        match nearest {
            0 if last > 0 && is_ahead(0, 1) => Some(End::First),
            k if k == last && last > 0 && is_ahead(last, last - 1) => Some(End::Last),
            _ => None,
        }
    }
}
