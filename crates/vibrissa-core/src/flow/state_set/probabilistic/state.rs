//! What a hypothesis says: where the robot is, what the nuisance parameters are, how its whiskers stand when its rows begin, and what rows before
//! these have told.

use super::map_symmetry::MapSymmetry;
use super::normal_equations::NormalEquations;
use super::unknowns::POSE;
use crate::contact::follow::WhiskerState;
use crate::plane::{Pose2, Vec2, wrap_angle};

/// Where a hypothesis puts the robot and what it takes the nuisance parameters to be.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    /// The odometry frame in the map frame, with the odometry as it is at the anchor.
    pub(super) frame: Pose2,
    /// The nuisance parameters.
    pub(super) values: Vec<f64>,
}

/// How each sensor's whisker stands to the map at the window's first row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Start {
    pub(super) states: Vec<WhiskerState>,
    /// Where each base was then; none where all are free.
    pub(super) bases: Vec<Pose2>,
    /// What rows before it have said.
    pub(super) prior: Option<Box<Prior>>,
}

/// What marginalised rows say of the pose at the window's first row and of the nuisance parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Prior {
    pub(super) equations: NormalEquations,
    /// Where they are linearised; the frame is anchored at that row.
    pub(super) at: State,
}

impl Start {
    /// The same on a map that this turn takes onto itself.
    pub(super) fn turned(&self, turn: &MapSymmetry) -> Self {
        let prior = self.prior.as_ref().map(|prior| {
            let frame = turn.motion.compose(prior.at.frame);
            let equations = prior.equations.turned(turn.motion.theta);
            Box::new(Prior { equations, at: State { frame, values: prior.at.values.clone() } })
        });
        Self {
            states: self.states.iter().map(|state| state.turned(turn.motion, &|piece| turn.piece(piece))).collect(),
            bases: self.bases.iter().map(|&base| turn.motion.compose(base)).collect(),
            prior,
        }
    }

    pub(super) fn free(sensors: usize) -> Self {
        Self { states: vec![WhiskerState::Free; sensors], bases: Vec::new(), prior: None }
    }
}

/// The frame moved by `d`: shifted by (x, y) and turned about the pivot.
pub(super) fn moved(frame: Pose2, pivot: Vec2, d: [f64; POSE]) -> Pose2 {
    let center = frame.transform_point(pivot);
    let place = center + (frame.position() - center).rotated(d[2]) + Vec2::new(d[0], d[1]);
    Pose2::new(place.x, place.y, frame.theta + d[2])
}

/// The move that takes one frame to another.
pub(super) fn difference(from: Pose2, to: Pose2, pivot: Vec2) -> [f64; POSE] {
    let shift = to.transform_point(pivot) - from.transform_point(pivot);
    [shift.x, shift.y, wrap_angle(to.theta - from.theta)]
}

impl State {
    /// The state a step away.
    pub(super) fn stepped(&self, pivot: Vec2, step: &[f64]) -> Self {
        let values = self.values.iter().zip(&step[POSE..]).map(|(v, d)| v + d).collect();
        Self { frame: moved(self.frame, pivot, [step[0], step[1], step[2]]), values }
    }
}
