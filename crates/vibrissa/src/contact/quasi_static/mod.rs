//! One contact after a small motion: which hold comes next along whisker and boundary, stick and slip.
//!
//! | hold | whisker | boundary | unknown besides the force |
//! | --- | --- | --- | --- |
//! | `Tip` | tip | a piece | place on the piece, tilt |
//! | `Corner` | tip | a concave corner | tilt |
//! | `Vertex` | side | a convex corner, the end of a wall | arc length |
//! | `Flank` | side | a piece, tangent | place on the piece, arc length |
//!
//! A contact that sticks keeps its place on the boundary and its arc length (a flank rolls), with the tilt unknown, as
//! long as the force stays in the friction cone; then it slides with the force on the cone's edge. Holds follow one
//! another: the tip slides over a convex corner onto the next piece or lies down on the one it is on, a flank rolls over a
//! corner, a side contact moves off the tip. Every solution must lie near the one before, or there is none.

mod friction;

use super::equilibrium::{OnPiece, Rule, Stance, Unknown};
use super::flex::{Load, State};
use super::foothold::{Foothold, Joint};
use crate::plane::Vec2;
use core::f64::consts::{FRAC_PI_2, PI};

/// Holds that one step may pass.
const MOST_MOVES: usize = 100;
/// How far beyond its ends a piece still counts (share of the piece).
const END_SLACK: f64 = 1e-9;
/// Arc length beyond the tip that is still the tip, over L.
const TIP_SLACK: f64 = 1e-12;
/// Largest travel of the contact along the boundary or the whisker in one step, over L.
const LARGEST_SLIDE: f64 = 0.03;
/// Largest turn of the whisker at the contact in one step (rad).
const LARGEST_TURN: f64 = 0.2;

/// What holds the whisker.
#[derive(Clone, Copy, Debug)]
pub(super) enum Hold {
    Tip(Foothold),
    Corner(Joint),
    /// With the load's tilt without friction: 0 or pi.
    Vertex(Joint, f64),
    Flank(Foothold, f64),
}

/// A whisker in contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    pub(super) load: Load,
    pub(super) state: State,
    pub(super) hold: Hold,
    /// The contact, map frame (m).
    pub(super) place: Vec2,
    pub(super) stuck: bool,
    /// The force's angle off the frictionless direction while it slides with friction (rad), else 0.
    pub(super) sliding: f64,
}

impl Contact {
    /// Where the contact comes to if it goes on as it did from `before`; none across a change of hold.
    fn extrapolated(&self, before: &Self, ratio: f64) -> Option<Self> {
        let on = |now: f64, then: f64| now + ratio * (now - then);
        let hold = match (self.hold, before.hold) {
            (Hold::Tip(a), Hold::Tip(b)) => Hold::Tip(Foothold { at: on(a.at, b.at), ..a }),
            (Hold::Flank(a, lay), Hold::Flank(b, _)) => Hold::Flank(Foothold { at: on(a.at, b.at), ..a }, lay),
            (hold, _) => hold,
        };
        let (a, b) = (self.load, before.load);
        let load = Load { q: on(a.q, b.q).max(0.0), s: on(a.s, b.s).min(1.0), beta: on(a.beta, b.beta) };
        self.hold.is_same(&before.hold).then_some(Self { load, hold, ..*self })
    }
}

/// What a step found.
pub(super) enum Next {
    Touching(Contact),
    /// The boundary would have to pull.
    LiftOff,
    /// No contact near the one before: why.
    Ends(&'static str),
}

pub(super) const LOST: &str = "loses its equilibrium";
pub(super) const WALL_END: &str = "slides off the end of a wall";
const SLIPS: &str = "slips over a corner";

/// A step in the making: the stance, and the half angle of the friction cone (rad).
pub(super) struct Step<'a> {
    pub(super) stance: Stance<'a>,
    pub(super) cone: f64,
}

impl Hold {
    fn is_tip(&self) -> bool {
        matches!(self, Self::Tip(_) | Self::Corner(_))
    }

    /// Whether this is the same piece or corner, held in the same way.
    fn is_same(&self, other: &Self) -> bool {
        let piece =
            |a: &Foothold, b: &Foothold| a.segment == b.segment && a.boundary == b.boundary && a.side * b.side > 0.0;
        match (self, other) {
            (Self::Tip(a), Self::Tip(b)) | (Self::Flank(a, _), Self::Flank(b, _)) => piece(a, b),
            (Self::Corner(a), Self::Corner(b)) | (Self::Vertex(a, _), Self::Vertex(b, _)) => piece(&a.after, &b.after),
            _ => false,
        }
    }
}

/// One hold tried: it holds, another is next, or the step ends.
enum Tried {
    Is(Next),
    Then(Hold, Load),
}

impl Step<'_> {
    /// As [`Step::next`], looked for first where a motion like the last one would lead; `ratio` says how long this one is
    /// over that one.
    pub(super) fn next_after(&self, before: Option<&Contact>, contact: &Contact, ratio: f64) -> Next {
        let Some(guess) = before.and_then(|before| contact.extrapolated(before, ratio)) else {
            return self.next(contact);
        };
        match self.from(contact, &guess) {
            Next::Touching(next) => Next::Touching(next),
            _ => self.next(contact),
        }
    }

    /// The equilibrium after a small motion, near enough to the one before to be its continuation.
    pub(super) fn next(&self, contact: &Contact) -> Next {
        self.from(contact, contact)
    }

    fn from(&self, contact: &Contact, guess: &Contact) -> Next {
        let next =
            if self.cone > 0.0 { self.stick_or_slip(contact, guess) } else { self.run(guess.hold, guess.load, 0.0) };
        match next {
            Next::Touching(next) if !self.is_near(contact, &next) => Next::Ends(LOST),
            other => other,
        }
    }

    fn is_near(&self, before: &Contact, after: &Contact) -> bool {
        let length = self.stance.flex.beam.length;
        let passed = (after.load.s - before.load.s).abs();
        let along = after.place.distance(before.place);
        along <= LARGEST_SLIDE * length
            && passed <= LARGEST_SLIDE
            && (after.state.slope - before.state.slope).abs() <= LARGEST_TURN
    }

    /// From hold to hold until one holds; `offset` is the force's angle off the frictionless direction (rad).
    pub(super) fn run(&self, mut hold: Hold, mut load: Load, offset: f64) -> Next {
        let mut before: Option<Hold> = None;
        for _ in 0..MOST_MOVES {
            match self.attempt(&hold, before.as_ref(), load, offset) {
                Tried::Is(next) => return next,
                Tried::Then(next, start) => {
                    if before.is_some_and(|before| before.is_same(&next)) {
                        // Back again: the contact has no place on either.
                        return Next::Ends(SLIPS);
                    }
                    before = Some(hold);
                    (hold, load) = (next, start);
                }
            }
        }
        Next::Ends(LOST)
    }

    fn attempt(&self, hold: &Hold, before: Option<&Hold>, load: Load, offset: f64) -> Tried {
        match *hold {
            Hold::Tip(foothold) => self.tip(foothold, before, load, offset),
            Hold::Corner(joint) => self.corner(&joint, load),
            Hold::Vertex(joint, lay) => self.vertex(&joint, lay, load, offset),
            Hold::Flank(foothold, lay) => self.flank(foothold, lay, load, offset),
        }
    }

    fn tip(&self, start: Foothold, before: Option<&Hold>, load: Load, offset: f64) -> Tried {
        let stance = &self.stance;
        let load = Load { s: 1.0, ..load };
        let (found, foothold) = match stance.on_piece(Rule::Slide { offset }, load, start) {
            OnPiece::Found { load, state, foothold, stable: true } => (Some((load, state)), foothold),
            OnPiece::Found { stable: false, .. } | OnPiece::Failed => return Tried::Is(Next::Ends(LOST)),
            OnPiece::Lost(foothold) => (None, foothold),
        };
        if (-END_SLACK..=1.0 + END_SLACK).contains(&foothold.at) {
            let Some((load, state)) = found else { return Tried::Is(Next::Ends(LOST)) };
            let normal = foothold.ground(stance.map).normal;
            if load.q > 0.0 && (stance.heading(&state) - normal).cos() > 0.0 {
                // The tip lies down on the boundary.
                let lay = if (load.beta - offset).cos() > 0.0 { 0.0 } else { PI };
                return Tried::Then(Hold::Flank(foothold, lay), Load { beta: lay + offset, ..load });
            }
            return Tried::Is(self.settle(load, state, Hold::Tip(foothold), false));
        }
        let forward = foothold.at > 0.5;
        let joint = foothold.joint(stance.map, forward);
        // Coming from one side, a concave corner is met before the other side. A weak force all but cannot be caught:
        // its direction turns at once, and the corner may find no solution at all.
        if joint.is_concave() {
            if let Some((held, state, lean)) = self.in_corner(load, &joint) {
                let slack = self.cone / joint.turn.abs();
                if (-slack..=1.0 + slack).contains(&lean) {
                    return Tried::Is(self.settle(held, state, Hold::Corner(joint), self.cone > 0.0));
                }
                if (lean > 0.5) != forward {
                    return Tried::Is(Next::Ends(LOST));
                }
            }
        } else if !joint.is_smooth()
            && let Some(state) = stance.flex.at(load)
        {
            let over = if forward { joint.after } else { joint.before };
            if (stance.heading(&state) - over.ground(stance.map).normal).cos() > 0.0 {
                return self.slips_past(&joint, load, offset);
            }
        }
        let next = Hold::Tip(if forward { joint.after } else { joint.before });
        if before.is_some_and(|before| before.is_same(&next)) {
            return Tried::Is(Next::Ends(LOST));
        }
        Tried::Then(next, load)
    }

    /// The tip goes past a convex corner, and the side comes to lie on it if it can.
    fn slips_past(&self, joint: &Joint, load: Load, offset: f64) -> Tried {
        let lay = if (load.beta - offset).cos() > 0.0 { 0.0 } else { PI };
        let load = Load { beta: lay + offset, ..load };
        match self.vertex(joint, lay, load, offset) {
            Tried::Is(Next::Touching(contact)) => Tried::Is(Next::Touching(contact)),
            _ if joint.is_end() => Tried::Is(Next::Ends(WALL_END)),
            _ => Tried::Is(Next::Ends(SLIPS)),
        }
    }

    fn in_corner(&self, load: Load, joint: &Joint) -> Option<(Load, State, f64)> {
        let (held, state, _) = self.stance.at_place(Unknown::Tilt, load, joint.position)?;
        Some((held, state, joint.lean(self.stance.direction(held, &state))))
    }

    fn corner(&self, joint: &Joint, load: Load) -> Tried {
        let Some((held, state, lean)) = self.in_corner(load, joint) else { return Tried::Is(Next::Ends(LOST)) };
        let slack = self.cone / joint.turn.abs();
        if lean < -slack {
            return Tried::Then(Hold::Tip(joint.before), load);
        }
        if lean > 1.0 + slack {
            return Tried::Then(Hold::Tip(joint.after), load);
        }
        Tried::Is(self.settle(held, state, Hold::Corner(*joint), self.cone > 0.0))
    }

    fn vertex(&self, joint: &Joint, lay: f64, load: Load, offset: f64) -> Tried {
        let stance = &self.stance;
        let start = Load { beta: lay + offset, ..load };
        let closed = if offset.abs() > 0.0 {
            None
        } else {
            let p = stance.map_from_whisker.inverse_transform_point(joint.position) * (1.0 / stance.flex.beam.length);
            let slope = stance.flex.at(load).map_or(0.0, |state| state.slope);
            stance.flex.touched_at(p, slope)
        };
        let solved = match closed {
            Some(found) => {
                found.map(|(load, state)| (Load { q: load.q * lay.cos().signum(), beta: lay, ..load }, state))
            }
            None => stance
                .at_place(Unknown::ArcLength, start, joint.position)
                .filter(|(.., stable)| *stable)
                .map(|(load, state, _)| (load, state)),
        };
        let Some((load, state)) = solved else { return Tried::Is(Next::Ends(LOST)) };
        if load.q < 0.0 {
            return Tried::Is(Next::LiftOff);
        }
        if load.s > 1.0 + TIP_SLACK {
            return self.slips_off(joint, &state, Load { s: 1.0, ..load });
        }
        let across = self.stance.heading(&state) + lay + FRAC_PI_2;
        let lean = joint.lean(across);
        if lean < 0.0 {
            return Tried::Then(Hold::Flank(joint.before, lay), load);
        }
        if lean > 1.0 {
            return Tried::Then(Hold::Flank(joint.after, lay), load);
        }
        Tried::Is(self.settle(load, state, Hold::Vertex(*joint, lay), false))
    }

    /// A convex corner has come to the tip: the tip goes on to a side of it that it faces, if any is near.
    fn slips_off(&self, joint: &Joint, state: &State, load: Load) -> Tried {
        let heading = self.stance.heading(state);
        for foothold in [joint.before, joint.after] {
            if (heading - foothold.ground(self.stance.map).normal).cos() < 0.0
                && let OnPiece::Found { load, state, foothold, stable: true } =
                    self.stance.on_piece(Rule::Slide { offset: 0.0 }, load, foothold)
                && (0.0..=1.0).contains(&foothold.at)
            {
                return Tried::Is(self.settle(load, state, Hold::Tip(foothold), false));
            }
        }
        Tried::Is(Next::Ends("slips off a corner"))
    }

    fn flank(&self, start: Foothold, lay: f64, load: Load, offset: f64) -> Tried {
        let start_load = Load { beta: lay + offset, ..load };
        match self.stance.on_piece(Rule::Flank { lay }, start_load, start) {
            OnPiece::Found { load, state, foothold, .. } => {
                if load.s > 1.0 + TIP_SLACK {
                    return Tried::Then(Hold::Tip(foothold), Load { s: 1.0, ..load });
                }
                self.on_flank(foothold, lay, load, state, false)
            }
            OnPiece::Lost(foothold) => self.beyond(foothold, lay, start_load),
            OnPiece::Failed => Tried::Is(Next::Ends(LOST)),
        }
    }

    fn on_flank(&self, foothold: Foothold, lay: f64, load: Load, state: State, stuck: bool) -> Tried {
        if (-END_SLACK..=1.0 + END_SLACK).contains(&foothold.at) {
            return Tried::Is(self.settle(load, state, Hold::Flank(foothold, lay), stuck));
        }
        self.beyond(foothold, lay, load)
    }

    /// A flank has left its piece.
    fn beyond(&self, foothold: Foothold, lay: f64, load: Load) -> Tried {
        let forward = foothold.at > 0.5;
        let joint = foothold.joint(self.stance.map, forward);
        if joint.is_smooth() {
            return Tried::Then(Hold::Flank(if forward { joint.after } else { joint.before }, lay), load);
        }
        if joint.is_concave() {
            return Tried::Is(Next::Ends(LOST));
        }
        Tried::Then(Hold::Vertex(joint, lay), load)
    }

    fn settle(&self, load: Load, state: State, hold: Hold, stuck: bool) -> Next {
        if load.q < 0.0 {
            return Next::LiftOff;
        }
        Next::Touching(Contact { load, state, hold, place: self.stance.place(&state), stuck, sliding: 0.0 })
    }
}
