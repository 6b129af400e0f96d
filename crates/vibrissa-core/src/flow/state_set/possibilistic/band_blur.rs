//! A boundary's band as what it adds to the thick pieces, and unknown stretches as discs \[chabert2009contractor\].
//!
//! A wall that is displaced within its bound stays within as much of its chord, its normals within the slope that the bound leaves open
//! of the chord's, and it may curve towards free space where it is drawn straight. What touches an unknown stretch touches one of
//! the discs around it, with the force in any direction.

use super::thick_piece::{ThickEdge, ThickVertex};
use crate::math;
use crate::plane::Vec2;
use crate::world::{Boundary, PieceCourse};
use core::f64::consts::PI;

/// From this slope on (rad) the direction in which a wall is drawn tells nothing.
const SHAPELESS: f64 = 0.8;

/// What a band adds to a piece: how far the wall may be from where it is drawn (m), how it may turn (rad) and curve (1/m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Blur {
    pub(super) bound: f64,
    slope: f64,
    bend: f64,
}

impl Blur {
    /// That of one piece of a boundary; none where it is exact or unknown.
    pub(super) fn of(boundary: &Boundary, segment: usize) -> Self {
        let widest = boundary.piece_course(segment).and_then(PieceCourse::widest);
        let (Some(course), Some(band)) = (boundary.course(), widest) else { return Self::default() };
        let (slope, bend) = course.slope_and_bend(band.bound);
        Self { bound: band.bound, slope, bend }
    }

    pub(super) fn largest(self, other: Self) -> Self {
        Self { bound: self.bound.max(other.bound), slope: self.slope.max(other.slope), bend: self.bend.max(other.bend) }
    }

    /// Whether the wall may run in any direction.
    pub(super) fn is_shapeless(self) -> bool {
        self.slope > SHAPELESS
    }

    pub(super) fn edge(self, edge: ThickEdge) -> ThickEdge {
        ThickEdge {
            sagitta: edge.sagitta + self.bound,
            slack: edge.slack + self.slope,
            concavity: edge.concavity + self.bend,
            ..edge
        }
    }

    /// A vertex at which the boundary turns by so much (rad): a convex one stays convex unless it is all but a cusp.
    pub(super) fn vertex(self, vertex: ThickVertex, turn: f64) -> ThickVertex {
        let may_flip = self.slope > 0.0 && math::sin(self.slope) >= math::cos(0.5 * turn.abs().min(PI));
        ThickVertex {
            spread: vertex.spread + self.bound,
            slack: vertex.slack + self.slope,
            concavity: if may_flip { f64::INFINITY } else { vertex.concavity + self.bend },
            ..vertex
        }
    }
}

/// Discs around all places within `depth` (m) of a segment.
pub(super) fn discs([from, to]: [Vec2; 2], depth: f64) -> impl Iterator<Item = ThickVertex> {
    let along = to - from;
    let count = if depth > 0.0 { (along.norm() / depth).ceil().clamp(1.0, MOST_DISCS) } else { MOST_DISCS };
    let spread = depth + 0.5 * along.norm() / count + ROUNDING;
    (0..count as usize).map(move |k| ThickVertex {
        point: from + along * ((k as f64 + 0.5) / count),
        spread,
        normal: 0.0,
        slack: PI,
        concavity: f64::INFINITY,
    })
}

/// Most discs along one segment: beyond that they are larger.
const MOST_DISCS: f64 = 64.0;
/// What rounding may add (m).
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discs_hold_every_place_within_the_depth() {
        let ends = [Vec2::new(0.1, 0.2), Vec2::new(0.25, 0.15)];
        let all: Vec<ThickVertex> = discs(ends, 0.02).collect();
        for k in 0..=50 {
            for turn in 0..12 {
                let place = ends[0] + (ends[1] - ends[0]) * (f64::from(k) / 50.0);
                let place = place + Vec2::from_angle(f64::from(turn) * 0.5236) * 0.02;
                assert!(all.iter().any(|disc| disc.point.distance(place) <= disc.spread));
            }
        }
    }
}
