//! The tip on a boundary.
//!
//! The tip stands on a piece of the boundary, the frictionless force is normal there: three equations for force, tilt
//! and place, solved by Newton's method from the contact before. In a concave corner the place is given and the force
//! may have any direction between the two normals. A tip that would point out of the boundary lies down, one that
//! slides past an edge leaves the side on it.

use super::system::System;
use super::{Contact, ForwardModel, Next, Prediction};
use crate::beam::TipChart;
use crate::contact::{Corner, Hold, Stance, Support};
use crate::math;
use crate::plane::{Vec2, wrap_angle};
use core::f64::consts::FRAC_PI_2;

/// Newton steps before an equilibrium is given up.
pub(super) const MOST_STEPS: usize = 12;
/// Largest change of the tilt in one Newton step (rad).
const LARGEST_TURN: f64 = 0.3;
/// Forces nearer than this to the whisker's own direction are not followed (rad): it buckles.
const HEAD_ON: f64 = 0.07;
/// Pieces that one step may pass.
pub(super) const MOST_PIECES: usize = 40;
/// Newton steps that may lead from piece to piece without an equilibrium on those between.
const HOPS: usize = 2;
/// How far beyond its ends a piece still counts (share of the piece).
pub(super) const END_SLACK: f64 = 1e-9;
/// Below this force a corner is solved from the small-angle solution on.
const WEAK: f64 = 0.02;

impl ForwardModel<'_> {
    /// From piece to piece until one holds the tip; what comes `from_side` does not go back there.
    pub(super) fn along(&self, stance: &Stance, start: &Contact, mut piece: u32, mut at: f64, from_side: bool) -> Next {
        let mut came: Option<bool> = None;
        let mut load = (start.q, start.beta);
        for _ in 0..MOST_PIECES {
            let (on, end, found) = match self.on_piece(stance, load, (piece, at), came.is_none()) {
                TipSolution::Found { piece, at, touch, predicted } => (piece, at, Some((touch, predicted))),
                TipSolution::Lost(piece, at) => (piece, at, None),
                TipSolution::Failed => return Next::None,
            };
            piece = on;
            load = found.map_or(load, |(touch, _)| (touch.q, touch.beta));
            if (-END_SLACK..=1.0 + END_SLACK).contains(&end) {
                let Some((touch, predicted)) = found else { return Next::None };
                return self.standing(stance, touch, predicted, (piece, end), from_side);
            }
            let forward = end > 0.5;
            let Some((id, corner)) = self.boundaries.corner_of(piece, forward) else { return Next::LetGo };
            if !from_side
                && corner.is_convex()
                && let Some((touch, _)) = found
                && touch.q > 0.0
                && points_out(stance.heading(touch.slope), self.normal_across(&corner, piece, forward))
            {
                let laid = touch.laid(Support::Corner(id));
                return self.on_side(stance, Contact { place: corner.position, ..laid });
            }
            if corner.is_end() {
                return Next::LetGo;
            }
            if came.is_some_and(|came| came != forward) {
                return Next::None;
            }
            if corner.is_concave()
                && let Some((touch, predicted, lean)) = self.in_corner(stance, start, id)
            {
                match lean {
                    0.0..=1.0 => return Next::Touching(touch, predicted),
                    _ if (lean > 1.0) != forward => return Next::None,
                    _ => {}
                }
            }
            came = Some(forward);
            (piece, at) = if forward { corner.after } else { corner.before };
        }
        Next::None
    }

    /// The normal (rad) across a corner that a tip passes from `piece`, at its end (`forward`) or its start.
    pub(super) fn normal_across(&self, corner: &Corner, piece: u32, forward: bool) -> f64 {
        // The two sides of a wall are travelled in one direction: at its end the side passed to may be the one before.
        match (corner.is_end(), forward) {
            (true, _) => self.boundaries.spot(corner.across(piece, forward)).normal,
            (false, true) => corner.normal + corner.turn,
            (false, false) => corner.normal,
        }
    }

    /// The tip at a place of a piece, or the side there where the tip points out of the boundary.
    fn standing(
        &self,
        stance: &Stance,
        touch: Contact,
        predicted: Prediction,
        place: (u32, f64),
        from_side: bool,
    ) -> Next {
        let normal = self.boundaries.spot(place).normal;
        if from_side || touch.q <= 0.0 || !points_out(stance.heading(touch.slope), normal) {
            return Next::Touching(touch, predicted);
        }
        match self.on_side(stance, touch.laid(place.into())) {
            Next::Touching(touch, predicted) => Next::Touching(touch, predicted),
            _ => Next::Touching(Contact { clear: -1.0, ..touch }, predicted),
        }
    }

    /// In the corner, or out of it along one of its sides.
    pub(super) fn caught(&self, stance: &Stance, touch: &Contact, before: u32) -> Next {
        match self.in_corner(stance, touch, before) {
            Some((.., lean)) if lean < 0.0 => self.along(stance, touch, before, 1.0, false),
            Some((.., lean)) if lean > 1.0 => match self.boundaries.corner(before) {
                Some(corner) => self.along(stance, touch, corner.after.0, 0.0, false),
                None => Next::None,
            },
            Some((touch, predicted, _)) => Next::Touching(touch, predicted),
            None => Next::None,
        }
    }

    /// The equilibrium with the tip on a piece, from this load and place on; where `hopping`, on the piece to which the
    /// first steps lead over slight corners.
    fn on_piece(&self, stance: &Stance, load: (f64, f64), place: (u32, f64), hopping: bool) -> TipSolution {
        let ((mut q, mut beta), (mut piece, mut at)) = (load, place);
        let mut here = self.boundaries.piece(piece);
        for step in 0..MOST_STEPS {
            let Some(tip) = self.mechanics.chart(q, beta) else { return TipSolution::Failed };
            let spot = here.spot(at);
            let target = stance.seen(spot.position);
            let gap = tip.position - target;
            let aslant = wrap_angle(stance.direction(tip.slope, beta) - spot.normal);
            let system = on_piece_system(&tip, stance.turned(spot.velocity), spot.turning);
            let Some([dq, dbeta, dat]) = system.solve([gap.x, gap.y, aslant]) else { return TipSolution::Failed };
            let damp = damping(q, dq, dbeta);
            (q, beta, at) = (q - damp * dq, beta - damp * dbeta, at - damp * dat);
            if hopping && step < HOPS && !(0.0..=1.0).contains(&at) && damp >= 1.0 {
                let (on, there) = self.boundaries.hop(piece, at);
                if on != piece {
                    (piece, at) = (on, there);
                    here = self.boundaries.piece(piece);
                    continue;
                }
            }
            if here.is_lost(at) {
                return TipSolution::Lost(piece, at);
            }
            if !q.is_finite() || is_head_on(beta) {
                return TipSolution::Failed;
            }
            if gap.norm_squared().sqrt().max(aslant.abs()) < self.mechanics.near() && damp >= 1.0 {
                // Weak forces have a negative determinant and are stable; the sign changes where the branch folds.
                if system.determinant * here.side() >= 0.0 {
                    return TipSolution::Failed;
                }
                let (value, [m, n]) = self.quantity.at_tip(&tip, q + dq, beta);
                let adjoint = system.solve_transposed([m, n, 0.0]);
                let tip_now = spot.position - spot.velocity * dat;
                let touch = Contact {
                    hold: Hold::Tip(Support::Piece(piece, at)),
                    place: tip_now,
                    ..settled(&tip, q, beta, dq, dbeta)
                };
                let predicted =
                    Prediction { value: value - m * dq - n * dbeta, gradient: stance.gradient(adjoint, target) };
                return TipSolution::Found { piece, at, touch, predicted };
            }
        }
        TipSolution::Failed
    }

    /// The equilibrium with the tip in the corner at the end of a piece, and where its force points within the corner:
    /// 0 along the normal before, 1 along the normal after.
    fn in_corner(&self, stance: &Stance, from: &Contact, before: u32) -> Option<(Contact, Prediction, f64)> {
        let corner = self.boundaries.corner(before)?;
        let target = stance.seen(corner.position);
        let (mut q, mut beta) = (from.q, from.beta);
        if q.abs() < WEAK {
            // A weak force can point anywhere without moving the tip much: start from the small-angle solution.
            beta = wrap_angle(corner.outward() - stance.theta() - FRAC_PI_2);
            q = 3.0 * target.y / math::cos(beta);
        }
        let placed = self.placed_at(q, beta, target)?;
        let (a, b) = (placed.tip.by_force.position, placed.tip.by_tilt.position);
        let det = a.cross(b);
        let (dq, dbeta) = placed.step;
        let (value, [m, n]) = self.quantity.at_tip(&placed.tip, placed.q + dq, placed.beta);
        let adjoint = [(m * b.y - n * a.y) / det, (n * a.x - m * b.x) / det, 0.0];
        let settled = settled(&placed.tip, placed.q, placed.beta, dq, dbeta);
        let lean = corner.lean(stance.direction(settled.slope, placed.beta));
        let touch = Contact { hold: Hold::Tip(Support::Corner(before)), place: corner.position, ..settled };
        let predicted = Prediction { value: value - m * dq - n * dbeta, gradient: stance.gradient(adjoint, target) };
        Some((touch, predicted, lean))
    }

    /// The same where the corner holds it, both of its sides pressing.
    pub(super) fn caught_in(&self, stance: &Stance, from: &Contact, before: u32) -> Option<(Contact, Prediction)> {
        let (touch, predicted, lean) = self.in_corner(stance, from, before)?;
        (touch.q > 0.0 && (0.0..=1.0).contains(&lean)).then_some((touch, predicted))
    }

    /// The force that has the tip at a place (whisker frame, over the length), from this one on.
    pub(super) fn placed_at(&self, mut q: f64, mut beta: f64, target: Vec2) -> Option<Placed> {
        for _ in 0..MOST_STEPS {
            let tip = self.mechanics.held_chart(q, beta)?;
            let gap = tip.position - target;
            let (a, b) = (tip.by_force.position, tip.by_tilt.position);
            let det = a.cross(b);
            let (dq, dbeta) = (gap.cross(b) / det, a.cross(gap) / det);
            // The place is nearly linear in the components of the force, and far from it in its size and direction.
            let damp = ((0.5 + 0.5 * q.abs()) / math::hypot(dq, q * dbeta)).min(1.0);
            let force = Vec2::new(q - damp * dq, -q * damp * dbeta).rotated(beta);
            let sign = 1.0_f64.copysign(q);
            (q, beta) = (sign * force.norm(), (force * sign).angle());
            if !q.is_finite() {
                return None;
            }
            if gap.norm_squared().sqrt() < self.mechanics.near() && damp >= 1.0 {
                if is_head_on(beta) {
                    return None;
                }
                return Some(Placed { q, beta, tip, step: (dq, dbeta) });
            }
        }
        None
    }
}

/// A whisker whose tip a force has at a place: the force after the last Newton step, the chart before it, and the step.
pub(super) struct Placed {
    pub(super) q: f64,
    pub(super) beta: f64,
    pub(super) tip: TipChart,
    step: (f64, f64),
}

impl Placed {
    /// The slope at the tip (rad, whisker frame).
    pub(super) fn slope(&self) -> f64 {
        settled(&self.tip, self.q, self.beta, self.step.0, self.step.1).slope
    }
}

/// Where Newton's method on a piece ended.
enum TipSolution {
    /// An equilibrium, maybe on the continuation of the piece.
    Found { piece: u32, at: f64, touch: Contact, predicted: Prediction },
    /// The place left the piece before an equilibrium was found.
    Lost(u32, f64),
    /// No stable equilibrium near.
    Failed,
}

/// The equations of a tip on a piece: its place and the direction of its force, by force, tilt and place on the piece.
fn on_piece_system(tip: &TipChart, velocity: Vec2, turning: f64) -> System {
    System::new([
        [tip.by_force.position.x, tip.by_tilt.position.x, -velocity.x],
        [tip.by_force.position.y, tip.by_tilt.position.y, -velocity.y],
        [tip.by_force.slope, 1.0 + tip.by_tilt.slope, -turning],
    ])
}

/// Whether a tip that points there points out of the boundary with this normal (rad, map frame).
pub(super) fn points_out(heading: f64, normal: f64) -> bool {
    math::cos(heading - normal) > 0.0
}

pub(super) fn damping(q: f64, dq: f64, dbeta: f64) -> f64 {
    (LARGEST_TURN / dbeta.abs()).min((0.5 + 0.5 * q.abs()) / dq.abs()).min(1.0)
}

/// Whether the force all but runs along the whisker at its tip.
fn is_head_on(beta: f64) -> bool {
    let off = (wrap_angle(beta).abs() - FRAC_PI_2).abs();
    off.is_nan() || off <= HEAD_ON
}

/// Load and slope after the last Newton step; the caller says what holds the tip.
fn settled(tip: &TipChart, q: f64, beta: f64, dq: f64, dbeta: f64) -> Contact {
    let slope = tip.slope - tip.by_force.slope * dq - tip.by_tilt.slope * dbeta;
    Contact { q, beta, s: 1.0, hold: Hold::Tip(Support::Piece(0, 0.0)), place: Vec2::ZERO, slope, clear: 0.0 }
}
