//! Force mode: the force is known.

use super::bend::{Bend, Found};
use super::elastica::{MAX_LENGTH, bend};
use super::fixed_line::FixedLine;
use super::load::{Line, Load};
use super::rod::Rod;
use super::whisker::Whisker;
use super::{check_arc_length, finite, sorted};
use crate::error::{Error, Result};
use crate::math;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Every first-mode equilibrium of a whisker under `force` (N) at arc length `s_a` (m), least slope first.
///
/// For a load that turns with the whisker there is at most one, and none when the force is so large that the whisker would
/// have an inflection between base and contact. For a load of fixed direction there is always the one that grows from the
/// undeflected whisker (the first), which grows from the undeflected whisker; strong forces add
/// shapes that curl over.
///
/// # Errors
/// Usage: `force` not finite, `s_a` outside (0, L], or a force beyond `62500 EI / s_a²`. Data: a whisker that makes no sense, see [`Rod::new`].
pub fn force_mode(whisker: &Whisker, force: f64, s_a: f64, load: Load) -> Result<Vec<Bend>> {
    if !whisker.is_uniform() {
        return Rod::new(whisker)?.force_mode(force, s_a, load);
    }
    whisker.require_uniform()?;
    finite("force", force, "N")?;
    check_arc_length(whisker.length, s_a)?;
    let line = load.line()?;
    let ei = whisker.flexural_rigidity;
    let t = s_a * (force.abs() / ei).sqrt();
    if t > MAX_LENGTH {
        let limit = MAX_LENGTH * MAX_LENGTH * ei / (s_a * s_a);
        return Err(Error::usage("force").value(force).allowed(format!("up to {limit:e} N at s_a = {s_a} m")));
    }
    match line {
        _ if t <= 0.0 => Ok(vec![Bend::straight(ei, s_a, line.beta(0.0))]),
        Line::Following(beta) => Ok(bend(ei, force, s_a, beta).into_iter().collect()),
        Line::Fixed(psi) => fixed(ei, force, s_a, psi, t),
    }
}

fn fixed(flexural_rigidity: f64, force: f64, s_a: f64, psi: f64, t: f64) -> Result<Vec<Bend>> {
    let line = Line::Fixed(psi);
    let direction = if force > 0.0 { psi } else { psi + PI };
    let mut bends = Vec::new();
    let axial = math::sin(direction).abs() <= 4.0 * f64::EPSILON;
    if axial && (math::cos(direction) > 0.0 || t <= PI) {
        bends.push(Bend { force, ..Bend::straight(flexural_rigidity, s_a, line.beta(0.0)) });
    }
    // A pull keeps the whisker straight, and so does a push below Euler's load.
    if axial && (math::cos(direction) > 0.0 || t <= 0.5 * PI) {
        return Ok(bends);
    }
    for side in [1.0, -1.0] {
        let family = FixedLine::new(if axial { PI } else { side * direction });
        for (tilt, swing) in family.at_length(t) {
            let found = Found { flexural_rigidity, force, s_a, side, tilt, swing };
            bends.push(Bend::new(found, |phi_a| line.beta(phi_a)));
        }
    }
    sorted(bends)
}
