//! The equations of a whisker that is held at tip and side.

use super::span::{Shape, UNKNOWNS};
use crate::contact::{Spot, Stance, Support, TwoContacts};
use crate::math;
use crate::plane::{Vec2, wrap_angle};
use core::f64::consts::{FRAC_PI_2, PI};

/// Unknowns and equations at most.
pub(super) const MOST: usize = UNKNOWNS + 2;
/// Equations with their right sides in the last column.
pub(super) type Rows = [[f64; MOST + 1]; MOST];

/// The linear equations of a step, residuals in the last column, and the largest residual.
///
/// | rows | equation | unknowns |
/// | --- | --- | --- |
/// | 0, 1 | the side is at its place | load, place of the side |
/// | 2 | no moment at the tip | load |
/// | 3, 4 | the tip is at its place | load, place of the tip |
/// | 5 | the tip's force is along the normal; where it does not slide the place is given | load, place of the tip |
/// | 6 | the side is tangent; on a corner the place is given | load, place of the side |
pub(super) fn equations(
    stance: &Stance,
    both: &TwoContacts,
    shape: &Shape,
    (side, tip): (&Spot, &Spot),
    tip_slides: bool,
) -> (Rows, f64) {
    let mut rows = [[0.0; MOST + 1]; MOST];
    let (at_side, at_tip) = (stance.seen(side.position), stance.seen(tip.position));
    let (side_on, tip_on) = (stance.turned(side.velocity), stance.turned(tip.velocity));
    let facing = Vec2::from_angle(tip.normal - stance.theta());
    let on_piece = |rest: Support| matches!(rest, Support::Piece(..));
    for (k, (side, tip)) in shape.side.by.iter().zip(&shape.tip.by).enumerate() {
        (rows[0][k], rows[1][k], rows[2][k]) = (side[2], side[3], tip[1]);
        (rows[3][k], rows[4][k]) = (tip[2], tip[3]);
        rows[5][k] = if tip_slides { shape.force_by[k].cross(facing) } else { 0.0 };
        rows[6][k] = if on_piece(both.side) { side[0] } else { 0.0 };
    }
    (rows[3][5], rows[4][5]) = (-tip_on.x, -tip_on.y);
    (rows[0][6], rows[1][6]) = (-side_on.x, -side_on.y);
    let (off_side, off_tip) = (shape.side.position - at_side, shape.tip.position - at_tip);
    let mut residuals = [off_side.x, off_side.y, shape.tip.curvature, off_tip.x, off_tip.y, 0.0, 0.0];
    if tip_slides {
        rows[5][5] = shape.force.dot(facing) * tip.turning;
        residuals[5] = shape.force.cross(facing);
    } else {
        (rows[3][5], rows[4][5], rows[5][5]) = (0.0, 0.0, 1.0);
    }
    if on_piece(both.side) {
        let across = stance.theta() + shape.side.slope + FRAC_PI_2 - side.normal;
        rows[6][6] = -side.turning;
        // To the whisker's left or to its right, whichever is nearer.
        residuals[6] = wrap_angle(if math::cos(across) > 0.0 { across } else { across + PI });
    } else {
        (rows[0][6], rows[1][6], rows[6][6]) = (0.0, 0.0, 1.0);
    }
    for (row, residual) in rows.iter_mut().zip(residuals) {
        row[MOST] = residual;
    }
    (rows, residuals.iter().map(|r| r.abs()).fold(0.0, f64::max))
}

/// The derivatives of the moment by the base's pose, from the adjoint of the equations.
pub(super) fn gradient(stance: &Stance, l: &[f64; MOST], shape: &Shape, side: &Spot, tip: &Spot) -> [f64; 3] {
    let (at_side, at_tip) = (stance.seen(side.position), stance.seen(tip.position));
    let a = stance.gradient([l[0], l[1], l[6]], at_side);
    let b = stance.gradient([l[3], l[4], 0.0], at_tip);
    let turned = l[5] * shape.force.dot(Vec2::from_angle(tip.normal - stance.theta()));
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
    solved(&mut fixed).is_some_and(|(_, positive_fixed)| (positive == positive_fixed) != forward)
}

/// The solution of the equations whose right side is the last column, by elimination, and whether their determinant is positive; none
/// when it is not finite.
pub(super) fn solved(m: &mut Rows) -> Option<([f64; MOST], bool)> {
    let mut positive = true;
    for k in 0..MOST {
        let pivot = (k..MOST).max_by(|&a, &b| m[a][k].abs().total_cmp(&m[b][k].abs()))?;
        m.swap(k, pivot);
        positive ^= (pivot != k) ^ (m[k][k] < 0.0);
        let per = 1.0 / m[k][k];
        for i in k + 1..MOST {
            let factor = m[i][k] * per;
            let above = m[k];
            m[i].iter_mut().zip(above).skip(k).for_each(|(value, above)| *value -= factor * above);
        }
    }
    let mut x = [0.0; MOST];
    for k in (0..MOST).rev() {
        let rest: f64 = (k + 1..MOST).map(|j| m[k][j] * x[j]).sum();
        x[k] = (m[k][MOST] - rest) / m[k][k];
    }
    x.iter().all(|v| v.is_finite()).then_some((x, positive))
}
