//! Whisker mechanics: the shapes of a whisker under one contact force.
//!
//! | mode | known | function | equilibria |
//! | --- | --- | --- | --- |
//! | force | `F, s_a` | [`force_mode`] | one, or none for a force that turns with the whisker and is too large |
//! | moment | `M0, s_a` | [`moment_mode`] | normal load: two below `M0 s_a / EI` = 2.944, none above |
//! | point | `x, y` | [`point_mode`] | one; two or none for points far to the side |
//! | moments in space | both transverse moments, `s_a` | [`moment_mode_in_space`] | as the moment mode, in the plane that they say |
//! | tip | `x, y` of the tip | [`tip_mode`] | force and its direction; one, or several where the whisker can snap |
//!
//! All in SI, in the whisker frame: base at the origin, undeflected whisker along +x, angles counter-clockwise. A push towards
//! +y bends the whisker towards +y and has a positive moment. Mirroring the whisker at its axis turns
//! `(F, M0, phi_a, y, beta)` into `(-F, -M0, -phi_a, -y, -beta)`; nothing else changes.
//!
//! Only first-mode equilibria are found, those without an inflection between base and contact. That a list is empty is an
//! answer: no such equilibrium exists. Stability is not judged; a rod may pass through itself.
//!
//! The closed form covers the uniform, straight, clamped whisker; see [`elastica::bend`] for the inner loop without a search.
//! Under a normal load [`normal`] is as exact and ten times as fast; [`small_angle`] is the model that it is not.
//! Taper, rest curvature, several wires and elastic bases are integrated; see [`Rod`]. Those who ask for millions of shapes
//! of one whisker tabulate it; see [`field`].

mod bend;
mod bending_plane;
pub mod elastica;
pub mod field;
mod fixed_line;
mod force_mode;
mod influence;
pub mod jacobi;
mod load;
mod moment_mode;
pub mod normal;
mod pair;
mod pendulum;
mod point_mode;
pub mod press;
pub mod rod;
mod root;
pub mod small_angle;
mod strain;
mod stretch;
mod tip_chart;
mod tip_curve;
mod tip_mode;
mod tip_model;
mod tip_table;
mod whisker;

pub use bend::{Bend, ShapePoint};
pub use bending_plane::{BendingPlane, SpatialContact, moment_mode_in_space};
pub use force_mode::force_mode;
pub use influence::{deflection_per_force, moment_per_travel, moment_per_turn};
pub use load::Load;
pub use moment_mode::moment_mode;
pub use point_mode::point_mode;
pub use rod::{Rod, Segment};
pub use small_angle::SmallAngle;
pub use strain::Strain;
pub use stretch::{MOST_STRETCHES, Stretch, Stretches};
pub use tip_chart::{TipChart, TipRate, held_tip_chart, tip_chart};
pub use tip_curve::{TipEquilibrium, largest_tip_moment, tip_curve};
pub use tip_mode::tip_mode;
pub use tip_model::{TipModel, TipReading};
pub use tip_table::TipTable;
pub use whisker::{CURVATURE_TERMS, Whisker};

use crate::error::{Error, Result};
use crate::plane::Vec2;
use alloc::format;
use alloc::vec::Vec;

/// Refuses a number that is not finite.
fn finite(name: &str, value: f64, unit: &str) -> Result<()> {
    if value.is_finite() {
        return Ok(());
    }
    Err(Error::usage(name).value(value).allowed(format!("a finite number of {unit}")))
}

/// Refuses a contact that is not on a whisker of `length`.
fn check_arc_length(length: f64, s_a: f64) -> Result<()> {
    if s_a > 0.0 && s_a <= length {
        return Ok(());
    }
    Err(Error::usage("s_a")
        .value(s_a)
        .allowed(format!("above 0 and up to the whisker's length {length} m"))
        .remedy("give the arc length from the base to the contact in metres"))
}

/// Refuses a contact point that is nowhere or at the base.
fn check_contact(contact: Vec2) -> Result<()> {
    let distance = contact.norm();
    if distance.is_finite() && distance > 0.0 {
        return Ok(());
    }
    Err(Error::usage("contact point")
        .value(format!("({}, {})", contact.x, contact.y))
        .allowed("finite, in metres, and away from the base"))
}

/// The equilibria, least slope first.
///
/// # Errors
/// Usage: one of them whose force, moment or rates no number holds; whiskers of 1e-300 m have such.
fn sorted(mut bends: Vec<Bend>) -> Result<Vec<Bend>> {
    bends.sort_by(|a, b| a.phi_a.abs().total_cmp(&b.phi_a.abs()));
    representable(bends)
}

/// The same equilibria, refused when a number of one of them is not finite.
fn representable(bends: Vec<Bend>) -> Result<Vec<Bend>> {
    if bends.iter().all(Bend::is_finite) {
        return Ok(bends);
    }
    Err(Error::usage("the force is beyond all numbers").remedy("check the units: lengths are in m, moments in N m"))
}
