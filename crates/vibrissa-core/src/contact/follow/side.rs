//! The side on a boundary.
//!
//! Without friction the force is normal to the whisker, and beyond the contact the whisker is straight: one family of
//! shapes, brought to size by the arc length `s` of the contact. On a convex corner the place is given, which fixes
//! both (in closed form). On a piece the whisker is tangent: three equations for force, arc length and place. A side
//! that turns past the normals of a corner goes on along the piece there and back; on the polygon of a round boundary
//! it passes from corner to corner. Where the contact comes to the tip, the tip goes on.

use super::system::System;
use super::tip::{END_SLACK, MOST_PIECES, MOST_STEPS};
use super::{Contact, ForwardModel, Mechanics, Next, Prediction};
use crate::beam::normal::{Branch, by_point};
use crate::contact::{Hold, Push, Stance, Support};
use crate::math;
use crate::plane::wrap_angle;

/// Below this force a side passes straight from corner to corner: where on a flat piece it lies is not defined.
const WEAK: f64 = 0.02;
/// Pieces shorter than this (whisker lengths) are facets of something round.
const FACET: f64 = 0.05;
/// Contacts up to so far beyond the tip are looked at, over the length.
const BEYOND: f64 = 2.0;
/// Arc length beyond the tip that is still the tip.
const TIP_SLACK: f64 = 1e-9;
/// Largest change of the force and of the arc length in one Newton step.
const LARGEST_PUSH: f64 = 0.5;
const LARGEST_SHIFT: f64 = 0.1;

/// The corner that a side has left, and the contact on it.
type Left = (u32, Contact, Prediction);

/// One hold of the side tried.
enum SideStep {
    Ends(Next),
    To(Contact),
}

impl ForwardModel<'_> {
    /// The equilibrium with the side on the boundary, from this hold on from one to the next.
    pub(super) fn on_side(&self, stance: &Stance, start: Contact) -> Next {
        // Only of a uniform whisker are all shapes beyond a side contact one family.
        if matches!(self.mechanics, Mechanics::Model(_)) {
            return Next::None;
        }
        let mut touch = start;
        let mut left: Option<Left> = None;
        for _ in 0..MOST_PIECES {
            let step = match touch.hold {
                Hold::Side(Support::Piece(piece, at), push) => self.flank(stance, &touch, (piece, at), push, left),
                Hold::Side(Support::Corner(id), push) => self.vertex(stance, &touch, id, push, &mut left),
                Hold::Tip(_) | Hold::Both(_) => return Next::None,
            };
            match step {
                SideStep::Ends(next) => return next,
                SideStep::To(next) => touch = next,
            }
        }
        Next::None
    }

    /// The side on a piece, or where it goes from there.
    fn flank(
        &self,
        stance: &Stance,
        touch: &Contact,
        (piece, start): (u32, f64),
        push: Push,
        left: Option<Left>,
    ) -> SideStep {
        let Some((found, predicted, at)) = self.on_flank(stance, touch, piece, start) else {
            return self.stayed(stance, left);
        };
        if (-END_SLACK..=1.0 + END_SLACK).contains(&at) {
            return SideStep::Ends(if found.s > 1.0 + TIP_SLACK {
                self.along(stance, &Contact { s: 1.0, ..found }, piece, at, true)
            } else {
                Next::Touching(found, predicted)
            });
        }
        let Some((id, corner)) = self.boundaries.corner_of(piece, at > 0.5) else { return SideStep::Ends(Next::LetGo) };
        if corner.is_concave() {
            return SideStep::Ends(Next::None);
        }
        // Off a corner and back onto it: the two agree but for rounding.
        if left.is_some_and(|(before, ..)| before == id) {
            return self.stayed(stance, left);
        }
        let on = if corner.is_convex() {
            Support::Corner(id)
        } else if at > 0.5 {
            corner.after.into()
        } else {
            corner.before.into()
        };
        SideStep::To(Contact { hold: Hold::Side(on, push), ..found })
    }

    /// The side on a corner, or where it goes from there.
    fn vertex(&self, stance: &Stance, touch: &Contact, id: u32, push: Push, left: &mut Option<Left>) -> SideStep {
        let Some((found, predicted, lean)) = self.on_vertex(stance, touch, id) else {
            return self.stayed(stance, *left);
        };
        let Some(corner) = self.boundaries.corner(id) else { return SideStep::Ends(Next::None) };
        if (0.0..=1.0).contains(&lean) {
            return SideStep::Ends(if found.s > 1.0 + TIP_SLACK {
                self.off_tip(stance, &found, id)
            } else {
                Next::Touching(found, predicted)
            });
        }
        let to = |on: Support| SideStep::To(Contact { hold: Hold::Side(on, push), ..found });
        let (piece, at) = if lean < 0.0 { corner.before } else { corner.after };
        let weak = found.q.abs() <= WEAK;
        let next = self.boundaries.corner_of(piece, at < 0.5).filter(|(_, next)| next.is_convex());
        let back = next.zip(*left).is_some_and(|((next, _), (before, ..))| next == before);
        // Along a facet to its other corner, which is in closed form; where that one says to come back, and on longer
        // pieces, between the two.
        let facet = self.boundaries.piece(piece).length() < FACET * self.length;
        if !weak && (back || !facet) {
            *left = Some((id, found, predicted));
            return to(Support::Piece(piece, at));
        }
        match next {
            Some(_) if back => self.stayed(stance, *left),
            Some((next, _)) => {
                *left = Some((id, found, predicted));
                to(Support::Corner(next))
            }
            None if !weak || found.q > 0.0 => to(Support::Piece(piece, at)),
            None => SideStep::Ends(Next::LetGo),
        }
    }

    /// The side on a corner, and where its force points within the corner.
    fn on_vertex(&self, stance: &Stance, from: &Contact, id: u32) -> Option<(Contact, Prediction, f64)> {
        let corner = self.boundaries.corner(id)?;
        let target = stance.seen(corner.position);
        let bend = [Branch::Least, Branch::Curled]
            .into_iter()
            .filter_map(|branch| by_point(1.0, BEYOND, target, branch))
            .min_by(|a, b| (a.phi_a - from.slope).abs().total_cmp(&(b.phi_a - from.slope).abs()))?;
        let (s, per) = (bend.s_a, 1.0 / bend.s_a);
        let q = bend.force * s * s * math::cos(from.beta);
        let chart = self.mechanics.chart(q, from.beta)?;
        let (a, b) = (chart.by_force.position * s, target * per);
        let (value, [m, n]) = self.quantity.at_side(&chart, q, s, from.beta);
        let det = a.cross(b);
        let adjoint = [(m * b.y - n * a.y) / det, (n * a.x - m * b.x) / det, 0.0];
        let predicted = Prediction { value, gradient: stance.gradient(adjoint, target) };
        let touch = Contact {
            q,
            beta: from.beta,
            s,
            hold: Hold::Side(Support::Corner(id), Push::of(from.beta)),
            place: corner.position,
            slope: bend.phi_a,
            clear: 0.0,
        };
        let lean = corner.lean(stance.direction(bend.phi_a, from.beta));
        predicted.gradient.iter().all(|g| g.is_finite()).then_some((touch, predicted, lean))
    }

    /// The side tangent to a piece or its continuation, and the parameter there.
    fn on_flank(&self, stance: &Stance, from: &Contact, piece: u32, mut at: f64) -> Option<(Contact, Prediction, f64)> {
        let here = self.boundaries.piece(piece);
        let (mut q, mut s, beta) = (from.q, from.s, from.beta);
        for _ in 0..MOST_STEPS {
            let chart = self.mechanics.chart(q, beta)?;
            let spot = here.spot(at);
            let target = stance.seen(spot.position);
            let velocity = stance.turned(spot.velocity);
            let gap = chart.position * s - target;
            let aslant = wrap_angle(stance.direction(chart.slope, beta) - spot.normal);
            let by_force = chart.by_force.position * s;
            let system = System::new([
                [by_force.x, chart.position.x, -velocity.x],
                [by_force.y, chart.position.y, -velocity.y],
                [chart.by_force.slope, 0.0, -spot.turning],
            ]);
            let [dq, ds, dat] = system.solve([gap.x, gap.y, aslant])?;
            let damp = (LARGEST_PUSH / dq.abs()).min(LARGEST_SHIFT / ds.abs()).min(1.0);
            let (value, [m, n]) = self.quantity.at_side(&chart, q, s, beta);
            (q, s, at) = (q - damp * dq, s - damp * ds, at - damp * dat);
            if here.is_lost(at) || !(s > 0.0 && s < BEYOND) {
                return None;
            }
            if gap.norm_squared().sqrt().max(aslant.abs()) < self.mechanics.near() && damp >= 1.0 {
                let adjoint = system.solve_transposed([m, n, 0.0]);
                let predicted =
                    Prediction { value: value - m * dq - n * ds, gradient: stance.gradient(adjoint, target) };
                let slope = chart.slope - chart.by_force.slope * dq;
                let place = spot.position - spot.velocity * dat;
                let touch = Contact {
                    q,
                    beta,
                    s,
                    hold: Hold::Side(Support::Piece(piece, at), Push::of(beta)),
                    place,
                    slope,
                    clear: 0.0,
                };
                return predicted.gradient.iter().all(|g| g.is_finite()).then_some((touch, predicted, at));
            }
        }
        None
    }

    /// The contact on the corner that was left, where nothing else is found.
    fn stayed(&self, stance: &Stance, left: Option<Left>) -> SideStep {
        SideStep::Ends(match left {
            Some((id, touch, _)) if touch.s > 1.0 + TIP_SLACK => self.off_tip(stance, &touch, id),
            Some((_, touch, predicted)) => Next::Touching(touch, predicted),
            None => Next::None,
        })
    }

    /// A corner has come to the tip: the tip goes on along that side of it which it faces.
    fn off_tip(&self, stance: &Stance, found: &Contact, id: u32) -> Next {
        let Some(corner) = self.boundaries.corner(id) else { return Next::None };
        let touch = Contact { s: 1.0, ..*found };
        let heading = stance.heading(found.slope);
        let sides = [(corner.before, corner.normal), (corner.after, corner.normal + corner.turn)];
        for ((piece, at), normal) in sides {
            if math::cos(heading - normal) < 0.0
                && let Next::Touching(touch, predicted) = self.along(stance, &touch, piece, at, true)
            {
                return Next::Touching(touch, predicted);
            }
        }
        Next::LetGo
    }
}
