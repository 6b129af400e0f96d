//! Point mode: the contact point is known.

use super::bend::{Bend, Found};
use super::elastica::canonical;
use super::fixed_line::FixedLine;
use super::load::{Line, Load};
use super::moment_mode::pushing;
use super::pendulum::{Pendulum, Swing, Tilt};
use super::rod::Rod;
use super::root::{root, root_through};
use super::whisker::Whisker;
use super::{check_contact, sorted};
use crate::error::Result;
use crate::math;
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Every first-mode equilibrium whose contact is at `contact` (m, whisker frame), least slope first.
///
/// The contact's polar angle alone fixes the shape, its distance then fixes `s_a` and the force. The force is the one that
/// pushes the whisker to the side to which it bends. There is none where no shape reaches the polar angle (a normal load
/// reaches 99.6 degrees, a vertical one less than 90) or where the whisker is too short. Beyond the polar angle at
/// which the force's line meets the base (90 degrees for a normal load) there are two.
///
/// # Errors
/// Usage: a contact that is not finite or at the base, or one so near to it that no number holds the force. Data: a whisker that makes no sense, see [`Rod::new`].
pub fn point_mode(whisker: &Whisker, contact: Vec2, load: Load) -> Result<Vec<Bend>> {
    if !whisker.is_uniform() {
        return Rod::new(whisker)?.point_mode(contact, load);
    }
    whisker.require_uniform()?;
    check_contact(contact)?;
    let distance = contact.norm();
    let line = load.line()?;
    let mut bends = Vec::new();
    if contact.y.abs() <= 0.0 && contact.x > 0.0 && distance <= whisker.length {
        bends.push(Bend::straight(whisker.flexural_rigidity, distance, line.beta(0.0)));
    }
    for side in [1.0, -1.0] {
        let polar = math::atan2(side * contact.y, contact.x);
        let polar = if polar < 0.0 { polar + 2.0 * PI } else { polar };
        if polar > 0.0 {
            bends.extend(shapes(line, side, polar).into_iter().filter_map(|s| scaled(whisker, contact, line, side, s)));
        }
    }
    sorted(bends)
}

/// The shapes that bend to `side` with the contact at polar angle `polar` (seen from there), and the force's sign.
fn shapes(line: Line, side: f64, polar: f64) -> Vec<(f64, Tilt, Swing)> {
    match line {
        Line::Following(beta) => {
            let sign = side * 1.0_f64.copysign(math::cos(beta));
            following(canonical(sign, beta).1, polar).into_iter().map(|(tilt, swing)| (sign, tilt, swing)).collect()
        }
        Line::Fixed(psi) => {
            let (sign, omega) = pushing(psi, side);
            let found = FixedLine::new(omega).at_polar_angle(polar);
            found.into_iter().map(|(tilt, swing)| (sign, tilt, swing)).collect()
        }
    }
}

/// The shape brought to size; `None` when the whisker is too short for it.
fn scaled(whisker: &Whisker, contact: Vec2, line: Line, side: f64, shape: (f64, Tilt, Swing)) -> Option<Bend> {
    let (sign, tilt, swing) = shape;
    let (x, y) = swing.contact();
    let rate = math::hypot(x, y) / contact.norm();
    let s_a = swing.t / rate;
    // A contact at the very tip must not be lost to rounding.
    if s_a.is_nan() || s_a > whisker.length * (1.0 + 1e-12) {
        return None;
    }
    let s_a = s_a.min(whisker.length);
    let flexural_rigidity = whisker.flexural_rigidity;
    let force = sign * flexural_rigidity * rate * rate;
    let found = Found { flexural_rigidity, force, s_a, side, tilt, swing };
    Some(Bend { contact, ..Bend::new(found, |phi_a| line.beta(phi_a)) })
}

/// The polar angle rises from zero over the first mode; it falls again before the mode ends unless the whisker pulls so
/// hard that the closed loop passes the base on the other side (`beta` below -0.7456).
fn following(tilt: Tilt, polar: f64) -> Vec<(Tilt, Swing)> {
    let pendulum = Pendulum::new(tilt);
    let end = pendulum.half_period();
    let angle = |t: f64| pendulum.at(t).polar_angle();
    // With p the contact seen from the base, dp/dt = (1 - u' y, u' x): the angle turns where u' |p|² = y.
    let turning = |t: f64| {
        let swing = pendulum.at(t);
        let (x, y) = swing.contact();
        swing.du * (x * x + y * y) - y
    };
    let top = root(turning, 0.5 * end, end).unwrap_or(end);
    let rising = root_through(|log_t: f64| math::ln(angle(math::exp(log_t)) / polar), &[-345.0, -3.0, math::ln(top)])
        .map(math::exp);
    let falling = root(|t| angle(t) - polar, top, end).filter(|_| top < end);
    rising.into_iter().chain(falling).map(|t| (tilt, pendulum.at(t))).collect()
}
