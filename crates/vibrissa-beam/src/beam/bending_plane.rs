//! A whisker in space: the plane in which it bends, from the moments about both transverse axes.
//!
//! A straight round whisker has the same rigidity in every direction. Under one force that has no part across it, it bends in the plane of its
//! axis and the force, and nothing twists it: the planar mechanics hold in the turned plane.

use super::{Bend, Load, Whisker, moment_mode};
use crate::error::{Error, Result};
use crate::math;
use crate::plane::Vec2;
use alloc::vec::Vec;

/// The plane in which a whisker bends, and how strongly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BendingPlane {
    /// The moment about the base in this plane (N m), 0 or more.
    pub moment: f64,
    /// The angle about the whisker's axis (rad), from +y towards +z, in (-π, π].
    pub angle: f64,
}

/// A contact in space.
#[derive(Clone, Debug, PartialEq)]
pub struct SpatialContact {
    /// The plane.
    pub plane: BendingPlane,
    /// The equilibrium in this plane, bent towards its positive side.
    pub bend: Bend,
    /// Along the undeflected whisker (m).
    pub x: f64,
    /// Distance from the undeflected whisker's axis (m).
    pub r: f64,
}

impl BendingPlane {
    /// The plane of two moments (N m): in the whisker's x-y plane, positive for a push towards +y, and across it, positive for a push towards
    /// +z (the moment about -y).
    #[must_use]
    pub fn of([moment, across]: [f64; 2]) -> Self {
        Self { moment: math::hypot(moment, across), angle: math::atan2(across, moment) }
    }

    /// Half widths of the bands of moment (N m) and angle (rad) where the two moments are wrong by no more than `errors` (N m). Without a moment
    /// beyond its error the angle may be anything.
    #[must_use]
    pub fn bands(&self, errors: [f64; 2]) -> [f64; 2] {
        let error = math::hypot(errors[0], errors[1]);
        let angle = if error < self.moment { math::asin(error / self.moment) } else { core::f64::consts::PI };
        [error, angle]
    }

    /// By how much the plane is turned out of the whisker's x-y plane (rad), in \[0, π/2\]: what the planar methods take for a smaller moment.
    #[must_use]
    pub fn out_of_plane(&self) -> f64 {
        let angle = self.angle.abs();
        angle.min(core::f64::consts::PI - angle)
    }

    /// A point of the plane (m) in the whisker frame: x along the undeflected whisker, y left, z up.
    #[must_use]
    pub fn in_space(&self, point: Vec2) -> [f64; 3] {
        let (sin, cos) = math::sin_cos(self.angle);
        [point.x, point.y * cos, point.y * sin]
    }
}

impl SpatialContact {
    /// The contact in the whisker frame (m).
    #[must_use]
    pub fn point(&self) -> [f64; 3] {
        self.plane.in_space(self.bend.contact)
    }

    /// The contact's force in the whisker frame (N).
    #[must_use]
    pub fn force(&self) -> [f64; 3] {
        let Bend { force, phi_a, beta, .. } = self.bend;
        let (sin, cos) = math::sin_cos(phi_a + beta);
        self.plane.in_space(Vec2::new(-force * sin, force * cos))
    }
}

/// The contacts at an arc length (m) that explain both moments (N m), as [`BendingPlane::of`] takes them; none where no contact does.
///
/// # Errors
///
/// A whisker with a rest curvature, whose rigidity or shape singles a direction out; else as [`moment_mode`].
pub fn moment_mode_in_space(whisker: &Whisker, moments: [f64; 2], s_a: f64, load: Load) -> Result<Vec<SpatialContact>> {
    let is_curved = whisker.curvature != 0.0 || whisker.curvature_rise.iter().any(|rise| *rise != 0.0);
    if is_curved {
        return Err(Error::usage("a curved whisker does not bend in the plane of its moment")
            .value(whisker.curvature)
            .allowed("a curvature of 0 1/m, constant or rising")
            .remedy("straighten the whisker, or use the moment in the plane of its curvature alone"));
    }
    let plane = BendingPlane::of(moments);
    let bends = moment_mode(whisker, plane.moment, s_a, load)?;
    let contact = |bend: Bend| SpatialContact { plane, x: bend.contact.x, r: bend.contact.y.abs(), bend };
    Ok(bends.into_iter().map(contact).collect())
}
