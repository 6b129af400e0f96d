//! The side on a boundary.
//!
//! Without friction the force is normal to the whisker, and beyond the contact the whisker is straight: one family of
//! shapes, brought to size by the arc length `s` of the contact. On a convex corner the place is given, which fixes both
//! (in closed form). On a piece the whisker is tangent: three equations for force, arc length and place. A side that
//! turns past the normals of a corner goes on along the piece there and back; on the polygon of a round boundary it
//! passes from corner to corner. Where the contact comes to the tip, the tip goes on.

use super::system::System;
use super::tip::{END_SLACK, MOST_PIECES, MOST_STEPS};
use super::{Felt, Forward, Hold, Next, Solver, Stance, Touch};
use crate::beam::normal::{Branch, by_point};
use crate::plane::wrap_angle;
use core::f64::consts::FRAC_PI_2;

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

impl Forward<'_> {
    /// The equilibrium with the side on the boundary, from this hold on from one to the next.
    pub(super) fn on_side(&self, stance: &Stance, start: Touch) -> Next {
        // Only of a uniform whisker are all shapes beyond a side contact one family.
        if matches!(self.solver, Solver::Table(_)) {
            return Next::None;
        }
        let mut touch = start;
        let mut left: Option<(u32, Touch, Felt)> = None;
        for _ in 0..MOST_PIECES {
            match touch.hold {
                Hold::Flank(piece, at) => {
                    let Some((found, felt, at)) = self.on_flank(stance, &touch, piece, at) else {
                        return left.map_or(Next::None, |(_, touch, felt)| Next::Touching(touch, felt));
                    };
                    if (-END_SLACK..=1.0 + END_SLACK).contains(&at) {
                        return if found.s > 1.0 + TIP_SLACK {
                            self.along(stance, &Touch { s: 1.0, ..found }, piece, at, true)
                        } else {
                            Next::Touching(found, felt)
                        };
                    }
                    let Some((id, corner)) = self.ground.corner_of(piece, at > 0.5) else { return Next::LetGo };
                    if corner.is_concave() {
                        return Next::None;
                    }
                    // Off a corner and back onto it: the two agree but for rounding.
                    if let Some((_, touch, felt)) = left.filter(|&(before, ..)| before == id) {
                        return Next::Touching(touch, felt);
                    }
                    touch = if corner.is_convex() {
                        Touch { hold: Hold::Vertex(id), ..found }
                    } else {
                        let (next, there) = if at > 0.5 { corner.after } else { corner.before };
                        Touch { hold: Hold::Flank(next, there), ..found }
                    };
                }
                Hold::Vertex(id) => {
                    let Some((found, felt, lean)) = self.on_vertex(stance, &touch, id) else {
                        return left.map_or(Next::None, |(_, touch, felt)| Next::Touching(touch, felt));
                    };
                    let Some(corner) = self.ground.corner(id) else { return Next::None };
                    if (0.0..=1.0).contains(&lean) {
                        return if found.s > 1.0 + TIP_SLACK {
                            self.off_tip(stance, &found, id)
                        } else {
                            Next::Touching(found, felt)
                        };
                    }
                    let (piece, at) = if lean < 0.0 { corner.before } else { corner.after };
                    let weak = found.q.abs() <= WEAK;
                    let next = self.ground.corner_of(piece, at < 0.5).filter(|(_, next)| next.is_convex());
                    let back = next.zip(left).is_some_and(|((next, _), (before, ..))| next == before);
                    // Along a facet to its other corner, which is in closed form; where that one says to come back, and on longer
                    // pieces, between the two.
                    let facet = self.ground.pieces[piece as usize].length < FACET * self.length;
                    if !weak && (back || !facet) {
                        left = Some((id, found, felt));
                        touch = Touch { hold: Hold::Flank(piece, at), ..found };
                        continue;
                    }
                    match (next, left) {
                        (Some(_), Some((_, touch, felt))) if back => return Next::Touching(touch, felt),
                        (Some((next, _)), _) => {
                            left = Some((id, found, felt));
                            touch = Touch { hold: Hold::Vertex(next), ..found };
                        }
                        (None, _) if !weak || found.q > 0.0 => {
                            touch = Touch { hold: Hold::Flank(piece, at), ..found };
                        }
                        (None, _) => return Next::LetGo,
                    }
                }
                Hold::Piece(..) | Hold::Corner(_) | Hold::Both(_) => return Next::None,
            }
        }
        Next::None
    }

    /// The side on a corner, and where its force points within the corner.
    fn on_vertex(&self, stance: &Stance, from: &Touch, id: u32) -> Option<(Touch, Felt, f64)> {
        let corner = self.ground.corner(id)?;
        let target = stance.seen(corner.position - stance.base);
        let bend = [Branch::Least, Branch::Curled]
            .into_iter()
            .filter_map(|branch| by_point(1.0, BEYOND, target, branch))
            .min_by(|a, b| (a.phi_a - from.slope).abs().total_cmp(&(b.phi_a - from.slope).abs()))?;
        let (s, per) = (bend.s_a, 1.0 / bend.s_a);
        let q = bend.force * s * s * from.beta.cos();
        let chart = self.solver.chart(q, from.beta)?;
        let (a, b) = (chart.by_force.position * s, target * per);
        let (value, [m, n]) = self.sense.at_side(&chart, q, s, from.beta);
        let det = a.cross(b);
        let adjoint = [(m * b.y - n * a.y) / det, (n * a.x - m * b.x) / det, 0.0];
        let felt = Felt { value, gradient: stance.gradient(adjoint, target) };
        let touch = Touch {
            q,
            beta: from.beta,
            s,
            hold: Hold::Vertex(id),
            place: corner.position,
            slope: bend.phi_a,
            clear: 0.0,
        };
        let lean = corner.lean(stance.theta + bend.phi_a + from.beta + FRAC_PI_2);
        felt.gradient.iter().all(|g| g.is_finite()).then_some((touch, felt, lean))
    }

    /// The side tangent to a piece or its continuation, and the parameter there.
    fn on_flank(&self, stance: &Stance, from: &Touch, piece: u32, mut at: f64) -> Option<(Touch, Felt, f64)> {
        let ground = &self.ground.pieces[piece as usize];
        let (mut q, mut s, beta) = (from.q, from.s, from.beta);
        for _ in 0..MOST_STEPS {
            let chart = self.solver.chart(q, beta)?;
            let spot = ground.spot(at);
            let target = stance.seen(spot.position - stance.base);
            let velocity = stance.seen(spot.velocity);
            let gap = chart.position * s - target;
            let aslant = wrap_angle(stance.theta + chart.slope + beta + FRAC_PI_2 - spot.normal);
            let by_force = chart.by_force.position * s;
            let system = System::new([
                [by_force.x, chart.position.x, -velocity.x],
                [by_force.y, chart.position.y, -velocity.y],
                [chart.by_force.slope, 0.0, -spot.turning],
            ]);
            let [dq, ds, dat] = system.solve([gap.x, gap.y, aslant])?;
            let damp = (LARGEST_PUSH / dq.abs()).min(LARGEST_SHIFT / ds.abs()).min(1.0);
            let (value, [m, n]) = self.sense.at_side(&chart, q, s, beta);
            (q, s, at) = (q - damp * dq, s - damp * ds, at - damp * dat);
            if ground.is_lost(at) || !(s > 0.0 && s < BEYOND) {
                return None;
            }
            if gap.norm_squared().sqrt().max(aslant.abs()) < self.solver.near() && damp >= 1.0 {
                let adjoint = system.solve_transposed([m, n, 0.0]);
                let felt = Felt { value: value - m * dq - n * ds, gradient: stance.gradient(adjoint, target) };
                let slope = chart.slope - chart.by_force.slope * dq;
                let place = spot.position - spot.velocity * dat;
                let touch = Touch { q, beta, s, hold: Hold::Flank(piece, at), place, slope, clear: 0.0 };
                return felt.gradient.iter().all(|g| g.is_finite()).then_some((touch, felt, at));
            }
        }
        None
    }

    /// A corner has come to the tip: the tip goes on along that side of it which it faces.
    fn off_tip(&self, stance: &Stance, found: &Touch, id: u32) -> Next {
        let Some(corner) = self.ground.corner(id) else { return Next::None };
        let touch = Touch { s: 1.0, ..*found };
        let heading = stance.theta + found.slope;
        let sides = [(corner.before, corner.normal), (corner.after, corner.normal + corner.turn)];
        for ((piece, at), normal) in sides {
            if (heading - normal).cos() < 0.0
                && let Next::Touching(touch, felt) = self.along(stance, &touch, piece, at, true)
            {
                return Next::Touching(touch, felt);
            }
        }
        Next::LetGo
    }
}
