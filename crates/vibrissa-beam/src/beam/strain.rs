//! How near a bent whisker comes to what its material bears.

use super::bend::{Bend, Body};
use super::root::highest;
use super::whisker::Whisker;
use alloc::vec::Vec;

/// The place of a whisker that is bent the most from its rest shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain {
    /// Arc length from the base (m).
    pub s: f64,
    /// Curvature less the curvature at rest (1/m), signed.
    pub curvature: f64,
    /// Strain at the surface: curvature times the radius there.
    pub strain: f64,
}

/// Places that are looked at before the best is refined.
const PLACES: usize = 128;

impl Bend {
    /// Where the surface of the whisker is strained the most, for a round whisker of `diameter` (m) at the base that
    /// narrows as its taper says; of a jointed rod, the wire is taken to be of that diameter throughout.
    #[must_use]
    pub fn largest_strain(&self, diameter: f64) -> Strain {
        let narrowing = match &self.body {
            Body::Uniform(_) => 0.0,
            Body::Rod(rod) => rod.narrowing(),
        };
        self.strained_most(|s| 0.5 * diameter * (1.0 - narrowing * s))
    }

    /// Where the surface of `whisker`, the one that is bent here, is strained the most; `None` when a diameter is missing.
    #[must_use]
    pub fn largest_strain_of(&self, whisker: &Whisker) -> Option<Strain> {
        let known = match whisker.stretches.as_slice() {
            [] => whisker.diameter.is_some(),
            list => list.iter().all(|stretch| stretch.diameter.is_some()),
        };
        known.then(|| self.strained_most(|s| whisker.radius_at(s).unwrap_or(0.0)))
    }

    fn strained_most(&self, radius: impl Fn(f64) -> f64) -> Strain {
        let at = |s: f64| {
            let rest = match &self.body {
                Body::Uniform(_) => 0.0,
                Body::Rod(rod) => rod.rest_curvature(s),
            };
            // At the base itself the moment counts, though the whisker is straight before it.
            let curvature = self.point_at(s.max(0.0)).curvature - rest;
            Strain { s, curvature, strain: curvature.abs() * radius(s) }
        };
        // Just short of the contact, whose far side carries nothing.
        let end = self.s_a * (1.0 - 1e-12);
        let step = self.s_a / PLACES as f64;
        let mut places: Vec<f64> = (0..=PLACES).map(|i| (step * i as f64).min(end)).collect();
        if let Body::Rod(rod) = &self.body {
            let sides = |joint: f64| [joint * (1.0 - 1e-9), joint * (1.0 + 1e-9)];
            places.extend(rod.joints().flat_map(sides).filter(|&s| s < end));
        }
        let larger = |a: Strain, b: Strain| if b.strain > a.strain { b } else { a };
        let best = places.into_iter().map(at).fold(at(0.0), larger);
        let (lo, hi) = ((best.s - step).max(0.0), (best.s + step).min(end));
        larger(best, at(highest(|s| at(s).strain, lo, hi)))
    }
}
