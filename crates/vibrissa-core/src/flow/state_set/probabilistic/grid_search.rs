//! Global localization: a grid over every place of the boundary, every heading and every branch \[thrun2005probabilistic, sec. 8.2\],
//! pruned by the readings of one contact.
//!
//! Where the whisker was free before, the row at which it began to touch puts the straight whisker's tip on the
//! boundary; otherwise a reading gives the tip for each direction of the force and each branch. Either way two numbers
//! are open, the place along the boundary and the heading. Each cell of them is run through a few well separated
//! readings as a Gaussian as wide as the cell, and most die at the first.

use super::admission::Admits;
use super::correlated_noise::UNKNOWN_COST;
use super::information::{Information, Prior};
use super::map_symmetry::MapSymmetries;
use super::measurement::{MeasurementModel, moved};
use super::sensor::Sensor;
use super::shared_runs::{ContactExtent, SharedRun, WallContact};
use crate::config::TipLoad;
use crate::contact::follow::{ForwardModel, WhiskerState};
use crate::flow::contact_set::TipContactSet;
use crate::plane::{Bounds, Pose2, Vec2, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI, TAU};

/// Headings further than this from the boundary's normal are left out (rad).
const WIDEST: f64 = 1.45;
/// Headings about head-on, in shares of their spacing: there a whisker buckles to one side or the other, and its readings change with the
/// heading as nowhere else. Of 165 sweeps by moments in rooms drawn at random 30 were inconsistent without these and with contacts that had
/// to be known at once, 3 with them.
const HEAD_ON: [f64; 2] = [0.15, 0.5];
/// Readings of a whisker that has buckled and is not known again yet.
const MOST_BUCKLED: usize = 4;
/// Cost above which a cell is dropped: this, and so much for each reading (nats). Errors at the ends of their bounds cost the latter.
const CELL_COST: [f64; 2] = [14.0, 0.67];
/// Standard deviations are enlarged by this while cells are judged.
const STD_INFLATION: f64 = 1.5;
/// Rounds of refinement.
const ROUNDS: usize = 2;
/// Longest step of one of them (m, rad), and one that is not worth it.
const LONGEST: [f64; 2] = [3e-3, 0.06];
const SHORT: [f64; 2] = [1e-4, 2e-3];
/// Share of the whisker that is kept clear of the boundaries when it begins to touch.
const CLEAR: f64 = 0.98;
/// Corners that turn by more than this (rad) are touched with the side; a whisker begins so far off them (m), and with no more of its length
/// than this share before them.
const SHARP: f64 = 0.3;
const JUST_OFF: f64 = 1e-4;
const LONGEST_ARM: f64 = 0.97;
/// Cells nearer to each other than this are one (m, rad), while there are many and when there are few.
const SAME: [[f64; 2]; 2] = [[2.5e-3, 0.04], [1.2e-3, 0.015]];
const MANY: usize = 100;
/// With more cells than this a contact is followed for longer.
const MANY_CELLS: usize = 4000;

/// What a cell knows: pose, gain, zero.
type Told = Information<5>;

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
    /// Standard deviations of gain and zero.
    pub(super) priors: [f64; 2],
}

/// A cell that explains the readings so far.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// The odometry frame in the map frame.
    pub(super) frame: Pose2,
    /// How the whisker stands at the onset.
    pub(super) state: WhiskerState,
    /// The cost at its best, and the step there.
    best: (f64, [f64; 3]),
    /// The heading of the grid that it comes from, if it has come to the same as all of that heading on straight walls.
    heading: Option<usize>,
    /// Through how many readings it has been run.
    readings: usize,
}

impl Cell {
    /// Whether it is linearised where it is best.
    fn is_at_best(&self) -> bool {
        let [x, y, turn] = self.best.1;
        x.hypot(y) < SHORT[0] && turn.abs() < SHORT[1]
    }

    /// The same elsewhere, where the piece that its tip is on goes to another.
    pub(super) fn moved(&self, motion: Pose2, to: &dyn Fn((u32, f64)) -> (u32, f64)) -> Self {
        let (cost, [x, y, turn]) = self.best;
        let shift = Vec2::new(x, y).rotated(motion.theta);
        let best = (cost, [shift.x, shift.y, turn]);
        Self { frame: motion.compose(self.frame), state: self.state.slid(motion, to), best, ..*self }
    }
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
        self.join(model);
        self.found.sort_by(|a, b| a.best.0.total_cmp(&b.best.0));
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

/// Headings from head-on (rad) at which a free whisker is taken to come to a wall: evenly spaced, and denser about head-on.
fn headings_at_touch(turn: f64) -> impl Iterator<Item = f64> {
    let count = (WIDEST / turn - 0.5).ceil() as usize;
    let even = (1..=count).map(move |k| k as f64 * turn);
    HEAD_ON.into_iter().map(move |share| share * turn).chain(even).flat_map(|off| [off, -off])
}

/// Calls `visit(piece, parameter)` every `spacing` metres along all pieces.
fn for_each_place(pieces: &[crate::contact::Piece], spacing: f64, mut visit: impl FnMut(u32, f64)) {
    let mut next = 0.5 * spacing;
    for (index, piece) in pieces.iter().enumerate() {
        while next < piece.length() {
            visit(index as u32, piece.parameter_at(next));
            next += spacing;
        }
        next -= piece.length();
    }
}

/// The place of the tip at the onset, odometry frame.
fn pivot(model: &MeasurementModel<'_>, onset: &ContactOnset) -> Vec2 {
    let sensor = &model.sensors[onset.sensor];
    let odom_from_whisker = model.window.pose(onset.row).compose(sensor.robot_from_whisker);
    odom_from_whisker.transform_point(Vec2::new(sensor.length, 0.0))
}

fn best_frame(cell: &Cell, pivot: Vec2) -> Pose2 {
    let d = cell.best.1;
    let share = (d[0].hypot(d[1]) / LONGEST[0]).max(d[2].abs() / LONGEST[1]).max(1.0).recip();
    moved(cell.frame, pivot, d.map(|v| v * share))
}

fn forward<'a>(model: &MeasurementModel<'a>, sensor: &'a Sensor) -> ForwardModel<'a> {
    let mechanics = sensor.solver(model.solver);
    let (length, quantity) = (sensor.length, sensor.quantity);
    ForwardModel {
        map: model.map,
        boundaries: model.ground,
        length,
        mechanics,
        whole: false,
        quantity,
        base: sensor.base,
    }
}

/// The inverse variances of a cell: place along and across the boundary, heading.
fn damping(onset: &ContactOnset) -> [f64; 3] {
    let place = (0.6 * onset.spacing).powi(-2);
    [place, place, (0.6 * onset.turn).powi(-2)]
}

/// The cell after the readings, unless they kill all of it; one that is `whole` is dropped where it lets go, too.
fn run(
    model: &MeasurementModel<'_>,
    onset: &ContactOnset,
    frame: Pose2,
    state: WhiskerState,
    whole: bool,
    work: &mut usize,
    extent: &mut Option<ContactExtent>,
) -> Option<Cell> {
    let sensor = &model.sensors[onset.sensor];
    let forward = forward(model, sensor);
    let priors = onset.priors.map(|std| Prior { mean: 0.0, std });
    let (pivot, damping) = (frame.transform_point(pivot(model, onset)), damping(onset));
    let mut told = Told::default();
    let mut best = (0.0, [0.0; 3]);
    let (mut touch, mut has_touched) = (state, false);
    let base = |row: usize| frame.compose(model.window.pose(row)).compose(sensor.robot_from_whisker);
    let mut last = base(onset.row);
    for (count, &row) in onset.rows.iter().enumerate() {
        let (there, z) = (base(row), model.window.readings(row)[onset.sensor]);
        let felt = forward.advance(&mut touch, last, there, model.window.contacts(row)[onset.sensor]);
        last = there;
        extent.iter_mut().for_each(|extent| extent.add(&touch));
        *work = work.saturating_sub(1);
        let WhiskerState::Touching(contact) = touch else {
            let is_buckled = matches!(touch, WhiskerState::Unknown) && !has_touched && count < MOST_BUCKLED;
            if is_buckled {
                told.constant += UNKNOWN_COST[count.min(1)];
                continue;
            }
            // A side that has just come to a corner may be off it at the first reading.
            if matches!(touch, WhiskerState::Unknown) || (whole && (state != WhiskerState::Free || count > 0)) {
                return None;
            }
            let residual = sensor.residual(0.0, z, false, false);
            told.constant += 0.5 * (residual.value / STD_INFLATION).powi(2);
            continue;
        };
        has_touched = true;
        let residual = sensor.residual(felt.value, z, contact.q > 0.0, true);
        let value = residual.value / STD_INFLATION;
        told.constant += 0.5 * value * value;
        if residual.informs {
            let scale = 1.0 / (residual.std * STD_INFLATION);
            let [x, y, turn] = felt.gradient.map(|g| g * scale);
            let arm = (there.position() - pivot).perp();
            told.add(&[x, y, turn + x * arm.x + y * arm.y, felt.value * scale, scale], value, 1.0);
        }
        best = told.marginal([0, 1, 2], [3, 4], priors)?.least(damping);
        // Readings that follow only add to it.
        if best.0 > CELL_COST[0] + CELL_COST[1] * (count + 1) as f64 {
            return None;
        }
    }
    let is_known = !matches!(touch, WhiskerState::Unknown);
    is_known.then_some(Cell { frame, state, best, heading: None, readings: onset.rows.len() })
}

/// The corners that a side can lie on, each with the direction in which it points.
fn sharp_corners(model: &MeasurementModel<'_>) -> Vec<(Vec2, f64)> {
    let mut seen = Vec::new();
    let mut corners = Vec::new();
    for piece in 0..model.ground.pieces.len() as u32 {
        for forward in [false, true] {
            let Some((id, corner)) = model.ground.corner_of(piece, forward) else { continue };
            if corner.is_convex() && corner.turn.abs() > SHARP && !seen.contains(&id) {
                seen.push(id);
                corners.push((corner.position, corner.outward()));
            }
        }
    }
    corners
}

/// A pose of the whisker's base that may begin a contact: its state, and up to where it must be clear of boundaries.
struct Seed {
    pose: Pose2,
    state: WhiskerState,
    clear: Vec2,
}

impl Seed {
    fn is_clear(&self, model: &MeasurementModel<'_>) -> bool {
        let base = self.pose.position();
        !model.map.crosses(base, self.clear) && model.map.is_free(base)
    }
}

/// The whisker's base and state where the straight whisker's tip touched here, if it can have.
fn touching(
    model: &MeasurementModel<'_>,
    onset: &ContactOnset,
    piece: u32,
    at: f64,
    heading: f64,
    admits: &Admits<'_>,
) -> Option<Seed> {
    let sensor = &model.sensors[onset.sensor];
    let z = model.window.readings(onset.row)[onset.sensor];
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
    let state = WhiskerState::Touching(forward(model, sensor).untouched(piece, at, heading));
    Some(Seed { pose, state, clear: base + along * (CLEAR * sensor.length) })
}

/// The same where the tip was pressed with the reading of the first row.
fn loaded(
    model: &MeasurementModel<'_>,
    onset: &ContactOnset,
    set: &TipContactSet,
    piece: u32,
    at: f64,
    heading: f64,
    admits: &Admits<'_>,
) -> Option<Seed> {
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
    let state = WhiskerState::Touching(forward(model, sensor).loaded(piece, at, q, beta, contact.slope));
    Some(Seed { pose, state, clear: base + chord * 0.5 })
}

/// The odometry frame in the map when the whisker's base is there at the first touch.
fn from_odom(model: &MeasurementModel<'_>, onset: &ContactOnset, map_from_whisker: Pose2) -> Pose2 {
    let odom_from_whisker = model.window.pose(onset.row).compose(model.sensors[onset.sensor].robot_from_whisker);
    map_from_whisker.compose(odom_from_whisker.inverse())
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
    keyed.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    keyed.dedup_by(|later, kept| later.0 == kept.0);
    keyed.iter().for_each(|&(.., index)| kept[index] = true);
    kept
}
