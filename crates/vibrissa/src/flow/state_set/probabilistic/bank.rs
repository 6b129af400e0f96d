//! All hypotheses together: started at a first contact, carried on, linearised anew, merged, dropped, weighed.

use super::contact::Solver;
use super::ground::Ground;
use super::history::{Feeler, History, Judge};
use super::hypothesis::{Hypothesis, Scene, difference, moved};
use super::normal::{Matrix, dot, times};
use super::seeds::{Onset, seeds};
use crate::beam::TipTable;
use crate::config::ProbabilisticOptions;
use crate::flow::prior;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::{Map, Robot};

/// A hypothesis less likely than the best by this (nats) is dropped; the second part shrinks with the share of the rows
/// that are used.
const DROP: f64 = 30.0;
const DROP_MORE: f64 = 20.0;
/// Inverse variances that keep a step finite where the readings leave a direction open (5 mm, 5°).
const LOOSE: [f64; 3] = [4e4, 4e4, 131.0];
/// Longest step of one linearisation (m, rad).
const LONGEST: [f64; 2] = [3e-3, 0.06];
/// A step longer than this (m, rad) asks for a new linearisation, if it promises so much (nats).
const STALE: [f64; 2] = [1e-4, 2e-3];
const PROMISE: f64 = 0.1;
/// Readings that may be run again for each new row.
const BUDGET: usize = 200;
/// Hypotheses this near to each other are one (m, rad),
const SAME_PLACE: f64 = 1.2e-3;
const SAME_HEADING: f64 = 0.015;
/// and while there are more than this many, those this near: the rest is left to their least squares.
const MANY: usize = 300;
const ROUGH_PLACE: f64 = 2.5e-3;
const ROUGH_HEADING: f64 = 0.04;
/// In the end so are those that lie within another's region (squared standard deviations) and no further away (m).
const OVERLAP: f64 = 0.5;
const FARTHEST: f64 = 0.05;
/// Inverse variances that keep covariances finite (20 mm, 20°).
pub(super) const OPEN: [f64; 3] = [2.5e3, 2.5e3, 8.2];
/// So many of the best are pulled back by readings that seem false, in steps with standard deviations enlarged so much,
/// when so many rows have cost so much each (nats), and not again for as many rows.
const RESCUED: usize = 12;
const TEMPERS: [f64; 5] = [8.0, 8.0, 8.0, 4.0, 2.0];
pub(super) const RESCUE_ROWS: usize = 8;
const RESCUE_COST: f64 = 2.5;
/// Rows between two merges.
const MERGE_EVERY: usize = 8;
/// So many hypotheses share one row; twice as many take every second one, and so on.
const LOAD: usize = 250;

/// The hypotheses and the rows that they have seen.
pub(super) struct Bank {
    pub(super) hypotheses: Vec<Hypothesis>,
    /// The rows of the history that are used, in order.
    pub(super) used: Vec<usize>,
    pub(super) pivot: Vec2,
    /// Standard deviation of a relative error that all readings share.
    pub(super) shared: f64,
    credit: usize,
    turn: usize,
    since_merge: usize,
    /// The least costs after the last few rows.
    recent: Vec<f64>,
    /// Whether rows have been summed up, the history's first among them.
    folded: bool,
}

/// What the bank works with.
#[derive(Clone, Copy)]
pub(super) struct Field<'a> {
    pub(super) map: &'a Map,
    pub(super) ground: &'a Ground,
    pub(super) table: &'a TipTable,
    pub(super) robot: &'a Robot,
    pub(super) feelers: &'a [Feeler],
    pub(super) options: &'a ProbabilisticOptions,
}

impl<'a> Field<'a> {
    pub(super) fn scene(&self, history: &'a History, pivot: Vec2, judge: Judge, shared: f64) -> Scene<'a> {
        Scene {
            solver: Solver::Quick(self.table),
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

/// A step cut to a length that linearisations can be trusted for.
pub(super) fn cut(d: [f64; 3]) -> [f64; 3] {
    let share = (LONGEST[0] / (d[0] * d[0] + d[1] * d[1]).sqrt()).min(LONGEST[1] / d[2].abs()).min(1.0);
    d.map(|v| v * share)
}

/// Whether a step is longer than a linearisation is trusted for.
fn is_stale(d: [f64; 3]) -> bool {
    d[0] * d[0] + d[1] * d[1] > STALE[0] * STALE[0] || d[2].abs() > STALE[1]
}

impl Bank {
    /// Seeds from the contact that began at row `onset` of the history with this whisker.
    pub(super) fn start(field: &Field<'_>, history: &History, feeler: usize, onset: usize, from_free: bool) -> Self {
        let options = field.options;
        let own = &field.feelers[feeler];
        let odom_from_whisker = history.pose(onset).compose(own.robot_from_whisker);
        let tip = Vec2::new(own.length, 0.0);
        let pivot = odom_from_whisker.transform_point(tip);
        let rows = judging_rows(history, feeler, onset, options.seed_step);
        let before = history.pose(onset.saturating_sub(3)).compose(own.robot_from_whisker);
        let approach = tip - odom_from_whisker.inverse_transform_point(before.transform_point(tip));
        let judge = Judge { temper: SEED_TEMPER, outlier_cost: f64::INFINITY };
        let scene = Scene { whole: false, ..field.scene(history, pivot, judge, 0.0) };
        let onset_of = Onset {
            feeler,
            beam: &field.robot.whiskers[feeler].beam,
            row: onset,
            from_free,
            approach,
            rows: &rows,
            spacing: options.seed_spacing,
            turn: options.seed_turn,
            near: options.prior.map(|region| {
                let arm = odom_from_whisker.position();
                let slack = 2.0 * options.seed_spacing + arm.norm() * options.seed_turn;
                prior::around(region, arm, slack, own.length)
            }),
        };
        let admits = |map_from_odom: Pose2| field.admits(history, map_from_odom);
        let mut hypotheses = seeds(&scene, &onset_of, &admits);
        if from_free {
            hypotheses.iter_mut().for_each(|h| {
                h.map_from_odom = moved(h.map_from_odom, pivot, cut(h.best(LOOSE, 0.0).1));
                *h = h.restarted_free();
            });
        }
        let used = (0..onset).chain(rows).collect();
        let mut bank = Self {
            hypotheses,
            used,
            pivot,
            shared: options.shared_gain.unwrap_or(own.shared_share()),
            credit: 0,
            turn: 0,
            since_merge: 0,
            recent: Vec::new(),
            folded: false,
        };
        bank.merge(field, history);
        bank.hypotheses.sort_by(|a, b| a.normal.cost.total_cmp(&b.normal.cost));
        bank.hypotheses.truncate(MOST_SEEDS);
        bank.rerun(field, history);
        bank.merge(field, history);
        bank.drop_unlikely(field, history);
        bank
    }

    /// Runs all hypotheses anew, each moved to its best place.
    pub(super) fn rerun(&mut self, field: &Field<'_>, history: &History) {
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        for h in &mut self.hypotheses {
            let (_, d) = h.best(LOOSE, self.shared);
            let to = moved(h.map_from_odom, self.pivot, cut(d));
            h.run(&scene, to, self.used.iter().copied());
        }
    }

    /// Takes in the history's last row, if it is one to be used.
    pub(super) fn step(&mut self, field: &Field<'_>, history: &History) {
        let row = history.len() - 1;
        let stride = (self.hypotheses.len() / LOAD).clamp(1, 8);
        let last = self.used.last().copied().unwrap_or(0);
        if row < last + stride {
            return;
        }
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        self.used.push(row);
        self.hypotheses.iter_mut().for_each(|h| {
            h.take(&scene, row);
        });
        self.drop_unlikely(field, history);
        self.linearise(field, history);
        self.recent.push(self.least());
        if self.recent.len() > RESCUE_ROWS {
            if self.recent[RESCUE_ROWS] - self.recent[0] > RESCUE_COST * RESCUE_ROWS as f64 {
                self.rescue(field, history);
                self.recent.clear();
            } else {
                self.recent.remove(0);
            }
        }
        self.since_merge += 1;
        if self.since_merge >= MERGE_EVERY {
            self.since_merge = 0;
            self.merge(field, history);
        }
    }

    /// Uses every row from now on, or so many that are evenly spread.
    pub(super) fn use_rows(&mut self, field: &Field<'_>, history: &History, most: usize) {
        let stride = history.len().div_ceil(most.max(1)).max(1);
        // The first row has been summed up where anything has.
        let folded = usize::from(self.folded);
        self.used = (folded..history.len()).rev().step_by(stride).collect();
        self.used.reverse();
        self.rerun(field, history);
    }

    /// Linearises those whose estimate has moved, as far as the budget goes: the best one first, then in turn.
    fn linearise(&mut self, field: &Field<'_>, history: &History) {
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        self.credit = (self.credit + BUDGET).min(self.used.len().max(4 * BUDGET));
        let costs = self.hypotheses.iter().enumerate().map(|(index, h)| (h.best(LOOSE, self.shared).0, index));
        let Some((_, best)) = costs.min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        for visit in 0..=self.hypotheses.len() {
            if self.credit < self.used.len() {
                return;
            }
            if visit > 0 {
                self.turn = (self.turn + 1) % self.hypotheses.len();
            }
            let index = if visit == 0 { best } else { self.turn };
            self.freshen(&scene, index);
        }
    }

    /// Linearises one hypothesis anew if its estimate has moved.
    fn freshen(&mut self, scene: &Scene<'_>, index: usize) {
        let h = &mut self.hypotheses[index];
        if h.age == 0 {
            return;
        }
        let (cost, d) = h.best(LOOSE, self.shared);
        if is_stale(d) && h.cost(self.shared) > cost + PROMISE {
            let runs = h.improve(scene, cut(d), &self.used);
            self.credit = self.credit.saturating_sub(runs * self.used.len());
        }
    }

    /// Fits the best few anew with all readings believed, before they are given up.
    ///
    /// A reading that is many standard deviations off counts as a false one and pulls no more; when all new readings are,
    /// since the estimate has crept along a ridge that earlier readings left open, it has to be pulled back by them first.
    pub(super) fn rescue(&mut self, field: &Field<'_>, history: &History) {
        let mut order: Vec<(f64, usize)> =
            self.hypotheses.iter().enumerate().map(|(index, h)| (h.best(LOOSE, self.shared).0, index)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let fair = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let mut pulled: Vec<Hypothesis> = Vec::new();
        for &(_, index) in order.iter().take(RESCUED) {
            let mut h = self.hypotheses[index].clone();
            for temper in TEMPERS {
                let judge = Judge { temper, outlier_cost: f64::INFINITY };
                let scene = field.scene(history, self.pivot, judge, self.shared);
                h.run(&scene, h.map_from_odom, self.used.iter().copied());
                let (_, d) = h.best(LOOSE, self.shared);
                h.run(&fair, moved(h.map_from_odom, self.pivot, cut(d)), self.used.iter().copied());
                if h.cost(self.shared) < self.hypotheses[index].cost(self.shared) - PROMISE {
                    pulled.push(h.clone());
                }
            }
        }
        self.hypotheses.extend(pulled);
    }

    /// Sums up the first `count` rows, so that no more than a window of them is kept.
    pub(super) fn fold(&mut self, field: &Field<'_>, history: &mut History, count: usize) {
        let early = self.used.partition_point(|&row| row < count);
        let Some(&last) = self.used[..early].last() else { return };
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let odometry = &field.robot.odometry;
        let (mut way, mut turn) = (0.0, 0.0);
        for row in 0..last {
            let (a, b) = (history.pose(row), history.pose(row + 1));
            way += a.position().distance(b.position());
            turn += a.between(b).theta.abs();
        }
        let place = (0.5 * odometry.translation_relative * way).powi(2);
        let heading = (odometry.rotation_relative / SQRT_3 * turn).powi(2);
        for h in &mut self.hypotheses {
            let robot = h.map_from_odom.transform_point(history.pose(last).position());
            let arm = (h.map_from_odom.transform_point(self.pivot) - robot).perp();
            let loose = [
                [place + heading * arm.x * arm.x, heading * arm.x * arm.y, heading * arm.x],
                [heading * arm.x * arm.y, place + heading * arm.y * arm.y, heading * arm.y],
                [heading * arm.x, heading * arm.y, heading],
            ];
            h.fold(&scene, &self.used[..early], &loose);
        }
        self.folded = true;
        self.used.drain(..early);
        self.used.iter_mut().for_each(|row| *row -= last);
        history.forget(last);
    }

    /// The least cost of any hypothesis.
    pub(super) fn least(&self) -> f64 {
        self.hypotheses.iter().map(|h| h.best(LOOSE, self.shared).0).fold(f64::INFINITY, f64::min)
    }

    /// Drops what is much less likely than the best; each gets one more chance at its best place.
    fn drop_unlikely(&mut self, field: &Field<'_>, history: &History) {
        let least = self.least();
        let drop = DROP + DROP_MORE * self.used.len() as f64 / history.len() as f64;
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let (used, shared) = (&self.used, self.shared);
        let mut credit = self.credit;
        self.hypotheses.retain_mut(|h| {
            let (cost, d) = h.best(LOOSE, shared);
            if cost <= least + drop {
                return true;
            }
            let fresh = h.age * 6 <= used.len();
            if cost > least + 1.4 * drop || fresh || !is_stale(d) {
                return false;
            }
            if credit < used.len() {
                return true;
            }
            credit = credit.saturating_sub(used.len() * h.improve(&scene, cut(d), used));
            h.best(LOOSE, shared).0 <= least + drop
        });
        self.credit = credit;
    }

    /// Keeps the best of hypotheses that have run into each other.
    pub(super) fn merge(&mut self, field: &Field<'_>, history: &History) {
        let Some(last) = history.len().checked_sub(1) else { return };
        let scene = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let best = |h: &Hypothesis| {
            let (cost, d) = h.best(LOOSE, self.shared);
            (cost, cut(d))
        };
        self.hypotheses = merged(core::mem::take(&mut self.hypotheses), &scene, history.pose(last), best);
    }

    /// Moves every hypothesis to its least cost and joins those that end at the same place.
    pub(super) fn settle(&mut self, field: &Field<'_>, history: &History, rounds: usize, exact: usize) {
        let quick = field.scene(history, self.pivot, Judge::FAIR, self.shared);
        let closed = Scene { solver: Solver::Exact, ..field.scene(history, self.pivot, Judge::FAIR, self.shared) };
        for (index, h) in self.hypotheses.iter_mut().enumerate() {
            let scene = if index < exact { &closed } else { &quick };
            let mut kept: Option<Hypothesis> = None;
            for _ in 0..rounds {
                let from = kept.as_ref().unwrap_or(h);
                let (least, d) = from.best(LOOSE, self.shared);
                if from.cost(self.shared) - least < SETTLED {
                    break;
                }
                let mut next = from.clone();
                next.run(scene, moved(from.map_from_odom, self.pivot, cut(d)), self.used.iter().copied());
                if next.cost(self.shared) > from.cost(self.shared) + 1e-3 {
                    // Half the way where the whole does not go down.
                    next.run(
                        scene,
                        moved(from.map_from_odom, self.pivot, cut(d).map(|v| 0.3 * v)),
                        self.used.iter().copied(),
                    );
                    if next.cost(self.shared) > from.cost(self.shared) {
                        break;
                    }
                }
                kept = Some(next);
            }
            if let Some(kept) = kept {
                *h = kept;
            }
        }
        self.join();
    }

    /// Keeps the best of hypotheses within each other's reach.
    fn join(&mut self) {
        let shared = self.shared;
        self.hypotheses.sort_by(|a, b| a.cost(shared).total_cmp(&b.cost(shared)));
        let mut kept: Vec<(Hypothesis, Matrix)> = Vec::new();
        for h in self.hypotheses.drain(..) {
            let near = |(k, curvature): &(Hypothesis, Matrix)| {
                let d = difference(k.map_from_odom, h.map_from_odom, self.pivot);
                d[0].hypot(d[1]) < 0.5 * SAME_PLACE && d[2].abs() < 0.5 * SAME_HEADING
                    || d[0].hypot(d[1]) < FARTHEST && dot(times(curvature, d), d) < OVERLAP
            };
            if !kept.iter().any(near) {
                let curvature = h.normal.marginal(shared).damped(OPEN);
                kept.push((h, curvature));
            }
        }
        self.hypotheses = kept.into_iter().map(|(h, _)| h).collect();
    }
}

/// The standard deviation of an even law is its bound over this.
const SQRT_3: f64 = 1.732_050_807_568_877_2;
/// A step that promises less than this (nats) is not taken: a few hundredths of a standard deviation.
const SETTLED: f64 = 1e-3;
/// More hypotheses than this are not carried on.
const MOST_SEEDS: usize = 8000;
/// Standard deviations are enlarged by this while cells are judged.
const SEED_TEMPER: f64 = 1.5;

/// The hypotheses without all but the best of those that meet, as `best` tells their cost and step to it; the robot is at
/// `odom_from_robot`.
pub(super) fn merged(
    hypotheses: Vec<Hypothesis>,
    scene: &Scene<'_>,
    odom_from_robot: Pose2,
    best: impl Fn(&Hypothesis) -> (f64, [f64; 3]),
) -> Vec<Hypothesis> {
    let size = if hypotheses.len() > MANY { [ROUGH_PLACE, ROUGH_HEADING] } else { [SAME_PLACE, SAME_HEADING] };
    let mut keyed: Vec<_> = hypotheses
        .iter()
        .enumerate()
        .map(|(index, h)| {
            let (cost, d) = best(h);
            (cell(moved(h.map_from_odom, scene.pivot, d), scene.pivot, odom_from_robot, size), cost, index)
        })
        .collect();
    keyed.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    keyed.dedup_by(|later, kept| later.0 == kept.0);
    let mut kept = vec![false; hypotheses.len()];
    keyed.iter().for_each(|&(.., index)| kept[index] = true);
    hypotheses.into_iter().zip(kept).filter_map(|(h, kept)| kept.then_some(h)).collect()
}

/// The cell of a frame's pose of the pivot and of the robot.
fn cell(at: Pose2, pivot: Vec2, odom_from_robot: Pose2, size: [f64; 2]) -> [i64; 5] {
    let (a, b) = (at.transform_point(pivot), at.compose(odom_from_robot));
    let round = |v: f64, by: f64| (v / by).round() as i64;
    let place = |v: f64| round(v, size[0]);
    [place(a.x), place(a.y), place(b.x), place(b.y), round(at.theta, size[1])]
}

/// The rows that judge seeds: the onset, then one for every `step` of the base's travel; of three neighbours always
/// that with the middle reading, so that no single false one is taken.
fn judging_rows(history: &History, feeler: usize, onset: usize, step: f64) -> Vec<usize> {
    let last = history.len() - 1;
    let mut rows = vec![onset];
    let mut travelled = 0.0;
    for row in onset + 1..last {
        travelled += history.pose(row).position().distance(history.pose(row - 1).position());
        if travelled >= step {
            let mut three = [row - 1, row, row + 1];
            three.sort_by(|&a, &b| history.readings(a)[feeler].total_cmp(&history.readings(b)[feeler]));
            if three[1] > rows[rows.len() - 1] {
                rows.push(three[1]);
                travelled = 0.0;
            }
        }
    }
    rows
}
