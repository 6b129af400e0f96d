//! The side on a boundary and further out the tip, or the side again: a bump that rises under a whisker whose tip is in a bay, a whisker
//! that is bent around two corners.
//!
//! The unknowns are the load of [`super::span`], the places of both contacts on their pieces (on a corner it is given), and the arc length
//! of an outer contact of the side, beyond which the whisker is straight. Newton's method solves for both places, the direction of the
//! outer force and the free end. Where one of the two forces would have to pull, that contact ends.

use super::balance::{MOST, count, equations, gradient, is_stable, solved};
use super::both_snap::BothSlid;
use super::span::{self, Shape, UNKNOWNS};
use super::tip::points_out;
use super::{Contact, ForwardModel, Mechanics, Next, Prediction};
use crate::contact::{Hold, Push, Spot, Stance, Support, TwoContacts};
use crate::math;
use crate::plane::{Vec2, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI};

/// Newton steps before an equilibrium is given up, and where one more ends the search (lengths, rad, curvature).
const MOST_STEPS: usize = 12;
const NEAR: f64 = 1e-3;
const NEAR_EXACT: f64 = 1e-5;
/// Largest change of the moment, of a force, and of the arc length, in one step: along an all but straight whisker
/// forces are large.
const LARGEST_MOMENT: f64 = 1.0;
const LARGEST_PUSH: f64 = 20.0;
const LARGEST_SHIFT: f64 = 0.08;
/// How far the outer contact is from the inner one at least (arc length over the length), and how far beyond the tip it is looked for.
const APART: f64 = 5e-4;
const BEYOND_TIP: f64 = 1.5;
/// How far (whisker lengths, rad) a tip may be beyond a corner and its piece both, where each of them says the other holds it.
const SLACK: f64 = 1e-3;
/// Contacts that one step may pass.
const MOST_MOVES: usize = 12;
/// Corners that turn by no more than this are passed over by a tip (rad).
const SLIGHT: f64 = 0.1;

/// An equilibrium.
pub(super) struct Solved {
    pub(super) both: TwoContacts,
    predicted: Prediction,
    pub(super) shape: Shape,
}

/// What a contact rests on next, and its arc length where it is one of the side.
type Rest = (Support, Option<f64>);

impl ForwardModel<'_> {
    /// A whisker with a contact and this share of its length, nearer to the base, near another place: both hold it.
    pub(super) fn propped(&self, stance: &Stance, touch: &Contact, share: f64, (piece, at): (u32, f64)) -> Next {
        let Some(both) = self.with_inner(touch, share, (piece, at)) else { return Next::None };
        let first = self.on_both(stance, both);
        if matches!(&first, Next::Touching(touch, _) if matches!(touch.hold, Hold::Both(_))) {
            return first;
        }
        // A whisker that bends the other way touches corners alone.
        let convex = |forward: bool| self.boundaries.corner_of(piece, forward).filter(|(_, corner)| corner.is_convex());
        match convex(at > 0.5).or_else(|| convex(at <= 0.5)) {
            Some((id, _)) => match self.on_both(stance, TwoContacts { inner: Support::Corner(id), ..both }) {
                Next::Touching(touch, predicted) => Next::Touching(touch, predicted),
                _ => first,
            },
            None => first,
        }
    }

    /// The two contacts of a whisker with this one and this share of its length, nearer to the base, near another place.
    pub(super) fn with_inner(&self, touch: &Contact, share: f64, (piece, at): (u32, f64)) -> Option<TwoContacts> {
        let chart = self.mechanics.held_chart(touch.q, touch.beta)?;
        let (outer, lies_at) = match touch.hold {
            Hold::Tip(on) => (on, None),
            Hold::Side(on, _) => (on, Some(touch.s)),
            Hold::Both(_) => return None,
        };
        let per = 1.0 / touch.s;
        let force = Vec2::from_angle(touch.slope + touch.beta + FRAC_PI_2) * (touch.q * per * per);
        let load = [chart.moment * per, force.x, force.y, share, 0.0];
        let inner = Support::Piece(piece, at.clamp(0.0, 1.0));
        Some(TwoContacts { load, inner, outer, lies_at })
    }

    /// A whisker with its side on a boundary whose straight end has come to another place: both hold it.
    pub(super) fn stopped(&self, stance: &Stance, touch: &Contact, (outer, lies_at): Rest) -> Next {
        let Hold::Side(inner, _) = touch.hold else { return Next::None };
        let per = 1.0 / touch.s;
        let Some(chart) = self.mechanics.chart(touch.q, touch.beta) else { return Next::None };
        let push = touch.q * per * per * math::cos(touch.beta);
        let force = Vec2::from_angle(touch.slope + FRAC_PI_2) * push;
        let load = [chart.moment * per, force.x, force.y, touch.s, push];
        let both = TwoContacts { load, inner, outer, lies_at };
        match self.on_both(stance, both) {
            Next::None => match self.both_slid(stance, &both, None) {
                // It gives way at once.
                Some(BothSlid::Rests(touch, predicted)) => Next::Touching(touch, predicted),
                _ => Next::None,
            },
            next => next,
        }
    }

    /// What goes on where the two contacts cannot: the stronger of them, or the other.
    pub(super) fn on_either(&self, stance: &Stance, both: &TwoContacts) -> Next {
        let shape = self.shape_of(both);
        let outer_first = shape.force.norm() > both.load[4].abs();
        match self.one(stance, both, &shape, outer_first) {
            Next::Touching(touch, predicted) => Next::Touching(touch, predicted),
            _ => self.one(stance, both, &shape, !outer_first),
        }
    }

    /// The shape under the load of two contacts.
    pub(super) fn shape_of(&self, both: &TwoContacts) -> Shape {
        span::shape(both.load, both.end(), !matches!(self.mechanics, Mechanics::ClosedForm))
    }

    /// The equilibrium with both, from these contacts on.
    pub(super) fn on_both(&self, stance: &Stance, mut both: TwoContacts) -> Next {
        let (mut inner_left, mut outer_left) = (None, None);
        let mut last: Option<Solved> = None;
        for _ in 0..MOST_MOVES {
            let solved = self.solve(stance, &both, matches!(both.outer, Support::Piece(..)));
            // Where it cannot go on it stays.
            let stuck = solved.is_none();
            let Some(Solved { both: found, predicted, shape }) = solved.or(last.take()) else { return Next::None };
            let Some((inner, held)) = self.inner_next(stance, &found, &shape) else { return Next::None };
            match inner.map(|on| (on, None)).filter(|&next| !stuck && !is_back(Some(next), inner_left)) {
                Some((inner, _)) => {
                    inner_left = Some((found.inner, None));
                    both = TwoContacts { inner, ..found };
                    last = Some(Solved { both: found, predicted, shape });
                    continue;
                }
                None if !held => return self.one(stance, &found, &shape, true),
                None => {}
            }
            let Some((outer, held)) = self.outer_next(stance, &found, &shape) else { return Next::None };
            if outer.is_some() && (stuck || is_back(outer, outer_left) && self.beyond(stance, &found, &shape) > SLACK) {
                return Next::None;
            }
            match outer.filter(|&next| !is_back(Some(next), outer_left)) {
                Some((outer, lies_at)) => {
                    outer_left = Some((found.outer, found.lies_at));
                    both = TwoContacts { outer, lies_at, ..found };
                    last = Some(Solved { both: found, predicted, shape });
                }
                None if !held => return self.one(stance, &found, &shape, false),
                None => {
                    let touch = Contact {
                        q: shape.force.norm(),
                        beta: 0.0,
                        s: found.end(),
                        hold: Hold::Both(found),
                        place: stance.placed(shape.outer.position),
                        slope: shape.outer.slope,
                        clear: 0.0,
                    };
                    return Next::Touching(touch, predicted);
                }
            }
        }
        Next::None
    }

    /// What the inner contact rests on next, if not on this, and whether the boundary pushes it. None where it leaves the whisker or the
    /// boundary.
    pub(super) fn inner_next(
        &self,
        stance: &Stance,
        both: &TwoContacts,
        shape: &Shape,
    ) -> Option<(Option<Support>, bool)> {
        let [.., s, push] = both.load;
        if !(0.02..both.end() - APART).contains(&s) {
            return None;
        }
        self.side_next(both.inner, push, stance.theta() + shape.inner.slope + FRAC_PI_2)
    }

    /// The same for a contact of the side with this force to the whisker's left; `across` is the direction there (rad, map frame).
    fn side_next(&self, on: Support, push: f64, across: f64) -> Option<(Option<Support>, bool)> {
        let to = |place: (u32, f64)| Some(Support::from(place));
        match on {
            Support::Piece(piece, at) => {
                let held = push * math::cos(across - self.boundaries.spot((piece, at)).normal) > 0.0;
                if (0.0..=1.0).contains(&at) {
                    return Some((None, held));
                }
                let (id, corner) = self.boundaries.corner_of(piece, at > 0.5)?;
                let over = to(if at > 0.5 { corner.after } else { corner.before });
                Some((if corner.is_convex() { Some(Support::Corner(id)) } else { over }, held))
            }
            Support::Corner(id) => {
                let corner = self.boundaries.corner(id)?;
                let facing = math::cos(across - corner.outward());
                let lean = corner.lean(if facing > 0.0 { across } else { across + PI });
                let next = if lean < 0.0 {
                    to(corner.before)
                } else if lean > 1.0 {
                    to(corner.after)
                } else {
                    None
                };
                Some((next, push * facing > 0.0))
            }
        }
    }

    /// What the outer contact rests on next, if not on this or not so, and whether the boundary pushes it.
    fn outer_next(&self, stance: &Stance, both: &TwoContacts, shape: &Shape) -> Option<(Option<Rest>, bool)> {
        let heading = stance.heading(shape.outer.slope);
        let Some(s) = both.lies_at else {
            return self.tip_next(both, heading, stance.theta() + shape.force.angle());
        };
        let push = shape.force.dot(Vec2::from_angle(shape.outer.slope + FRAC_PI_2));
        let (next, held) = self.side_next(both.outer, push, heading + FRAC_PI_2)?;
        if s <= 1.0 {
            return Some((next.map(|on| (on, both.lies_at)), held));
        }
        // What has come to the tip is one of the tip, of a corner along the side that it faces.
        let tip = match both.outer {
            Support::Piece(piece, at) => Some(Support::Piece(piece, at.clamp(0.0, 1.0))),
            Support::Corner(id) => {
                let corner = self.boundaries.corner(id)?;
                let sides = [(corner.before, corner.normal), (corner.after, corner.normal + corner.turn)];
                let facing = sides.into_iter().find(|(_, normal)| math::cos(heading - normal) < 0.0);
                facing.map(|(place, _)| place.into())
            }
        };
        Some((tip.map(|on| (on, None)), held))
    }

    /// The same for a tip that points there and whose force points in this direction (rad, map frame).
    fn tip_next(&self, both: &TwoContacts, heading: f64, direction: f64) -> Option<(Option<Rest>, bool)> {
        let to = |place: (u32, f64)| Some((Support::from(place), None));
        match both.outer {
            Support::Piece(piece, at) => {
                let normal = self.boundaries.spot((piece, at)).normal;
                let held = math::cos(direction - normal) > 0.0;
                if (0.0..=1.0).contains(&at) {
                    // One that points out of the boundary lies down.
                    let lies = (held && points_out(heading, normal)).then_some((both.outer, Some(1.0)));
                    return Some((lies, held));
                }
                let forward = at > 0.5;
                let (id, corner) = self.boundaries.corner_of(piece, forward)?;
                if corner.is_convex() && held && points_out(heading, self.normal_across(&corner, piece, forward)) {
                    return Some((Some((Support::Corner(id), Some(1.0))), held));
                }
                if corner.is_end() {
                    return None;
                }
                // Slight corners are those of polygons of round boundaries: they do not catch the tip for long.
                let caught = corner.is_concave() && corner.turn.abs() > SLIGHT;
                let over = to(if forward { corner.after } else { corner.before });
                Some((if caught { Some((Support::Corner(id), None)) } else { over }, held))
            }
            Support::Corner(id) => {
                let corner = self.boundaries.corner(id)?;
                let held = math::cos(direction - corner.outward()) > 0.0;
                let (lean, slack) = (corner.lean(direction), SLACK / corner.turn.abs());
                // Where one side does not press the tip may slide along the other, if that holds it.
                let next = if lean < slack {
                    to(corner.before)
                } else if lean > 1.0 - slack {
                    to(corner.after)
                } else {
                    None
                };
                Some((next, held))
            }
        }
    }

    /// How far the outer contact is beyond what it rests on: whisker lengths past the end of a piece or past the tip, rad past the normals
    /// of a corner.
    fn beyond(&self, stance: &Stance, both: &TwoContacts, shape: &Shape) -> f64 {
        let past = match both.outer {
            Support::Piece(piece, at) => (at - 1.0).max(-at) * self.boundaries.piece(piece).length() / self.length,
            Support::Corner(id) => self.boundaries.corner(id).map_or(0.0, |corner| {
                let lean = corner.lean(stance.theta() + shape.force.angle());
                (lean - 1.0).max(-lean) * corner.turn.abs()
            }),
        };
        past.max(both.end() - 1.0)
    }

    /// The concave corner in which a place of a piece all but is.
    pub(super) fn corner_at(&self, piece: u32, at: f64) -> Option<u32> {
        let end = (1.0 - at).min(at) * self.boundaries.piece(piece).length() / self.length;
        let corner = self.boundaries.corner_of(piece, at > 0.5);
        corner.filter(|(_, corner)| end <= SLACK && corner.is_concave()).map(|(id, _)| id)
    }

    /// One of the contacts has ended; the other goes on.
    fn one(&self, stance: &Stance, both: &TwoContacts, shape: &Shape, outer_stays: bool) -> Next {
        let [_, x, y, s, push] = both.load;
        if !outer_stays {
            return self.with_side(stance, both.inner, (push, s), (shape.inner.position, shape.inner.slope));
        }
        let outer = (shape.outer.position, shape.outer.slope);
        if let Some(s) = both.lies_at {
            let push = shape.force.dot(Vec2::from_angle(shape.outer.slope + FRAC_PI_2));
            return self.with_side(stance, both.outer, (push, s), outer);
        }
        let force = Vec2::new(x, y);
        let touch = Contact {
            q: force.norm(),
            beta: wrap_angle(force.angle() - outer.1 - FRAC_PI_2),
            s: 1.0,
            hold: Hold::Tip(both.outer),
            place: stance.placed(outer.0),
            slope: outer.1,
            clear: 0.0,
        };
        match both.outer {
            Support::Piece(piece, at) => {
                let at = at.clamp(0.0, 1.0);
                match self.corner_at(piece, at).and_then(|id| self.caught_in(stance, &touch, id)) {
                    Some((touch, predicted)) => Next::Touching(touch, predicted),
                    None => self.along(stance, &touch, piece, at, false),
                }
            }
            Support::Corner(id) => self.caught(stance, &touch, id),
        }
    }

    /// The whisker with nothing but its side here, from this force to its left at this arc length on.
    fn with_side(&self, stance: &Stance, on: Support, (push, s): (f64, f64), (position, slope): (Vec2, f64)) -> Next {
        let beta = if push > 0.0 { 0.0 } else { PI };
        let (hold, place) = (Hold::Side(on, Push::of(beta)), stance.placed(position));
        self.on_side(stance, Contact { q: push.abs() * s * s, beta, s, hold, place, slope, clear: 0.0 })
    }

    fn under(&self, rest: Support) -> Option<Spot> {
        Some(match rest {
            Support::Piece(piece, at) => self.boundaries.spot((piece, at)),
            Support::Corner(id) => {
                let corner = self.boundaries.corner(id)?;
                Spot { position: corner.position, velocity: Vec2::ZERO, normal: corner.normal, turning: 0.0 }
            }
        })
    }

    /// Newton's method on these contacts, wherever it leads along their pieces; an outer one that does not slide stays at its place.
    pub(super) fn solve(&self, stance: &Stance, from: &TwoContacts, outer_slides: bool) -> Option<Solved> {
        let mut both = *from;
        let near = self.mechanics.pick(NEAR, NEAR_EXACT);
        for _ in 0..MOST_STEPS {
            let shape = self.shape_of(&both);
            let under = (&self.under(both.inner)?, &self.under(both.outer)?);
            let (rows, residual) = equations(stance, &both, &shape, under, outer_slides);
            let (mut steps, mut adjoint) = (rows, [0.0; MOST]);
            let (d, positive) = solved(&mut steps, count(&both))?;
            let damp = (LARGEST_SHIFT / d[3].abs().max(d[7].abs()))
                .min(LARGEST_MOMENT / d[0].abs())
                .min(LARGEST_PUSH / d[1].abs().max(d[2].abs()).max(d[4].abs()))
                .min(1.0);
            (0..UNKNOWNS).for_each(|k| both.load[k] -= damp * d[k]);
            for (rest, step) in [(&mut both.outer, d[5]), (&mut both.inner, d[6])] {
                if let Support::Piece(piece, at) = rest {
                    *at -= damp * step;
                    if self.boundaries.piece(*piece).is_lost(*at) {
                        return None;
                    }
                }
            }
            both.lies_at = both.lies_at.map(|s| s - damp * d[7]);
            let (s, end) = (both.load[3], both.end());
            if !(s > 0.01 && s < end && end < BEYOND_TIP && both.load[4].is_finite()) {
                return None;
            }
            if residual < near && damp >= 1.0 {
                if outer_slides && both.lies_at.is_none() && !is_stable(&rows, positive, stance, under.1) {
                    return None;
                }
                let mut transposed = [[0.0; MOST + 1]; MOST];
                (0..MOST).for_each(|i| (0..MOST).for_each(|j| transposed[i][j] = rows[j][i]));
                transposed[0][MOST] = 1.0;
                adjoint.copy_from_slice(&solved(&mut transposed, count(&both))?.0);
                let gradient = gradient(stance, &both, &adjoint, &shape, under);
                let predicted = Prediction { value: both.load[0], gradient };
                return predicted.gradient.iter().all(|g| g.is_finite()).then_some(Solved { both, predicted, shape });
            }
        }
        None
    }
}

/// Whether this is what was left: where each of two says the other, one is as good as the other.
fn is_back(next: Option<Rest>, left: Option<Rest>) -> bool {
    next.zip(left).is_some_and(|(next, left)| next.0.is_same(&left.0) && next.1.is_some() == left.1.is_some())
}
