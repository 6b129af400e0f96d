//! What a whisker in contact is, and what it reads.

use crate::contact::{Hold, Push, Support};
use crate::plane::{Pose2, Vec2};

/// A whisker on a boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    /// Dimensionless force `F s² / EI`; negative while the whisker is glued across a small gap.
    pub(crate) q: f64,
    /// Tilt of the force from the whisker's normal at the contact (rad); at the side 0, or pi for a push to its right.
    pub(super) beta: f64,
    /// Arc length of the contact over the whisker's length, 1 at the tip.
    pub(super) s: f64,
    pub(crate) hold: Hold,
    /// The contact (m), map frame.
    pub(crate) place: Vec2,
    /// The slope of the whisker there (rad).
    pub(super) slope: f64,
    /// How far it may still move (m) before the rest of the whisker can have come to a boundary.
    pub(super) clear: f64,
}

impl Contact {
    /// The whisker lying down here: the force along its normal, on the side on which it is.
    pub(super) fn laid(self, on: Support) -> Self {
        let push = Push::of(self.beta);
        Self { beta: push.tilt(), hold: Hold::Side(on, push), ..self }
    }
}

/// The reading that a pose of the whisker makes, see [`crate::contact::SensedQuantity`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Prediction {
    /// Without dimension; of a glued whisker what its pull would make.
    pub(crate) value: f64,
    /// Its derivatives by the whisker base's x, y (1/m, map frame) and heading (1/rad).
    pub(crate) gradient: [f64; 3],
}

/// How a whisker stands to the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum WhiskerState {
    /// Straight, touching nothing.
    Free,
    /// With its tip or its side on a boundary.
    Touching(Contact),
    /// In a contact that the model does not follow: what it feels is not known.
    Unknown,
}

impl WhiskerState {
    /// The piece that holds the tip, pressed or glued, and the parameter.
    pub(crate) fn on_piece(&self) -> Option<(u32, f64)> {
        match self {
            Self::Touching(Contact { hold: Hold::Tip(Support::Piece(piece, at)), .. }) => Some((*piece, *at)),
            _ => None,
        }
    }

    /// The same moved to where its tip's piece and parameter go.
    pub(crate) fn slid(&self, motion: Pose2, to: &dyn Fn((u32, f64)) -> (u32, f64)) -> Self {
        let Self::Touching(touch) = *self else { return *self };
        let hold = match touch.hold {
            Hold::Tip(Support::Piece(piece, at)) => {
                let (piece, at) = to((piece, at));
                Hold::Tip(Support::Piece(piece, at))
            }
            other => other,
        };
        Self::Touching(Contact { hold, place: motion.transform_point(touch.place), ..touch })
    }

    /// The same on a map that a motion takes onto itself, and each piece onto that of the number which `piece` gives.
    pub(crate) fn turned(&self, motion: Pose2, piece: &dyn Fn(u32) -> u32) -> Self {
        let Self::Touching(touch) = *self else { return *self };
        let hold = touch.hold.renumbered(piece);
        Self::Touching(Contact { hold, place: motion.transform_point(touch.place), ..touch })
    }
}
