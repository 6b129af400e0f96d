//! Tip and side on boundaries at once: a bump that rises under a whisker whose tip is in a bay.
//!
//! The unknowns are the load of [`super::span`], the place of the tip on its piece (in a concave corner it is given)
//! and that of the side on a curved piece (on a corner it is given). Newton's method solves for both places, the
//! direction of the tip's force and the free end. Where one of the two forces would have to pull, that contact ends.

use super::balance::{MOST, equations, gradient, is_stable, solved};
use super::both_snap::BothSlid;
use super::span::{self, Shape, UNKNOWNS};
use super::{Contact, ForwardModel, Mechanics, Next, Prediction};
use crate::contact::{Hold, Push, Spot, Stance, Support, TwoContacts};
use crate::math;
use crate::plane::{Vec2, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI};

/// Newton steps before an equilibrium is given up, and where one more ends the search (lengths, rad, curvature).
const MOST_STEPS: usize = 12;
const NEAR: f64 = 4e-3;
const NEAR_EXACT: f64 = 1e-5;
/// Largest change of the moment, of a force, and of the arc length, in one step: along an all but straight whisker
/// forces are large.
const LARGEST_MOMENT: f64 = 1.0;
const LARGEST_PUSH: f64 = 20.0;
const LARGEST_SHIFT: f64 = 0.08;
/// A side contact this near to the tip may become one of the tip (arc length over the length).
const ALMOST_TIP: f64 = 0.9;
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

impl ForwardModel<'_> {
    /// A whisker with its tip on a boundary and this share of its length near another place: both hold it.
    pub(super) fn propped(&self, stance: &Stance, touch: &Contact, share: f64, (piece, at): (u32, f64)) -> Next {
        let Some(both) = self.beside_tip(touch, share, (piece, at)) else { return Next::None };
        let first = self.on_both(stance, both);
        if matches!(&first, Next::Touching(touch, _) if matches!(touch.hold, Hold::Both(_))) {
            return first;
        }
        // A whisker that bends the other way touches corners alone.
        let convex = |forward: bool| self.boundaries.corner_of(piece, forward).filter(|(_, corner)| corner.is_convex());
        match convex(at > 0.5).or_else(|| convex(at <= 0.5)) {
            Some((id, _)) => match self.on_both(stance, TwoContacts { side: Support::Corner(id), ..both }) {
                Next::Touching(touch, predicted) => Next::Touching(touch, predicted),
                _ => first,
            },
            None => first,
        }
    }

    /// The two contacts of a whisker with its tip on a boundary, and this share of its length near another place.
    pub(super) fn beside_tip(&self, touch: &Contact, share: f64, (piece, at): (u32, f64)) -> Option<TwoContacts> {
        let chart = self.mechanics.held_chart(touch.q, touch.beta)?;
        let tip = match touch.hold {
            Hold::Tip(on) => on,
            // What has only just lain down counts as its tip.
            Hold::Side(Support::Piece(piece, at), _) if touch.s > ALMOST_TIP => Support::Piece(piece, at),
            Hold::Side(Support::Corner(id), _) if touch.s > ALMOST_TIP => self.boundaries.corner(id)?.before.into(),
            _ => return None,
        };
        let per = 1.0 / touch.s;
        let force = Vec2::from_angle(touch.slope + touch.beta + FRAC_PI_2) * (touch.q * per * per);
        let load = [chart.moment * per, force.x, force.y, share, 0.0];
        let side = Support::Piece(piece, at.clamp(0.0, 1.0));
        Some(TwoContacts { load, tip, side })
    }

    /// A whisker with its side on a boundary whose tip has come to another place: both hold it.
    pub(super) fn stopped(&self, stance: &Stance, touch: &Contact, (piece, at): (u32, f64)) -> Next {
        let Hold::Side(side, _) = touch.hold else { return Next::None };
        let per = 1.0 / touch.s;
        let Some(chart) = self.mechanics.chart(touch.q, touch.beta) else { return Next::None };
        let push = touch.q * per * per * math::cos(touch.beta);
        let force = Vec2::from_angle(touch.slope + FRAC_PI_2) * push;
        let load = [chart.moment * per, force.x, force.y, touch.s, push];
        let both = TwoContacts { load, tip: Support::Piece(piece, at.clamp(0.0, 1.0)), side };
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
        let shape = span::shape(both.load, !matches!(self.mechanics, Mechanics::ClosedForm));
        let tip_first = shape.force.norm() > both.load[4].abs();
        match self.one(stance, both, &shape, tip_first) {
            Next::Touching(touch, predicted) => Next::Touching(touch, predicted),
            _ => self.one(stance, both, &shape, !tip_first),
        }
    }

    /// The equilibrium with both, from these contacts on.
    pub(super) fn on_both(&self, stance: &Stance, mut both: TwoContacts) -> Next {
        let (mut side_left, mut tip_left) = (None, None);
        let mut last: Option<Solved> = None;
        for _ in 0..MOST_MOVES {
            let solved = self.solve(stance, &both, matches!(both.tip, Support::Piece(..)));
            // Where it cannot go on it stays.
            let stuck = solved.is_none();
            let Some(Solved { both: found, predicted, shape }) = solved.or(last.take()) else { return Next::None };
            let across = stance.theta() + shape.side.slope + FRAC_PI_2;
            let (side, held) = match self.side_next(&found, across) {
                Some(next) => next,
                None => return Next::None,
            };
            match side.filter(|&next| !stuck && !is_back(Some(next), side_left)) {
                Some(next) => {
                    side_left = Some(found.side);
                    both = TwoContacts { side: next, ..found };
                    last = Some(Solved { both: found, predicted, shape });
                    continue;
                }
                None if !held => return self.one(stance, &found, &shape, true),
                None => {}
            }
            let Some((tip, held)) = self.tip_next(&found, stance.theta() + shape.force.angle()) else {
                return Next::None;
            };
            if tip.is_some()
                && (stuck
                    || is_back(tip, tip_left) && self.beyond(&found, stance.theta() + shape.force.angle()) > SLACK)
            {
                return Next::None;
            }
            match tip.filter(|&next| !is_back(Some(next), tip_left)) {
                Some(next) => {
                    tip_left = Some(found.tip);
                    both = TwoContacts { tip: next, ..found };
                    last = Some(Solved { both: found, predicted, shape });
                }
                None if !held => return self.one(stance, &found, &shape, false),
                None => {
                    let touch = Contact {
                        q: shape.force.norm(),
                        beta: 0.0,
                        s: 1.0,
                        hold: Hold::Both(found),
                        place: stance.placed(shape.tip.position),
                        slope: shape.tip.slope,
                        clear: 0.0,
                    };
                    return Next::Touching(touch, predicted);
                }
            }
        }
        Next::None
    }

    /// What the side rests on next, if not on this, and whether the boundary pushes it; `across` is the direction to
    /// the whisker's left there (rad, map frame). None where the side leaves the whisker or the boundary.
    pub(super) fn side_next(&self, both: &TwoContacts, across: f64) -> Option<(Option<Support>, bool)> {
        let [.., s, push] = both.load;
        if !(0.02..0.9995).contains(&s) {
            return None;
        }
        let to = |place: (u32, f64)| Some(Support::from(place));
        match both.side {
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

    /// The same for the tip, whose force points in this direction (rad, map frame).
    fn tip_next(&self, both: &TwoContacts, direction: f64) -> Option<(Option<Support>, bool)> {
        let to = |place: (u32, f64)| Some(Support::from(place));
        match both.tip {
            Support::Piece(piece, at) => {
                let held = math::cos(direction - self.boundaries.spot((piece, at)).normal) > 0.0;
                if (0.0..=1.0).contains(&at) {
                    return Some((None, held));
                }
                let (id, corner) = self.boundaries.corner_of(piece, at > 0.5)?;
                if corner.is_end() {
                    return None;
                }
                // Slight corners are those of polygons of round boundaries: they do not catch the tip for long.
                let caught = corner.is_concave() && corner.turn.abs() > SLIGHT;
                let over = to(if at > 0.5 { corner.after } else { corner.before });
                Some((if caught { Some(Support::Corner(id)) } else { over }, held))
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

    /// How far a tip whose force points in this direction (rad, map frame) is beyond what it rests on: whisker lengths past the end of a
    /// piece, rad past the normals of a corner.
    fn beyond(&self, both: &TwoContacts, direction: f64) -> f64 {
        match both.tip {
            Support::Piece(piece, at) => (at - 1.0).max(-at) * self.boundaries.piece(piece).length() / self.length,
            Support::Corner(id) => self.boundaries.corner(id).map_or(0.0, |corner| {
                let lean = corner.lean(direction);
                (lean - 1.0).max(-lean) * corner.turn.abs()
            }),
        }
    }

    /// The concave corner in which a place of a piece all but is.
    pub(super) fn corner_at(&self, piece: u32, at: f64) -> Option<u32> {
        let end = (1.0 - at).min(at) * self.boundaries.piece(piece).length() / self.length;
        let corner = self.boundaries.corner_of(piece, at > 0.5);
        corner.filter(|(_, corner)| end <= SLACK && corner.is_concave()).map(|(id, _)| id)
    }

    /// One of the contacts has ended; the other goes on.
    fn one(&self, stance: &Stance, both: &TwoContacts, shape: &Shape, tip_stays: bool) -> Next {
        let [_, x, y, s, push] = both.load;
        if tip_stays {
            let force = Vec2::new(x, y);
            let q = force.norm();
            let beta = wrap_angle(force.angle() - shape.tip.slope - FRAC_PI_2);
            let place = stance.placed(shape.tip.position);
            let touch = Contact {
                q,
                beta,
                s: 1.0,
                hold: Hold::Tip(Support::Piece(0, 0.0)),
                place,
                slope: shape.tip.slope,
                clear: 0.0,
            };
            return match both.tip {
                Support::Piece(piece, at) => {
                    let at = at.clamp(0.0, 1.0);
                    match self.corner_at(piece, at).and_then(|id| self.caught_in(stance, &touch, id)) {
                        Some((touch, predicted)) => Next::Touching(touch, predicted),
                        None => self.along(stance, &touch, piece, at, false),
                    }
                }
                Support::Corner(id) => self.caught(stance, &touch, id),
            };
        }
        let beta = if push > 0.0 { 0.0 } else { PI };
        let hold = Hold::Side(both.side, Push::of(beta));
        let place = stance.placed(shape.side.position);
        self.on_side(
            stance,
            Contact { q: push.abs() * s * s, beta, s, hold, place, slope: shape.side.slope, clear: 0.0 },
        )
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

    /// Newton's method on these contacts, wherever it leads along their pieces; a tip that does not slide stays at its place.
    pub(super) fn solve(&self, stance: &Stance, from: &TwoContacts, tip_slides: bool) -> Option<Solved> {
        let mut both = *from;
        let near = self.mechanics.pick(NEAR, NEAR_EXACT);
        for _ in 0..MOST_STEPS {
            let shape = span::shape(both.load, !matches!(self.mechanics, Mechanics::ClosedForm));
            let (under_side, under_tip) = (self.under(both.side)?, self.under(both.tip)?);
            let (rows, residual) = equations(stance, &both, &shape, (&under_side, &under_tip), tip_slides);
            let (mut steps, mut adjoint) = (rows, [0.0; MOST]);
            let (d, positive) = solved(&mut steps)?;
            let damp = (LARGEST_SHIFT / d[3].abs())
                .min(LARGEST_MOMENT / d[0].abs())
                .min(LARGEST_PUSH / d[1].abs().max(d[2].abs()).max(d[4].abs()))
                .min(1.0);
            (0..UNKNOWNS).for_each(|k| both.load[k] -= damp * d[k]);
            for (rest, step) in [(&mut both.tip, d[5]), (&mut both.side, d[6])] {
                if let Support::Piece(piece, at) = rest {
                    *at -= damp * step;
                    if self.boundaries.piece(*piece).is_lost(*at) {
                        return None;
                    }
                }
            }
            if !(both.load[3] > 0.01 && both.load[3] < 1.0 && both.load[4].is_finite()) {
                return None;
            }
            if residual < near && damp >= 1.0 {
                if tip_slides && !is_stable(&rows, positive, stance, &under_tip) {
                    return None;
                }
                let mut transposed = [[0.0; MOST + 1]; MOST];
                (0..MOST).for_each(|i| (0..MOST).for_each(|j| transposed[i][j] = rows[j][i]));
                transposed[0][MOST] = 1.0;
                adjoint.copy_from_slice(&solved(&mut transposed)?.0);
                let predicted = Prediction {
                    value: both.load[0],
                    gradient: gradient(stance, &adjoint, &shape, &under_side, &under_tip),
                };
                return predicted.gradient.iter().all(|g| g.is_finite()).then_some(Solved { both, predicted, shape });
            }
        }
        None
    }
}

/// Whether this is what was left: where each of two says the other, one is as good as the other.
fn is_back(next: Option<Support>, left: Option<Support>) -> bool {
    next.zip(left).is_some_and(|(next, left)| next.is_same(&left))
}
