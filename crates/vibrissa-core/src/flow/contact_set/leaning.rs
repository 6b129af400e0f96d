//! Where the tip of a whisker that leans out of the horizontal can be on upright walls, given the moment in its plane.
//!
//! A wall without friction pushes along its normal, which is horizontal. A straight round whisker then bends in the plane of its axis and this
//! normal, in which the wall is a line: there the contact is the planar one, with the force at the angle between axis and normal. What the
//! sensor reads is the share of the moment in its own plane.
//!
//! With the whisker's axis `a`, the wall's normal `n` (horizontal), and `b` the unit vector of what of `n` is across `a`:
//!
//! | quantity | value |
//! | --- | --- |
//! | direction of the force in the bending plane, from the axis | `psi = atan2(|n - (n·a) a|, n·a)` |
//! | reading of a moment `M` | `M (b·y)`, with `y` the sensor's left |
//! | place of the tip at `(X, Y)` of the bending plane | `X a + Y b`, of which the map sees the horizontal part |

use super::tip::{TipContact, TipContactSet};
use crate::beam::{Bend, Load, Whisker, moment_mode};
use crate::math;
use crate::plane::Vec2;
use crate::world::Lean;
use core::f64::consts::PI;

/// Directions of the force that are tried, over the half circle on the side of the reading.
const NODES: usize = 240;
/// Least angle between the force and the whisker's direction at its tip (rad): a wall does not pull a whisker out.
const LEAST_ANGLE: f64 = 0.35;

/// The bending plane of a force.
#[derive(Clone, Copy, Debug)]
struct Plane {
    /// The horizontal parts of axis and of the direction across it.
    along: Vec2,
    across: Vec2,
    /// Direction of the force from the axis (rad).
    psi: f64,
    /// What the sensor reads of a moment in this plane, as a share.
    share: f64,
}

impl Lean {
    /// The plane in which a force in this horizontal direction (rad, whisker frame) bends the whisker; none along the axis itself.
    fn plane(&self, direction: f64) -> Option<Plane> {
        let (sin_e, cos_e) = math::sin_cos(self.elevation);
        let (sin_d, cos_d) = math::sin_cos(direction);
        let along = cos_e * cos_d;
        // n less its part along the axis: in x, y, z.
        let across = [cos_d - along * cos_e, sin_d, -along * sin_e];
        let size = across.iter().map(|v| v * v).sum::<f64>().sqrt();
        if size < 1e-9 {
            return None;
        }
        // The sensor's left: y turned about the axis towards its up, which is (-sin e, 0, cos e).
        let (sin_r, cos_r) = math::sin_cos(self.roll);
        let left = [-sin_r * sin_e, cos_r, sin_r * cos_e];
        let share = (0..3).map(|k| across[k] * left[k]).sum::<f64>() / size;
        let across = Vec2::new(across[0], across[1]) * (1.0 / size);
        Some(Plane { along: Vec2::new(cos_e, 0.0), across, psi: math::atan2(size, along), share })
    }

    /// The bent whisker whose tip is pushed in this horizontal direction (rad, whisker frame) and whose sensor reads `reading` (N m).
    fn bend(&self, whisker: &Whisker, reading: f64, direction: f64) -> Option<(Plane, Bend)> {
        let plane = self.plane(direction)?;
        let moment = reading / plane.share;
        // A moment of the other sign would be a wall that pulls.
        if !(moment > 0.0 && moment.is_finite()) {
            return None;
        }
        let found = moment_mode(whisker, moment, whisker.length, Load::Directed(plane.psi)).ok()?;
        let pushed = |bend: &Bend| bend.force > 0.0 && bend.phi_a.abs() < PI && plane.psi - bend.phi_a >= LEAST_ANGLE;
        let bend = found.into_iter().find(pushed)?;
        Some((plane, bend))
    }

    /// The tip contacts on upright walls that a reading (N m) of a straight uniform whisker leaves open, by the direction of the wall's force;
    /// empty for a reading of zero.
    #[must_use]
    pub fn tip_contacts(&self, whisker: &Whisker, reading: f64) -> Vec<TipContactSet> {
        let contact = |k: usize| {
            let direction = -PI + 2.0 * PI * (k as f64 + 0.5) / (2 * NODES) as f64;
            let (plane, bend) = self.bend(whisker, reading, direction)?;
            let position = plane.along * bend.contact.x + plane.across * bend.contact.y;
            Some(TipContact { direction, slope: 0.0, position, force: bend.force })
        };
        let mut sets = Vec::new();
        let mut run: Vec<TipContact> = Vec::new();
        // From the back of the whisker on, so that no run is cut where the circle closes: there no wall pushes.
        for k in 0..2 * NODES {
            match contact(k) {
                Some(contact) => run.push(contact),
                None if run.len() > 1 => sets.push(TipContactSet::new(core::mem::take(&mut run))),
                None => run.clear(),
            }
        }
        if run.len() > 1 {
            sets.push(TipContactSet::new(run));
        }
        sets
    }

    /// Points along the whisker that is bent by such a contact as the map sees them (m, whisker frame), at these shares of its length.
    #[must_use]
    pub fn shape(&self, whisker: &Whisker, contact: &TipContact, shares: &[f64]) -> Vec<Vec2> {
        let Some(plane) = self.plane(contact.direction) else { return Vec::new() };
        // Where the tip is in the bending plane, and with it the moment.
        let determinant = plane.along.cross(plane.across);
        if determinant.abs() < 1e-9 {
            return Vec::new();
        }
        let x = contact.position.cross(plane.across) / determinant;
        let y = plane.along.cross(contact.position) / determinant;
        let (sin, cos) = math::sin_cos(plane.psi);
        let moment = contact.force * (x * sin - y * cos);
        let found = moment_mode(whisker, moment, whisker.length, Load::Directed(plane.psi));
        let Some(bend) = found.ok().and_then(|found| found.into_iter().find(|bend| bend.force > 0.0)) else {
            return Vec::new();
        };
        let place = |share: &f64| {
            let at = bend.point_at(share * whisker.length).position;
            plane.along * at.x + plane.across * at.y
        };
        shares.iter().map(place).collect()
    }
}
