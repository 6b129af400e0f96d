//! The small-angle model of straight whiskers: what the paper's small-angle moment sensor uses.

use super::Contact;
use crate::beam::Whisker;
use crate::math;
use crate::plane::Vec2;

/// How many contacts are tried for the largest displacement of the tip.
const PLACES: usize = 64;

/// A straight whisker whose slope is taken to be small: uniform or tapered, on a clamped or an elastic base.
///
/// With `w = 1 - (1 - tip_ratio) s_a / L` the radius at the contact over the base's,
///
/// ```text
/// M0 = F s_a,   x = s_a,   y = F s_a³ / (3 w EI) + F s_a² / k,   phi_a = F s_a² (1 + 2 w) / (6 w² EI) + F s_a / k
/// ```
///
/// which is \[routray, eq. "momentSmallAngle"\] and the integrals of a beam whose rigidity falls like `w⁴`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SmallBeam {
    length: f64,
    flexural_rigidity: f64,
    /// How fast the radius falls, as a share of the base's (1/m).
    narrowing: f64,
    base_compliance: f64,
}

impl SmallBeam {
    /// The model of `whisker`; none when it is curved at rest.
    pub(super) fn new(whisker: &Whisker) -> Option<Self> {
        (whisker.curvature.abs() <= 0.0).then(|| Self {
            length: whisker.length,
            flexural_rigidity: whisker.flexural_rigidity,
            narrowing: (1.0 - whisker.tip_ratio) / whisker.length,
            base_compliance: 1.0 / whisker.base_stiffness,
        })
    }

    /// Slope at the contact for a unit force (rad/N).
    pub(super) fn slope_compliance(&self, s_a: f64) -> f64 {
        let w = 1.0 - self.narrowing * s_a;
        s_a * s_a * (1.0 + 2.0 * w) / (6.0 * w * w * self.flexural_rigidity) + s_a * self.base_compliance
    }

    fn deflection_compliance(&self, s_a: f64) -> f64 {
        let w = 1.0 - self.narrowing * s_a;
        s_a * s_a * (s_a / (3.0 * w * self.flexural_rigidity) + self.base_compliance)
    }

    pub(super) fn contact(&self, force: f64, s_a: f64) -> Contact {
        Contact {
            force,
            s_a,
            phi_a: force * self.slope_compliance(s_a),
            position: Vec2::new(s_a, force * self.deflection_compliance(s_a)),
            moment: force * s_a,
            tilt: 0.0,
        }
    }

    /// The largest displacement of the tip (m) that `moment` (N m) can cause, wherever the contact is.
    pub(super) fn tip_displacement(&self, moment: f64) -> f64 {
        let tip = |i: usize| {
            let s_a = self.length * i as f64 / PLACES as f64;
            let contact = self.contact(moment / s_a, s_a);
            (contact.position.y + (self.length - s_a) * contact.phi_a).abs()
        };
        (1..=PLACES).map(tip).fold(0.0, f64::max)
    }

    /// The whisker at `n` evenly spaced places from base to tip (m).
    pub(super) fn shape(&self, contact: &Contact, n: usize) -> Vec<Vec2> {
        let (mut slope, mut y) = (contact.moment * self.base_compliance, 0.0);
        let step = self.length / (n.max(2) - 1) as f64;
        let across = contact.force * math::cos(contact.tilt);
        let curvature = |s: f64| {
            let w = 1.0 - self.narrowing * s;
            across * (contact.s_a - s).max(0.0) / (self.flexural_rigidity * w * w * w * w)
        };
        let mut points = vec![Vec2::ZERO];
        for i in 1..n {
            // Simpson's rule for the slope and for the deflection, exact while the whisker is uniform.
            let s = step * (i - 1) as f64;
            let [a, b, c] = [s, s + 0.5 * step, s + step].map(curvature);
            y += step * slope + step * step * (a + 2.0 * b) / 6.0;
            slope += step * (a + 4.0 * b + c) / 6.0;
            points.push(Vec2::new(step * i as f64, y));
        }
        points
    }
}
