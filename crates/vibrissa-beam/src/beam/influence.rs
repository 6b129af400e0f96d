//! Small deflections of a tapered whisker on an elastic base: what a touch at arc length `s_a` does per unit motion.
//!
//! With the radius falling linearly, `EI(s) = EI (1 - n s)^4` with `n = (1 - tip_ratio) / L`, a normal force `F` at `s_a`
//! deflects the whisker there by
//!
//! ```text
//! y / F = ∫0^s_a (s_a - s)² / EI(s) ds + s_a² / k_base = s_a³ / (3 EI (1 - n s_a)) + s_a² / k_base
//! ```
//!
//! and the base feels `F s_a`. A base that turns by `theta` against a peg moves the whisker there by `s_a theta`, one
//! that travels sideways by its travel. The error is of second order in the slope, as in [`super::small_angle`].

use super::check_arc_length;
use super::load::Load;
use super::rod::Rod;
use super::whisker::Whisker;
use crate::error::{Error, Result};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// A dimensionless force `F s_a² / EI` whose shape is straight but for its linear part.
const SMALL_LOAD: f64 = 1e-7;

/// The deflection at `s_a` (m) that a unit normal force there causes (m/N).
///
/// # Errors
/// Data: a whisker that makes no sense, see [`Rod::new`], or that is curved at rest. Usage: `s_a` outside (0, L].
pub fn deflection_per_force(whisker: &Whisker, s_a: f64) -> Result<f64> {
    let rod = Rod::new(whisker)?;
    if let Some(term) = whisker.curvature_terms().iter().find(|term| term.abs() > 0.0) {
        return Err(Error::data("curvature").value(term).allowed("0 for small deflections"));
    }
    check_arc_length(whisker.length, s_a)?;
    if !whisker.stretches.as_slice().is_empty() {
        return of_rod(&rod, whisker.flexural_rigidity, s_a);
    }
    let narrowing = (1.0 - whisker.tip_ratio) / whisker.length;
    let shaft = s_a.powi(3) / (3.0 * whisker.flexural_rigidity * (1.0 - narrowing * s_a));
    Ok(shaft + s_a * s_a / whisker.base_stiffness)
}

/// The deflection per force of several wires: the rod itself under a force so small that nothing but the linear part is
/// left.
fn of_rod(rod: &Rod, flexural_rigidity: f64, s_a: f64) -> Result<f64> {
    let force = SMALL_LOAD * flexural_rigidity / (s_a * s_a);
    let bends = rod.force_mode(force, s_a, Load::Normal)?;
    let bend = bends.first().ok_or_else(|| Error::data("segments").value(s_a).allowed("wires of similar stiffness"))?;
    Ok(bend.contact.y / force)
}

/// The moment about the base for each radian that the base turns against a peg at `s_a` (N m/rad).
///
/// # Errors
/// As [`deflection_per_force`].
pub fn moment_per_turn(whisker: &Whisker, s_a: f64) -> Result<f64> {
    deflection_per_force(whisker, s_a).map(|influence| s_a * s_a / influence)
}

/// The moment about the base for each metre that the base travels sideways against a peg at `s_a` (N m/m).
///
/// # Errors
/// As [`deflection_per_force`].
pub fn moment_per_travel(whisker: &Whisker, s_a: f64) -> Result<f64> {
    deflection_per_force(whisker, s_a).map(|influence| s_a / influence)
}
