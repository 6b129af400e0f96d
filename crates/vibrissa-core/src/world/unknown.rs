//! Where a map knows nothing: around the stretches of boundaries that nobody has seen or felt.

use crate::plane::{Bounds, SegmentTree, Vec2};

/// Places of which a map says nothing: within the depth of an unknown stretch of boundary.
#[derive(Clone, Debug, Default)]
pub struct UnknownZones {
    tree: SegmentTree,
    depths: Vec<f64>,
    deepest: f64,
}

impl UnknownZones {
    /// The zones around chords, each with its depth (m).
    pub(super) fn new(zones: Vec<([Vec2; 2], f64)>) -> Self {
        let (chords, depths): (Vec<[Vec2; 2]>, Vec<f64>) = zones.into_iter().unzip();
        let deepest = depths.iter().copied().fold(0.0, f64::max);
        let tree = if chords.is_empty() { SegmentTree::default() } else { SegmentTree::new(&chords) };
        Self { tree, depths, deepest }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.depths.is_empty()
    }

    /// Whether a place within `slack` (m) of `point` lies in one of them.
    #[must_use]
    pub fn may_hold(&self, point: Vec2, slack: f64) -> bool {
        self.may_meet([point, point], slack)
    }

    /// Whether a place within `slack` (m) of the segment lies in one of them.
    #[must_use]
    pub fn may_meet(&self, segment: [Vec2; 2], slack: f64) -> bool {
        if self.is_empty() {
            return false;
        }
        let mut found = false;
        self.tree.for_each_in(Bounds::of(&segment).inflated(self.deepest + slack), |index, chord| {
            found = distance(segment, chord) <= self.depths[index] + slack;
            found
        });
        found
    }
}

/// The distance between two segments (m).
fn distance([a, b]: [Vec2; 2], [c, d]: [Vec2; 2]) -> f64 {
    let (along, other) = (b - a, d - c);
    let cross = along.cross(other);
    if cross != 0.0 {
        let (s, t) = ((c - a).cross(other) / cross, (c - a).cross(along) / cross);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            return 0.0;
        }
    }
    to_point(a, c, d).min(to_point(b, c, d)).min(to_point(c, a, b)).min(to_point(d, a, b))
}

/// The distance of a point from the segment between two others (m).
fn to_point(p: Vec2, a: Vec2, b: Vec2) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((p - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a + along * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zone_reaches_as_far_as_its_depth() {
        let zones = UnknownZones::new(vec![([Vec2::ZERO, Vec2::new(0.1, 0.0)], 0.02)]);
        let at = Vec2::new;
        assert!(zones.may_hold(at(0.05, 0.0199), 0.0) && !zones.may_hold(at(0.05, 0.0201), 0.0));
        assert!(zones.may_hold(at(0.125, 0.0), 0.006) && !zones.may_hold(at(0.125, 0.0), 0.004));
        assert!(zones.may_meet([at(0.05, -1.0), at(0.05, 1.0)], 0.0));
        assert!(!zones.may_meet([at(0.0, 0.03), at(0.1, 0.03)], 0.0));
        assert!(!UnknownZones::default().may_hold(at(0.0, 0.0), 1.0));
    }

    #[test]
    fn distances_between_segments_are_those_of_their_nearest_samples() {
        let place = |k: f64| Vec2::new((12.9898 * k).sin(), (78.233 * k).sin());
        for case in 0..200 {
            let [a, b, c, d] = [0.1, 0.2, 0.3, 0.4].map(|k| place(k + 1.7 * f64::from(case)));
            let at = |from: Vec2, to: Vec2, k: i32| from + (to - from) * (f64::from(k) / 100.0);
            let pairs = (0..=100).flat_map(|i| (0..=100).map(move |j| (i, j)));
            let nearest = pairs.map(|(i, j)| at(a, b, i).distance(at(c, d, j))).fold(f64::INFINITY, f64::min);
            let told = distance([a, b], [c, d]);
            assert!(told <= nearest + 1e-12 && told > nearest - 0.03, "{told} {nearest}");
        }
    }
}
