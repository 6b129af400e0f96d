//! All hypotheses together: started at a first contact, carried on, linearised anew, merged, dropped, weighed.

mod congruent;
mod dropped;
mod merge;
mod odometry;
mod outside;
mod rescue;
mod rows;
mod start;

use super::feeler::{Feeler, Judge};
use super::history::History;
use super::hypothesis::{Hypothesis, Limits, Scene, difference, moved};
use super::shares::Shared;
use super::symmetry::Turns;
use crate::beam::TipTable;
use crate::config::ProbabilisticOptions;
use crate::contact::Boundaries;
use crate::contact::follow::Mechanics;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, Robot};
use congruent::Trail;
use core::ops::Range;
use dropped::Dropped;
pub(super) use merge::{Prospect, best_of_cells, cells};
pub(super) use rescue::RESCUED;
use rows::Underway;
pub(super) use start::Search;

/// Inverse variances that keep a step finite where the readings leave a direction open (5 mm, 5°).
pub(super) const LOOSE: [f64; 3] = [4e4, 4e4, 131.0];
/// Longest step of one linearisation (m, rad).
const LONGEST: [f64; 2] = [3e-3, 0.06];
/// A step longer than this (m, rad) asks for a new linearisation, if it promises so much (nats).
const STALE: [f64; 2] = [1e-4, 2e-3];
const PROMISE: f64 = 0.1;
/// One that promises so much (nats) asks for it however short it is.
const MUCH: f64 = 8.0;
/// Readings that may be run again for each new row, and how many are saved up for it when there is nothing to do.
const BUDGET: usize = 80;
const SAVED: usize = 3 * BUDGET;
/// Inverse variances that keep covariances finite (20 mm, 20°).
pub(super) const OPEN: [f64; 3] = [2.5e3, 2.5e3, 8.2];
/// When so many rows have cost so much each (nats), hypotheses are pulled back by readings that seem false.
pub(super) const RESCUE_ROWS: usize = 8;
const RESCUE_COST: f64 = 2.5;
/// Those that are pulled back together
/// stand so far apart (m, rad).
const APART: [f64; 2] = [15e-3, 0.1];
/// Hypotheses this near to each other (m, rad) are to be told on the same side of a map that turns onto itself.
const GATHERED: [f64; 2] = [60e-3, 0.2];

/// Errors of the odometry that are not the same share of every increment, as a part of the declared bound, when rows are summed up.
const VARYING: f64 = 0.25;

/// The hypotheses and the rows that they have seen.
pub(super) struct Bank {
    pub(super) hypotheses: Vec<Hypothesis>,
    /// The rows of the history that are used, in order.
    pub(super) used: Vec<usize>,
    /// The first row that has not been looked at.
    pub(super) next: usize,
    pub(super) pivot: Vec2,
    pub(super) shared: Shared,
    /// The last row that is used, as long as not all hypotheses have taken it.
    underway: Option<Underway>,
    credit: usize,
    turn: usize,
    since_merge: usize,
    /// The least cost after each of the used rows.
    usual: Vec<f64>,
    /// The least costs after the last few rows.
    recent: Vec<f64>,
    dropped: Dropped,
    /// What is kept of rows that have been summed up; nothing where the log began in contact.
    trail: Option<Trail>,
    /// Whether rows have been summed up, the history's first among them.
    folded: bool,
    /// Whether each hypothesis stands for all its images on a map that turns onto itself.
    pub(super) for_all: bool,
}

/// What the bank works with.
#[derive(Clone, Copy)]
pub(super) struct Field<'a> {
    pub(super) map: &'a Map,
    pub(super) ground: &'a Boundaries,
    pub(super) turns: &'a Turns,
    pub(super) table: &'a TipTable,
    pub(super) robot: &'a Robot,
    pub(super) feelers: &'a [Feeler],
    pub(super) options: &'a ProbabilisticOptions,
}

impl<'a> Field<'a> {
    pub(super) fn scene(&self, history: &'a History, pivot: Vec2, judge: Judge, shared: Shared) -> Scene<'a> {
        Scene {
            solver: Mechanics::Table(self.table),
            map: self.map,
            ground: self.ground,
            feelers: self.feelers,
            history,
            pivot,
            judge,
            shared,
            blur: false,
            whole: true,
            heading_std: self.options.heading_error / SQRT_3,
        }
    }
}

impl Field<'_> {
    /// Whether a place is in the prior's region and near the absolute headings, give or take a cell of the search. The
    /// odometry frame is the robot's at the first row.
    pub(super) fn admits(&self, history: &History, map_from_odom: Pose2) -> bool {
        let (place, turn) = (self.options.seed_spacing, self.options.seed_turn);
        let within = |[[a, b], [c, d], [e, f]]: [[f64; 2]; 3]| {
            let off = wrap_angle(map_from_odom.theta - 0.5 * (e + f)).abs();
            (a - place..=b + place).contains(&map_from_odom.x)
                && (c - place..=d + place).contains(&map_from_odom.y)
                && off <= 0.5 * (f - e) + turn
        };
        let points =
            |heading: f64| wrap_angle(map_from_odom.theta - heading).abs() <= 1.5 * self.options.heading_error + turn;
        self.options.prior.is_none_or(within) && history.heading().is_none_or(points)
    }
}

impl Field<'_> {
    /// Whether the robot's origin stands in free space at a row, give or take a step of the search; the whisker's base is
    /// asked elsewhere.
    pub(super) fn stands(&self, history: &History, map_from_odom: Pose2, row: usize) -> bool {
        if self.feelers.iter().all(|f| f.robot_from_whisker.position().norm_squared() == 0.0) {
            return true;
        }
        let origin = map_from_odom.transform_point(history.pose(row).position());
        self.map.is_free(origin) || self.map.nearest_within(origin, self.options.seed_spacing).is_some()
    }
}

/// A step cut to a length that linearisations can be trusted for.
pub(super) fn cut(d: [f64; 3]) -> [f64; 3] {
    let share = (LONGEST[0] / (d[0] * d[0] + d[1] * d[1]).sqrt()).min(LONGEST[1] / d[2].abs()).min(1.0);
    d.map(|v| v * share)
}

/// Whether a step is longer than a linearisation is trusted for.
fn is_stale(d: [f64; 3]) -> bool {
    d[0] * d[0] + d[1] * d[1] > STALE[0] * STALE[0] || d[2].abs() > STALE[1]
}

/// Whether a step that promises so much (nats) asks for a new linearisation.
fn asks(promise: f64, d: [f64; 3]) -> bool {
    is_stale(d) && promise > PROMISE || promise > MUCH
}

impl Bank {
    /// Runs these hypotheses anew, each moved to its best place.
    pub(super) fn rerun(&mut self, field: &Field<'_>, history: &History, which: Range<usize>) {
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        for h in &mut self.hypotheses[which] {
            let (_, d) = h.best(LOOSE, self.shared);
            let to = moved(h.map_from_odom, self.pivot, cut(d));
            h.run(&scene, to, self.used.iter().copied());
            h.look(LOOSE, self.shared);
        }
    }

    /// Uses every row from now on, or so many that are evenly spread; the best hypothesis comes first, and those that come
    /// to cost so much more are given up.
    pub(super) fn use_rows(&mut self, field: &Field<'_>, history: &History, most: usize, more: f64) {
        let stride = history.len().div_ceil(most.max(1)).max(1);
        // The first row has been summed up where anything has.
        let folded = usize::from(self.folded);
        self.used = (folded..history.len()).rev().step_by(stride).collect();
        self.used.reverse();
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        self.rerun(field, history, 0..self.hypotheses.len().min(1));
        self.usual = self.hypotheses.first().map_or_else(Vec::new, |h| h.costs(&scene, &self.used));
        let (used, shared, pivot) = (&self.used, self.shared, self.pivot);
        let limits = Limits { usual: &self.usual, more };
        let mut first = true;
        self.hypotheses.retain_mut(|h| {
            if core::mem::take(&mut first) {
                return true;
            }
            let to = moved(h.map_from_odom, pivot, cut(h.best(LOOSE, shared).1));
            let below = h.run_below(&scene, to, used, limits);
            h.look(LOOSE, shared);
            below
        });
    }

    /// Whether some of the rows are not used.
    pub(super) fn leaves_out_rows(&self, history: &History) -> bool {
        self.used.len() + usize::from(self.folded) < history.len()
    }

    /// Takes these among the hypotheses, run with the rows that are used now where they stand.
    pub(super) fn take_back(&mut self, field: &Field<'_>, history: &History, hypotheses: Vec<Hypothesis>) {
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        for mut h in hypotheses {
            h.run(&scene, h.map_from_odom, self.used.iter().copied());
            h.look(LOOSE, self.shared);
            self.hypotheses.push(h);
        }
    }

    /// Finds the costs of the best hypothesis after each used row.
    fn find_usual(&mut self, field: &Field<'_>, history: &History) {
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let known = self.hypotheses.iter().filter(|h| !h.waits);
        let best = known.min_by(|a, b| a.cost(self.shared).total_cmp(&b.cost(self.shared)));
        self.usual = best.map_or_else(|| vec![f64::INFINITY; self.used.len()], |h| h.costs(&scene, &self.used));
    }

    /// Linearises those whose estimate has moved, as far as the budget goes: what is under way, then the best one, then in turn.
    fn linearise(&mut self, field: &Field<'_>, history: &History) {
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        self.credit = (self.credit + BUDGET).min(SAVED);
        let costs = self.hypotheses.iter().enumerate().map(|(index, h)| (h.promise.0, index));
        let Some((_, best)) = costs.min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        let underway = self.hypotheses.iter().position(|h| h.rerun.is_some() && !h.waits);
        for index in underway.into_iter().chain([best]) {
            self.freshen(&scene, index);
        }
        for _ in 0..self.hypotheses.len() {
            if self.credit == 0 {
                return;
            }
            self.turn = (self.turn + 1) % self.hypotheses.len();
            self.freshen(&scene, self.turn);
        }
    }

    /// Linearises one hypothesis anew if its estimate has moved, or goes on with that.
    fn freshen(&mut self, scene: &Scene<'_>, index: usize) {
        let h = &mut self.hypotheses[index];
        if h.age == 0 || h.waits || self.credit == 0 {
            return;
        }
        let (cost, d) = h.promise;
        let moved = || asks(h.cost(self.shared) - cost, d);
        if (h.rerun.is_some() || moved()) && h.improve(scene, cut(d), &self.used, &mut self.credit) {
            h.look(LOOSE, self.shared);
        }
    }

    /// How many places each hypothesis stands for.
    pub(super) fn times(&self, turns: &Turns) -> usize {
        if self.for_all { turns.order() } else { 1 }
    }

    /// Puts all images in the place of the hypotheses that stand for them.
    pub(super) fn expand(&mut self, turns: &Turns) {
        if core::mem::take(&mut self.for_all) {
            let images = self.hypotheses.iter().flat_map(|h| turns.all.iter().map(|turn| h.turned(turn)));
            let images: Vec<Hypothesis> = images.collect();
            self.hypotheses.extend(images);
        }
    }

    /// Turns hypotheses to where better ones are, so that none stands at an image of another's place.
    pub(super) fn gather(&mut self, turns: &Turns) {
        if !self.for_all {
            return;
        }
        let shared = self.shared;
        self.hypotheses.sort_by(|a, b| a.cost(shared).total_cmp(&b.cost(shared)));
        let mut open = core::mem::take(&mut self.hypotheses);
        while !open.is_empty() {
            let mut next = self.hypotheses.len();
            self.hypotheses.push(open.remove(0));
            while let Some(at) = self.hypotheses.get(next).map(|h| h.map_from_odom) {
                let mut rest = Vec::new();
                for h in open {
                    let near = |frame: Pose2| {
                        let [x, y, turn] = difference(at, frame, self.pivot);
                        x.hypot(y) < GATHERED[0] && turn.abs() < GATHERED[1]
                    };
                    if near(h.map_from_odom) {
                        self.hypotheses.push(h);
                    } else if let Some(turn) = turns.all.iter().find(|t| near(t.motion.compose(h.map_from_odom))) {
                        self.hypotheses.push(h.turned(turn));
                    } else {
                        rest.push(h);
                    }
                }
                open = rest;
                next += 1;
            }
        }
        self.hypotheses.sort_by(|a, b| a.cost(shared).total_cmp(&b.cost(shared)));
    }

    /// Whether rows have been summed up.
    pub(super) fn is_folded(&self) -> bool {
        self.folded
    }

    /// Hypotheses on the side, with these rows.
    pub(super) fn beside(&self, hypotheses: Vec<Hypothesis>, used: Vec<usize>) -> Self {
        Self {
            hypotheses,
            used,
            next: self.next,
            pivot: self.pivot,
            shared: self.shared,
            underway: None,
            credit: 0,
            turn: 0,
            since_merge: 0,
            usual: Vec::new(),
            recent: Vec::new(),
            dropped: Dropped::default(),
            trail: None,
            folded: self.folded,
            for_all: self.for_all,
        }
    }

    /// Those of these, in order, that stand apart from all before.
    ///
    /// Equal places explain the readings equally well; if all that are fitted anew stood at one of them, the others would be
    /// lost for no reason but their order.
    pub(super) fn apart(&self, order: impl Iterator<Item = usize>, most: usize) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        for index in order {
            let near = |other: &usize| {
                let [x, y, turn] =
                    difference(self.hypotheses[*other].map_from_odom, self.hypotheses[index].map_from_odom, self.pivot);
                x.hypot(y) < APART[0] && turn.abs() < APART[1]
            };
            if chosen.len() < most && !chosen.iter().any(near) {
                chosen.push(index);
            }
        }
        chosen
    }

    /// Sums up the first `count` rows, so that no more than a window of them is kept.
    pub(super) fn fold(&mut self, field: &Field<'_>, history: &mut History, count: usize) {
        let early = self.used.partition_point(|&row| row < count);
        let Some(&last) = self.used[..early].last() else { return };
        // What is summed up is never linearised again: readings that are steep over a tiny range must not fix a place for good.
        let scene = Scene { blur: true, ..field.scene(history, self.pivot, Judge::FAIR, self.shared) };
        let odometry = &field.robot.odometry;
        let (mut way, mut turn) = (0.0, 0.0);
        for row in 0..last {
            let (a, b) = (history.pose(row), history.pose(row + 1));
            way += a.position().distance(b.position());
            turn += a.between(b).theta.abs();
        }
        let place = (VARYING * 0.5 * odometry.translation_relative * way).powi(2);
        let heading = (VARYING * odometry.rotation_relative / SQRT_3 * turn).powi(2);
        for h in self.hypotheses.iter_mut().chain(self.dropped.since(early, self.pivot)) {
            let robot = h.map_from_odom.transform_point(history.pose(last).position());
            let arm = (h.map_from_odom.transform_point(self.pivot) - robot).perp();
            let loose = [
                [place + heading * arm.x * arm.x, heading * arm.x * arm.y, heading * arm.x],
                [heading * arm.x * arm.y, place + heading * arm.y * arm.y, heading * arm.y],
                [heading * arm.x, heading * arm.y, heading],
            ];
            h.fold(&scene, &self.used[..early], &loose);
        }
        if let Some(trail) = &mut self.trail {
            // The first row that is left by the time before is the last that was summed up then.
            trail.take(history, usize::from(self.folded)..last);
        }
        self.folded = true;
        self.used.drain(..early);
        self.usual.drain(..early);
        self.used.iter_mut().for_each(|row| *row -= last);
        self.next -= last;
        history.forget(last);
    }

    /// The least cost of any hypothesis, as last looked at.
    pub(super) fn least(&self) -> f64 {
        self.hypotheses.iter().map(|h| h.promise.0).fold(f64::INFINITY, f64::min)
    }
}

/// The standard deviation of an even law is its bound over this.
const SQRT_3: f64 = 1.732_050_807_568_877_2;
