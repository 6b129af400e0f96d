//! Where a whisker with two contacts comes to rest whose tip has lost its equilibrium.
//!
//! A whisker that lies along a wall and runs into the next one with its tip is a column: under more than Euler's load it buckles off the
//! wall. As with one contact (`snap`) the tip then slides along its boundary, the way the whisker pushes it, to where the boundary does
//! not push it along any more; the side slides with it. On the way the place of the tip is given, and the two contacts are solved for.

use super::snap::{MOST_HALVED, MOST_STRIDES, STRIDE, TipForce};
use super::{Contact, ForwardModel, Next, Prediction};
use crate::contact::{Stance, Support, TwoContacts};
use crate::plane::{Vec2, wrap_angle};
use core::f64::consts::FRAC_PI_2;

/// The direction (its sign) into a piece from the end that is near a place of it.
fn inwards(at: f64) -> f64 {
    if at > 0.5 { -1.0 } else { 1.0 }
}

/// How a slide with two contacts ends.
pub(super) enum BothSlid {
    Rests(Contact, Prediction),
    /// The side has come off, with the tip here under this force.
    TipAlone(TipForce, (u32, f64)),
}

impl ForwardModel<'_> {
    /// How the slide of a whisker ends that is held so at tip and side; one that `came` sliding keeps its direction (its sign).
    pub(super) fn both_slid(&self, stance: &Stance, from: &TwoContacts, came: Option<f64>) -> Option<BothSlid> {
        if from.lies_at.is_some() {
            return None;
        }
        let found = self.solve(stance, from, false)?;
        let mut both = found.both;
        let per = |piece: u32| self.length / self.boundaries.piece(piece).length();
        let (piece, start, mut last) = match both.outer {
            // One in a corner slides out of it.
            Support::Piece(piece, at) if came.is_none() && self.corner_at(piece, at).is_some() => {
                (piece, at.clamp(0.0, 1.0), Some(inwards(at)))
            }
            Support::Piece(piece, at) => (piece, at, came),
            Support::Corner(id) => {
                let corner = self.boundaries.corner(id)?;
                let lean = corner.lean(stance.theta() + found.shape.force.angle());
                let (piece, end) = if lean < 0.5 { corner.before } else { corner.after };
                (piece, end, Some(inwards(end)))
            }
        };
        let (mut stride, mut halved) = (STRIDE, 0);
        let (mut before, mut at) = match last {
            Some(way) if came.is_none() => (start, start + way * stride * per(piece)),
            _ => (start, start),
        };
        for _ in 0..MOST_STRIDES {
            let Some(found) = self.solve(stance, &TwoContacts { outer: Support::Piece(piece, at), ..both }, false)
            else {
                if halved == MOST_HALVED {
                    return None;
                }
                (at, stride, halved) = (0.5 * (at + before), 0.5 * stride, halved + 1);
                continue;
            };
            both = found.both;
            let (next, held) = self.inner_next(stance, &both, &found.shape)?;
            if !held {
                let force = found.shape.force;
                let beta = wrap_angle(force.angle() - found.shape.outer.slope - FRAC_PI_2);
                return Some(BothSlid::TipAlone(TipForce { q: force.norm(), beta }, (piece, at)));
            }
            if let Some(side) = next {
                both.inner = side;
            }
            let spot = self.boundaries.spot((piece, at));
            let force = Vec2::from_angle(stance.theta() + found.shape.force.angle());
            if force.dot(Vec2::from_angle(spot.normal)) <= 0.0 {
                return None;
            }
            let along = -force.dot(spot.velocity);
            if last.is_some_and(|last: f64| along * last < 0.0) {
                return self.rests_with_both(stance, both);
            }
            last = Some(along);
            before = at;
            at += stride * per(piece) * along.signum();
            if !(0.0..=1.0).contains(&at) {
                let (id, _) = self.boundaries.corner_of(piece, at > 0.5).filter(|(_, corner)| corner.is_concave())?;
                return self.rests_with_both(stance, TwoContacts { outer: Support::Corner(id), ..both });
            }
        }
        None
    }

    fn rests_with_both(&self, stance: &Stance, both: TwoContacts) -> Option<BothSlid> {
        match self.on_both(stance, both) {
            Next::Touching(touch, predicted) => Some(BothSlid::Rests(touch, predicted)),
            _ => None,
        }
    }
}
