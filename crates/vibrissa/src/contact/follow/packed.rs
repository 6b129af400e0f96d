//! A whisker with its tip on a piece in half the memory: most of what a search finds begins so.

use super::{Hold, State, Touch};
use crate::plane::Vec2;

/// The contact of a tip with a piece.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Packed {
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
    pub(in super::super) fn of(state: &State) -> Option<Self> {
        match *state {
            State::Touching(Touch { q, beta, s: 1.0, hold: Hold::Piece(piece, at), place, slope, clear }) => {
                Some(Self { q, beta, at, place, slope, clear, piece })
            }
            _ => None,
        }
    }

    pub(in super::super) fn state(self) -> State {
        let Self { q, beta, at, place, slope, clear, piece } = self;
        State::Touching(Touch { q, beta, s: 1.0, hold: Hold::Piece(piece, at), place, slope, clear })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tip_on_a_piece_is_kept_as_it_is_and_nothing_else_is() {
        let touch = Touch {
            q: -0.03,
            beta: -2.5,
            s: 1.0,
            hold: Hold::Piece(7, 0.25),
            place: Vec2::new(0.3, -4.0),
            slope: 0.6,
            clear: -1.0,
        };
        let state = State::Touching(touch);
        assert_eq!(Packed::of(&state).map(Packed::state), Some(state));
        let others = [
            State::Free,
            State::Unknown,
            State::Touching(Touch { hold: Hold::Corner(7), ..touch }),
            State::Touching(Touch { hold: Hold::Flank(7, 0.25), s: 0.4, ..touch }),
        ];
        assert!(others.iter().all(|other| Packed::of(other).is_none()));
    }
}
