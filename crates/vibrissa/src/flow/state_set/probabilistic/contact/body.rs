//! Whether the rest of the whisker is clear of the boundaries.
//!
//! The contact holds one place; a bump may rise under another. The whisker's shape is taken from the cubic through its
//! ends, which is good to about a hundredth of the deflection; what it crosses is then solved for. How far it is clear of
//! everything is kept, so that it is not looked at again before it has moved as far.

use super::{Forward, Hold, Stance, Touch};
use crate::plane::Vec2;

/// Where along the whisker (share of the length to the contact) it is compared with the boundaries.
const KNOTS: [f64; 7] = [0.0, 0.2, 0.4, 0.56, 0.7, 0.82, 0.93];
/// How far beyond a contact of the side its straight end is looked at (share of that end).
const BEYOND: f64 = 0.4;
/// Of the distance to the nearest boundary, the share that motion may use up.
const SAFE: f64 = 0.4;
/// Distances are looked for up to this (m).
const FARTHEST: f64 = 0.02;

/// What the whisker runs into besides its contact.
pub(super) enum Body {
    /// Nothing within this (m).
    Clear(f64),
    /// Something before its contact, at this share of its length.
    Before(f64),
    /// Something beyond its contact.
    Beyond,
}

impl Forward<'_> {
    /// What a whisker that stands so runs into.
    pub(super) fn body(&self, stance: &Stance, touch: &Touch) -> Body {
        let end = stance.seen(touch.place - stance.base);
        let (sin, cos) = touch.slope.sin_cos();
        let point = |u: f64| {
            let (a, b, c) = (u * (1.0 - u) * (1.0 - u), u * u * (3.0 - 2.0 * u), -u * u * (1.0 - u));
            let s = touch.s;
            stance.placed(Vec2::new(a * s + b * end.x + c * s * cos, b * end.y + c * s * sin))
        };
        let points = KNOTS.map(point);
        for (k, pair) in points.windows(2).enumerate() {
            if self.map.crosses(pair[0], pair[1]) {
                return Body::Before(0.5 * (KNOTS[k] + KNOTS[k + 1]) * touch.s);
            }
        }
        let free = (1.0 - touch.s) * self.length;
        if matches!(touch.hold, Hold::Vertex(_) | Hold::Flank(..)) && free > 0.0 {
            let along = Vec2::from_angle(stance.theta + touch.slope) * free;
            if self.map.crosses(touch.place + along * BEYOND, touch.place + along) {
                return Body::Beyond;
            }
            return Body::Clear(0.0);
        }
        let near = points[1..].iter().map(|&p| {
            self.map.nearest_within(p, FARTHEST).map_or(FARTHEST, |near| near.distance)
        });
        Body::Clear(SAFE * near.fold(FARTHEST, f64::min))
    }
}
