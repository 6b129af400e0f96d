//! Global localization: a grid over every place of the boundary, every heading and every branch \[thrun2005probabilistic, sec. 8.2\],
//! pruned by the readings of the first contact.
//!
//! Where the whisker was free before, the row at which it began to touch puts the straight whisker's tip on the
//! boundary; otherwise a reading gives the tip for each direction of the force and each branch. Either way two numbers
//! are open, the place along the boundary and the heading. Each cell of them is run through a few well separated
//! readings as a Gaussian as wide as the cell, and most die at the first.

use super::bank::{PredictedOptimum, best_of_cells, merge_cell_size};
use super::calibrated_path::CalibrationPrior;
use super::hypothesis::{GaussianHypothesis, MeasurementModel, moved};
use super::map_symmetry::MapSymmetries;
use super::packed_hypothesis::PackedHypothesis;
use super::shared_runs::{ContactExtent, SharedRun, WallContact};
use crate::config::TipLoad;
use crate::contact::Piece;
use crate::contact::follow::WhiskerState;
use crate::flow::contact_set::TipContactSet;
use crate::plane::{Bounds, Pose2, Vec2, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI, TAU};

/// Headings further than this from the boundary's normal are left out (rad).
const WIDEST: f64 = 1.45;
/// Cost above which a cell is dropped, and the same once it has been refined.
const CELL_COST: f64 = 20.0;
const REFINED_COST: f64 = 18.0;
/// Rounds of refinement.
const ROUNDS: usize = 3;
/// Share of the whisker that is kept clear of the boundaries when it begins to touch.
const CLEAR: f64 = 0.98;

/// What seeds are made from.
pub(super) struct ContactOnset<'a> {
    /// Index of the whisker that touches.
    pub(super) sensor: usize,
    /// The row of the first touch.
    pub(super) row: usize,
    /// Whether the whisker was free before.
    pub(super) from_free: bool,
    /// How the tip moved before the touch, whisker frame (m).
    pub(super) approach: Vec2,
    /// The rows that judge, in order, after the first.
    pub(super) rows: &'a [usize],
    /// Spacing along the boundary (m) and of headings (rad).
    pub(super) spacing: f64,
    pub(super) turn: f64,
    /// Turns of the map onto itself, where one place is to stand for all.
    pub(super) symmetries: Option<&'a MapSymmetries>,
    /// Where the tip can be with the first pose in the prior's region.
    pub(super) near: Option<Bounds>,
}

/// The search, which can be left and taken up again: cells one after the other, then rounds of refinement.
pub(super) struct GridSearch {
    /// Where the tip may be: pieces and parameters, and which is next.
    places: Vec<(u32, f64)>,
    next: usize,
    /// The shapes of a whisker that is loaded already.
    branches: Vec<TipContactSet>,
    found: Vec<PackedHypothesis>,
    /// The round of refinement, and what it has not come to yet, the last one first.
    round: usize,
    left: Option<Vec<PackedHypothesis>>,
    /// For each heading (and branch) what a cell on a straight wall has come to in this round.
    shared_runs: Vec<Option<SharedRun>>,
}

impl GridSearch {
    /// The search from the cells on, or from what an earlier one has found, to be judged by more rows.
    pub(super) fn new(model: &MeasurementModel<'_>, onset: &ContactOnset<'_>, carried: Vec<PackedHypothesis>) -> Self {
        if !carried.is_empty() {
            return Self {
                places: Vec::new(),
                next: 0,
                branches: Vec::new(),
                found: carried,
                round: 0,
                left: None,
                shared_runs: Vec::new(),
            };
        }
        let sensor = &model.sensors[onset.sensor];
        let z = model.history.readings(onset.row)[onset.sensor];
        let branches = if onset.from_free {
            Vec::new()
        } else {
            TipContactSet::branches(&sensor.tip, sensor.reading(z), TipLoad::BoundaryNormal)
        };
        let mut places = Vec::new();
        for_each_place(&model.ground.pieces, onset.spacing, |piece, at| {
            if onset
                .symmetries
                .is_none_or(|t| t.is_representative(model.ground.pieces[piece as usize].spot(at).position))
            {
                places.push((piece, at));
            }
        });
        Self { places, next: 0, branches, found: Vec::new(), round: 0, left: None, shared_runs: Vec::new() }
    }

    /// Goes on until `work` (readings run through the forward model) is used up; whether it has come to the end. `admits`
    /// says whether a `map_from_odom` is in the prior's region.
    pub(super) fn step(
        &mut self,
        model: &MeasurementModel<'_>,
        onset: &ContactOnset<'_>,
        admits: &dyn Fn(Pose2) -> bool,
        work: &mut usize,
    ) -> bool {
        while let Some(&(piece, at)) = self.places.get(self.next) {
            if *work == 0 {
                return false;
            }
            self.try_place(model, onset, piece, at, admits, work);
            self.next += 1;
        }
        while self.round < ROUNDS {
            if !self.refine(model, onset, work) {
                return false;
            }
            self.round += 1;
        }
        true
    }

    /// The hypotheses that explain the first readings.
    pub(super) fn into_found(mut self) -> Vec<PackedHypothesis> {
        self.found.shrink_to_fit();
        self.found
    }

    /// All headings at one place of the boundary.
    fn try_place(
        &mut self,
        model: &MeasurementModel<'_>,
        onset: &ContactOnset<'_>,
        piece: u32,
        at: f64,
        admits: &dyn Fn(Pose2) -> bool,
        work: &mut usize,
    ) {
        let spot = model.ground.pieces[piece as usize].spot(at);
        if onset.near.is_some_and(|near| !near.contains(spot.position)) {
            return;
        }
        *work = work.saturating_sub(1);
        let straight = WallContact::new(model.ground, piece, at);
        let touching = |heading: f64| touching(model, onset, piece, at, heading, admits);
        if onset.from_free {
            let count = (2.0 * WIDEST / onset.turn).ceil();
            for k in 0..count as usize {
                let heading = spot.normal + PI - WIDEST + (k as f64 + 0.5) * (2.0 * WIDEST / count);
                if let Some(cell) = touching(heading) {
                    self.test_cell(model, onset, (straight, k), cell, work);
                }
            }
            return;
        }
        let count = (TAU / onset.turn).ceil() as usize;
        for branch in 0..self.branches.len() {
            for k in 0..count {
                let heading = wrap_angle(k as f64 * TAU / count as f64);
                let set = &self.branches[branch];
                if let Some(cell) = loaded(model, onset, set, piece, at, heading, admits) {
                    self.test_cell(model, onset, (straight, branch * count + k), cell, work);
                }
            }
        }
    }

    /// Keeps the hypothesis that begins like this if the first readings do not kill its cell, the `heading_class`-th of its place.
    fn test_cell(
        &mut self,
        model: &MeasurementModel<'_>,
        onset: &ContactOnset<'_>,
        (straight, heading_class): (Option<WallContact>, usize),
        cell: SeedCell,
        work: &mut usize,
    ) {
        if self.shared_runs.len() <= heading_class {
            self.shared_runs.resize_with(heading_class + 1, || None);
        }
        if let Some(straight) = &straight
            && let Some(outcome) =
                self.shared_runs[heading_class].as_ref().and_then(|t| t.at(straight, cell.pose.theta))
        {
            *work = work.saturating_sub(1);
            self.found.extend(outcome.filter(|_| cell.is_clear(model)).as_ref().map(PackedHypothesis::of));
            return;
        }
        if !cell.is_clear(model) {
            return;
        }
        let mut span = ContactExtent::new(straight, model);
        let heading = cell.pose.theta;
        let mut found = tested(model, onset, cell.pose, cell.state, work, &mut span);
        if let Some(h) = &mut found {
            h.heading_class = Some(heading_class as u32);
        }
        match SharedRun::new(span, heading, found.as_ref()) {
            Some(twin) => self.shared_runs[heading_class] = Some(twin),
            None => found.iter_mut().for_each(|h| h.heading_class = None),
        }
        self.found.extend(found.as_ref().map(PackedHypothesis::of));
    }

    /// Moves each hypothesis to its best place and drops those that stay bad, and all but the best of those that meet.
    fn refine(&mut self, model: &MeasurementModel<'_>, onset: &ContactOnset<'_>, work: &mut usize) -> bool {
        let last = onset.rows.last().copied().unwrap_or(onset.row);
        let limit = if self.round + 1 == ROUNDS { REFINED_COST } else { CELL_COST };
        let round = self.round;
        if self.left.is_none() {
            self.shared_runs.clear();
            let all = core::mem::take(&mut self.found);
            let size = if round == 0 { [1.3 * onset.spacing, onset.turn] } else { merge_cell_size(all.len()) };
            let prospects = all.iter().map(|seed| {
                let (cost, d) = seed.place(0.0).least(cell(onset));
                PredictedOptimum { at: moved(seed.map_from_odom, model.pivot, d), cost }
            });
            let kept = best_of_cells(prospects, model.pivot, model.history.pose(last), size);
            let mut left: Vec<PackedHypothesis> =
                all.into_iter().zip(kept).filter_map(|(seed, kept)| kept.then_some(seed)).collect();
            left.shrink_to_fit();
            left.reverse();
            self.left = Some(left);
        }
        while *work > 0 {
            let Some(seed) = self.left.as_mut().and_then(Vec::pop) else {
                self.left = None;
                self.shared_runs.clear();
                return true;
            };
            let h = self.again(model, onset, seed.into_hypothesis(onset.row), work);
            if h.damped_step(cell(onset), CalibrationPrior::default()).0 <= limit {
                self.found.push(PackedHypothesis::of(&h));
            }
        }
        false
    }
}

impl GridSearch {
    /// A hypothesis at its best place, run through the first readings again.
    fn again(
        &mut self,
        model: &MeasurementModel<'_>,
        onset: &ContactOnset<'_>,
        mut h: GaussianHypothesis,
        work: &mut usize,
    ) -> GaussianHypothesis {
        let straight = h.heading_class.and_then(|_| WallContact::of(model.ground, &h));
        let heading = h.map_from_odom.theta;
        let heading_class = h.heading_class.map_or(0, |heading_class| heading_class as usize);
        if self.shared_runs.len() <= heading_class {
            self.shared_runs.resize_with(heading_class + 1, || None);
        }
        if let Some(straight) = &straight
            && let Some(Some(outcome)) =
                self.shared_runs[heading_class].as_ref().and_then(|twin| twin.at(straight, heading))
        {
            *work = work.saturating_sub(1);
            return outcome;
        }
        let mut span = ContactExtent::new(straight, model);
        let (_, d) = h.damped_step(cell(onset), CalibrationPrior::default());
        h.relinearise(model, moved(h.map_from_odom, model.pivot, d), core::iter::empty());
        for &row in onset.rows {
            h.add_row(model, row);
            span.iter_mut().for_each(|span| span.add(&h));
        }
        h.age = 0;
        *work = work.saturating_sub(onset.rows.len());
        match SharedRun::new(span, heading, Some(&h)) {
            Some(twin) => self.shared_runs[heading_class] = Some(twin),
            None => h.heading_class = None,
        }
        h
    }
}

/// Calls `visit(piece, parameter)` every `spacing` metres along all pieces.
pub(super) fn for_each_place(pieces: &[Piece], spacing: f64, mut visit: impl FnMut(u32, f64)) {
    let mut next = 0.5 * spacing;
    for (index, piece) in pieces.iter().enumerate() {
        while next < piece.length() {
            visit(index as u32, piece.parameter_at(next));
            next += spacing;
        }
        next -= piece.length();
    }
}

/// A cell that may begin a contact: the whisker's base and state, and up to where it must be clear of boundaries.
struct SeedCell {
    pose: Pose2,
    state: WhiskerState,
    clear: Vec2,
}

impl SeedCell {
    fn is_clear(&self, model: &MeasurementModel<'_>) -> bool {
        let base = self.pose.position();
        !model.map.crosses(base, self.clear) && model.map.is_free(base)
    }
}

/// The whisker's base and state where the straight whisker's tip touched here, if it can have.
fn touching(
    model: &MeasurementModel<'_>,
    onset: &ContactOnset<'_>,
    piece: u32,
    at: f64,
    heading: f64,
    admits: &dyn Fn(Pose2) -> bool,
) -> Option<SeedCell> {
    let sensor = &model.sensors[onset.sensor];
    let z = model.history.readings(onset.row)[onset.sensor];
    let spot = model.ground.pieces[piece as usize].spot(at);
    let push = (spot.normal - heading).sin();
    let along = Vec2::from_angle(heading);
    let normal = Vec2::from_angle(spot.normal);
    if push * z < 0.0 || onset.approach.rotated(heading).dot(normal) > 0.0 {
        return None;
    }
    let base = spot.position - along * sensor.length;
    let pose = Pose2::new(base.x, base.y, heading);
    // The region is asked first: on a large map little is left.
    if !admits(from_odom(model, onset, pose)) {
        return None;
    }
    let state = WhiskerState::Touching(model.forward(sensor).untouched(piece, at, heading));
    Some(SeedCell { pose, state, clear: base + along * (CLEAR * sensor.length) })
}

/// The same where the tip was pressed with the reading of the first row.
fn loaded(
    model: &MeasurementModel<'_>,
    onset: &ContactOnset<'_>,
    set: &TipContactSet,
    piece: u32,
    at: f64,
    heading: f64,
    admits: &dyn Fn(Pose2) -> bool,
) -> Option<SeedCell> {
    let sensor = &model.sensors[onset.sensor];
    let spot = model.ground.pieces[piece as usize].spot(at);
    let contact = set.at_direction(spot.normal - heading)?;
    let base = spot.position - contact.position.rotated(heading);
    let chord = spot.position - base;
    // The whisker comes to the boundary from its free side.
    let aslant = Vec2::from_angle(heading + contact.slope).dot(Vec2::from_angle(spot.normal));
    let pose = Pose2::new(base.x, base.y, heading);
    if aslant >= 0.0 || !admits(from_odom(model, onset, pose)) {
        return None;
    }
    let q = contact.force.abs() * sensor.length.powi(2) / sensor.tip.rigidity();
    let beta = wrap_angle(spot.normal - heading - contact.slope - FRAC_PI_2);
    let state = WhiskerState::Touching(model.forward(sensor).loaded(piece, at, q, beta, contact.slope));
    Some(SeedCell { pose, state, clear: base + chord * 0.5 })
}

/// The odometry frame in the map when the whisker's base is there at the first touch.
fn from_odom(model: &MeasurementModel<'_>, onset: &ContactOnset<'_>, map_from_whisker: Pose2) -> Pose2 {
    let odom_from_whisker = model.history.pose(onset.row).compose(model.sensors[onset.sensor].robot_from_whisker);
    map_from_whisker.compose(odom_from_whisker.inverse())
}

/// The inverse variances of a cell: place along and across the boundary, heading.
fn cell(onset: &ContactOnset<'_>) -> [f64; 3] {
    let place = (0.6 * onset.spacing).powi(-2);
    [place, place, (0.6 * onset.turn).powi(-2)]
}

/// The hypothesis after the first readings, unless they kill its whole cell.
fn tested(
    model: &MeasurementModel<'_>,
    onset: &ContactOnset<'_>,
    map_from_whisker: Pose2,
    state: WhiskerState,
    work: &mut usize,
    span: &mut Option<ContactExtent>,
) -> Option<GaussianHypothesis> {
    let map_from_odom = from_odom(model, onset, map_from_whisker);
    let mut states = vec![WhiskerState::Free; model.sensors.len()];
    states[onset.sensor] = state;
    let mut hypothesis = GaussianHypothesis::new(map_from_odom, states, onset.row);
    for &row in onset.rows {
        hypothesis.add_row(model, row);
        span.iter_mut().for_each(|span| span.add(&hypothesis));
        *work = work.saturating_sub(1);
        let held = matches!(hypothesis.states[onset.sensor], WhiskerState::Touching(_));
        if !held || hypothesis.damped_step(cell(onset), CalibrationPrior::default()).0 > CELL_COST {
            return None;
        }
    }
    Some(hypothesis)
}
