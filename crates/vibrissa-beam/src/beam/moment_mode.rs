//! Moment mode: the moment about the base and the arc length are known.

use super::bend::{Bend, Found};
use super::elastica::canonical;
use super::fixed_line::FixedLine;
use super::load::{Line, Load};
use super::pendulum::{Pendulum, Swing, Tilt};
use super::rod::Rod;
use super::root::{root, root_through};
use super::whisker::Whisker;
use super::{check_arc_length, finite, sorted};
use crate::error::{Error, Result};
use crate::math;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Every first-mode equilibrium with `moment` (N m) about the base and contact at arc length `s_a` (m), least slope first.
///
/// The force is the one that pushes the whisker to the side to which the moment bends it.
///
/// | load | equilibria |
/// | --- | --- |
/// | normal | two up to `moment s_a / EI` = 2.944, none above |
/// | tilted | two up to a maximum that depends on the tilt, none above |
/// | vertical, directed | one, up to the longest whisker that is solved (`s_a sqrt(F/EI)` = 250) |
///
/// # Errors
/// Usage: `moment` not finite or `s_a` outside (0, L], or so small that no number holds the force. Data: a whisker that makes no sense, see [`Rod::new`].
pub fn moment_mode(whisker: &Whisker, moment: f64, s_a: f64, load: Load) -> Result<Vec<Bend>> {
    if !whisker.is_uniform() {
        return Rod::new(whisker)?.moment_mode(moment, s_a, load);
    }
    whisker.require_uniform()?;
    finite("moment", moment, "N m")?;
    check_arc_length(whisker.length, s_a)?;
    let line = load.line()?;
    let flexural_rigidity = whisker.flexural_rigidity;
    let scaled = moment.abs() * s_a / flexural_rigidity;
    if scaled <= 0.0 {
        return Ok(vec![Bend::straight(flexural_rigidity, s_a, line.beta(0.0))]);
    }
    let side = 1.0_f64.copysign(moment);
    let (sign, shapes) = match line {
        Line::Following(beta) => {
            let sign = side * 1.0_f64.copysign(math::cos(beta));
            (sign, following(canonical(sign, beta).1, scaled))
        }
        Line::Fixed(psi) => {
            let (sign, omega) = pushing(psi, side);
            (sign, FixedLine::new(omega).at_moment(scaled).into_iter().collect())
        }
    };
    let bends = shapes.into_iter().map(|(tilt, swing)| {
        let force = sign * flexural_rigidity * (swing.t / s_a) * (swing.t / s_a);
        let found = Found { flexural_rigidity, force, s_a, side, tilt, swing };
        Bend { moment, ..Bend::new(found, |phi_a| line.beta(phi_a)) }
    });
    sorted(bends.collect()).map_err(|_| {
        Error::usage("s_a: no finite force causes this moment so near to the base")
            .value(format!("{s_a} m for {moment} N m"))
            .remedy("give the arc length from the base to the contact in metres")
    })
}

/// The sign of the force along `psi` that pushes to `side`, and its direction seen from there, in (0, pi].
pub(super) fn pushing(psi: f64, side: f64) -> (f64, f64) {
    if math::sin(side * psi) > 0.0 { (1.0, side * psi) } else { (-1.0, side * psi + PI) }
}

/// Both shapes of dimensionless moment `scaled`: `t u'(t)` is log-concave over the first mode, so it has one maximum.
fn following(tilt: Tilt, scaled: f64) -> Vec<(Tilt, Swing)> {
    let pendulum = Pendulum::new(tilt);
    let end = pendulum.half_period();
    let moment = |t: f64| t * pendulum.at(t).du;
    // The derivative is u' + t cos(u + beta), whose root is sharp where the maximum itself is flat.
    let slope = |t: f64| {
        let swing = pendulum.at(t);
        let (sin, cos) = math::sin_cos(swing.u);
        swing.du + t * (tilt.cos * cos - tilt.sin * sin)
    };
    let top = root(slope, 0.5 * end, end).unwrap_or(end);
    let rising = root_through(|log_t: f64| math::ln(moment(math::exp(log_t)) / scaled), &[-360.0, -3.0, math::ln(top)])
        .map(math::exp);
    let falling = root(|t| moment(t) - scaled, top, end);
    rising.into_iter().chain(falling).map(|t| (tilt, pendulum.at(t))).collect()
}
