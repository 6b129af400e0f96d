//! A whisker with its tip on a piece in half the memory: most of what a search finds begins so.

use super::{Contact, WhiskerState};
use crate::contact::{Hold, Support};
use crate::plane::Vec2;

/// The contact of a tip with a piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packed {
    q: f64,
    beta: f64,
    at: f64,
    place: Vec2,
    slope: f64,
    clear: f64,
    piece: u32,
}

impl Packed {
    /// None of what is no contact of a tip with a piece.
    pub(crate) fn of(state: &WhiskerState) -> Option<Self> {
        match *state {
            WhiskerState::Touching(Contact {
                q,
                beta,
                s: 1.0,
                hold: Hold::Tip(Support::Piece(piece, at)),
                place,
                slope,
                clear,
            }) => Some(Self { q, beta, at, place, slope, clear, piece }),
            _ => None,
        }
    }

    pub(crate) fn state(self) -> WhiskerState {
        let Self { q, beta, at, place, slope, clear, piece } = self;
        WhiskerState::Touching(Contact {
            q,
            beta,
            s: 1.0,
            hold: Hold::Tip(Support::Piece(piece, at)),
            place,
            slope,
            clear,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Push;

    #[test]
    fn a_tip_on_a_piece_is_kept_as_it_is_and_nothing_else_is() {
        let touch = Contact {
            q: -0.03,
            beta: -2.5,
            s: 1.0,
            hold: Hold::Tip(Support::Piece(7, 0.25)),
            place: Vec2::new(0.3, -4.0),
            slope: 0.6,
            clear: -1.0,
        };
        let state = WhiskerState::Touching(touch);
        assert_eq!(Packed::of(&state).map(Packed::state), Some(state));
        let others = [
            WhiskerState::Free,
            WhiskerState::Unknown,
            WhiskerState::Touching(Contact { hold: Hold::Tip(Support::Corner(7)), ..touch }),
            WhiskerState::Touching(Contact { hold: Hold::Side(Support::Piece(7, 0.25), Push::Left), s: 0.4, ..touch }),
        ];
        assert!(others.iter().all(|other| Packed::of(other).is_none()));
    }
}
