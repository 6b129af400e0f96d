//! Stick and slip: whether friction holds a contact where it is, and which way it slides where it does not.

use super::{Contact, Hold, LOST, Next, Step, TIP_SLACK, Tried};
use crate::plane::{Vec2, wrap_angle};
use crate::tasks::simulate::equilibrium::{OnPiece, Rule, Unknown};
use crate::tasks::simulate::flex::Load;
use crate::tasks::simulate::foothold::Foothold;
use core::f64::consts::{FRAC_PI_2, PI};

/// Force below which a stuck contact starts afresh, over `EI / L²`.
const WEAK: f64 = 1e-3;

impl Step<'_> {
    /// With friction: the contact where it is if the cone allows it, else sliding with the force on the cone's edge.
    pub(super) fn stick_or_slip(&self, contact: &Contact, guess: &Contact) -> Next {
        // What slides goes on sliding as long as friction opposes it.
        if contact.sliding.abs() > 0.0
            && let Some(next) = self.slide(contact, guess, contact.sliding)
        {
            return next;
        }
        let start = Load { s: contact.load.s, ..guess.load };
        let off = match self.stuck(&Contact { load: start, sliding: 0.0, ..*contact }) {
            Some((Next::Touching(next), off)) if off.abs() <= self.cone && self.is_near(contact, &next) => {
                return Next::Touching(next);
            }
            Some((_, off)) => off,
            None => self.cone,
        };
        let first = self.cone.copysign(off);
        let mut end = Next::Ends(LOST);
        for offset in [first, -first] {
            match self.slide(contact, guess, offset) {
                Some(Next::LiftOff) => end = Next::LiftOff,
                Some(next) => return next,
                None => {}
            }
        }
        end
    }

    /// The slide with the force this far off the frictionless direction (rad), if friction then opposes it.
    fn slide(&self, contact: &Contact, guess: &Contact, offset: f64) -> Option<Next> {
        match self.run(guess.hold, guess.load, offset) {
            Next::Touching(next) if self.opposes(contact, &next, offset) && self.is_near(contact, &next) => {
                Some(Next::Touching(Contact { sliding: if next.stuck { 0.0 } else { offset }, ..next }))
            }
            Next::LiftOff => Some(Next::LiftOff),
            _ => None,
        }
    }

    /// Whether friction with the force this far off acts against the way that the whisker slid.
    fn opposes(&self, before: &Contact, after: &Contact, offset: f64) -> bool {
        let across = Vec2::from_angle(self.stance.direction(after.load, &after.state) - offset).perp();
        // The contact moves over the boundary, and the whisker's material over the contact.
        let along = Vec2::from_angle(self.stance.heading(&after.state));
        let passed = (before.load.s - after.load.s) * self.stance.flex.beam.length;
        let slid = (after.place - before.place + along * passed).dot(across);
        slid * offset.signum() <= 1e-9 * self.stance.flex.beam.length
    }

    /// The contact stuck where it is, and the force's angle off the frictionless direction (rad).
    fn stuck(&self, contact: &Contact) -> Option<(Next, f64)> {
        let stance = &self.stance;
        if let Hold::Flank(foothold, lay) = contact.hold {
            return self.rolled(contact, foothold, lay);
        }
        let solve = |start: Load| stance.at_place(Unknown::Tilt, start, contact.place);
        let (load, state, _) = solve(self.first_push(contact)).or_else(|| solve(contact.load))?;
        let direction = stance.direction(load, &state);
        let off = match contact.hold {
            Hold::Tip(foothold) => wrap_angle(direction - foothold.ground(stance.map).normal),
            Hold::Corner(joint) => {
                let lean = joint.lean(direction);
                (lean - lean.clamp(0.0, 1.0)) * joint.turn
            }
            Hold::Vertex(joint, lay) => {
                let lean = joint.lean(stance.heading(&state) + lay + FRAC_PI_2);
                if lean < 0.0 {
                    return self.rolled(contact, joint.before, lay);
                }
                if lean > 1.0 {
                    return self.rolled(contact, joint.after, lay);
                }
                wrap_angle(load.beta - lay)
            }
            Hold::Flank(..) => 0.0,
        };
        let next = Contact { load, state, stuck: true, ..*contact };
        if contact.hold.is_tip()
            && let Hold::Tip(foothold) = contact.hold
            && (stance.heading(&state) - foothold.ground(stance.map).normal).cos() > 0.0
        {
            let lay = if load.beta.cos() > 0.0 { 0.0 } else { PI };
            return self.rolled(&next, foothold, lay);
        }
        if load.q < 0.0 {
            return Some((Next::LiftOff, 0.0));
        }
        Some((Next::Touching(next), off))
    }

    /// Where the search for a stuck contact starts: at its load, or at the small push across the whisker that brings an
    /// unloaded one to its place.
    fn first_push(&self, contact: &Contact) -> Load {
        let rest = Load { q: 0.0, ..contact.load };
        let Some(state) = self.stance.flex.at(rest).filter(|_| contact.load.q < WEAK) else { return contact.load };
        let across = (self.stance.seen(contact.place) - state.p).rotated(-state.slope).y;
        let s = contact.load.s;
        Load { q: 3.0 * across.abs() / (s * s * s), beta: if across < 0.0 { PI } else { 0.0 }, s }
    }

    /// The side rolled on along a piece without sliding.
    fn rolled(&self, contact: &Contact, foothold: Foothold, lay: f64) -> Option<(Next, f64)> {
        let rule = Rule::Roll { lay, s: contact.load.s, at: foothold.at };
        let OnPiece::Found { load, state, foothold, .. } = self.stance.on_piece(rule, contact.load, foothold) else {
            return None;
        };
        if load.s > 1.0 + TIP_SLACK {
            return None;
        }
        let off = wrap_angle(load.beta - lay);
        match self.on_flank(foothold, lay, load, state, true) {
            Tried::Is(next) => Some((next, off)),
            Tried::Then(Hold::Vertex(joint, lay), load) => {
                // Rolled to a corner: it sticks there, with the arc length that it has come to.
                let at_corner = Contact { load, hold: Hold::Vertex(joint, lay), place: joint.position, ..*contact };
                let (load, state, _) = self.stance.at_place(Unknown::Tilt, load, joint.position)?;
                Some((Next::Touching(Contact { load, state, stuck: true, ..at_corner }), wrap_angle(load.beta - lay)))
            }
            Tried::Then(..) => None,
        }
    }
}
