//! The elastica as an initial value problem: a force of known tilt, solved in closed form without a search.

use super::bend::{Bend, Found};
use super::pendulum::{Pendulum, Tilt};
use crate::math;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Largest dimensionless length `s_a sqrt(|F|/EI)` that is solved.
pub(super) const MAX_LENGTH: f64 = 250.0;

/// The whisker under `force` (N) at arc length `s_a` (m), tilted by `beta` (rad) from the whisker's normal there.
///
/// This is the inner loop of everything: no search, no allocation. `flexural_rigidity` is E I (N m²).
///
/// Accuracy: `phi_a`, contact and moment to about 1e-13 relative (where they do not pass through zero), at every angle.
///
/// `None` when the shape would have an inflection between base and contact, which is beyond the first mode:
/// `s_a sqrt(|F|/EI) > 2 K(m)` with `m = (1 - sign(F) sin(beta)) / 2` (3.708 for a normal force). Also when `s_a` or
/// `flexural_rigidity` is not positive, or when anything is not finite.
#[must_use]
pub fn bend(flexural_rigidity: f64, force: f64, s_a: f64, beta: f64) -> Option<Bend> {
    let finite = force.is_finite() && s_a.is_finite() && beta.is_finite() && flexural_rigidity.is_finite();
    if !finite || s_a <= 0.0 || flexural_rigidity <= 0.0 {
        return None;
    }
    let t = s_a * (force.abs() / flexural_rigidity).sqrt();
    if t <= 0.0 {
        return Some(Bend { force, ..Bend::straight(flexural_rigidity, s_a, beta) });
    }
    let (side, tilt) = canonical(force, beta);
    let pendulum = Pendulum::new(tilt);
    // A whisker that sits at the end of the first mode must not fall off it by rounding.
    let end = pendulum.half_period();
    if t > end * (1.0 + 4.0 * f64::EPSILON) {
        return None;
    }
    let swing = pendulum.at(t.min(end));
    Some(Bend::new(Found { flexural_rigidity, force, s_a, side, tilt, swing }, |_| beta))
}

/// The side to which the whisker bends, and the tilt seen from there.
///
/// | force | cos(beta) | side | tilt |
/// | --- | --- | --- | --- |
/// | + | + | + | beta |
/// | + | - | - | pi - beta |
/// | - | + | - | -beta |
/// | - | - | + | pi + beta |
pub(super) fn canonical(force: f64, beta: f64) -> (f64, Tilt) {
    let (sin, cos) = math::sin_cos(beta);
    let sign = 1.0_f64.copysign(force);
    (sign * 1.0_f64.copysign(cos), Tilt::new(sign * sin, cos.abs()))
}
