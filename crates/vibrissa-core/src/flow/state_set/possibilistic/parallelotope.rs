//! One cell of the paving: a parallelotope of states \[kuhn1998rigorously\], contracted by linear strips.

use crate::linear_algebra::determinant;
use crate::plane::{Pose2, Vec2};
use crate::sets::{Interval, StateBox};

/// No side of a cell becomes shorter than this (m, and rad times [`HEADING_ARM`]): rounding stays far below it.
const LEAST: f64 = 1e-7;
/// Weighs headings against places (m).
pub(super) const HEADING_ARM: f64 = 0.1;
/// A cut that would replace a side must make the cell smaller by this factor.
const LEAST_CONTRACTION: f64 = 1.03;
/// How much wider a cut may make the rectangle around the cell.
const WIDER: f64 = 1.3;
/// Half the width of the rectangle from which on a cut must not make it any wider (m, m, rad): cut after cut it would grow
/// until readings tell nothing about it.
const WIDE: [f64; 3] = [0.02, 0.02, 0.05];

/// A linear form over a cell's three sides.
pub(super) type LinearForm = [f64; 3];

/// The states `center + sum of w_j sides[j]` with every `|w_j| <= 1`: the robot at the row `anchor`, map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parallelotope {
    pub(super) center: Pose2,
    /// Half sides (m, m, rad).
    pub(super) sides: [[f64; 3]; 3],
    /// The record at which the robot is meant.
    pub(super) anchor: u32,
    /// The newest record that it has met.
    pub(super) seen: u32,
    /// Readings that it does not explain.
    pub(super) missed: u8,
    /// It is not halved before this record.
    pub(super) rest_until: u32,
    /// Records for which it rests the next time that bisection does not help.
    pub(super) patience: u16,
    /// It has met no reading yet.
    pub(super) is_fresh: bool,
}

impl Parallelotope {
    /// Half the width of the box around the cell (m, m, rad).
    pub(super) fn reach(&self) -> [f64; 3] {
        let s = &self.sides;
        [0, 1, 2].map(|i| s[0][i].abs() + s[1][i].abs() + s[2][i].abs())
    }

    /// The box around the cell.
    pub(super) fn hull(&self) -> StateBox {
        let [x, y, theta] = self.reach();
        let around = |at: f64, by: f64| Interval::new(at - by, at + by);
        StateBox { x: around(self.center.x, x), y: around(self.center.y, y), theta: around(self.center.theta, theta) }
    }

    /// The volume (m² rad).
    pub(super) fn volume(&self) -> f64 {
        8.0 * determinant(&self.sides).abs()
    }

    /// How long a side is (m), headings by their arm.
    pub(super) fn length(&self, side: usize) -> f64 {
        let [x, y, theta] = self.sides[side];
        (x * x + y * y + HEADING_ARM * HEADING_ARM * theta * theta).sqrt()
    }

    /// Keeps the part with each `w_j` in its interval.
    pub(super) fn restrict(&mut self, part: &[(f64, f64); 3]) {
        let mut shift = [0.0; 3];
        for (j, &(lo, hi)) in part.iter().enumerate() {
            let (middle, mut half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
            let length = self.length(j);
            if half * length < LEAST {
                half = LEAST / length;
            }
            for (shift, side) in shift.iter_mut().zip(&mut self.sides[j]) {
                *shift += middle * *side;
                *side *= half;
            }
        }
        self.shift(shift);
    }

    fn shift(&mut self, by: [f64; 3]) {
        let Pose2 { x, y, theta } = self.center;
        self.center = Pose2::new(x + by[0], y + by[1], theta + by[2]);
    }

    /// Keeps a cell that holds the part with `form · w` in `[lo, hi]`: one side is replaced if that pays.
    pub(super) fn contract(&mut self, form: &LinearForm, (lo, hi): (f64, f64)) {
        let total = form.iter().map(|k| k.abs()).sum::<f64>();
        let (lo, hi) = (lo.max(-total), hi.min(total));
        if hi < lo {
            return;
        }
        let (middle, half) = (0.5 * (lo + hi), (0.5 * (hi - lo)).max(LEAST * 0.1));
        let wide = self.reach();
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| form[b].abs().total_cmp(&form[a].abs()));
        for j in order {
            if form[j].abs() < LEAST_CONTRACTION * half {
                return;
            }
            let mut sides = self.sides;
            for i in 0..3 {
                if i != j {
                    let along = form[i] / form[j];
                    (0..3).for_each(|a| sides[i][a] -= along * self.sides[j][a]);
                }
            }
            (0..3).for_each(|a| sides[j][a] *= half / form[j]);
            let cut = Self { sides, ..*self };
            let narrow = cut.reach();
            let fits = |a: usize| narrow[a] <= wide[a].max((WIDER * wide[a]).min(WIDE[a]));
            if (0..3).all(fits) && cut.length(j) >= LEAST {
                let shift = [0, 1, 2].map(|a| self.sides[j][a] * middle / form[j]);
                *self = cut;
                self.shift(shift);
                return;
            }
        }
    }

    /// The two halves along a side.
    pub(super) fn bisected(&self, side: usize) -> [Self; 2] {
        let mut half = *self;
        half.sides[side] = half.sides[side].map(|v| 0.5 * v);
        let step = half.sides[side];
        let (mut a, mut b) = (half, half);
        a.shift(step.map(|v| -v));
        b.shift(step);
        [a, b]
    }

    /// Grows the cell by every move of at most `place` (m) and turn of at most `turn` (rad).
    pub(super) fn inflate(&mut self, place: f64, turn: f64) {
        if place <= 0.0 && turn <= 0.0 {
            return;
        }
        let det = determinant(&self.sides).abs();
        let [a, b, c] = self.sides;
        let mut more = [0.0; 3];
        for (more, (p, q)) in more.iter_mut().zip([(b, c), (c, a), (a, b)]) {
            // The row of the inverse that belongs to this side.
            let normal = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
            *more = (place * (normal[0] * normal[0] + normal[1] * normal[1]).sqrt() + turn * normal[2].abs()) / det;
        }
        let [x, y, theta] = self.reach();
        let wide = [(x + place).max(LEAST), (y + place).max(LEAST), (theta + turn).max(LEAST / HEADING_ARM)];
        let slanted = det * more.iter().map(|m| 1.0 + m).product::<f64>();
        if slanted <= wide.iter().product() && slanted.is_finite() {
            (0..3).for_each(|j| self.sides[j] = self.sides[j].map(|v| v * (1.0 + more[j])));
        } else {
            // Too slanted or too thin for that: the box around it.
            self.sides = [[wide[0], 0.0, 0.0], [0.0, wide[1], 0.0], [0.0, 0.0, wide[2]]];
        }
    }

    /// The same states after the robot moved by `step`, seen from itself; the caller says at which record.
    pub(super) fn transport(&mut self, step: Pose2, anchor: u32) {
        let arm = step.position().rotated(self.center.theta);
        let turn = self.reach()[2];
        let lever = arm.perp();
        for side in &mut self.sides {
            side[0] += lever.x * side[2];
            side[1] += lever.y * side[2];
        }
        self.center = self.center.compose(step);
        self.anchor = anchor;
        self.inflate(0.5 * arm.norm() * turn * turn + 1e-12, 0.0);
    }

    /// The point of the plane in the middle.
    pub(super) fn place(&self) -> Vec2 {
        self.center.position()
    }
}

/// Keeps the part of a box in which a form can lie in an interval, as tight as can be; false when there is none.
#[inline]
pub(super) fn contract_box(part: &mut [(f64, f64); 3], form: &LinearForm, (lo, hi): (f64, f64)) -> bool {
    let (mut least, mut most) = (0.0, 0.0);
    for (&(a, b), &k) in part.iter().zip(form) {
        let (a, b) = (k * a, k * b);
        (least, most) = (least + a.min(b), most + a.max(b));
    }
    if lo > most || hi < least {
        return false;
    }
    // How far the form may rise from its least value, and fall from its largest.
    let (up, down) = (hi - least, most - lo);
    if up >= most - least && down >= most - least {
        return true;
    }
    for (side, &k) in part.iter_mut().zip(form) {
        let (a, b) = *side;
        let range = k.abs() * (b - a);
        if up < range {
            if k > 0.0 { side.1 = a + up / k } else { side.0 = b + up / k }
        }
        if down < range {
            if k > 0.0 { side.0 = b - down / k } else { side.1 = a - down / k }
        }
        if side.0 > side.1 {
            // By rounding only: the interval is not empty.
            *side = (side.1, side.0);
        }
    }
    true
}
