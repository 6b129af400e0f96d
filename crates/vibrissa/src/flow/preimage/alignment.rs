//! The boundary's slope where the whisker touches, from a short history of whisker shapes.
//!
//! Each shape of the history puts the tip somewhere in the odometry frame; a parabola through these places has the
//! slope of the boundary \[routray, section "Constructing a Preimage from Sensor Observation"\]. Where a shape lies
//! depends on the direction of the contact force, which is normal to the boundary, whose slope is sought: a scalar
//! equation in the slope at the centre, of which every root is an alignment.

use crate::flow::contact_set::{TipContact, TipContactSet};
use crate::flow::quadratic::Quadratic;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::sets::Interval;
use core::f64::consts::{FRAC_PI_2, PI};

/// How many force directions are tried before roots are refined.
const SCAN: usize = 96;
/// Rounds in which the boundary's curvature within the history is refined.
const CURVATURE_ROUNDS: usize = 3;
/// Bisections of a root: from 3 degrees to a millionth.
const BISECTIONS: usize = 24;
/// A boundary cannot bend more sharply than this within a history (1/m).
const SHARPEST: f64 = 200.0;
/// A change of slope between neighbouring trials beyond which a change of sign is a pole, not a root (rad).
const POLE: f64 = 0.6;

/// One shape of the history: the tip contacts that its moment allows, and where the base was, seen from the centre's.
#[derive(Clone, Debug)]
pub(crate) struct HistoryShape<'a> {
    pub(crate) center_from_whisker: Pose2,
    pub(crate) contacts: &'a TipContactSet,
}

/// How the whisker lies against the boundary: whisker frame of the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Direction of the boundary at the contact, free space on its left (rad); the paper's `phi_E`.
    pub boundary_slope: f64,
    /// The tip contact.
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
}

/// The wall that a trial direction of the force implies.
struct Trial {
    /// Slope of the parabola at the centre against the assumed wall (rad): zero at a root.
    fault: f64,
}

/// The history around one centre, ready to be tried.
pub(crate) struct History<'a> {
    shapes: Vec<HistoryShape<'a>>,
    center: &'a TipContactSet,
}

impl<'a> History<'a> {
    pub(crate) fn new(center: &'a TipContactSet, shapes: Vec<HistoryShape<'a>>) -> Self {
        Self { shapes, center }
    }

    /// The slopes of the boundary at the centre that agree with the history: centre frame, free space on the left (rad).
    pub(crate) fn slopes(&self) -> Vec<f64> {
        if self.center.is_point() { self.slope_of_points().into_iter().collect() } else { self.roots() }
    }

    /// The slope where shapes do not depend on the boundary: the paper's load normal to the whisker.
    fn slope_of_points(&self) -> Option<f64> {
        let middle = self.center.contacts().first()?;
        let places: Vec<Vec2> = self.shapes.iter().filter_map(|s| s.place(0.0, middle.direction)).collect();
        let (first, last) = (places.first()?, places.last()?);
        let chord = (*last - *first).angle();
        let seen = places.iter().map(|p| (*p - middle.position).rotated(-chord)).map(|v| (v.x, v.y));
        let slope = chord + Quadratic::fit(seen)?.b.atan();
        // Of the two directions along the wall, the one with free space on its left: the wall pushes towards there.
        let pushed = (middle.direction - (slope + FRAC_PI_2)).cos() >= 0.0;
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

    fn roots(&self) -> Vec<f64> {
        let range = self.directions();
        if range.is_empty() {
            return Vec::new();
        }
        let at = |k: usize| range.lo() + range.width() * (k as f64 + 0.5) / SCAN as f64;
        let faults: Vec<Option<Trial>> = (0..SCAN).map(|k| self.trial(at(k))).collect();
        let mut roots = Vec::new();
        for k in 1..SCAN {
            let (Some(a), Some(b)) = (&faults[k - 1], &faults[k]) else { continue };
            if (a.fault < 0.0) != (b.fault < 0.0) && (a.fault - b.fault).abs() < POLE {
                roots.push(wrap_angle(self.refine(at(k - 1), at(k), a.fault < 0.0) - FRAC_PI_2));
            }
        }
        roots
    }

    fn refine(&self, mut lo: f64, mut hi: f64, negative_at_lo: bool) -> f64 {
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (lo + hi);
            match self.trial(middle) {
                Some(trial) if (trial.fault < 0.0) == negative_at_lo => lo = middle,
                _ => hi = middle,
            }
        }
        0.5 * (lo + hi)
    }

    /// What the history says of the boundary if the force at the centre acts in `direction` (rad, centre frame).
    fn trial(&self, direction: f64) -> Option<Trial> {
        let origin = self.center.at_direction(direction)?.position;
        let tangent = direction - FRAC_PI_2;
        let mut along = vec![0.0; self.shapes.len()];
        let mut curvature = 0.0;
        let mut slope = 0.0;
        for _ in 0..CURVATURE_ROUNDS {
            let mut seen = Vec::with_capacity(self.shapes.len());
            for (shape, along) in self.shapes.iter().zip(&mut along) {
                let place = shape.place(direction, direction + curvature * *along)?;
                let local = (place - origin).rotated(-tangent);
                *along = local.x;
                seen.push((local.x, local.y));
            }
            let fit = Quadratic::fit(seen.into_iter())?;
            slope = fit.b;
            curvature = (2.0 * fit.c / (1.0 + fit.b * fit.b).powf(1.5)).clamp(-SHARPEST, SHARPEST);
        }
        Some(Trial { fault: slope.atan() })
    }
}

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
