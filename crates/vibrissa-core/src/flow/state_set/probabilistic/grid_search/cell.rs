//! A cell of the grid: a Gaussian over pose, gain and zero as wide as the grid's spacing, run through the readings that judge it one after the
//! other, by a linearised forward model \[barshalom2001estimation, sec. 10.3\].

use super::super::correlated_noise::{OUTLIER_COST, unknown_reading_cost};
use super::super::information::{Information, Prior};
use super::super::measurement::MeasurementModel;
use super::super::sensor::Sensor;
use super::super::shared_runs::ContactExtent;
use super::super::state::moved;
use super::{ContactOnset, pivot};
use crate::contact::follow::{ForwardModel, WhiskerState};
use crate::plane::{Pose2, Vec2};

/// Readings of a whisker that has buckled and is not known again yet.
const MOST_BUCKLED: usize = 4;
/// Cost above which a cell is dropped: this, and so much for each reading (nats). Errors at the ends of their bounds cost the latter.
const CELL_COST: [f64; 2] = [14.0, 0.67];
/// A cell at its best place explains the readings if so many tell it something for each one that does not: pose, gain and zero fit any three. Of
/// 30 logs of presses against a corner the true place is missed in 11 without the gate, in none with it.
const PASSED_FOR_EACH: usize = 3;
/// Standard deviations are enlarged by this while cells are judged.
const STD_INFLATION: f64 = 1.5;
/// Longest step of one of them (m, rad), and one that is not worth it.
const LONGEST: [f64; 2] = [3e-3, 0.06];
const SHORT: [f64; 2] = [1e-4, 2e-3];

/// What a cell knows: pose, gain, zero.
type Told = Information<5>;

/// A cell that explains the readings so far.
#[derive(Clone, Debug)]
pub(in super::super) struct Cell {
    /// The odometry frame in the map frame.
    pub(in super::super) frame: Pose2,
    /// How the whisker stands at the onset.
    pub(in super::super) state: WhiskerState,
    /// The cost at its best, and the step there.
    pub(super) best: (f64, [f64; 3]),
    /// The heading of the grid that it comes from, if it has come to the same as all of that heading on straight walls.
    pub(super) heading: Option<usize>,
    /// Through how many readings it has been run.
    pub(super) readings: usize,
    /// Which of them tell something.
    gate: Gate,
}

impl Cell {
    /// Whether it is linearised where it is best.
    pub(super) fn is_at_best(&self) -> bool {
        let [x, y, turn] = self.best.1;
        x.hypot(y) < SHORT[0] && turn.abs() < SHORT[1]
    }

    /// Whether the readings that tell it something are enough to explain all.
    pub(super) fn explains(&self) -> bool {
        self.gate.explains()
    }

    /// The same elsewhere, where the piece that its tip is on goes to another.
    pub(in super::super) fn moved(&self, motion: Pose2, to: &dyn Fn((u32, f64)) -> (u32, f64)) -> Self {
        let (cost, [x, y, turn]) = self.best;
        let shift = Vec2::new(x, y).rotated(motion.theta);
        let best = (cost, [shift.x, shift.y, turn]);
        Self { frame: motion.compose(self.frame), state: self.state.slid(motion, to), best, ..*self }
    }
}

pub(super) fn best_frame(cell: &Cell, pivot: Vec2) -> Pose2 {
    let d = cell.best.1;
    let share = (d[0].hypot(d[1]) / LONGEST[0]).max(d[2].abs() / LONGEST[1]).max(1.0).recip();
    moved(cell.frame, pivot, d.map(|v| v * share))
}

pub(super) fn forward<'a>(model: &MeasurementModel<'a>, sensor: &'a Sensor) -> ForwardModel<'a> {
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

/// Whether a cell costs too much after the first readings up to this one; those that follow only add to it.
fn is_dead(cost: f64, last: usize) -> bool {
    cost > CELL_COST[0] + CELL_COST[1] * (last + 1) as f64
}

/// A validation gate \[barshalom2001estimation\]: a reading that would add more than a false one costs tells a cell nothing. It may be
/// false, or lie on the other side of an event (a snap, the end of a wall, a corner) than the middle of the cell, where no linearisation leads.
#[derive(Clone, Copy, Debug, Default)]
struct Gate {
    passed: usize,
    gated: usize,
}

impl Gate {
    /// Whether a reading that adds so much (nats) tells something.
    fn passes(&mut self, cost: f64) -> bool {
        let passes = cost <= OUTLIER_COST;
        *if passes { &mut self.passed } else { &mut self.gated } += 1;
        passes
    }

    /// Whether what has passed explains the readings.
    fn explains(self) -> bool {
        self.gated * PASSED_FOR_EACH <= self.passed
    }
}

/// The cell after the readings, unless they kill all of it; one that is `whole` is dropped where it lets go, too.
pub(super) fn run(
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
    let priors = [(0.0, onset.priors[0]), (onset.level, onset.priors[1])].map(|(mean, std)| Prior { mean, std });
    let (pivot, damping) = (frame.transform_point(pivot(model, onset)), damping(onset));
    let mut told = Told::default();
    let mut best = (0.0, [0.0; 3]);
    let (mut touch, mut has_touched) = (state, false);
    let mut gate = Gate::default();
    let base = |row: usize| frame.compose(model.window.pose(row)).compose(sensor.robot_from_whisker);
    let mut last = base(onset.row);
    for (count, &row) in onset.rows.iter().enumerate() {
        let (there, z) = (base(row), model.window.readings(row)[onset.sensor]);
        let felt = forward.advance(&mut touch, last, there, model.window.contacts(row)[onset.sensor]);
        let wander = sensor.wander(core::mem::replace(&mut last, there), there, z);
        extent.iter_mut().for_each(|extent| extent.add(&touch));
        *work = work.saturating_sub(1);
        let WhiskerState::Touching(contact) = touch else {
            let is_buckled = matches!(touch, WhiskerState::Unknown) && !has_touched && count < MOST_BUCKLED;
            if is_buckled {
                let cost = unknown_reading_cost((count > 0).then_some(wander));
                (told.constant, best.0) = (told.constant + cost, best.0 + cost);
                continue;
            }
            // A side that has just come to a corner may be off it at the first reading.
            if matches!(touch, WhiskerState::Unknown) || (whole && (state != WhiskerState::Free || count > 0)) {
                return None;
            }
            let residual = sensor.residual(0.0, z, false, false);
            let cost = 0.5 * (residual.value / STD_INFLATION).powi(2);
            let cost = if gate.passes(cost) { cost } else { OUTLIER_COST };
            (told.constant, best.0) = (told.constant + cost, best.0 + cost);
            if is_dead(best.0, count) {
                return None;
            }
            continue;
        };
        has_touched = true;
        let residual = sensor.residual(felt.value, z, contact.q > 0.0, true);
        let value = residual.value / STD_INFLATION;
        let before = told;
        told.constant += 0.5 * value * value;
        if residual.informs {
            let scale = 1.0 / (residual.std * STD_INFLATION);
            let [x, y, turn] = felt.gradient.map(|g| g * scale);
            let arm = (there.position() - pivot).perp();
            told.add(&[x, y, turn + x * arm.x + y * arm.y, felt.value * scale, scale], value, 1.0);
        }
        let after = told.marginal([0, 1, 2], [3, 4], priors)?.least(damping);
        if gate.passes(after.0 - best.0) {
            best = after;
        } else {
            told = before;
            (told.constant, best.0) = (told.constant + OUTLIER_COST, best.0 + OUTLIER_COST);
        }
        if is_dead(best.0, count) {
            return None;
        }
    }
    let is_known = !matches!(touch, WhiskerState::Unknown);
    is_known.then_some(Cell { frame, state, best, heading: None, readings: onset.rows.len(), gate })
}
