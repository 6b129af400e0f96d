//! One contact of any whisker with friction after a small motion, for simulation.
//!
//! | hold | unknown besides the force |
//! | --- | --- |
//! | tip on a piece | place on the piece, tilt |
//! | tip in a corner | tilt |
//! | side on a corner | arc length |
//! | side on a piece | place on the piece, arc length |
//!
//! A contact that sticks keeps its place on the boundary and its arc length (a side rolls along a piece), with the tilt
//! unknown, as long as the force stays in the friction cone; then it slides with the force on the cone's edge. Holds
//! follow one another: the tip slides over a convex corner onto the next piece or lies down on the one it is on, a side
//! rolls over a corner, a side contact moves off the tip. Every solution must lie near the one before, or there is
//! none; two contacts at once are none.

mod friction;
mod loaded;
mod newton;
mod onset;

use super::{Corner, Hold, Push, Support};
use crate::math;
use crate::plane::Vec2;
pub use loaded::{LoadedState, LoadedWhisker, PointLoad};
pub use newton::WhiskerOnMap;
use newton::{PieceSolution, Rule, Unknown};
pub use onset::{between, blocked, first_touch, meets, onset, side_hold};

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
/// Largest change of `M0 L / EI` in one step: a whisker that buckles has another equilibrium with the opposite moment near by.
const LARGEST_CHANGE: f64 = 0.25;

/// A whisker in contact.
#[derive(Clone, Copy, Debug)]
pub struct Equilibrium {
    /// The force.
    pub load: PointLoad,
    /// The whisker under it.
    pub state: LoadedState,
    /// What holds it; never two contacts.
    pub hold: Hold,
    /// The contact, map frame (m).
    pub place: Vec2,
    /// Whether friction holds it in place.
    pub stuck: bool,
    /// The force's angle off the frictionless direction while it slides with friction (rad), else 0.
    pub sliding: f64,
}

impl Equilibrium {
    /// Where the contact comes to if it goes on as it did from `before`; none across a change of hold.
    fn extrapolated(&self, before: &Self, ratio: f64) -> Option<Self> {
        let on = |now: f64, then: f64| now + ratio * (now - then);
        let hold = match (self.hold, before.hold) {
            (Hold::Tip(Support::Piece(piece, a)), Hold::Tip(Support::Piece(_, b))) => {
                Hold::Tip(Support::Piece(piece, on(a, b)))
            }
            (Hold::Side(Support::Piece(piece, a), push), Hold::Side(Support::Piece(_, b), _)) => {
                Hold::Side(Support::Piece(piece, on(a, b)), push)
            }
            (hold, _) => hold,
        };
        let (a, b) = (self.load, before.load);
        let load = PointLoad { q: on(a.q, b.q).max(0.0), s: on(a.s, b.s).min(1.0), beta: on(a.beta, b.beta) };
        self.hold.is_same(&before.hold).then_some(Self { load, hold, ..*self })
    }
}

/// What a step found.
#[derive(Clone, Copy, Debug)]
pub enum Outcome {
    /// In contact.
    Touching(Equilibrium),
    /// The boundary would have to pull.
    LiftOff,
    /// No contact near the one before: why.
    Ends(&'static str),
}

/// Why a step ends: nothing is found near the contact before.
const LOST: &str = "loses its equilibrium";
/// Why a step ends: the tip has left a wall over its end.
pub const WALL_END: &str = "slides off the end of a wall";
const SLIPS: &str = "slips over a corner";

/// A step in the making.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// The whisker where the step leads.
    pub on: WhiskerOnMap<'a>,
    /// Half angle of the friction cone (rad).
    pub cone: f64,
}

/// One hold tried: it holds, another is next, or the step ends.
enum Tried {
    Is(Outcome),
    Then(Hold, PointLoad),
}

impl Step<'_> {
    /// As [`Step::next`], looked for first where a motion like the last one would lead; `ratio` says how long this one
    /// is over that one.
    #[must_use]
    pub fn next_after(&self, before: Option<&Equilibrium>, contact: &Equilibrium, ratio: f64) -> Outcome {
        let Some(guess) = before.and_then(|before| contact.extrapolated(before, ratio)) else {
            return self.next(contact);
        };
        match self.from(contact, &guess) {
            Outcome::Touching(next) => Outcome::Touching(next),
            _ => self.next(contact),
        }
    }

    /// The equilibrium after a small motion, near enough to the one before to be its continuation.
    #[must_use]
    pub fn next(&self, contact: &Equilibrium) -> Outcome {
        self.from(contact, contact)
    }

    fn from(&self, contact: &Equilibrium, guess: &Equilibrium) -> Outcome {
        let next =
            if self.cone > 0.0 { self.stick_or_slip(contact, guess) } else { self.run(guess.hold, guess.load, 0.0) };
        match next {
            Outcome::Touching(next) if !self.is_near(contact, &next) => Outcome::Ends(LOST),
            other => other,
        }
    }

    fn is_near(&self, before: &Equilibrium, after: &Equilibrium) -> bool {
        let length = self.on.whisker.beam.length;
        let passed = (after.load.s - before.load.s).abs();
        let along = after.place.distance(before.place);
        along <= LARGEST_SLIDE * length
            && passed <= LARGEST_SLIDE
            && (after.state.slope - before.state.slope).abs() <= LARGEST_TURN
            && (after.state.m - before.state.m).abs() <= LARGEST_CHANGE
    }

    /// From hold to hold until one holds; `offset` is the force's angle off the frictionless direction (rad).
    #[must_use]
    pub fn run(&self, mut hold: Hold, mut load: PointLoad, offset: f64) -> Outcome {
        let mut before: Option<Hold> = None;
        for _ in 0..MOST_MOVES {
            match self.attempt(&hold, before.as_ref(), load, offset) {
                Tried::Is(next) => return next,
                Tried::Then(next, start) => {
                    if before.is_some_and(|before| before.is_same(&next)) {
                        // Back again: the contact has no place on either.
                        return Outcome::Ends(SLIPS);
                    }
                    before = Some(hold);
                    (hold, load) = (next, start);
                }
            }
        }
        Outcome::Ends(LOST)
    }

    fn attempt(&self, hold: &Hold, before: Option<&Hold>, load: PointLoad, offset: f64) -> Tried {
        match *hold {
            Hold::Tip(Support::Piece(piece, at)) => self.tip((piece, at), before, load, offset),
            Hold::Tip(Support::Corner(id)) => self.corner(id, load),
            Hold::Side(Support::Corner(id), push) => self.vertex(id, push, load, offset),
            Hold::Side(Support::Piece(piece, at), push) => self.flank((piece, at), push, load, offset),
            Hold::Both(_) => Tried::Is(Outcome::Ends(LOST)),
        }
    }

    fn tip(&self, (piece, start): (u32, f64), before: Option<&Hold>, load: PointLoad, offset: f64) -> Tried {
        let load = PointLoad { s: 1.0, ..load };
        let (found, at) = match self.on.on_piece(Rule::Slide { offset }, load, (piece, start)) {
            PieceSolution::Found { load, state, at, stable: true } => (Some((load, state)), at),
            PieceSolution::Found { stable: false, .. } | PieceSolution::Failed => {
                return Tried::Is(Outcome::Ends(LOST));
            }
            PieceSolution::Lost(at) => (None, at),
        };
        if (-END_SLACK..=1.0 + END_SLACK).contains(&at) {
            let Some((load, state)) = found else { return Tried::Is(Outcome::Ends(LOST)) };
            let normal = self.on.boundaries.spot((piece, at)).normal;
            if load.q > 0.0 && math::cos(self.on.stance.heading(state.slope) - normal) > 0.0 {
                // The tip lies down on the boundary.
                let push = Push::of(load.beta - offset);
                let laid = PointLoad { beta: push.tilt() + offset, ..load };
                return Tried::Then(Hold::Side(Support::Piece(piece, at), push), laid);
            }
            return Tried::Is(self.settle(load, state, Hold::Tip(Support::Piece(piece, at)), false));
        }
        self.past_end(piece, at > 0.5, before, load, offset)
    }

    /// The tip has slid past the start or the end of a piece.
    fn past_end(&self, piece: u32, forward: bool, before: Option<&Hold>, load: PointLoad, offset: f64) -> Tried {
        let Some((id, corner)) = self.on.boundaries.corner_of(piece, forward) else {
            return Tried::Is(Outcome::Ends(LOST));
        };
        let over = corner.across(piece, forward);
        // Coming from one side, a concave corner is met before the other side. A weak force all but cannot be caught:
        // its direction turns at once, and the corner may find no solution at all.
        if corner.is_concave() {
            if let Some((held, state, lean)) = self.in_corner(load, &corner) {
                let slack = self.cone / corner.turn.abs();
                if (-slack..=1.0 + slack).contains(&lean) {
                    return Tried::Is(self.settle(held, state, Hold::Tip(Support::Corner(id)), self.cone > 0.0));
                }
                if (lean > 0.5) != forward {
                    return Tried::Is(Outcome::Ends(LOST));
                }
            }
        } else if !corner.is_smooth()
            && let Some(state) = self.on.whisker.at(load)
            && math::cos(self.on.stance.heading(state.slope) - self.on.boundaries.spot(over).normal) > 0.0
        {
            return self.slips_past(id, corner.is_end(), load, offset);
        }
        let next = Hold::Tip(over.into());
        if before.is_some_and(|before| before.is_same(&next)) {
            return Tried::Is(Outcome::Ends(LOST));
        }
        Tried::Then(next, load)
    }

    /// The tip goes past a convex corner, and the side comes to lie on it if it can.
    fn slips_past(&self, id: u32, is_end: bool, load: PointLoad, offset: f64) -> Tried {
        let push = Push::of(load.beta - offset);
        let load = PointLoad { beta: push.tilt() + offset, ..load };
        match self.vertex(id, push, load, offset) {
            Tried::Is(Outcome::Touching(contact)) => Tried::Is(Outcome::Touching(contact)),
            _ if is_end => Tried::Is(Outcome::Ends(WALL_END)),
            _ => Tried::Is(Outcome::Ends(SLIPS)),
        }
    }

    fn in_corner(&self, load: PointLoad, corner: &Corner) -> Option<(PointLoad, LoadedState, f64)> {
        let (held, state, _) = self.on.at_place(Unknown::Tilt, load, corner.position)?;
        Some((held, state, corner.lean(self.on.direction(held, &state))))
    }

    fn corner(&self, id: u32, load: PointLoad) -> Tried {
        let solved = self.on.boundaries.corner(id).and_then(|corner| Some((corner, self.in_corner(load, &corner)?)));
        let Some((corner, (held, state, lean))) = solved else { return Tried::Is(Outcome::Ends(LOST)) };
        let slack = self.cone / corner.turn.abs();
        if lean < -slack {
            return Tried::Then(Hold::Tip(corner.before.into()), load);
        }
        if lean > 1.0 + slack {
            return Tried::Then(Hold::Tip(corner.after.into()), load);
        }
        Tried::Is(self.settle(held, state, Hold::Tip(Support::Corner(id)), self.cone > 0.0))
    }

    fn vertex(&self, id: u32, push: Push, load: PointLoad, offset: f64) -> Tried {
        let Some(corner) = self.on.boundaries.corner(id) else { return Tried::Is(Outcome::Ends(LOST)) };
        let Some((load, state)) = self.on_vertex(corner.position, push, load, offset) else {
            return Tried::Is(Outcome::Ends(LOST));
        };
        if load.q < 0.0 {
            return Tried::Is(Outcome::LiftOff);
        }
        if load.s > 1.0 + TIP_SLACK {
            return self.slips_off(&corner, &state, PointLoad { s: 1.0, ..load });
        }
        let lean = corner.lean(self.on.stance.direction(state.slope, push.tilt()));
        if lean < 0.0 {
            return Tried::Then(Hold::Side(corner.before.into(), push), load);
        }
        if lean > 1.0 {
            return Tried::Then(Hold::Side(corner.after.into(), push), load);
        }
        Tried::Is(self.settle(load, state, Hold::Side(Support::Corner(id), push), false))
    }

    /// The equilibrium with the side at a place, in closed form where there is one.
    fn on_vertex(&self, place: Vec2, push: Push, load: PointLoad, offset: f64) -> Option<(PointLoad, LoadedState)> {
        let closed = if offset.abs() > 0.0 {
            None
        } else {
            let slope = self.on.whisker.at(load).map_or(0.0, |state| state.slope);
            self.on.whisker.touched_at(self.on.stance.seen(place), slope)
        };
        if let Some(found) = closed {
            return found
                .map(|(load, state)| (PointLoad { q: load.q * push.sign(), beta: push.tilt(), ..load }, state));
        }
        let start = PointLoad { beta: push.tilt() + offset, ..load };
        let (load, state, stable) = self.on.at_place(Unknown::ArcLength, start, place)?;
        stable.then_some((load, state))
    }

    /// A convex corner has come to the tip: the tip goes on to a side of it that it faces, if any is near.
    fn slips_off(&self, corner: &Corner, state: &LoadedState, load: PointLoad) -> Tried {
        let heading = self.on.stance.heading(state.slope);
        for (piece, end) in [corner.before, corner.after] {
            if math::cos(heading - self.on.boundaries.spot((piece, end)).normal) < 0.0
                && let PieceSolution::Found { load, state, at, stable: true } =
                    self.on.on_piece(Rule::Slide { offset: 0.0 }, load, (piece, end))
                && (0.0..=1.0).contains(&at)
            {
                return Tried::Is(self.settle(load, state, Hold::Tip(Support::Piece(piece, at)), false));
            }
        }
        Tried::Is(Outcome::Ends("slips off a corner"))
    }

    fn flank(&self, (piece, start): (u32, f64), push: Push, load: PointLoad, offset: f64) -> Tried {
        let start_load = PointLoad { beta: push.tilt() + offset, ..load };
        match self.on.on_piece(Rule::Flank { push }, start_load, (piece, start)) {
            PieceSolution::Found { load, state, at, .. } => {
                if load.s > 1.0 + TIP_SLACK {
                    return Tried::Then(Hold::Tip(Support::Piece(piece, at)), PointLoad { s: 1.0, ..load });
                }
                self.on_flank((piece, at), push, load, state, false)
            }
            PieceSolution::Lost(at) => self.beyond((piece, at), push, start_load),
            PieceSolution::Failed => Tried::Is(Outcome::Ends(LOST)),
        }
    }

    fn on_flank(&self, (piece, at): (u32, f64), push: Push, load: PointLoad, state: LoadedState, stuck: bool) -> Tried {
        if (-END_SLACK..=1.0 + END_SLACK).contains(&at) {
            return Tried::Is(self.settle(load, state, Hold::Side(Support::Piece(piece, at), push), stuck));
        }
        self.beyond((piece, at), push, load)
    }

    /// A flank has left its piece.
    fn beyond(&self, (piece, at): (u32, f64), push: Push, load: PointLoad) -> Tried {
        let forward = at > 0.5;
        let corner = self.on.boundaries.corner_of(piece, forward).filter(|(_, corner)| !corner.is_concave());
        match corner {
            None => Tried::Is(Outcome::Ends(LOST)),
            Some((_, corner)) if corner.is_smooth() => {
                Tried::Then(Hold::Side(corner.across(piece, forward).into(), push), load)
            }
            Some((id, _)) => Tried::Then(Hold::Side(Support::Corner(id), push), load),
        }
    }

    fn settle(&self, load: PointLoad, state: LoadedState, hold: Hold, stuck: bool) -> Outcome {
        if load.q < 0.0 {
            return Outcome::LiftOff;
        }
        Outcome::Touching(Equilibrium { load, state, hold, place: self.on.place(&state), stuck, sliding: 0.0 })
    }
}
