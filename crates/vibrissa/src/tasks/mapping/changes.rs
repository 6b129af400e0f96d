//! Walls that changed between logs: what a later log felt beside an earlier wall, and earlier walls where a later log passed.

use super::free_space::PassedSpace;
use super::front_end::{FrontEnd, StretchPoint};
use super::graph::{Marginals, Solution};
use super::submap::passed_space;
use crate::config::MappingOptions;
use crate::plane::Vec2;
use crate::tasks::profile::NearPoints;
use std::collections::{HashMap, HashSet};

/// How a wall changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChangeKind {
    /// It was felt elsewhere: so far towards the side where the whisker is (m), with its standard deviation.
    Moved {
        /// How far (m).
        by: f64,
        /// Its standard deviation (m).
        std: f64,
    },
    /// The robot or its whiskers passed where it was.
    Gone,
}

/// A stretch of wall that is not where an earlier log felt it.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The log that tells, by its number from 0.
    pub log: usize,
    /// How it changed.
    pub kind: ChangeKind,
    /// Where it was felt by that log, or before where it is gone (m).
    pub points: Vec<Vec2>,
}

impl Change {
    /// Its length along the wall (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }
}

/// Which points of which stretches are no longer.
pub(super) type Outdated = HashSet<(usize, usize)>;

/// Normals of one wall differ by less (cosine).
const SAME_WAY: f64 = 0.9;
/// Side of the cells by which earlier points are found (m): neighbours along a wall are half a millimetre apart.
const CELL: f64 = 2e-3;
/// A wall that has moved goes on straight so far beyond what was felt of it (m): across a corner that a robot does not feel.
const BEYOND: f64 = 0.15;

/// A felt point in the map.
#[derive(Clone, Copy)]
struct Placed {
    place: Vec2,
    normal: Vec2,
    /// What its contact leaves open across the wall (m).
    std: f64,
    key: usize,
    /// Its stretch, and which of its points it is.
    index: (usize, usize),
}

/// A later point beside an earlier one.
struct Beside {
    now: Placed,
    before: Placed,
    by: f64,
    std: f64,
}

/// What is searched, and what is known so far.
struct Comparison<'a> {
    front: &'a FrontEnd,
    visit: usize,
    solution: &'a Solution,
    marginals: &'a Marginals,
    options: &'a MappingOptions,
    earlier: Vec<Placed>,
    near: NearPoints<usize>,
    /// What pairs of key poses leave open across a wall (m).
    open: HashMap<(usize, usize), f64>,
}

/// What a log says of the walls that earlier logs felt, as far as their key poses are known; notes the points of these that no longer hold.
pub(super) fn changes(
    (front, visit): (&FrontEnd, usize),
    (solution, marginals, is_known): (&Solution, &Marginals, &dyn Fn(usize) -> bool),
    options: &MappingOptions,
    outdated: &mut Outdated,
) -> Vec<Change> {
    let placed = |index: usize| in_map(front, solution, index);
    let keys = front.visit(visit);
    let is_before = |index: &usize| {
        let key = front.stretches[*index].key;
        key < keys.start && is_known(key)
    };
    let mut earlier: Vec<Placed> = (0..front.stretches.len()).filter(is_before).flat_map(placed).collect();
    earlier.retain(|point| !outdated.contains(&point.index));
    let near = NearPoints::new(CELL, earlier.iter().enumerate().map(|(k, point)| (point.place, k)));
    let open = HashMap::new();
    let mut search = Comparison { front, visit, solution, marginals, options, earlier, near, open };
    let runs = search.runs();
    let mut old: Outdated = runs.iter().flatten().map(|beside| beside.before.index).collect();
    for run in &runs {
        old.extend(search.replaced(run));
    }
    let mut found: Vec<Change> = runs.iter().map(|run| moved(run, visit)).collect();
    found.extend(search.gone(&mut old));
    outdated.extend(old);
    found
}

impl Comparison<'_> {
    /// Runs of later points that lie beside an earlier wall.
    fn runs(&mut self) -> Vec<Vec<Beside>> {
        let keys = self.front.visit(self.visit);
        let mut runs: Vec<Vec<Beside>> = Vec::new();
        let mut last: Option<Vec2> = None;
        for index in (0..self.front.stretches.len()).filter(|&index| keys.contains(&self.front.stretches[index].key)) {
            for now in in_map(self.front, self.solution, index) {
                let beside = self.beside(now);
                let Some(beside) = beside.filter(|beside| self.is_elsewhere(beside)) else { continue };
                // Between traces a few millimetres are not kept.
                let follows = last.is_some_and(|last| last.distance(now.place) <= self.options.shortest)
                    && runs.last().and_then(|run| run.last()).is_some_and(|before| {
                        (before.by - beside.by).abs() <= self.options.least_change.max(before.std + beside.std)
                    });
                last = Some(now.place);
                match runs.last_mut().filter(|_| follows) {
                    Some(run) => run.push(beside),
                    None => runs.push(vec![beside]),
                }
            }
        }
        runs.retain(|run| length(run.iter().map(|beside| beside.now.place)) >= self.options.shortest);
        runs
    }

    fn is_elsewhere(&self, beside: &Beside) -> bool {
        beside.by.abs() > (self.options.stds_in_bound * beside.std).max(self.options.least_change)
    }

    /// The earlier point straight across the wall from a later one that is nearest.
    fn beside(&mut self, now: Placed) -> Option<Beside> {
        let steps = (self.options.largest_change / CELL).ceil() as i64;
        let at = |step: i64| now.place + now.normal * (CELL * step as f64);
        // From near to far, to either side.
        let before = (0..=steps).flat_map(|step| [step, -step]).find_map(|step| {
            let near = self.near.around(at(step)).map(|(_, k)| self.earlier[k]);
            let across = near.filter(|old| {
                old.normal.dot(now.normal) > SAME_WAY && (old.place - now.place).cross(now.normal).abs() <= CELL
            });
            across.min_by(|a, b| a.place.distance(now.place).total_cmp(&b.place.distance(now.place)))
        })?;
        let pair = (now.key, before.key);
        let open = *self
            .open
            .entry(pair)
            .or_insert_with(|| self.marginals.between(self.solution, pair, now.place, before.normal));
        let by = (now.place - before.place).dot(before.normal);
        Some(Beside { now, before, by, std: now.std.hypot(before.std).hypot(open) })
    }

    /// Earlier points that a moved wall replaces, on as far as it goes on straight: its own, and what lies behind it where it has come nearer.
    fn replaced(&self, run: &[Beside]) -> Vec<(usize, usize)> {
        let by = mean(run.iter().map(|beside| beside.by));
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return Vec::new() };
        let along = last.now.place - first.now.place;
        let length = along.norm().max(1e-9);
        let along = along * (1.0 / length);
        let normal = if along.perp().dot(first.now.normal) > 0.0 { along.perp() } else { along.perp() * -1.0 };
        let limits = self.options.least_change..by.abs() + self.options.least_change;
        let is_replaced = |point: &&Placed| {
            let from = point.place - first.now.place;
            let off = from.dot(normal) * -by.signum();
            let is_hidden = by > 0.0 || point.normal.dot(normal) > SAME_WAY;
            is_hidden && limits.contains(&off) && (-BEYOND..length + BEYOND).contains(&from.dot(along))
        };
        self.earlier.iter().filter(is_replaced).map(|point| point.index).collect()
    }

    /// Earlier walls where the log passed, without those of which the points are known to be old.
    fn gone(&self, old: &mut Outdated) -> Vec<Change> {
        let space = self.passed();
        let is_gone = |point: &Placed| {
            let errors = self.options.stds_in_bound * point.std + self.options.least_change;
            !old.contains(&point.index) && space.depth(point.place) > errors
        };
        let gone: Vec<Placed> = self.earlier.iter().filter(|point| is_gone(point)).copied().collect();
        let near = |a: &Placed, b: &Placed| a.place.distance(b.place) <= self.options.largest_gap;
        let mut found = Vec::new();
        for run in gone.chunk_by(near) {
            let points: Vec<Vec2> = run.iter().map(|point| point.place).collect();
            if length(points.iter().copied()) >= self.options.shortest {
                old.extend(run.iter().map(|point| point.index));
                found.push(Change { log: self.visit, kind: ChangeKind::Gone, points });
            }
        }
        found
    }

    /// The space that the log passed, in the map.
    fn passed(&self) -> PassedSpace {
        passed_space(self.front, self.front.visit(self.visit), self.options, &|key, local| {
            let (pose, c) = (self.solution.poses[key], &self.marginals.poses[key]);
            let std = (c[0][0] + c[1][1]).max(0.0).sqrt() + c[2][2].max(0.0).sqrt() * local.norm();
            (pose.transform_point(local), self.options.stds_in_bound * std)
        })
    }
}

/// The points of a stretch in the map.
fn in_map<'a>(front: &'a FrontEnd, solution: &Solution, index: usize) -> impl Iterator<Item = Placed> + use<'a> {
    let stretch = &front.stretches[index];
    let pose = solution.poses[stretch.key];
    stretch.points.iter().enumerate().map(move |(k, point): (usize, &StretchPoint)| Placed {
        place: pose.transform_point(point.position),
        normal: point.normal.rotated(pose.theta),
        std: point.std,
        key: stretch.key,
        index: (index, k),
    })
}

/// A run as a change.
fn moved(run: &[Beside], log: usize) -> Change {
    // Errors are alike along all of it.
    let (by, std) = (mean(run.iter().map(|beside| beside.by)), mean(run.iter().map(|beside| beside.std)));
    Change { log, kind: ChangeKind::Moved { by, std }, points: run.iter().map(|beside| beside.now.place).collect() }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
    sum / f64::max(count, 1.0)
}

fn length(points: impl Iterator<Item = Vec2>) -> f64 {
    let points: Vec<Vec2> = points.collect();
    points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}
