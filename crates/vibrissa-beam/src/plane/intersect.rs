//! Where two straight segments meet.

use super::{Bounds, Vec2};

/// Twice the signed area of the triangle `a b p`: positive when `p` lies left of the line from `a` to `b`.
pub(super) fn orientation(a: Vec2, b: Vec2, p: Vec2) -> f64 {
    (b - a).cross(p - a)
}

/// A common point of the closed segments `ab` and `cd`, or none.
///
/// | case | answer |
/// | --- | --- |
/// | crossing inside both | the crossing point |
/// | an end on the other segment | that end |
/// | overlapping on one line | an end inside the overlap |
/// | apart | none |
///
/// An end common to both is reported only when they meet nowhere else. Decided in f64: a gap or an overlap below
/// about 1e-16 of the coordinates' size may be judged either way.
#[must_use]
pub fn segment_contact(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> Option<Vec2> {
    if !Bounds::of(&[a, b]).overlaps(Bounds::of(&[c, d])) {
        return None;
    }
    let (of_a, of_b) = (orientation(c, d, a), orientation(c, d, b));
    let (of_c, of_d) = (orientation(a, b, c), orientation(a, b, d));
    if opposite(of_a, of_b) && opposite(of_c, of_d) {
        return Some(a + (b - a) * (of_a / (of_a - of_b)));
    }
    let touching = [
        (a, of_a, Bounds::of(&[c, d]), a == c || a == d),
        (b, of_b, Bounds::of(&[c, d]), b == c || b == d),
        (c, of_c, Bounds::of(&[a, b]), c == a || c == b),
        (d, of_d, Bounds::of(&[a, b]), d == a || d == b),
    ];
    let touch = |shared: bool| {
        let on_line = |turn: f64| turn.abs() <= 0.0;
        touching
            .iter()
            .find(|(point, turn, bounds, is_shared)| *is_shared == shared && on_line(*turn) && bounds.contains(*point))
            .map(|(point, ..)| *point)
    };
    touch(false).or_else(|| touch(true))
}

fn opposite(a: f64, b: f64) -> bool {
    (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0)
}
