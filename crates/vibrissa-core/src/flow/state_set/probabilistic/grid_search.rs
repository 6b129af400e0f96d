//! Global localization: a grid over every place of the boundary, every heading and every branch \[thrun2005probabilistic, sec. 8.2\],
//! pruned by the readings of one contact.
//!
//! Where the whisker was free before, the row at which it began to touch puts the straight whisker's tip on the
//! boundary; otherwise a reading gives the tip for each direction of the force and each branch. Either way two numbers
//! are open, the place along the boundary and the heading. Each cell of them is run through a few well separated
//! readings as a Gaussian as wide as the cell, and most die at the first.

mod cell;
mod seeds;

pub(super) use cell::Cell;

use super::admission::Admits;
use super::information::by_cost;
use super::map_symmetry::MapSymmetries;
use super::measurement::MeasurementModel;
use super::shared_runs::{ContactExtent, SharedRun, WallContact};
use crate::config::TipLoad;
use crate::contact::follow::WhiskerState;
use crate::flow::contact_set::TipContactSet;
use crate::plane::{Bounds, Pose2, Vec2, wrap_angle};
use cell::{best_frame, forward, run};
use core::f64::consts::{PI, TAU};
use seeds::{Seed, for_each_place, from_odom, headings_at_touch, loaded, sharp_corners, touching};

/// Rounds of refinement.
const ROUNDS: usize = 2;
/// A side begins so far off a corner (m), and with no more of the whisker's length than this share before it.
const JUST_OFF: f64 = 1e-4;
const LONGEST_ARM: f64 = 0.97;
/// Cells nearer to each other than this are one (m, rad), while there are many and when there are few.
const SAME: [[f64; 2]; 2] = [[2.5e-3, 0.04], [1.2e-3, 0.015]];
const MANY: usize = 100;
/// With more cells than this a contact is followed for longer.
const MANY_CELLS: usize = 1000;

/// Readings that are run for one row of the log: at least (some milliseconds), and for each place of the boundary. A place costs some hundred.
const LEAST_WORK: usize = 4000;
const WORK_OF_A_PLACE: f64 = 3.0;

/// Where a contact began, and which rows judge it.
pub(super) struct ContactOnset {
    /// Index of the sensor that is read.
    pub(super) sensor: usize,
    /// The row of the first touch.
    pub(super) row: usize,
    /// Whether the whisker was free before.
    pub(super) from_free: bool,
    /// How the tip moved before the touch, whisker frame (m).
    pub(super) approach: Vec2,
    /// The rows that judge, in order, after the first.
    pub(super) rows: Vec<usize>,
    /// Spacing along the boundary (m) and of headings (rad).
    pub(super) spacing: f64,
    pub(super) turn: f64,
    /// Where the tip can be with the first pose in the prior's region.
    pub(super) near: Option<Bounds>,
    /// What the sensor read while its whisker was free, where its zero drifts.
    pub(super) level: f64,
    /// Standard deviations of the gain, and of the zero about that.
    pub(super) priors: [f64; 2],
}

/// The search, which can be left and taken up again: cells one after the other, then rounds of refinement.
pub(super) struct GridSearch {
    onset: ContactOnset,
    /// Where the tip may be: pieces and parameters, and which is next.
    places: Vec<(u32, f64)>,
    next: usize,
    /// Corners on which a side may have come to lie, with the directions in which they point, and which is next.
    corners: Vec<(Vec2, f64)>,
    next_corner: usize,
    /// The shapes of a whisker that is loaded already.
    branches: Vec<TipContactSet>,
    found: Vec<Cell>,
    /// The round of refinement, and what it has not come to yet.
    round: usize,
    left: Option<Vec<Cell>>,
    /// For each heading (and branch) what a cell on a straight wall has come to in this round.
    shared_runs: Vec<Option<SharedRun>>,
}

impl GridSearch {
    /// Over the whole map, or over the share that stands for all where it is symmetric.
    pub(super) fn new(model: &MeasurementModel<'_>, onset: ContactOnset, symmetries: Option<&MapSymmetries>) -> Self {
        let counts = |place: Vec2| symmetries.is_none_or(|all| all.is_representative(place));
        let sensor = &model.sensors[onset.sensor];
        let z = model.window.readings(onset.row)[onset.sensor];
        let branches = if onset.from_free {
            Vec::new()
        } else {
            TipContactSet::branches(&sensor.tip, sensor.reading(z), TipLoad::BoundaryNormal)
        };
        let mut places = Vec::new();
        for_each_place(&model.ground.pieces, onset.spacing, |piece, at| {
            if counts(model.ground.pieces[piece as usize].spot(at).position) {
                places.push((piece, at));
            }
        });
        let mut corners = if onset.from_free { sharp_corners(model) } else { Vec::new() };
        corners.retain(|&(corner, _)| counts(corner));
        Self {
            onset,
            places,
            next: 0,
            corners,
            next_corner: 0,
            branches,
            found: Vec::new(),
            round: 0,
            left: None,
            shared_runs: Vec::new(),
        }
    }

    pub(super) fn onset(&self) -> &ContactOnset {
        &self.onset
    }

    /// Readings that are run through the forward model for one row of the log: in proportion to the outline, so that the search takes about as
    /// many rows on any map.
    pub(super) fn work_of_a_row(&self) -> usize {
        LEAST_WORK.max((self.places.len() as f64 * WORK_OF_A_PLACE) as usize)
    }

    /// Goes on with more rows.
    pub(super) fn resume(&mut self, rows: Vec<usize>) {
        self.onset.rows = rows;
        self.round = 0;
    }

    /// Goes on until `work` (readings run through the forward model) is used up; whether it has come to the end. `admits`
    /// says whether the odometry frame can be there, `is_last` that no more readings of this contact will follow.
    pub(super) async fn step(
        &mut self,
        model: &MeasurementModel<'_>,
        admits: &Admits<'_>,
        is_last: bool,
        work: &mut usize,
    ) -> bool {
        while let Some(&(piece, at)) = self.places.get(self.next) {
            if *work == 0 {
                return false;
            }
            self.try_place(model, piece, at, admits, work).await;
            self.next += 1;
        }
        while let Some(&(corner, outward)) = self.corners.get(self.next_corner) {
            if *work == 0 {
                return false;
            }
            self.try_corner(model, corner, outward, admits, work).await;
            self.next_corner += 1;
        }
        while self.left.is_some() || self.round < self.rounds(is_last) {
            if !self.refine(model, work).await {
                return false;
            }
            self.round += 1;
        }
        true
    }

    /// Rounds of refinement: one where there are many cells and more readings will follow.
    fn rounds(&self, is_last: bool) -> usize {
        if !is_last && self.is_many() { 1 } else { ROUNDS }
    }

    /// Whether there are so many cells that the contact is to be followed for longer.
    pub(super) fn is_many(&self) -> bool {
        self.found.len() > MANY_CELLS
    }

    /// The cells that explain the readings, each at its best place, the best first.
    pub(super) fn into_found(mut self, model: &MeasurementModel<'_>) -> Vec<Cell> {
        self.found.retain(Cell::explains);
        self.join(model);
        self.found.sort_by(|a, b| by_cost(a.best.0, b.best.0));
        self.found.iter_mut().for_each(|cell| cell.frame = best_frame(cell, pivot(model, &self.onset)));
        self.found
    }

    /// All headings at one place of the boundary.
    async fn try_place(
        &mut self,
        model: &MeasurementModel<'_>,
        piece: u32,
        at: f64,
        admits: &Admits<'_>,
        work: &mut usize,
    ) {
        let spot = model.ground.pieces[piece as usize].spot(at);
        if self.onset.near.is_some_and(|near| !near.contains(spot.position)) {
            return;
        }
        *work = work.saturating_sub(1);
        if self.onset.from_free {
            for (k, off) in headings_at_touch(self.onset.turn).enumerate() {
                let heading = spot.normal + PI + off;
                if let Some(seed) = touching(model, &self.onset, piece, at, heading, admits) {
                    self.test(model, &seed, k, work).await;
                }
            }
            model.works(1).await;
            return;
        }
        let count = (TAU / self.onset.turn).ceil() as usize;
        for branch in 0..self.branches.len() {
            for k in 0..count {
                let heading = wrap_angle(k as f64 * TAU / count as f64);
                let seed = loaded(model, &self.onset, &self.branches[branch], piece, at, heading, admits);
                if let Some(seed) = seed {
                    self.test(model, &seed, branch * count + k, work).await;
                }
            }
            model.works(1).await;
        }
    }

    /// All headings and all places along the whisker where its side touched a corner.
    async fn try_corner(
        &mut self,
        model: &MeasurementModel<'_>,
        corner: Vec2,
        outward: f64,
        admits: &Admits<'_>,
        work: &mut usize,
    ) {
        let length = model.sensors[self.onset.sensor].length;
        if self.onset.near.is_some_and(|near| !near.contains(corner)) {
            return;
        }
        let just_off = corner + Vec2::from_angle(outward) * JUST_OFF;
        let headings = (TAU / self.onset.turn).ceil() as usize;
        let places = (LONGEST_ARM * length / self.onset.spacing).ceil() as usize;
        for heading in (0..headings).map(|k| wrap_angle(k as f64 * TAU / headings as f64)) {
            let before = *work;
            let along = Vec2::from_angle(heading);
            for place in 0..places {
                let base = just_off - along * ((place as f64 + 0.5) * self.onset.spacing);
                *work = work.saturating_sub(1);
                if !model.map.is_free(base) || model.map.crosses(base, base + along * length) {
                    continue;
                }
                let frame = from_odom(model, &self.onset, Pose2::new(base.x, base.y, heading));
                if admits(frame) {
                    let found = run(model, &self.onset, frame, WhiskerState::Free, true, work, &mut None);
                    self.found.extend(found);
                }
            }
            model.works(before.saturating_sub(*work)).await;
        }
    }

    /// Keeps the cell of a heading if the readings do not kill it.
    async fn test(&mut self, model: &MeasurementModel<'_>, seed: &Seed, heading: usize, work: &mut usize) {
        if seed.is_clear(model) {
            let frame = from_odom(model, &self.onset, seed.pose);
            let before = *work;
            let found = self.run(model, frame, (seed.state, Some(heading)), true, work);
            self.found.extend(found);
            model.works(before - *work).await;
        }
    }

    /// What a cell comes to whose whisker begins like this, run or known from its like.
    fn run(
        &mut self,
        model: &MeasurementModel<'_>,
        frame: Pose2,
        (state, heading): (WhiskerState, Option<usize>),
        whole: bool,
        work: &mut usize,
    ) -> Option<Cell> {
        let (Some(wall), Some(class)) = (WallContact::of(model.ground, &state), heading) else {
            return run(model, &self.onset, frame, state, whole, work, &mut None);
        };
        if self.shared_runs.len() <= class {
            self.shared_runs.resize(class + 1, None);
        }
        if let Some(known) = self.shared_runs[class].as_ref().and_then(|run| run.at(&wall, frame.theta)) {
            *work = work.saturating_sub(1);
            return known;
        }
        let mut extent = Some(ContactExtent::new(wall));
        let mut found = run(model, &self.onset, frame, state, whole, work, &mut extent);
        if let Some(cell) = &mut found {
            cell.heading = heading;
        }
        match SharedRun::new(extent, frame.theta, found.as_ref()) {
            Some(run) => self.shared_runs[class] = Some(run),
            None => found.iter_mut().for_each(|cell| cell.heading = None),
        }
        found
    }

    /// Moves each cell to its best place and drops those that stay bad, and all but the best of those that meet.
    async fn refine(&mut self, model: &MeasurementModel<'_>, work: &mut usize) -> bool {
        if self.left.is_none() {
            self.join(model);
            self.shared_runs.clear();
            let mut left = core::mem::take(&mut self.found);
            left.reverse();
            self.left = Some(left);
        }
        while *work > 0 {
            let Some(cell) = self.left.as_mut().and_then(Vec::pop) else {
                self.left = None;
                return true;
            };
            if cell.readings == self.onset.rows.len() && cell.is_at_best() {
                self.found.push(cell);
                continue;
            }
            let to = best_frame(&cell, pivot(model, &self.onset));
            let mut state = cell.state;
            let sensor = &model.sensors[self.onset.sensor];
            let odom_from_whisker = model.window.pose(self.onset.row).compose(sensor.robot_from_whisker);
            let (before, now) = (cell.frame.compose(odom_from_whisker), to.compose(odom_from_whisker));
            if state != WhiskerState::Free {
                forward(model, sensor).advance(&mut state, before, now, true);
            }
            let before = *work;
            let found = self.run(model, to, (state, cell.heading), false, work);
            self.found.extend(found);
            model.works(before - *work).await;
        }
        false
    }

    /// Keeps the best of cells that lead to the same place.
    fn join(&mut self, model: &MeasurementModel<'_>) {
        let last = self.onset.rows.last().copied().unwrap_or(self.onset.row);
        let pivot = pivot(model, &self.onset);
        let size = SAME[usize::from(self.found.len() <= MANY)];
        let at = self.found.iter().map(|cell| (best_frame(cell, pivot), cell.best.0));
        let mut kept = best_of_cells(at, pivot, model.window.pose(last), size).into_iter();
        self.found.retain(|_| kept.next() == Some(true));
    }
}

/// The place of the tip at the onset, odometry frame.
fn pivot(model: &MeasurementModel<'_>, onset: &ContactOnset) -> Vec2 {
    let sensor = &model.sensors[onset.sensor];
    let odom_from_whisker = model.window.pose(onset.row).compose(sensor.robot_from_whisker);
    odom_from_whisker.transform_point(Vec2::new(sensor.length, 0.0))
}

/// Which of these frames, each with its cost, are the best of those that they meet; the robot is at `odom_from_robot`.
pub(super) fn best_of_cells(
    frames: impl Iterator<Item = (Pose2, f64)>,
    pivot: Vec2,
    odom_from_robot: Pose2,
    size: [f64; 2],
) -> Vec<bool> {
    let round = |v: f64, by: f64| (v / by).round() as i64;
    let key = |(index, (at, cost)): (usize, (Pose2, f64))| {
        let (a, b) = (at.transform_point(pivot), at.compose(odom_from_robot));
        let place = [a.x, a.y, b.x, b.y].map(|v| round(v, size[0]));
        ((place, round(at.theta, size[1])), cost, index)
    };
    let mut keyed: Vec<_> = frames.enumerate().map(key).collect();
    let mut kept = vec![false; keyed.len()];
    keyed.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(by_cost(a.1, b.1)).then(a.2.cmp(&b.2)));
    keyed.dedup_by(|later, kept| later.0 == kept.0);
    keyed.iter().for_each(|&(.., index)| kept[index] = true);
    kept
}
