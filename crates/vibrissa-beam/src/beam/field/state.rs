//! What a field says about one contact.

use super::table::{ENERGY, Jet, MOMENT, Row, SLOPE, X, Y};
use crate::plane::Vec2;
use core::f64::consts::FRAC_PI_2;

/// The quantities of a loaded whisker, or their derivatives by one number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
// In this order, which is a table's: two numbers are copied at once.
#[repr(C)]
pub struct Quantities {
    /// Slope of the whisker at the contact (rad), not wrapped.
    pub slope: f64,
    /// Moment of the contact force about the base (N m).
    pub moment: f64,
    /// Elastic energy, the base's share included (J).
    pub energy: f64,
    /// The contact, whisker frame (m).
    pub position: Vec2,
}

/// Bounds on how far a field's quantities are from those of the beam.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldErrors {
    /// Slope at the contact (rad).
    pub slope: f64,
    /// Each coordinate of the contact (m).
    pub position: f64,
    /// Base moment (N m).
    pub moment: f64,
    /// Elastic energy (J).
    pub energy: f64,
}

/// A whisker in equilibrium with its tip in contact, and how it changes with its load.
///
/// Guarantee: `moment = x F_y - y F_x` and `d energy = force_vector . d position`, both within the field's errors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct TipState {
    /// Rotation (rad, counter-clockwise) from the whisker's normal at the tip to the direction of a positive force.
    pub tilt: f64,
    /// The force (N); negative when it acts the other way.
    pub force: f64,
    /// Slope at the tip (rad), not wrapped.
    pub slope: f64,
    /// Moment of the force about the base (N m).
    pub moment: f64,
    /// Elastic energy (J).
    pub energy: f64,
    /// The tip, whisker frame (m).
    pub position: Vec2,
    /// Derivatives by the tilt (per rad), the force held.
    pub by_tilt: Quantities,
    /// Derivatives by the force (per N), the tilt held.
    pub by_force: Quantities,
}

/// How force and moment change when the tip is moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionRates {
    /// Gradient of the base moment (N m/m).
    pub moment: Vec2,
    /// Derivatives of the force on the whisker by x and by y (N/m): the columns of the stiffness, which is symmetric.
    pub force: [Vec2; 2],
}

/// How the tip moves when direction and moment change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingRates {
    /// Derivative of the tip's position by the force's direction (m/rad), the moment held.
    pub by_direction: Vec2,
    /// Derivative of the tip's position by the moment (m/(N m)), the direction held.
    pub by_moment: Vec2,
}

impl TipState {
    /// The direction in which the force pushes the whisker, whisker frame (rad), not wrapped.
    #[must_use]
    pub fn direction(&self) -> f64 {
        self.tilt + self.slope + FRAC_PI_2.copysign(self.force)
    }

    /// The force on the whisker, whisker frame (N).
    #[must_use]
    pub fn force_vector(&self) -> Vec2 {
        self.force * Vec2::from_angle(self.tilt + self.slope).perp()
    }

    /// Whether the shape withstands every disturbance that leaves the tip where it is.
    ///
    /// True from rest on until the tip's position, as a function of tilt and force, first folds: there the second variation
    /// of the energy with the tip held gets a null vector. Beyond the fold it is negative in one direction. A tip that may
    /// slide along a wall needs more: a positive curvature of the energy along the wall, see [`TipState::by_position`].
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.force.abs() <= 0.0 || self.by_tilt.position.cross(self.by_force.position) * self.force < 0.0
    }

    /// How force and moment change with the tip's position on this branch; `None` where it folds, and at rest.
    #[must_use]
    pub fn by_position(&self) -> Option<PositionRates> {
        let (a, b) = (self.by_tilt.position, self.by_force.position);
        let det = a.cross(b);
        if self.force.abs() <= 0.0 || det.abs() <= 0.0 || !det.is_finite() {
            return None;
        }
        // Rows of the inverse: tilt and force by position.
        let (tilt, force) = (Vec2::new(b.y, -b.x) * (1.0 / det), Vec2::new(-a.y, a.x) * (1.0 / det));
        let along = Vec2::from_angle(self.tilt + self.slope).perp();
        let across = self.force * along.perp();
        let turn = (1.0 + self.by_tilt.slope) * tilt + self.by_force.slope * force;
        Some(PositionRates {
            moment: self.by_tilt.moment * tilt + self.by_force.moment * force,
            force: [force.x * along + turn.x * across, force.y * along + turn.y * across],
        })
    }

    /// How the tip moves with direction and moment on this branch; `None` where it folds.
    #[must_use]
    pub fn by_reading(&self) -> Option<ReadingRates> {
        let (direction, moment) =
            ((1.0 + self.by_tilt.slope, self.by_force.slope), (self.by_tilt.moment, self.by_force.moment));
        let det = direction.0 * moment.1 - direction.1 * moment.0;
        if det.abs() <= 0.0 || !det.is_finite() {
            return None;
        }
        let (a, b) = (self.by_tilt.position, self.by_force.position);
        Some(ReadingRates {
            by_direction: (moment.1 / det) * a - (moment.0 / det) * b,
            by_moment: (direction.0 / det) * b - (direction.1 / det) * a,
        })
    }
}

impl Quantities {
    #[inline(always)]
    pub(super) fn new(row: &Row, factor: f64) -> Self {
        Self {
            slope: row[SLOPE] * factor,
            position: Vec2::new(row[X] * factor, row[Y] * factor),
            moment: row[MOMENT] * factor,
            energy: row[ENERGY] * factor,
        }
    }

    /// The derivatives of the mirrored whisker by the mirrored number.
    pub(super) fn of_mirrored(&self) -> Self {
        Self { position: -flipped(self.position), energy: -self.energy, ..*self }
    }
}

impl TipState {
    /// The state with this jet.
    #[inline(always)]
    pub(super) fn new(tilt: f64, force: f64, jet: &Jet) -> Self {
        let of = |kind: usize| {
            let [slope, moment, energy, x] = jet.four[kind];
            Quantities { slope, moment, energy, position: Vec2::new(x, jet.last[kind]) }
        };
        let (Quantities { slope, moment, energy, position }, by_tilt, by_force) = (of(0), of(1), of(2));
        Self { tilt, force, slope, position, moment, energy, by_tilt, by_force }
    }
}

fn flipped(v: Vec2) -> Vec2 {
    Vec2::new(v.x, -v.y)
}
