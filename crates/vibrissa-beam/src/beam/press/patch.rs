//! A small range of loads of a rod: its contacts as a linear model of the wall's direction and the moment, with a bound on
//! what that leaves.

use super::{ROUNDING, SAFETY};
use crate::math;
use crate::plane::Vec2;
use alloc::vec::Vec;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// What variants of the rod and of the load may exceed those at the ends of their ranges by.
const VARIANT_SAFETY: f64 = 1.2;

/// A patch tells its contacts by their place alone where its model reaches so many times farther.
const FARTHER: f64 = 1.5;

/// One contact: the wall's direction (rad), the moment, the contact; dimensionless.
#[derive(Clone, Copy, Debug)]
pub(super) struct RodSample {
    pub(super) direction: f64,
    pub(super) moment: f64,
    pub(super) contact: Vec2,
}

/// What other rods, or other forces, change over a range: direction, moment and contact of each sample.
pub(super) type Variant = Vec<[f64; 4]>;

/// The middle and the ends of a range of both coordinates: `first + 3 second`, each of 0, 1, 2.
pub(super) type Samples = [RodSample; 9];
pub(super) const CORNERS: [usize; 4] = [0, 2, 6, 8];
/// The middle and the middles of the edges as means of corners, and how far that leaves the samples: across the first
/// coordinate, the second or both.
const PROBES: [(usize, [f64; 4]); 5] = [
    (4, [0.25; 4]),
    (1, [0.5, 0.5, 0.0, 0.0]),
    (7, [0.0, 0.0, 0.5, 0.5]),
    (3, [0.5, 0.0, 0.5, 0.0]),
    (5, [0.0, 0.5, 0.0, 0.5]),
];

/// Contacts `center + by_direction (psi - direction) + by_moment (mu - moment)`, up to `radius`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// Direction and moment lie in the convex hull of these points, up to `off`.
    hull: [[f64; 2]; 4],
    off: [f64; 2],
    direction: f64,
    moment: f64,
    center: Vec2,
    by_direction: Vec2,
    by_moment: Vec2,
    radius: f64,
    /// All contacts are within this of a place.
    place: Vec2,
    extent: f64,
    /// Least and largest moment.
    pub(super) moments: (f64, f64),
    /// Whether the whisker can be there only if its contact is held.
    pub(super) inflected: bool,
}

/// The part of a patch within ranges of direction and moment: `center + by_direction (psi - middle) + share by_moment` with
/// `|share| <= 1`, up to `radius`.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchPart {
    /// The middle and half of the range of directions (rad).
    pub(super) middle: f64,
    pub(super) half: f64,
    pub(super) center: Vec2,
    pub(super) by_direction: Vec2,
    pub(super) by_moment: Vec2,
    pub(super) radius: f64,
    pub(super) inflected: bool,
}

impl PatchPart {
    /// One part that holds two, if its radius is not above `limit`.
    pub(super) fn joined(&self, other: &Self, limit: f64) -> Option<Self> {
        if self.inflected != other.inflected || self.radius.max(other.radius) > limit {
            return None;
        }
        let least = (self.middle - self.half).min(other.middle - other.half);
        let most = (self.middle + self.half).max(other.middle + other.half);
        let (middle, half) = (0.5 * (least + most), 0.5 * (most - least));
        // The wider range tells the slope better.
        let whole = self.half + other.half;
        let share = if whole > 0.0 { self.half / whole } else { 0.5 };
        let by_direction = self.by_direction * share + other.by_direction * (1.0 - share);
        let turned = |part: &Self| (part.by_direction - by_direction).norm_squared().sqrt() * part.half;
        let rest = (turned(self) + self.radius).max(turned(other) + other.radius);
        if rest > limit {
            return None;
        }
        let center = |part: &Self| part.center + by_direction * (middle - part.middle);
        let (mine, others) = (center(self), center(other));
        let ends = [mine - self.by_moment, mine + self.by_moment, others - other.by_moment, others + other.by_moment];
        // Along the two ends that are farthest apart.
        let (mut axis, mut square) = (Vec2::new(1.0, 0.0), 0.0);
        for (k, a) in ends.iter().enumerate() {
            for b in &ends[k + 1..] {
                let apart = *b - *a;
                if apart.norm_squared() > square {
                    (axis, square) = (apart, apart.norm_squared());
                }
            }
        }
        if square > 0.0 {
            axis = axis * (1.0 / square.sqrt());
        }
        let range = |d: Vec2| {
            let of = ends.map(|end| end.dot(d));
            (of.into_iter().fold(f64::INFINITY, f64::min), of.into_iter().fold(f64::NEG_INFINITY, f64::max))
        };
        let ((from, to), (right, left)) = (range(axis), range(axis.perp()));
        let radius = 0.5 * (left - right) + rest;
        (radius <= limit).then(|| Self {
            middle,
            half,
            center: axis * (0.5 * (from + to)) + axis.perp() * (0.5 * (left + right)),
            by_direction,
            by_moment: axis * (0.5 * (to - from)),
            radius,
            inflected: self.inflected,
        })
    }

    /// The same with a slope by the direction of `most` at most: the rest of it moves along the moment, or anywhere.
    pub(super) fn flattened(mut self, most: f64) -> Self {
        let size = self.by_direction.norm();
        if size > most {
            let over = self.by_direction * ((1.0 - most / size) * self.half);
            self.by_direction = self.by_direction * (most / size);
            let thick = self.by_moment.norm();
            let axis =
                if thick > 0.0 { self.by_moment * (1.0 / thick) } else { over * (1.0 / over.norm().max(1e-300)) };
            self.by_moment = axis * (thick + over.dot(axis).abs());
            self.radius += over.cross(axis).abs();
        }
        self
    }
}

/// The deviations of a patch's samples from what their corners tell.
pub(super) struct Fit {
    pub(super) patch: Patch,
    /// How wide the patch leaves what it tells of the rod itself: the radius, and what direction and moment are off.
    pub(super) width: f64,
    /// How much of that is due to each coordinate.
    pub(super) bends: [f64; 2],
    /// And to both together.
    pub(super) twist: f64,
}

impl Fit {
    /// The model of some samples; `variants` are how other rods or other forces differ from them, each of which may hold by
    /// itself or with the others.
    pub(super) fn new(samples: &Samples, variants: &[Variant], inflected: bool) -> Self {
        let corners = CORNERS.map(|at| samples[at]);
        let mean = |of: &dyn Fn(&RodSample) -> f64| corners.iter().map(of).sum::<f64>() * 0.25;
        let (direction, moment) = (mean(&|s| s.direction), mean(&|s| s.moment));
        let place = Vec2::new(mean(&|s| s.contact.x), mean(&|s| s.contact.y));
        // How far each probe is from the mean of its corners.
        let sums = PROBES.map(|(at, weights)| {
            let (mut d, mut m, mut p) = (samples[at].direction, samples[at].moment, samples[at].contact);
            for (corner, weight) in corners.iter().zip(weights) {
                d -= weight * corner.direction;
                m -= weight * corner.moment;
                p = p - corner.contact * weight;
            }
            (d, m, p)
        });
        let most = |of: &dyn Fn(&(f64, f64, Vec2)) -> f64| sums.iter().map(of).fold(0.0, f64::max);
        let mut off = [SAFETY * most(&|s| s.0.abs()) + ROUNDING, SAFETY * most(&|s| s.1.abs()) + ROUNDING];
        let [by_direction, by_moment] = slopes(&corners, (direction, moment, place), off);
        let left = |d: f64, m: f64, p: Vec2| p - by_direction * d - by_moment * m;
        let rest = |s: &RodSample| left(s.direction - direction, s.moment - moment, s.contact - place);
        let rests = corners.map(|corner| rest(&corner));
        let (mut least, mut largest) = (rests[0], rests[0]);
        for at in rests {
            least = Vec2::new(least.x.min(at.x), least.y.min(at.y));
            largest = Vec2::new(largest.x.max(at.x), largest.y.max(at.y));
        }
        let twist = 0.5 * (largest - least).norm();
        let mut radius = twist + SAFETY * most(&|&(d, m, p)| left(d, m, p).norm()) + ROUNDING;
        let far = corners.iter().map(|corner| corner.contact.distance(place)).fold(0.0, f64::max);
        let mut extent = far + SAFETY * most(&|s| s.2.norm()) + ROUNDING;
        let (across, along) = (by_direction.norm(), by_moment.norm());
        let width = radius + across * off[0] + along * off[1];
        for variant in variants {
            let (mut far, mut apart, mut moved) = (0.0_f64, [0.0_f64; 2], 0.0_f64);
            for &[d, m, x, y] in variant {
                far = far.max(left(d, m, Vec2::new(x, y)).norm());
                moved = moved.max(math::hypot(x, y));
                apart = [apart[0].max(d.abs()), apart[1].max(m.abs())];
            }
            radius += VARIANT_SAFETY * far;
            extent += VARIANT_SAFETY * moved;
            off = [off[0] + VARIANT_SAFETY * apart[0], off[1] + VARIANT_SAFETY * apart[1]];
        }
        // No whisker is longer than it is.
        let (around, extent) = if extent > 1.0 { (Vec2::ZERO, 1.0 + ROUNDING) } else { (place, extent) };
        let bend = |probes: [usize; 2]| {
            let of = |k: usize| {
                let (d, m, p) = sums[k];
                left(d, m, p).norm() + across * d.abs() + along * m.abs()
            };
            probes.map(of).into_iter().fold(0.0, f64::max)
        };
        let least_moment = corners.iter().map(|corner| corner.moment).fold(f64::INFINITY, f64::min);
        let most_moment = corners.iter().map(|corner| corner.moment).fold(f64::NEG_INFINITY, f64::max);
        let patch = Patch {
            moments: (least_moment - off[1], most_moment + off[1]),
            hull: corners.map(|corner| [corner.direction, corner.moment]),
            off,
            direction,
            moment,
            center: place + (least + largest) * 0.5,
            by_direction,
            by_moment,
            radius,
            place: around,
            extent,
            inflected,
        };
        let bends = [bend([3, 4]), bend([1, 2])];
        Self { patch, width, bends, twist }
    }
}

/// The slopes by direction and moment that leave little of the corners; where these do not tell them apart, small ones.
fn slopes(corners: &[RodSample; 4], (direction, moment, place): (f64, f64, Vec2), off: [f64; 2]) -> [Vec2; 2] {
    let (mut a, mut b, mut c) = (off[0] * off[0], 0.0, off[1] * off[1]);
    let (mut p, mut q) = (Vec2::ZERO, Vec2::ZERO);
    for corner in corners {
        let (d, m, r) = (corner.direction - direction, corner.moment - moment, corner.contact - place);
        a += d * d;
        b += d * m;
        c += m * m;
        p += r * d;
        q += r * m;
    }
    let determinant = a * c - b * b;
    if determinant <= 1e-14 * a * c {
        return [Vec2::ZERO; 2];
    }
    let per = 1.0 / determinant;
    [(p * c - q * b) * per, (q * a - p * b) * per]
}

impl Patch {
    /// What is known of contacts of which nothing is known but that they are on the whisker.
    pub(super) fn anywhere(inflected: bool) -> Self {
        Self {
            hull: [[0.0; 2]; 4],
            off: [f64::INFINITY; 2],
            moments: (f64::NEG_INFINITY, f64::INFINITY),
            direction: 0.0,
            moment: 0.0,
            center: Vec2::ZERO,
            by_direction: Vec2::ZERO,
            by_moment: Vec2::ZERO,
            radius: 1.0 + ROUNDING,
            place: Vec2::ZERO,
            extent: 1.0 + ROUNDING,
            inflected,
        }
    }

    /// The directions of its contacts with a moment in a range; none if there are none.
    pub(super) fn directions(&self, (lo, hi): (f64, f64)) -> Option<(f64, f64)> {
        if !self.off[0].is_finite() {
            return Some((0.0, core::f64::consts::TAU));
        }
        let (least, most) = self.cut(1, (lo - self.off[1], hi + self.off[1]))?;
        Some((least - self.off[0], most + self.off[0]))
    }

    /// The range of one coordinate over the part of the hull in which the other (direction 0, moment 1) is in a range.
    fn cut(&self, other: usize, (lo, hi): (f64, f64)) -> Option<(f64, f64)> {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut take = |value: f64| (least, most) = (least.min(value), most.max(value));
        for (k, a) in self.hull.iter().enumerate() {
            if lo <= a[other] && a[other] <= hi {
                take(a[1 - other]);
            }
            for b in &self.hull[k + 1..] {
                for level in [lo, hi] {
                    let (before, after) = (level - a[other], b[other] - level);
                    if before * after > 0.0 {
                        take(a[1 - other] + (b[1 - other] - a[1 - other]) * (before / (before + after)));
                    }
                }
            }
        }
        (least <= most).then_some((least, most))
    }

    /// Its contacts with directions in a bucket (middle and half) and moments in a range, which have directions from `first` to
    /// `last`; `turned` is what the bucket is turned by against the patch (rad).
    pub(super) fn part(
        &self,
        (middle, half): (f64, f64),
        turned: f64,
        range: (f64, f64),
        (first, last): (f64, f64),
    ) -> Option<PatchPart> {
        let (none, inflected) = (Vec2::ZERO, self.inflected);
        if !self.off[0].is_finite() {
            let Self { center, radius, .. } = *self;
            return Some(PatchPart { middle, half, center, by_direction: none, by_moment: none, radius, inflected });
        }
        let (from, to) = (first.max(middle - turned - half), last.min(middle - turned + half));
        let (least, most) = if from <= first && to >= last {
            self.moments
        } else {
            let (least, most) = self.cut(0, (from - self.off[0], to + self.off[0]))?;
            (least - self.off[1], most + self.off[1])
        };
        let (lo, hi) = (range.0.max(least), range.1.min(most));
        let (at, half) = (0.5 * (from + to), 0.5 * (to - from));
        if lo > hi || from > to {
            return None;
        }
        // Where direction and moment hardly tell the contact, the place tells more.
        let told = self.by_direction.norm() * half + self.by_moment.norm() * 0.5 * (hi - lo) + self.radius;
        if told > FARTHER * self.extent {
            let (center, radius) = (self.place, self.extent);
            let half = half + ROUNDING;
            let middle = at + turned;
            return Some(PatchPart { middle, half, center, by_direction: none, by_moment: none, radius, inflected });
        }
        Some(PatchPart {
            middle: at + turned,
            half: half + ROUNDING,
            center: self.center
                + self.by_direction * (at - self.direction)
                + self.by_moment * (0.5 * (lo + hi) - self.moment),
            by_direction: self.by_direction,
            by_moment: self.by_moment * (0.5 * (hi - lo)),
            radius: self.radius,
            inflected,
        })
    }
}
