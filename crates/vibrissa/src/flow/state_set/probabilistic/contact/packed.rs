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
