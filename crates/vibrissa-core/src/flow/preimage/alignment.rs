//! The boundary's slope where the whisker touches, from a short history of whisker shapes.
//!
//! Each shape of the history puts the tip somewhere in the odometry frame; a parabola through these places has the
//! slope of the boundary \[routray, section "Constructing a Preimage from Sensor Observation"\]. Where a shape lies
//! depends on the direction of the contact force, which is normal to the boundary, whose slope is sought. So every
//! slope is tried: it is admissible if the parabola that it leads to agrees with it, give or take what the readings'
//! errors leave open. While the contact hardly moves, that is everything.

use crate::flow::contact_set::{TipContact, TipContactSet};
use crate::flow::quadratic::Quadratic;
use crate::math;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::sets::Interval;
use core::f64::consts::{FRAC_PI_2, PI};

/// How many force directions are tried.
const SCAN: usize = 96;
/// Rounds in which the boundary's curvature within the history is refined.
const CURVATURE_ROUNDS: usize = 3;
/// Bisections of a root: from 3 degrees to a millionth.
const BISECTIONS: usize = 20;
/// A boundary cannot bend more sharply than this within a history (1/m).
const SHARPEST: f64 = 200.0;
/// A change of slope between neighbouring trials beyond which a change of sign is a pole, not a root (rad).
const POLE: f64 = 0.6;
/// A stretch of more scanned directions than this is taken as it is; a narrower one is measured at its root.
const NARROW: usize = 4;
/// Disagreement up to which a slope is admissible, in standard deviations.
const ADMISSIBLE: f64 = 3.0;

/// The tip contacts that one shape's moment allows, and where the base was, seen from the centre's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HistoryShape<'a> {
    pub(crate) center_from_whisker: Pose2,
    pub(crate) contacts: &'a TipContactSet,
}

/// One range of ways in which the whisker can lie against the boundary: whisker frame of the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Direction of the boundary at the contact, free space on its left (rad), where the history agrees best; the
    /// paper's `phi_E`.
    pub boundary_slope: f64,
    /// The admissible slopes, as offsets from that (rad): from at most 0 to at least 0.
    pub offsets: Interval,
    /// The tip contact at the best slope.
    pub contact: TipContact,
    /// Standard deviation of the boundary's slope (rad).
    pub std: f64,
}

impl Alignment {
    /// Angle from the boundary to the whisker at the contact (rad): `phi_a - phi_E`.
    ///
    /// The paper's `gamma = pi - (phi_a + phi_E)` counts its slopes clockwise and the boundary the other way round.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        wrap_angle(self.contact.slope - self.boundary_slope)
    }

    fn new(center: &TipContactSet, slope: f64, lo: f64, hi: f64) -> Option<Self> {
        let contact = center.at_direction(slope + FRAC_PI_2)?;
        let offsets = Interval::new(lo.min(slope) - slope, hi.max(slope) - slope);
        let std = offsets.hi().max(-offsets.lo()) / ADMISSIBLE;
        Some(Self { boundary_slope: wrap_angle(slope), offsets, contact, std })
    }
}

/// The shapes of a history on one branch: as the readings are, and with the readings off by a standard deviation in
/// the ways that matter.
pub(crate) struct BranchHistory<'a> {
    pub(crate) center: &'a TipContactSet,
    pub(crate) shapes: Vec<HistoryShape<'a>>,
    pub(crate) disturbed: [Vec<HistoryShape<'a>>; 2],
    /// Standard deviation of each place across the boundary, for a force in this direction (m).
    pub(crate) place_std: &'a dyn Fn(&TipContact) -> f64,
}

/// What the history says about one direction of the force.
#[derive(Clone, Copy)]
struct Trial {
    /// Slope of the parabola at the centre against the assumed wall (rad): zero if they agree.
    fault: f64,
    /// Its standard deviation.
    std: f64,
}

impl BranchHistory<'_> {
    /// All admissible slopes of the boundary, as separate ranges.
    pub(crate) fn alignments(&self) -> Vec<Alignment> {
        if self.center.is_point() { self.of_points().into_iter().collect() } else { self.of_scan() }
    }

    /// Where shapes do not depend on the boundary: the paper's load normal to the whisker.
    fn of_points(&self) -> Option<Alignment> {
        let slope = self.slope_of_points(&self.shapes)?;
        let off = |shapes: &[HistoryShape]| self.slope_of_points(shapes).map(|s| wrap_angle(s - slope));
        let [a, b] = &self.disturbed;
        let half = ADMISSIBLE * math::hypot(off(a)?, off(b)?);
        Alignment::new(self.center, slope, slope - half, slope + half)
    }

    fn slope_of_points(&self, shapes: &[HistoryShape]) -> Option<f64> {
        let middle = self.center.contacts().first()?;
        let places: Vec<Vec2> = shapes.iter().filter_map(|s| s.place(0.0, middle.direction)).collect();
        let (first, last) = (places.first()?, places.last()?);
        let chord = (*last - *first).angle();
        let seen = places.iter().map(|p| (*p - middle.position).rotated(-chord)).map(|v| (v.x, v.y));
        let slope = chord + math::atan(Quadratic::fit(seen)?.b);
        // Of the two directions along the wall, the one with free space on its left: the wall pushes towards there.
        let pushed = math::cos(middle.direction - (slope + FRAC_PI_2)) >= 0.0;
        Some(wrap_angle(if pushed { slope } else { slope + PI }))
    }

    /// The directions at the centre that every shape of the history can have (rad, centre frame).
    fn directions(&self) -> Interval {
        let middle_of = |range: Interval| 0.5 * (range.lo() + range.hi());
        let all = self.center.directions();
        self.shapes.iter().fold(all, |range, shape| {
            let own = shape.contacts.directions();
            let turned = middle_of(own) + shape.center_from_whisker.theta;
            let shift = middle_of(all) + wrap_angle(turned - middle_of(all)) - middle_of(own);
            range.intersection(Interval::new(own.lo() + shift, own.hi() + shift))
        })
    }

    fn of_scan(&self) -> Vec<Alignment> {
        let range = self.directions();
        if range.is_empty() {
            return Vec::new();
        }
        let cell = range.width() / SCAN as f64;
        let at = |k: usize| range.lo() + cell * (k as f64 + 0.5);
        let trials: Vec<Option<Trial>> = (0..SCAN).map(|k| self.trial(at(k))).collect();
        let fault = |k: usize| trials[k].map(|t| t.fault);
        let crosses = |k: usize| match (fault(k), fault(k + 1)) {
            (Some(a), Some(b)) => (a < 0.0) != (b < 0.0) && (a - b).abs() < POLE,
            _ => false,
        };
        let agrees = |k: usize| trials[k].is_some_and(|t| t.fault.abs() <= ADMISSIBLE * t.std);
        let mut found = Vec::new();
        let mut k = 0;
        while k < SCAN {
            let start = k;
            // A stretch of directions that agree, or that a root lies between.
            while k + 1 < SCAN && ((agrees(k) && agrees(k + 1)) || crosses(k)) {
                k += 1;
            }
            if k > start || agrees(start) {
                let (best, lo, hi) = if k > start + NARROW {
                    (0.5 * (at(start) + at(k)), at(start), at(k))
                } else {
                    let root = (start..k).find(|&j| crosses(j));
                    let best = root.map_or(at(start), |j| self.root(at(j), at(j + 1), fault(j) < Some(0.0)));
                    self.narrow(best, at(start), at(k), cell)
                };
                found.extend(Alignment::new(self.center, best - FRAC_PI_2, lo - FRAC_PI_2, hi - FRAC_PI_2));
            }
            k += 1;
        }
        found
    }

    /// The best direction of a narrow stretch and its ends, which a scan is too coarse to tell.
    fn narrow(&self, best: f64, lo: f64, hi: f64, cell: f64) -> (f64, f64, f64) {
        let step = 0.5 * cell;
        let (Some(at), Some(after)) = (self.trial(best), self.trial(best + step)) else { return (best, lo, hi) };
        let steepness = ((after.fault - at.fault) / step).abs();
        let half = if steepness > 0.0 { (ADMISSIBLE * at.std / steepness).min(hi - lo + cell) } else { hi - lo };
        (best, best - half, best + half)
    }

    /// The direction between `lo` and `hi` at which the fault changes its sign.
    fn root(&self, mut lo: f64, mut hi: f64, negative_at_lo: bool) -> f64 {
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (lo + hi);
            match self.fault(&self.shapes, middle) {
                Some(fault) if (fault < 0.0) == negative_at_lo => lo = middle,
                _ => hi = middle,
            }
        }
        0.5 * (lo + hi)
    }

    /// What the history says about a direction; none where the centre has no contact with such a force.
    fn trial(&self, direction: f64) -> Option<Trial> {
        let contact = self.center.at_direction(direction)?;
        // Where the shapes show no wall at all, nothing can be said against the direction.
        let Some(wall) = self.wall(&self.shapes, direction) else { return Some(Trial { fault: 0.0, std: PI }) };
        let fault = math::atan(wall.b);
        let own = (self.place_std)(&contact) * wall.variance_b.sqrt();
        let off = |shapes: &[HistoryShape]| self.fault(shapes, direction).map_or(PI, |f| f - fault);
        let [a, b] = &self.disturbed;
        Some(Trial { fault, std: math::hypot(math::hypot(off(a), off(b)), own) })
    }

    /// Slope at the centre of the wall that the shapes show if the force at the centre acts in `direction` (rad,
    /// centre frame), seen from the wall that this direction means.
    fn fault(&self, shapes: &[HistoryShape], direction: f64) -> Option<f64> {
        self.wall(shapes, direction).map(|wall| math::atan(wall.b))
    }

    /// That wall as a parabola over the wall that the direction means.
    fn wall(&self, shapes: &[HistoryShape], direction: f64) -> Option<Quadratic> {
        let origin = self.center.at_direction(direction)?.position;
        let tangent = Vec2::from_angle(direction - FRAC_PI_2);
        let mut along = [0.0; MOST_SHAPES];
        let mut seen = [(0.0, 0.0); MOST_SHAPES];
        let mut curvature = 0.0;
        let mut wall = None;
        for _ in 0..CURVATURE_ROUNDS {
            for (k, shape) in shapes.iter().enumerate().take(MOST_SHAPES) {
                let place = shape.place(direction, direction + curvature * along[k])?;
                let off = place - origin;
                along[k] = tangent.dot(off);
                seen[k] = (along[k], tangent.cross(off));
            }
            let fit = Quadratic::fit(seen[..shapes.len().min(MOST_SHAPES)].iter().copied())?;
            wall = Some(fit);
            let steep = 1.0 + fit.b * fit.b;
            curvature = (2.0 * fit.c / (steep * steep.sqrt())).clamp(-SHARPEST, SHARPEST);
        }
        wall
    }
}

/// The most shapes in a history.
const MOST_SHAPES: usize = 5;

impl HistoryShape<'_> {
    /// Where the tip is in the centre frame if the force acts in `direction` (rad, centre frame); directions that the
    /// branch does not reach are brought to its end, but only near it.
    fn place(&self, center_direction: f64, direction: f64) -> Option<Vec2> {
        let turn = self.center_from_whisker.theta;
        let contact = self
            .contacts
            .at_direction(direction - turn)
            .or_else(|| self.contacts.at_direction(center_direction - turn))?;
        Some(self.center_from_whisker.transform_point(contact.position))
    }
}
