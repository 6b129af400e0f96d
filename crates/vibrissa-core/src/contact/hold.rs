//! What holds a whisker: which part of it touches, and what that rests on.

use crate::math;
use core::f64::consts::PI;

/// What a contact rests on; pieces and corners by their numbers in [`super::Boundaries`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Support {
    /// A piece, at this parameter.
    Piece(u32, f64),
    /// A corner.
    Corner(u32),
}

impl Support {
    /// Whether this is the same piece, wherever along it, or the same corner.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Piece(a, _), Self::Piece(b, _)) | (Self::Corner(a), Self::Corner(b)) => a == b,
            _ => false,
        }
    }

    /// The same with the pieces' numbers changed; corners go by the number of the piece before them.
    pub(crate) fn renumbered(self, number: &dyn Fn(u32) -> u32) -> Self {
        match self {
            Self::Piece(piece, at) => Self::Piece(number(piece), at),
            Self::Corner(id) => Self::Corner(number(id)),
        }
    }
}

impl From<(u32, f64)> for Support {
    fn from((piece, at): (u32, f64)) -> Self {
        Self::Piece(piece, at)
    }
}

/// To which side a whisker is pushed whose side touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Push {
    /// To its left, along its normal: the boundary is on its right.
    Left,
    /// To its right.
    Right,
}

impl Push {
    /// The side to which a force points, by its tilt from the whisker's normal (rad).
    #[must_use]
    pub fn of(tilt: f64) -> Self {
        if math::cos(tilt) > 0.0 { Self::Left } else { Self::Right }
    }

    /// The tilt of the force without friction (rad): 0 or pi.
    #[must_use]
    pub fn tilt(self) -> f64 {
        match self {
            Self::Left => 0.0,
            Self::Right => PI,
        }
    }

    /// 1 to the left, -1 to the right.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// What holds a whisker.
///
/// | hold | on a piece | on a corner |
/// | --- | --- | --- |
/// | tip | stands on it | is caught in a concave one |
/// | side | lies on it, tangent | lies on a convex one or on the end of a wall |
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// The tip.
    Tip(Support),
    /// The side.
    Side(Support, Push),
    /// Two places.
    Both(TwoContacts),
}

impl Hold {
    /// Whether this is the same part of the whisker on the same piece or corner.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Tip(a), Self::Tip(b)) | (Self::Side(a, _), Self::Side(b, _)) => a.is_same(b),
            _ => false,
        }
    }

    /// The same with the pieces' numbers changed, see [`Support::renumbered`].
    pub(crate) fn renumbered(self, number: &dyn Fn(u32) -> u32) -> Self {
        match self {
            Self::Tip(on) => Self::Tip(on.renumbered(number)),
            Self::Side(on, push) => Self::Side(on.renumbered(number), push),
            Self::Both(both) => Self::Both(TwoContacts {
                outer: both.outer.renumbered(number),
                inner: both.inner.renumbered(number),
                ..both
            }),
        }
    }
}

/// The side on a boundary and further out the tip, or the side again, without friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoContacts {
    /// Moment at the base (over `EI / L`), sum of the forces (x and y, whisker frame, over `EI / L²`), arc length of
    /// the inner contact (over `L`), and the force there to the whisker's left (over `EI / L²`).
    pub load: [f64; 5],
    /// What the inner contact rests on, which is of the side.
    pub inner: Support,
    /// What the outer contact rests on.
    pub outer: Support,
    /// Arc length of the outer contact (over `L`) where that is of the side, too; none where it is the tip.
    pub lies_at: Option<f64>,
}

impl TwoContacts {
    /// Arc length of the outer contact (over `L`).
    #[must_use]
    pub fn end(&self) -> f64 {
        self.lies_at.unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_are_the_same_on_one_piece_whatever_the_place() {
        let tip = Hold::Tip(Support::Piece(3, 0.2));
        let side = Hold::Side(Support::Corner(3), Push::Left);
        assert!(tip.is_same(&Hold::Tip(Support::Piece(3, 0.9))));
        assert!(side.is_same(&Hold::Side(Support::Corner(3), Push::Right)));
        let others = [Hold::Tip(Support::Piece(4, 0.2)), Hold::Tip(Support::Corner(3)), side];
        assert!(others.iter().all(|other| !tip.is_same(other)));
    }

    #[test]
    fn a_push_has_the_tilt_that_it_was_told_by() {
        for push in [Push::Left, Push::Right] {
            assert_eq!(Push::of(push.tilt() + 1.5), push);
            assert!((math::cos(push.tilt()) - push.sign()).abs() < 1e-15);
        }
    }
}
