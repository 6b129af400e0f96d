//! Splines as cubics.

use crate::config::budgets::MOST_PIECES;
use crate::plane::{Segment, Vec2};
use crate::{Error, Result};

/// Highest degree that is read; drawing programs write 2, 3 and 5.
const HIGHEST_DEGREE: usize = 11;
/// How often a span is halved at most: a millionth of it is no longer drawn.
const MOST_HALVINGS: usize = 12;

/// A B-spline, rational where its weights differ.
#[derive(Debug)]
pub(super) struct Spline {
    degree: usize,
    knots: Vec<f64>,
    /// Control points times their weights, and the weights.
    points: Vec<(Vec2, f64)>,
}

impl Spline {
    /// The spline, if its parts fit together.
    pub(super) fn new(degree: f64, knots: Vec<f64>, points: &[Vec2], weights: &[f64]) -> Result<Self> {
        let whole = degree >= 1.0 && degree <= HIGHEST_DEGREE as f64 && degree.fract().abs() < f64::EPSILON;
        if !whole {
            return Err(Error::data("the spline's degree").value(degree).allowed(format!("1 to {HIGHEST_DEGREE}")));
        }
        let degree = degree as usize;
        if points.is_empty() {
            return Err(Error::data("the spline has no control points").remedy("export it with them, or as a polyline"));
        }
        if points.len() <= degree || knots.len() != points.len() + degree + 1 {
            let told = format!("{} knots for {} control points of degree {degree}", knots.len(), points.len());
            return Err(Error::data("the spline's knots do not fit its control points").value(told));
        }
        if knots.windows(2).any(|pair| pair[0] > pair[1]) {
            return Err(Error::data("the spline's knots decrease"));
        }
        if !(weights.is_empty() || weights.len() == points.len()) || weights.iter().any(|&weight| weight <= 0.0) {
            let due = "one above 0 for each control point";
            return Err(Error::data("the spline's weights do not fit").value(weights.len()).allowed(due));
        }
        let weight = |i: usize| weights.get(i).copied().unwrap_or(1.0);
        let points = points.iter().enumerate().map(|(i, &point)| (point * weight(i), weight(i))).collect();
        Ok(Self { degree, knots, points })
    }

    /// Cubics within `tolerance` (in the points' unit) of the spline; exact up to degree three without weights.
    pub(super) fn cubics(&self, tolerance: f64) -> Vec<Segment> {
        let mut cubics = Vec::new();
        for span in self.degree..self.points.len() {
            // More than a map may have is refused when the pieces are counted.
            if cubics.len() > MOST_PIECES {
                break;
            }
            let (from, to) = (self.knots[span], self.knots[span + 1]);
            if to > from {
                self.add(span, [from, to], tolerance, MOST_HALVINGS, &mut cubics);
            }
        }
        cubics
    }

    fn add(&self, span: usize, [from, to]: [f64; 2], tolerance: f64, halvings: usize, out: &mut Vec<Segment>) {
        let ((a, da), (b, db)) = (self.at(span, from), self.at(span, to));
        let third = (to - from) / 3.0;
        // The next piece starts where the one before ended, to the bit.
        let a = out.last().map_or(a, |last: &Segment| if last.end().distance(a) <= tolerance { last.end() } else { a });
        let cubic = Segment::Cubic([a, a + third * da, b - third * db, b]);
        let misses = |share: f64| cubic.point(share).distance(self.at(span, from + share * (to - from)).0) > tolerance;
        let middle = 0.5 * (from + to);
        if halvings > 0 && middle > from && middle < to && [0.25, 0.5, 0.75].into_iter().any(misses) {
            self.add(span, [from, middle], tolerance, halvings - 1, out);
            self.add(span, [middle, to], tolerance, halvings - 1, out);
        } else {
            out.push(cubic);
        }
    }

    /// The point and the derivative at `u` in a span, by de Boor's scheme.
    fn at(&self, span: usize, u: f64) -> (Vec2, Vec2) {
        let p = self.degree;
        let mut d = self.points[span - p..=span].to_vec();
        let mut rise = (Vec2::ZERO, 0.0);
        for stage in 1..=p {
            let last = stage == p;
            for j in (stage..=p).rev() {
                let (lo, hi) = (self.knots[span - p + j], self.knots[span + 1 + j - stage]);
                let share = if hi > lo { (u - lo) / (hi - lo) } else { 0.0 };
                let ((q0, w0), (q1, w1)) = (d[j - 1], d[j]);
                if last {
                    let scale = p as f64 / (hi - lo);
                    rise = ((q1 - q0) * scale, (w1 - w0) * scale);
                }
                d[j] = (q0 * (1.0 - share) + q1 * share, w0 * (1.0 - share) + w1 * share);
            }
        }
        let (q, w) = d[p];
        let point = q * (1.0 / w);
        (point, (rise.0 - point * rise.1) * (1.0 / w))
    }
}
