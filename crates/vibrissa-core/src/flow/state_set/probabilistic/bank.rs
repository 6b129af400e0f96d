//! The bank of modes: a multi-hypothesis smoother \[reid1979algorithm\] whose modes are refitted to all rows of the window as it grows
//! \[dellaert2017factor, ch. 2\]; older rows are marginalised \[sibley2010sliding\]. At the end of a log `refinement` fits them to all rows.

mod refinement;

use super::admission::Admits;
use super::correlated_noise::NoiseModel;
use super::grid_search::best_of_cells;
use super::information::{Information, by_cost};
use super::map_symmetry::MapSymmetries;
use super::measurement::{Linearisation, MeasurementModel};
use super::optimisation::{GRADUATED_RUNS, Mode};
use super::state::{Prior, Start, difference};
use super::unknowns::POSE;
use crate::linear_algebra::{determinant, dot, times};
use crate::plane::Pose2;
use core::ops::Range;

/// Travel of a whisker between two rows that modes are compared by (m).
const KEY_STEP: f64 = 3e-3;
/// Modes take in so many rows together, and of those that they are compared by so many at once where there are many modes.
pub(super) const TAKEN_TOGETHER: usize = 24;
const AT_ONCE: usize = 8;
/// Readings that are run again at most, about, each time that rows are taken in.
const TAKES: usize = 6_000;
/// The same where the readings that have come are unexplained: modes that wait for it may be the true one. Of 600 beginnings of logs that robots
/// made in 150 rooms, the true place is not told in 26, and three of these are localized, with 30,000 and no search for events before modes are
/// dropped; in 21, none of them localized, with both.
const OFF_TAKES: usize = 200_000;
/// A mode is fitted anew when that promises so much (nats).
const MOVED: f64 = 1.0;
/// Modes nearer to each other than this are one (m, rad), while there are many and when there are few.
const SAME: [[f64; 2]; 2] = [[2.5e-3, 0.04], [1.2e-3, 0.015]];
const MANY: usize = 100;
/// Modes that lie within another's region (squared standard deviations) and no further away (m) are one when no row will follow.
const OVERLAP: f64 = 0.5;
const FARTHEST: f64 = 0.05;
/// Modes nearer to each other than this (m, rad) are told on the same side of a symmetric map.
const SAME_SIDE: [f64; 2] = [60e-3, 0.2];
/// So near (m, rad) they are one whatever these say.
const EQUAL: [f64; 2] = [3e-5, 3e-4];
/// Inverse variances that keep covariances finite (20 mm, 20°).
pub(super) const WEAK_PRIOR: [f64; POSE] = [2.5e3, 2.5e3, 8.2];

/// So many modes are compared with another in the time in which a reading is run.
const COMPARED: usize = 40;
/// Steps over all rows.
const STEPS: usize = 10;
/// Slack for modes that are not at their least yet (nats).
pub(super) const SLACK: f64 = 8.0;

/// Modes and the rows that they have been fitted to.
#[derive(Clone)]
pub(super) struct Bank {
    pub(super) modes: Vec<Mode>,
    /// Rows of the window that they were last fitted to.
    pub(super) rows: Vec<usize>,
    /// Rows that the window had then.
    pub(super) seen: usize,
    /// Whether each mode stands for all its images on a symmetric map.
    pub(super) by_symmetry: bool,
    /// Whether its modes have been fitted to any rows.
    pub(super) is_fitted: bool,
    /// The rows that are being taken in.
    pending: Option<Extension>,
    scratch: Linearisation,
}

/// Rows that are taken in over several calls.
#[derive(Clone)]
struct Extension {
    rows: Vec<usize>,
    /// The modes with these rows, as far as they have come,
    carried: Vec<Mode>,
    /// and once all have, those that are still to be refitted, the first last, within so many readings.
    refits: Option<(Vec<usize>, usize)>,
}

/// How thoroughly modes are fitted, and how much costlier than the best one may be (nats).
#[derive(Clone, Copy)]
pub(super) struct Effort {
    pub(super) takes: usize,
    pub(super) steps: usize,
    pub(super) gate: f64,
}

impl Effort {
    /// While rows come.
    pub(super) const ONLINE: Self = Self { takes: TAKES, steps: 2, gate: 25.0 };
}

impl Bank {
    pub(super) fn new(modes: Vec<Mode>, by_symmetry: bool) -> Self {
        Self {
            modes,
            rows: Vec::new(),
            seen: 0,
            by_symmetry,
            is_fitted: false,
            pending: None,
            scratch: Linearisation::default(),
        }
    }

    /// How many places each mode stands for.
    pub(super) fn times(&self, symmetries: &MapSymmetries) -> usize {
        if self.by_symmetry { symmetries.order() } else { 1 }
    }

    /// Lets every image of a mode stand for itself, where something tells them apart.
    pub(super) fn expand_images(&mut self, symmetries: &MapSymmetries) {
        if core::mem::take(&mut self.by_symmetry) {
            let images = |mode: &Mode| symmetries.all.iter().map(|turn| mode.turned(turn)).collect::<Vec<_>>();
            let all: Vec<Mode> = self.modes.iter().flat_map(images).collect();
            self.modes.extend(all);
        }
    }

    /// Turns modes to where better ones are, so that none stands at an image of another's place; the best come first.
    pub(super) async fn gather_images(&mut self, symmetries: &MapSymmetries, model: &MeasurementModel<'_>) {
        if !self.by_symmetry {
            return;
        }
        let near = |a: Pose2, b: Pose2| {
            let [x, y, turn] = difference(a, b, model.pivot());
            x.hypot(y) < SAME_SIDE[0] && turn.abs() < SAME_SIDE[1]
        };
        let mut open = core::mem::take(&mut self.modes);
        while !open.is_empty() {
            let mut next = self.modes.len();
            self.modes.push(open.remove(0));
            while let Some(at) = self.modes.get(next).map(|mode| mode.state.frame) {
                let mut rest = Vec::new();
                for mode in open {
                    let frame = mode.state.frame;
                    if near(at, frame) {
                        self.modes.push(mode);
                    } else if let Some(turn) = symmetries.all.iter().find(|t| near(at, t.motion.compose(frame))) {
                        self.modes.push(mode.turned(turn));
                    } else {
                        rest.push(mode);
                    }
                }
                open = rest;
                next += 1;
            }
        }
        self.sort(model).await;
    }

    /// Takes in the rows that have come at once, see [`Self::advance`].
    pub(super) async fn extend(&mut self, model: &MeasurementModel<'_>, admits: &Admits<'_>, effort: Effort) {
        self.advance(model, admits, effort, &mut { usize::MAX }).await;
        loop {
            self.begin(model, admits).await;
            self.advance(model, admits, effort, &mut { usize::MAX }).await;
            if self.seen == model.window.len() {
                return;
            }
        }
    }

    /// Fits all anew to the rows when the next ones are taken in: readings have been left out.
    pub(super) fn forget_fits(&mut self) {
        self.pending = None;
        self.modes.iter_mut().for_each(|mode| (mode.end, mode.is_off) = (None, false));
    }

    /// Whether the best mode explains the rows that it was last fitted to, from this one of the window on.
    pub(super) async fn explains_from(&mut self, model: &MeasurementModel<'_>, row: usize) -> bool {
        let Some(mode) = self.modes.first() else { return false };
        let newest = self.rows.iter().filter(|&&own| own >= row).count() * model.sensors.len();
        !mode.is_off_at(model, &self.rows, newest, &mut self.scratch).await
    }

    /// Whether rows are being taken in.
    pub(super) fn is_busy(&self) -> bool {
        self.pending.is_some()
    }

    /// Whether the modes can be weighed now.
    pub(super) fn is_whole(&self) -> bool {
        self.pending.is_none() || self.modes.len() <= MANY
    }

    /// Begins to take in the rows that have come; where there are many modes only the first of these, since most modes will not be there for
    /// the others.
    pub(super) async fn begin(&mut self, model: &MeasurementModel<'_>, admits: &Admits<'_>) {
        self.keep_admitted(model, admits).await;
        let all = model.window.len();
        let mut rows = key_rows(model, self.rows.last().copied(), self.seen..all);
        self.seen = all;
        if self.modes.len() > MANY && rows.len() > AT_ONCE {
            self.seen = rows[AT_ONCE];
            rows.truncate(AT_ONCE);
        }
        self.rows.extend(&rows);
        self.pending = Some(Extension { rows, carried: Vec::with_capacity(self.modes.len()), refits: None });
    }

    /// Goes on taking in rows until `work` (readings run through the forward model) is used up; whether all is done. Every mode goes on from
    /// where it stands, and those that the new readings move are fitted anew, as far as the effort allows; kept are those that explain all
    /// about as well as the best. Until every mode has the rows none has.
    pub(super) async fn advance(
        &mut self,
        model: &MeasurementModel<'_>,
        admits: &Admits<'_>,
        effort: Effort,
        work: &mut usize,
    ) -> bool {
        let Some(mut pending) = self.pending.take() else { return true };
        let sensors = model.sensors.len().max(1);
        while pending.refits.is_none() {
            let Some(mode) = self.modes.get(pending.carried.len()) else {
                self.modes = core::mem::take(&mut pending.carried);
                self.prune(effort.gate);
                let is_off = self.modes.iter().any(|mode| mode.is_off);
                let takes = if is_off { effort.takes.max(OFF_TAKES) } else { effort.takes };
                pending.refits = Some((self.most_promising(), takes));
                break;
            };
            if *work == 0 {
                self.pending = Some(pending);
                return false;
            }
            let mut mode = if self.modes.len() > MANY {
                // Of many nothing but where they stand is asked until all have the rows.
                let place = Mode::new(mode.state.clone(), Start::free(0), &[]);
                core::mem::replace(&mut self.modes[pending.carried.len()], place)
            } else {
                mode.clone()
            };
            let rows = if mode.end.is_some() {
                mode.carry_on(model, &pending.rows, &mut self.scratch).await;
                pending.rows.len()
            } else {
                mode.relinearise(model, &self.rows, &mut self.scratch).await;
                self.rows.len()
            };
            *work = work.saturating_sub((rows + 1) * sensors);
            pending.carried.push(mode);
        }
        let each = 2 * effort.steps * self.rows.len();
        while let Some((order, left)) = &mut pending.refits {
            let Some(index) = order.pop().filter(|_| *left >= self.rows.len()) else { break };
            let mode = &mut self.modes[index];
            let before = *left;
            if mode.gain() > MOVED {
                *left = left.saturating_sub(each);
                mode.descend(model, &self.rows, effort.steps, &mut self.scratch).await;
            }
            if core::mem::take(&mut mode.is_off)
                && mode.is_off_at(model, &self.rows, pending.rows.len() * sensors, &mut self.scratch).await
            {
                *left = left.saturating_sub(GRADUATED_RUNS * self.rows.len());
                mode.descend_graduated(model, &self.rows, &mut self.scratch).await;
            }
            if *left > self.rows.len() && mode.might_move(MOVED) {
                *left = left.saturating_sub(each);
                mode.descend_independently(model, &self.rows, effort.steps, &mut self.scratch).await;
            }
            *work = work.saturating_sub((before - *left) * sensors);
            if *work == 0 {
                self.pending = Some(pending);
                return false;
            }
        }
        self.modes.sort_by(|a, b| by_cost(a.evidence(), b.evidence()));
        self.keep_admitted(model, admits).await;
        self.prune(effort.gate);
        self.join(model).await;
        self.is_fitted = true;
        true
    }

    /// The modes in the order of what refitting them promises, the most last, those that are off first of all, the likeliest before others:
    /// what is not refitted in time seems to be wrong when the next corner comes.
    fn most_promising(&self) -> Vec<usize> {
        let promise = |mode: &Mode| if mode.is_off { (f64::INFINITY, -mode.evidence()) } else { (mode.gain(), 0.0) };
        let mut order: Vec<((f64, f64), usize)> = self.modes.iter().map(promise).zip(0..).collect();
        order.sort_by(|(a, _), (b, _)| by_cost(a.0, b.0).then(by_cost(a.1, b.1)));
        order.into_iter().map(|(_, index)| index).collect()
    }

    /// Linearises all modes by the rows.
    async fn relinearise(&mut self, model: &MeasurementModel<'_>) {
        for mode in &mut self.modes {
            mode.relinearise(model, &self.rows, &mut self.scratch).await;
        }
    }

    /// Keeps modes that may be where they stand.
    async fn keep_admitted(&mut self, model: &MeasurementModel<'_>, admits: &Admits<'_>) {
        let mut kept = Vec::with_capacity(self.modes.len());
        for mode in core::mem::take(&mut self.modes) {
            if admits(mode.state.frame) {
                kept.push(mode);
            }
            model.works(1).await;
        }
        self.modes = kept;
    }

    /// The same modes, fitted to the same rows.
    pub(super) async fn copy(&self, model: &MeasurementModel<'_>) -> Self {
        let mut copy = Self {
            rows: self.rows.clone(),
            is_fitted: self.is_fitted,
            seen: self.seen,
            ..Self::new(Vec::new(), self.by_symmetry)
        };
        for mode in &self.modes {
            copy.modes.push(mode.clone());
            model.works(1).await;
        }
        copy
    }

    /// Keeps modes that cost, or promise to cost, no more than so much above the best as it stands, and beside these, as long as there are not
    /// many, the likeliest of those that are off and have not been refitted yet: where nearly all of many modes come to an event at once, the
    /// few that do not are no better.
    fn prune(&mut self, gate: f64) {
        let least = self.modes.iter().map(Mode::evidence_here).fold(f64::INFINITY, f64::min);
        let is_kept = |mode: &Mode| mode.evidence() <= least + gate;
        let mut kept: Vec<bool> = self.modes.iter().map(is_kept).collect();
        let count = kept.iter().filter(|kept| **kept).count();
        let waiting = self.modes.iter().map(Mode::evidence).zip(0..);
        let waiting = waiting.filter(|(_, index)| !kept[*index] && self.modes[*index].is_off).collect();
        likeliest_first(waiting)
            .into_iter()
            .take(MANY.saturating_sub(count))
            .for_each(|index: usize| kept[index] = true);
        let mut kept = kept.into_iter();
        self.modes.retain(|_| kept.next() == Some(true));
    }

    /// Keeps the best of modes that have run into each other, those of the largest evidence first.
    pub(super) async fn join(&mut self, model: &MeasurementModel<'_>) {
        let size = SAME[usize::from(self.modes.len() <= MANY)];
        let evidences = self.evidences(model).await;
        let at = self.modes.iter().map(|mode| mode.state.frame).zip(evidences.iter().copied());
        let kept = best_of_cells(at, model.pivot(), model.window.last_pose(), size);
        let modes = evidences.into_iter().zip(self.modes.drain(..)).zip(kept);
        self.modes = likeliest_first(modes.filter_map(|(keyed, kept)| kept.then_some(keyed)).collect());
    }

    /// Those of the largest evidence first.
    pub(super) async fn sort(&mut self, model: &MeasurementModel<'_>) {
        let evidences = self.evidences(model).await;
        self.modes = likeliest_first(evidences.into_iter().zip(self.modes.drain(..)).collect());
    }

    /// Minus the logarithm of each mode's evidence.
    async fn evidences(&self, model: &MeasurementModel<'_>) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.modes.len());
        for mode in &self.modes {
            all.push(evidence(mode, model));
            model.works(1).await;
        }
        all
    }

    /// Keeps the best of modes within each other's region, of those that explain the same readings: one that explains what the other does not
    /// knows of an event of which the other's region says nothing.
    pub(super) async fn join_overlapping(&mut self, model: &MeasurementModel<'_>) {
        self.sort(model).await;
        let mut kept: Vec<(Mode, Information<POSE>, Option<Vec<usize>>)> = Vec::new();
        for mode in core::mem::take(&mut self.modes) {
            let mut unexplained: Option<Vec<usize>> = None;
            let mut is_known = false;
            for (other, told, theirs) in &mut kept {
                let d = difference(other.state.frame, mode.state.frame, model.pivot());
                let apart = d[0].hypot(d[1]);
                if apart < EQUAL[0] && d[2].abs() < EQUAL[1] {
                    is_known = true;
                    break;
                }
                if apart >= FARTHEST || dot(times(&told.damped(WEAK_PRIOR), d), d) >= OVERLAP {
                    continue;
                }
                // Only what lies within another's region is run again.
                for (mode, rows) in [(&*other, &mut *theirs), (&mode, &mut unexplained)] {
                    if rows.is_none() {
                        model.run(&mode.state, &mode.start, &self.rows, &mut self.scratch).await;
                        *rows = Some(self.scratch.unexplained_or_unknown());
                    }
                }
                let own = unexplained.as_deref().unwrap_or_default();
                if theirs.iter().flatten().all(|row| own.contains(row)) {
                    is_known = true;
                    break;
                }
            }
            if !is_known {
                let told = mode.marginal(model);
                kept.push((mode, told, unexplained));
            }
            model.works(1 + kept.len() / COMPARED).await;
        }
        self.modes = kept.into_iter().map(|(mode, ..)| mode).collect();
    }

    /// The linearisation of the best mode.
    pub(super) async fn run(&mut self, model: &MeasurementModel<'_>) -> &Linearisation {
        let rows = core::mem::take(&mut self.rows);
        self.run_rows(model, &rows).await;
        self.rows = rows;
        &self.scratch
    }

    /// The same over other rows.
    pub(super) async fn run_rows(&mut self, model: &MeasurementModel<'_>, rows: &[usize]) -> &Linearisation {
        if let Some(mode) = self.modes.first() {
            model.run(&mode.state, &mode.start, rows, &mut self.scratch).await;
        }
        &self.scratch
    }

    /// Expresses every mode by its pose at this row.
    pub(super) fn anchor(&mut self, model: &MeasurementModel<'_>, row: usize) {
        self.modes.iter_mut().for_each(|mode| mode.state = model.anchored(&mode.state, row));
    }

    /// Moves every mode to its least cost over the rows that modes are compared by, before rows are marginalised: what these say is never
    /// linearised again.
    pub(super) async fn converge(&mut self, model: &MeasurementModel<'_>) {
        for mode in &mut self.modes {
            mode.relinearise(model, &self.rows, &mut self.scratch).await;
            mode.descend(model, &self.rows, STEPS, &mut self.scratch).await;
        }
    }

    /// Marginalises the first `count` rows; the window forgets them afterwards. `forgetting` is the weight that they keep.
    pub(super) async fn marginalise(&mut self, model: &MeasurementModel<'_>, count: usize, forgetting: f64) {
        let rows: Vec<usize> = (0..count).collect();
        for mode in &mut self.modes {
            let ends = model.run(&mode.state, &mode.start, &(0..=count).collect::<Vec<_>>(), &mut self.scratch).await;
            let there = MeasurementModel { anchor: count, ..*model };
            let state = model.anchored(&mode.state, count);
            let (noise, _) = mode.estimated_noise(model, &self.rows, &mut self.scratch).await;
            // What a bound says where it is touched is no Gaussian, which would tell as much of the other side.
            let mut early = mode.by(NoiseModel { bounded: false, ..noise });
            early.state = state.clone();
            early.relinearise(&there, &rows, &mut self.scratch).await;
            // What is known beside the readings is added again with those that follow.
            let mut own = early.equations().clone();
            there.remove_shared(&state, &mut own);
            model.loosen(&mut own);
            let equations = own.with_forgetting(forgetting);
            (mode.state, mode.end) = (state.clone(), None);
            mode.start = Start { prior: Some(Box::new(Prior { equations, at: state })), ..ends };
        }
        self.seen -= count;
        self.rows = self.rows.iter().filter_map(|row| row.checked_sub(count)).collect();
    }
}

/// In the order of minus the logarithms of their evidences; of those that are equal the first stays first.
fn likeliest_first<T>(mut keyed: Vec<(f64, T)>) -> Vec<T> {
    keyed.sort_by(|a, b| by_cost(a.0, b.0));
    keyed.into_iter().map(|(_, one)| one).collect()
}

/// Laplace's approximation of minus the logarithm of a mode's evidence \[mackay2003information, ch. 27\]: in a corner of a facet the cost may
/// be a little lower over a range that is tiny.
fn evidence(mode: &Mode, model: &MeasurementModel<'_>) -> f64 {
    let told = mode.marginal(model);
    told.constant + 0.5 * determinant(&told.damped(WEAK_PRIOR)).max(f64::MIN_POSITIVE).ln()
}

/// The rows of these that modes are compared by, where `last` is the one before them: one each time that a whisker has moved far enough, or
/// has met or left a boundary.
pub(super) fn key_rows(model: &MeasurementModel<'_>, last: Option<usize>, of: Range<usize>) -> Vec<usize> {
    let window = model.window;
    let lever = model.sensors.iter().map(|sensor| sensor.length).fold(0.0, f64::max);
    let mut rows: Vec<usize> = Vec::new();
    let mut last = last;
    for row in of {
        let far = last.is_none_or(|last| {
            let step = window.pose(last).between(window.pose(row));
            step.position().norm().max(step.theta.abs() * lever) >= KEY_STEP
                || window.contacts(last) != window.contacts(row)
        });
        if far {
            rows.push(row);
            last = Some(row);
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_likeliest_come_first_and_equal_ones_stay_in_their_order() {
        let keyed = |values: &[f64]| values.iter().copied().zip(0..).collect::<Vec<(f64, usize)>>();
        assert_eq!(likeliest_first(keyed(&[3.0, 1.0, 2.0, 0.0])), [3, 1, 2, 0]);
        // Places along a wall differ by rounding alone: they stay in their order, whatever that is.
        for seed in 0..20 {
            let rounding = |k: usize| 1e-13 * (((k * 7919 + seed * 104_729) % 11) as f64 - 5.0);
            let values: Vec<f64> = (0..250).map(|k| 80.0 + rounding(k)).collect();
            assert_eq!(likeliest_first(keyed(&values)), (0..250).collect::<Vec<_>>());
        }
    }
}
