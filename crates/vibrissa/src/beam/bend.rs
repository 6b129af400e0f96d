//! One loaded whisker in equilibrium: everything that can be asked about it.

use super::pendulum::{Pendulum, Swing, Tilt};
use crate::plane::Vec2;

/// A point of a bent whisker, whisker frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapePoint {
    /// Where it lies (m).
    pub position: Vec2,
    /// The direction of the whisker there (rad), counter-clockwise from the undeflected whisker.
    pub slope: f64,
    /// The derivative of the slope by arc length (1/m).
    pub curvature: f64,
}

/// A uniform straight clamped whisker in equilibrium under one force.
///
/// Guarantee: `moment = x F_y - y F_x` and `force_vector = force (-sin(phi_a + beta), cos(phi_a + beta))`, for every sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// The force (N) along the load's direction; negative when it acts the other way.
    pub force: f64,
    /// Arc length from the base to the contact (m).
    pub s_a: f64,
    /// Slope of the whisker at the contact (rad), counter-clockwise; not wrapped, up to a full turn in size.
    pub phi_a: f64,
    /// Rotation (rad, counter-clockwise) from the whisker's normal at the contact, `phi_a + pi/2`, to the load's direction.
    pub beta: f64,
    /// The contact point, whisker frame (m).
    pub contact: Vec2,
    /// Moment of the contact force about the base (N m), counter-clockwise positive.
    pub moment: f64,
    pub(super) flexural_rigidity: f64,
    pub(super) tilt: Tilt,
    pub(super) side: f64,
}

/// What the three modes know when they have found an equilibrium.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) flexural_rigidity: f64,
    pub(super) force: f64,
    pub(super) s_a: f64,
    /// +1 when the whisker bends towards +y, -1 when it bends towards -y.
    pub(super) side: f64,
    pub(super) tilt: Tilt,
    pub(super) swing: Swing,
}

impl Bend {
    /// The whisker without load.
    pub(super) fn straight(flexural_rigidity: f64, s_a: f64, beta: f64) -> Self {
        let (sin, cos) = beta.sin_cos();
        Self {
            force: 0.0,
            s_a,
            phi_a: 0.0,
            beta,
            contact: Vec2::new(s_a, 0.0),
            moment: 0.0,
            flexural_rigidity,
            tilt: Tilt::new(sin, cos.abs()),
            side: 1.0,
        }
    }

    /// The whisker in the equilibrium found; the caller says how the force is tilted.
    pub(super) fn new(found: Found, beta: impl FnOnce(f64) -> f64) -> Self {
        let Found { flexural_rigidity, force, s_a, side, tilt, swing } = found;
        let scale = if swing.t > 0.0 { s_a / swing.t } else { 0.0 };
        let (x, y) = swing.contact();
        let phi_a = side * swing.u;
        Self {
            force,
            s_a,
            phi_a,
            beta: beta(phi_a),
            contact: Vec2::new(scale * x, side * scale * y),
            moment: side * flexural_rigidity / s_a * swing.t * swing.du,
            flexural_rigidity,
            tilt,
            side,
        }
    }

    /// The force as a vector, whisker frame (N).
    #[must_use]
    pub fn force_vector(&self) -> Vec2 {
        self.force * Vec2::from_angle(self.phi_a + self.beta).perp()
    }

    /// Dimensionless arc length per metre, `sqrt(|F| / EI)` (1/m).
    fn rate(&self) -> f64 {
        (self.force.abs() / self.flexural_rigidity).sqrt()
    }

    /// The whisker at arc length `s` (m) from the base; straight beyond the contact, and before the base.
    #[must_use]
    pub fn point_at(&self, s: f64) -> ShapePoint {
        self.point_with(&Pendulum::new(self.tilt), s)
    }

    fn point_with(&self, pendulum: &Pendulum, s: f64) -> ShapePoint {
        let rate = self.rate();
        if s >= self.s_a {
            let position = self.contact + (s - self.s_a) * Vec2::from_angle(self.phi_a);
            return ShapePoint { position, slope: self.phi_a, curvature: 0.0 };
        }
        if s <= 0.0 || rate <= 0.0 {
            let curvature = if s < 0.0 { 0.0 } else { self.moment / self.flexural_rigidity };
            return ShapePoint { position: Vec2::new(s, 0.0), slope: 0.0, curvature };
        }
        let swing = pendulum.at((self.s_a - s) * rate);
        let back = Vec2::new(-swing.along, self.side * swing.across) * (1.0 / rate);
        ShapePoint {
            position: self.contact + back.rotated(self.phi_a),
            slope: self.phi_a - self.side * swing.u,
            curvature: self.side * rate * swing.du,
        }
    }

    /// `n` points from base to tip of a whisker of `length` (m), evenly spaced in arc length, whisker frame (m).
    ///
    /// Fewer than two points are none.
    #[must_use]
    pub fn shape(&self, length: f64, n: usize) -> Vec<Vec2> {
        self.shape_points(length, n).into_iter().map(|(_, point)| point.position).collect()
    }

    /// As [`Bend::shape`], with arc length, slope and curvature.
    #[must_use]
    pub fn shape_points(&self, length: f64, n: usize) -> Vec<(f64, ShapePoint)> {
        if n < 2 {
            return Vec::new();
        }
        let pendulum = Pendulum::new(self.tilt);
        let at = |i: usize| length * (i as f64 / (n - 1) as f64);
        (0..n).map(|i| (at(i), self.point_with(&pendulum, at(i)))).collect()
    }

    /// The tip of a whisker of `length` (m), which is straight beyond the contact, whisker frame (m).
    #[must_use]
    pub fn tip(&self, length: f64) -> Vec2 {
        self.contact + (length - self.s_a) * Vec2::from_angle(self.phi_a)
    }

    /// How far the tip moved from where the undeflected whisker has it (m), whisker frame.
    #[must_use]
    pub fn tip_displacement(&self, length: f64) -> Vec2 {
        self.tip(length) - Vec2::new(length, 0.0)
    }

    /// The elastic energy (J): `∫ M(s)² / (2 EI) ds`.
    #[must_use]
    pub fn energy(&self) -> f64 {
        let rate = self.rate();
        self.flexural_rigidity * rate * Pendulum::new(self.tilt).at(self.s_a * rate).energy
    }
}
