//! The equations of a whisker that is held at two places.

use super::span::{Shape, UNKNOWNS};
use crate::contact::{Spot, Stance, Support, TwoContacts};
use crate::math;
use crate::plane::{Vec2, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI};

/// Unknowns and equations at most: one less where the outer contact is the tip.
pub(super) const MOST: usize = UNKNOWNS + 3;
/// Equations with their right sides in the last column.
pub(super) type Rows = [[f64; MOST + 1]; MOST];

/// How many equations there are.
pub(super) fn count(both: &TwoContacts) -> usize {
    if both.lies_at.is_some() { MOST } else { MOST - 1 }
}

/// The linear equations of a step, residuals in the last column, and the largest residual.
///
/// | rows | equation | unknowns |
/// | --- | --- | --- |
/// | 0, 1 | the inner contact is at its place | load, place of the inner contact |
/// | 2 | no moment at the outer one | load, arc length of the outer contact |
/// | 3, 4 | the outer one is at its place | load, place and arc length of the outer contact |
/// | 5 | the outer force is along the normal of its piece; on a corner, and where a tip does not slide, the place is given | load, place of the outer contact |
/// | 6 | the inner contact is tangent; on a corner the place is given | load, place of the inner contact |
/// | 7 | an outer contact of the side is tangent; on a corner its force is along the whisker's normal | load, place and arc length of the outer contact |
pub(super) fn equations(
    stance: &Stance,
    both: &TwoContacts,
    shape: &Shape,
    (inner, outer): (&Spot, &Spot),
    outer_slides: bool,
) -> (Rows, f64) {
    let mut rows = [[0.0; MOST + 1]; MOST];
    let (at_inner, at_outer) = (stance.seen(inner.position), stance.seen(outer.position));
    let (inner_on, outer_on) = (stance.turned(inner.velocity), stance.turned(outer.velocity));
    let facing = Vec2::from_angle(outer.normal - stance.theta());
    let on_piece = |rest: Support| matches!(rest, Support::Piece(..));
    let end = &shape.outer;
    for (k, (inner, outer)) in shape.inner.by.iter().zip(&end.by).enumerate() {
        (rows[0][k], rows[1][k], rows[2][k]) = (inner[2], inner[3], outer[1]);
        (rows[3][k], rows[4][k]) = (outer[2], outer[3]);
        rows[5][k] = if outer_slides { shape.force_by[k].cross(facing) } else { 0.0 };
        rows[6][k] = if on_piece(both.inner) { inner[0] } else { 0.0 };
    }
    (rows[3][5], rows[4][5]) = (-outer_on.x, -outer_on.y);
    (rows[0][6], rows[1][6]) = (-inner_on.x, -inner_on.y);
    let (off_inner, off_outer) = (shape.inner.position - at_inner, end.position - at_outer);
    let mut residuals = [off_inner.x, off_inner.y, end.curvature, off_outer.x, off_outer.y, 0.0, 0.0, 0.0];
    if outer_slides {
        rows[5][5] = shape.force.dot(facing) * outer.turning;
        residuals[5] = shape.force.cross(facing);
    } else {
        (rows[3][5], rows[4][5], rows[5][5]) = (0.0, 0.0, 1.0);
    }
    if on_piece(both.inner) {
        rows[6][6] = -inner.turning;
        residuals[6] = aslant(stance, shape.inner.slope, inner);
    } else {
        (rows[0][6], rows[1][6], rows[6][6]) = (0.0, 0.0, 1.0);
    }
    if both.lies_at.is_some() {
        let [slope, curvature, x, y] = end.rates(shape.force);
        (rows[2][7], rows[3][7], rows[4][7]) = (curvature, x, y);
        if on_piece(both.outer) {
            (0..UNKNOWNS).for_each(|k| rows[7][k] = end.by[k][0]);
            (rows[7][5], rows[7][7]) = (-outer.turning, slope);
            residuals[7] = aslant(stance, end.slope, outer);
        } else {
            let tangent = Vec2::from_angle(end.slope);
            let across = shape.force.dot(tangent.perp());
            (0..UNKNOWNS).for_each(|k| rows[7][k] = shape.force_by[k].dot(tangent) + across * end.by[k][0]);
            rows[7][7] = across * slope;
            residuals[7] = shape.force.dot(tangent);
        }
    }
    for (row, residual) in rows.iter_mut().zip(residuals) {
        row[MOST] = residual;
    }
    (rows, residuals.iter().map(|r| r.abs()).fold(0.0, f64::max))
}

/// How far (rad) a whisker of this slope is from tangent to what it lies on, to its left or to its right, whichever is nearer.
fn aslant(stance: &Stance, slope: f64, on: &Spot) -> f64 {
    let across = stance.theta() + slope + FRAC_PI_2 - on.normal;
    wrap_angle(if math::cos(across) > 0.0 { across } else { across + PI })
}

/// The derivatives of the moment by the base's pose, from the adjoint of the equations.
pub(super) fn gradient(
    stance: &Stance,
    both: &TwoContacts,
    l: &[f64; MOST],
    shape: &Shape,
    (inner, outer): (&Spot, &Spot),
) -> [f64; 3] {
    let (at_inner, at_outer) = (stance.seen(inner.position), stance.seen(outer.position));
    let tangent = if matches!(both.outer, Support::Piece(..)) { l[7] } else { 0.0 };
    let a = stance.gradient([l[0], l[1], l[6]], at_inner);
    let b = stance.gradient([l[3], l[4], tangent], at_outer);
    let turned = l[5] * shape.force.dot(Vec2::from_angle(outer.normal - stance.theta()));
    [a[0] + b[0], a[1] + b[1], a[2] + b[2] + turned]
}

/// Whether a tip that slides is pushed back to where it is when it is moved along its piece, by the equations there and whether their
/// determinant is positive.
///
/// The ratio of the determinants with and without its sliding is the derivative of the cross product of its force and the normal by its
/// place (Schur complement).
pub(super) fn is_stable(rows: &Rows, positive: bool, stance: &Stance, tip: &Spot) -> bool {
    let mut fixed = *rows;
    fixed[5] = core::array::from_fn(|k| if k == 5 { 1.0 } else { 0.0 });
    let forward = stance.turned(tip.velocity).dot(Vec2::from_angle(tip.normal - stance.theta()).perp()) > 0.0;
    solved(&mut fixed, MOST - 1).is_some_and(|(_, positive_fixed)| (positive == positive_fixed) != forward)
}

/// The solution of the first `count` equations, whose right side is the last column, by elimination, and whether their determinant is
/// positive; none when it is not finite.
pub(super) fn solved(m: &mut Rows, count: usize) -> Option<([f64; MOST], bool)> {
    let mut positive = true;
    for k in 0..count {
        let pivot = (k..count).max_by(|&a, &b| m[a][k].abs().total_cmp(&m[b][k].abs()))?;
        m.swap(k, pivot);
        positive ^= (pivot != k) ^ (m[k][k] < 0.0);
        let per = 1.0 / m[k][k];
        for i in k + 1..count {
            let factor = m[i][k] * per;
            let above = m[k];
            m[i].iter_mut().zip(above).skip(k).for_each(|(value, above)| *value -= factor * above);
        }
    }
    let mut x = [0.0; MOST];
    for k in (0..count).rev() {
        let rest: f64 = (k + 1..count).map(|j| m[k][j] * x[j]).sum();
        x[k] = (m[k][MOST] - rest) / m[k][k];
    }
    x.iter().all(|v| v.is_finite()).then_some((x, positive))
}
