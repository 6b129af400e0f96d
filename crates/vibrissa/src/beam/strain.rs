//! How near a bent whisker comes to what its material bears.

use super::bend::{Bend, Body};
use super::root::highest;

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
        let at = |s: f64| {
            let rest = match &self.body {
                Body::Uniform(_) => 0.0,
                Body::Rod(rod) => rod.rest_curvature(s),
            };
            // At the base itself the moment counts, though the whisker is straight before it.
            let curvature = self.point_at(s.max(0.0)).curvature - rest;
            Strain { s, curvature, strain: curvature.abs() * 0.5 * diameter * (1.0 - narrowing * s) }
        };
        let step = self.s_a / PLACES as f64;
        let mut best = at(0.0);
        for i in 1..=PLACES {
            let here = at((step * i as f64).min(self.s_a * (1.0 - 1e-12)));
            if here.strain > best.strain {
                best = here;
            }
        }
        let (lo, hi) = ((best.s - step).max(0.0), (best.s + step).min(self.s_a * (1.0 - 1e-12)));
        let refined = at(highest(|s| at(s).strain, lo, hi));
        if refined.strain > best.strain { refined } else { best }
    }
}
