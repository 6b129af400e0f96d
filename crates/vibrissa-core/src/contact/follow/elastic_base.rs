//! A uniform whisker on an elastic base: the clamped whisker with its root turned by what the base yields to the moment.
//!
//! The root's heading is that of the mount plus moment over stiffness. Newton's method \[nocedal2006numerical, sec. 11.1\] finds the turn
//! at which the moment of the clamped whisker, with all its contacts, is the one that turns it; the implicit function theorem gives the
//! derivatives by the pose. Only the smoother of declared errors and `predicted_moments` use it. Where the base yields faster than the contact does the whisker has no equilibrium there and snaps.

use super::{Contact, ForwardModel, Prediction, WhiskerState};
use crate::beam::{TipModel, Whisker};
use crate::contact::{Hold, SensedQuantity};
use crate::plane::Pose2;

/// Steps of Newton's method before the contact is not known, and the longest one (rad).
const MOST_STEPS: usize = 12;
const LONGEST: f64 = 0.1;
/// How exactly the turn is found (rad): in closed form, and by a table.
const EXACT: f64 = 1e-9;
const QUICK: f64 = 1e-5;
/// With less of its stiffness left than this share a whisker snaps.
const STIFF: f64 = 1e-3;

/// An elastic base under a whisker that is uniform otherwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ElasticBase {
    /// How far it turns (rad) under the dimensionless moment `M L / EI` of one.
    compliance: f64,
    /// Flexural rigidity over that by which moments are made dimensionless outside, see [`TipModel::rigidity`].
    per: f64,
}

impl ElasticBase {
    /// The base of a whisker whose moment is read; none where it is clamped, or the whisker is not uniform.
    pub(crate) fn of(tip: &TipModel, quantity: SensedQuantity) -> Option<Self> {
        let beam = tip.whisker();
        let clamped = Whisker { base_stiffness: f64::INFINITY, ..*beam };
        let is_one = !tip.is_uniform() && clamped.is_uniform() && quantity == SensedQuantity::Moment;
        is_one.then(|| Self {
            compliance: beam.flexural_rigidity / (beam.length * beam.base_stiffness),
            per: beam.flexural_rigidity / tip.rigidity(),
        })
    }

    /// The root of the clamped whisker at a mount's pose where its moment reads so, and what that whisker's dimensionless moment of one reads.
    pub(super) fn clamped(&self, mount: Pose2, reading: f64) -> (Pose2, f64) {
        (turned(mount, self.compliance * reading / self.per), self.per)
    }
}

fn turned(pose: Pose2, by: f64) -> Pose2 {
    Pose2 { theta: pose.theta + by, ..pose }
}

impl ForwardModel<'_> {
    /// Moves a whisker on an elastic base from one base pose to another, see [`ForwardModel::advance`].
    pub(super) fn advance_on(
        &self,
        base: ElasticBase,
        state: &mut WhiskerState,
        (from, to): (Pose2, Pose2),
        wanted: bool,
    ) -> Prediction {
        let mut turn = match state {
            WhiskerState::Touching(touch) => base.compliance * self.moment_of(touch).unwrap_or(0.0),
            WhiskerState::Free | WhiskerState::Unknown => 0.0,
        };
        let near = self.mechanics.pick(QUICK, EXACT);
        let mut root = turned(from, turn);
        let mut may_snap = true;
        for _ in 0..MOST_STEPS {
            let next = turned(to, turn);
            let mut felt = self.advance_clamped(state, root, next, wanted);
            root = next;
            let mut stiff = 1.0 - base.compliance * felt.gradient[2];
            if stiff < STIFF
                && may_snap
                && let WhiskerState::Touching(touch) = *state
            {
                may_snap = false;
                let rests = self.snapped(&touch, next);
                *state = rests.map_or(WhiskerState::Free, |(touch, _)| WhiskerState::Touching(touch));
                felt = rests.map_or(Prediction::default(), |(_, felt)| felt);
                stiff = 1.0 - base.compliance * felt.gradient[2];
            }
            let off = turn - base.compliance * felt.value;
            if off.abs() <= near {
                let per = base.per / stiff.max(STIFF);
                return Prediction { value: felt.value * base.per, gradient: felt.gradient.map(|g| g * per) };
            }
            turn -= (off / stiff.max(STIFF)).clamp(-LONGEST, LONGEST);
        }
        *state = WhiskerState::Unknown;
        Prediction::default()
    }

    /// A contact of the tip that was found with the base as part of the whisker, for the clamped one: force and slope.
    pub(super) fn on_its_root(&self, touch: Contact) -> Contact {
        let Some(base) = self.base else { return touch };
        let touch = Contact { q: touch.q / base.per, ..touch };
        let turn = base.compliance * self.moment_of(&touch).unwrap_or(0.0);
        Contact { slope: touch.slope - turn, ..touch }
    }

    /// The dimensionless moment of a contact of the clamped whisker.
    fn moment_of(&self, touch: &Contact) -> Option<f64> {
        match touch.hold {
            Hold::Tip(_) => Some(self.mechanics.held_chart(touch.q, touch.beta)?.moment),
            Hold::Side(..) => Some(self.mechanics.chart(touch.q, touch.beta)?.moment / touch.s),
            Hold::Both(both) => Some(both.load[0]),
        }
    }
}
