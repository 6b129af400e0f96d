//! Stick and slip: whether friction holds a contact where it is, and which way it slides where it does not.

use super::newton::{PieceSolution, Rule, Unknown};
use super::{Equilibrium, LOST, Outcome, PointLoad, Step, TIP_SLACK, Tried};
use crate::contact::{Hold, Push, Support};
use crate::math;
use crate::plane::{Vec2, wrap_angle};

/// Force below which a stuck contact starts afresh, over `EI / L²`.
const WEAK: f64 = 1e-3;

impl Step<'_> {
    /// With friction: the contact where it is if the cone allows it, else sliding with the force on the cone's edge.
    pub(super) fn stick_or_slip(&self, contact: &Equilibrium, guess: &Equilibrium) -> Outcome {
        // What slides goes on sliding as long as friction opposes it.
        if contact.sliding.abs() > 0.0
            && let Some(next) = self.slide(contact, guess, contact.sliding)
        {
            return next;
        }
        let start = PointLoad { s: contact.load.s, ..guess.load };
        let off = match self.stuck(&Equilibrium { load: start, sliding: 0.0, ..*contact }) {
            Some((Outcome::Touching(next), off)) if off.abs() <= self.cone && self.is_near(contact, &next) => {
                return Outcome::Touching(next);
            }
            Some((_, off)) => off,
            None => self.cone,
        };
        let first = self.cone.copysign(off);
        let mut end = Outcome::Ends(LOST);
        for offset in [first, -first] {
            match self.slide(contact, guess, offset) {
                Some(Outcome::LiftOff) => end = Outcome::LiftOff,
                Some(next) => return next,
                None => {}
            }
        }
        end
    }

    /// The slide with the force this far off the frictionless direction (rad), if friction then opposes it.
    fn slide(&self, contact: &Equilibrium, guess: &Equilibrium, offset: f64) -> Option<Outcome> {
        match self.run(guess.hold, guess.load, offset) {
            Outcome::Touching(next) if self.opposes(contact, &next, offset) && self.is_near(contact, &next) => {
                Some(Outcome::Touching(Equilibrium { sliding: if next.stuck { 0.0 } else { offset }, ..next }))
            }
            Outcome::LiftOff => Some(Outcome::LiftOff),
            _ => None,
        }
    }

    /// Whether friction with the force this far off acts against the way that the whisker slid.
    fn opposes(&self, before: &Equilibrium, after: &Equilibrium, offset: f64) -> bool {
        let across = Vec2::from_angle(self.on.direction(after.load, &after.state) - offset).perp();
        // The contact moves over the boundary, and the whisker's material over the contact.
        let along = Vec2::from_angle(self.on.stance.heading(after.state.slope));
        let passed = (before.load.s - after.load.s) * self.on.whisker.beam.length;
        let slid = (after.place - before.place + along * passed).dot(across);
        slid * offset.signum() <= 1e-9 * self.on.whisker.beam.length
    }

    /// The contact stuck where it is, and the force's angle off the frictionless direction (rad).
    fn stuck(&self, contact: &Equilibrium) -> Option<(Outcome, f64)> {
        let on = &self.on;
        if let Hold::Side(Support::Piece(piece, at), push) = contact.hold {
            return self.rolled(contact, (piece, at), push);
        }
        let solve = |start: PointLoad| on.at_place(Unknown::Tilt, start, contact.place);
        let (load, state, _) = solve(self.first_push(contact)).or_else(|| solve(contact.load))?;
        let direction = on.direction(load, &state);
        let next = Equilibrium { load, state, stuck: true, ..*contact };
        let off = match contact.hold {
            Hold::Tip(Support::Piece(piece, at)) => {
                let normal = on.boundaries.spot((piece, at)).normal;
                if math::cos(on.stance.heading(state.slope) - normal) > 0.0 {
                    return self.rolled(&next, (piece, at), Push::of(load.beta));
                }
                wrap_angle(direction - normal)
            }
            Hold::Tip(Support::Corner(id)) => {
                let corner = on.boundaries.corner(id)?;
                let lean = corner.lean(direction);
                (lean - lean.clamp(0.0, 1.0)) * corner.turn
            }
            Hold::Side(Support::Corner(id), push) => {
                let corner = on.boundaries.corner(id)?;
                let lean = corner.lean(on.stance.direction(state.slope, push.tilt()));
                if lean < 0.0 {
                    return self.rolled(contact, corner.before, push);
                }
                if lean > 1.0 {
                    return self.rolled(contact, corner.after, push);
                }
                wrap_angle(load.beta - push.tilt())
            }
            Hold::Side(Support::Piece(..), _) | Hold::Both(_) => return None,
        };
        if load.q < 0.0 {
            return Some((Outcome::LiftOff, 0.0));
        }
        Some((Outcome::Touching(next), off))
    }

    /// Where the search for a stuck contact starts: at its load, or at the small push across the whisker that brings an
    /// unloaded one to its place.
    fn first_push(&self, contact: &Equilibrium) -> PointLoad {
        let rest = PointLoad { q: 0.0, ..contact.load };
        let Some(state) = self.on.whisker.at(rest).filter(|_| contact.load.q < WEAK) else { return contact.load };
        let across = (self.on.stance.seen(contact.place) - state.p).rotated(-state.slope).y;
        let s = contact.load.s;
        PointLoad {
            q: 3.0 * across.abs() / (s * s * s),
            beta: if across < 0.0 { Push::Right } else { Push::Left }.tilt(),
            s,
        }
    }

    /// The side rolled on along a piece without sliding.
    fn rolled(&self, contact: &Equilibrium, (piece, start): (u32, f64), push: Push) -> Option<(Outcome, f64)> {
        let rule = Rule::Roll { push, s: contact.load.s, at: start };
        let PieceSolution::Found { load, state, at, .. } = self.on.on_piece(rule, contact.load, (piece, start)) else {
            return None;
        };
        if load.s > 1.0 + TIP_SLACK {
            return None;
        }
        let off = wrap_angle(load.beta - push.tilt());
        match self.on_flank((piece, at), push, load, state, true) {
            Tried::Is(next) => Some((next, off)),
            Tried::Then(hold @ Hold::Side(Support::Corner(id), push), load) => {
                // Rolled to a corner: it sticks there, with the arc length that it has come to.
                let place = self.on.boundaries.corner(id)?.position;
                let (load, state, _) = self.on.at_place(Unknown::Tilt, load, place)?;
                let at_corner = Equilibrium { load, state, hold, place, stuck: true, ..*contact };
                Some((Outcome::Touching(at_corner), wrap_angle(load.beta - push.tilt())))
            }
            Tried::Then(..) => None,
        }
    }
}
