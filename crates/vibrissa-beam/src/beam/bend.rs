//! One loaded whisker in equilibrium: everything that can be asked about it.

use super::pendulum::{Pendulum, Swing, Tilt};
use super::rod::Rod;
use crate::math;
use crate::plane::Vec2;
use crate::platform::Shared;
use alloc::vec::Vec;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

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

/// A whisker in equilibrium under one force.
///
/// Guarantee: `moment = x F_y - y F_x` and `force_vector = force (-sin(phi_a + beta), cos(phi_a + beta))`, for every sign.
/// The base's reaction is the opposite force and moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Bend {
    /// The force (N) along the load's direction; negative when it acts the other way.
    pub force: f64,
    /// Shared length from the base to the contact (m).
    pub s_a: f64,
    /// Slope of the whisker at the contact (rad), counter-clockwise; not wrapped, up to a full turn in size.
    pub phi_a: f64,
    /// Rotation (rad, counter-clockwise) from the whisker's normal at the contact, `phi_a + pi/2`, to the load's direction.
    pub beta: f64,
    /// The contact point, whisker frame (m).
    pub contact: Vec2,
    /// Moment of the contact force about the base (N m), counter-clockwise positive.
    pub moment: f64,
    pub(super) body: Body,
}

/// What bends.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Body {
    /// The closed form covers it.
    Uniform(Uniform),
    /// It is integrated.
    Rod(Shared<Rod>),
}

/// A uniform straight clamped whisker, and how its closed form is posed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Uniform {
    flexural_rigidity: f64,
    tilt: Tilt,
    side: f64,
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
        let (sin, cos) = math::sin_cos(beta);
        Self {
            force: 0.0,
            s_a,
            phi_a: 0.0,
            beta,
            contact: Vec2::new(s_a, 0.0),
            moment: 0.0,
            body: Body::Uniform(Uniform { flexural_rigidity, tilt: Tilt::new(sin, cos.abs()), side: 1.0 }),
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
            body: Body::Uniform(Uniform { flexural_rigidity, tilt, side }),
        }
    }

    /// Whether every number of it is finite, those that are derived from it included.
    pub(super) fn is_finite(&self) -> bool {
        let numbers = [self.force, self.s_a, self.phi_a, self.beta, self.contact.x, self.contact.y, self.moment];
        let derived = match &self.body {
            Body::Uniform(uniform) => uniform.rate(self.force),
            Body::Rod(rod) => self.moment * rod.base_angle(self.moment),
        };
        numbers.into_iter().chain([derived]).all(f64::is_finite)
    }

    /// The force as a vector, whisker frame (N).
    #[must_use]
    pub fn force_vector(&self) -> Vec2 {
        self.force * Vec2::from_angle(self.phi_a + self.beta).perp()
    }

    /// The whisker at arc length `s` (m) from the base; at rest beyond the contact, straight before the base.
    #[must_use]
    pub fn point_at(&self, s: f64) -> ShapePoint {
        match &self.body {
            Body::Uniform(uniform) => uniform.point_with(self, &Pendulum::new(uniform.tilt), s),
            Body::Rod(rod) => rod.bent(self).point_at(s),
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
        self.points_at((0..n).map(|i| length * (i as f64 / (n - 1) as f64)))
    }

    /// The shape at these arc lengths (m), each with its own.
    pub fn points_at(&self, arcs: impl Iterator<Item = f64>) -> Vec<(f64, ShapePoint)> {
        match &self.body {
            Body::Uniform(uniform) => {
                let pendulum = Pendulum::new(uniform.tilt);
                arcs.map(|s| (s, uniform.point_with(self, &pendulum, s))).collect()
            }
            Body::Rod(rod) => {
                let bent = rod.bent(self);
                arcs.map(|s| (s, bent.point_at(s))).collect()
            }
        }
    }

    /// The tip of a whisker of `length` (m), which carries no load beyond the contact, whisker frame (m).
    #[must_use]
    pub fn tip(&self, length: f64) -> Vec2 {
        match &self.body {
            Body::Uniform(_) => self.contact + (length - self.s_a) * Vec2::from_angle(self.phi_a),
            Body::Rod(rod) => rod.bent(self).point_at(length).position,
        }
    }

    /// How far the tip of a straight whisker of `length` (m) moved: from `(length, 0)` to [`Bend::tip`] (m).
    #[must_use]
    pub fn tip_displacement(&self, length: f64) -> Vec2 {
        self.tip(length) - Vec2::new(length, 0.0)
    }

    /// The elastic energy (J): `∫ M(s)² / (2 EI) ds`, and the base's `M0² / (2 k_base)`.
    #[must_use]
    pub fn energy(&self) -> f64 {
        match &self.body {
            Body::Uniform(uniform) => uniform.energy(self),
            Body::Rod(rod) => rod.bent(self).energy() + 0.5 * self.moment * rod.base_angle(self.moment),
        }
    }

    /// How far the base has turned (rad); 0 when it is clamped.
    #[must_use]
    pub fn base_angle(&self) -> f64 {
        match &self.body {
            Body::Uniform(_) => 0.0,
            Body::Rod(rod) => rod.base_angle(self.moment),
        }
    }
}

impl Uniform {
    /// Dimensionless arc length per metre, `sqrt(|F| / EI)` (1/m).
    fn rate(&self, force: f64) -> f64 {
        (force.abs() / self.flexural_rigidity).sqrt()
    }

    fn point_with(&self, bend: &Bend, pendulum: &Pendulum, s: f64) -> ShapePoint {
        let rate = self.rate(bend.force);
        if s >= bend.s_a {
            let position = bend.contact + (s - bend.s_a) * Vec2::from_angle(bend.phi_a);
            return ShapePoint { position, slope: bend.phi_a, curvature: 0.0 };
        }
        if s <= 0.0 || rate <= 0.0 {
            let curvature = if s < 0.0 { 0.0 } else { bend.moment / self.flexural_rigidity };
            return ShapePoint { position: Vec2::new(s, 0.0), slope: 0.0, curvature };
        }
        let swing = pendulum.at((bend.s_a - s) * rate);
        let back = Vec2::new(-swing.along, self.side * swing.across) * (1.0 / rate);
        ShapePoint {
            position: bend.contact + back.rotated(bend.phi_a),
            slope: bend.phi_a - self.side * swing.u,
            curvature: self.side * rate * swing.du,
        }
    }

    fn energy(&self, bend: &Bend) -> f64 {
        let rate = self.rate(bend.force);
        self.flexural_rigidity * rate * Pendulum::new(self.tilt).at(bend.s_a * rate).energy
    }
}
