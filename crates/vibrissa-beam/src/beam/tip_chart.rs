//! The loaded tip as a smooth function of two numbers, with its first derivatives: the chart in which estimators move.
//!
//! With the force at the tip, dimensionless force `q = F L² / EI` and tilt `beta` name the equilibrium. In the pendulum's
//! terms (`w = u + beta`, `C = ∫cos w = w'`, `S = ∫sin w`, `e = ∫ w'²/2 = S - t sin beta`) the derivatives by the tilt are
//! closed, too, since `2 cos w + w' e` solves the linearised pendulum `v'' = -sin(w) v`:
//!
//! | derivative by beta of | closed form |
//! | --- | --- |
//! | `w` | `v = (2 cos w + w' e) / (2 cos beta)` |
//! | `C` | `v' = (e cos w - w' (sin w + sin beta)) / (2 cos beta)` |
//! | `S` | `(t - S sin beta + w' cos w + e sin w) / (2 cos beta)` |

use super::elastica::canonical;
use super::pendulum::Pendulum;
use crate::math;
use crate::plane::Vec2;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Below this size of force the power series to second order stands in (its error is below 1e-11).
const WEAK: f64 = 1e-4;

/// How a tip changes with one of its two numbers, lengths over L.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TipRate {
    /// Of the tip's place over the length.
    pub position: Vec2,
    /// Of the slope at the tip (rad).
    pub slope: f64,
    /// Of the dimensionless base moment.
    pub moment: f64,
}

/// A uniform, straight, clamped whisker under a force at its tip, lengths over L.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipChart {
    /// The tip over the whisker's length, whisker frame.
    pub position: Vec2,
    /// Slope at the tip (rad), counter-clockwise.
    pub slope: f64,
    /// The dimensionless base moment `M0 L / EI`, counter-clockwise positive.
    pub moment: f64,
    /// Derivatives by the dimensionless force.
    pub by_force: TipRate,
    /// Derivatives by the tilt (1/rad).
    pub by_tilt: TipRate,
}

/// The whisker under the dimensionless force `q = F L² / EI` at its tip, tilted by `beta` (rad) from the tip's normal.
///
/// Negative forces pull the other way along the same line; the chart is smooth through zero. Accuracy about 1e-11. None
/// beyond the first mode, where `cos(beta)` vanishes, and for what is not finite.
#[must_use]
pub fn tip_chart(q: f64, beta: f64) -> Option<TipChart> {
    within(q, beta, 1.0)
}

/// The same up to the second mode, where the whisker has an inflection: a tip that cannot slide, in a corner, holds such shapes.
#[must_use]
pub fn held_tip_chart(q: f64, beta: f64) -> Option<TipChart> {
    within(q, beta, 2.0)
}

/// The chart up to so many half swings of the pendulum, each a mode.
fn within(q: f64, beta: f64, modes: f64) -> Option<TipChart> {
    if q.abs() < WEAK {
        return beta.is_finite().then(|| weak(q, beta));
    }
    let (side, tilt) = canonical(q, beta);
    let (sin, cos) = (tilt.sin, tilt.cos);
    let t = q.abs().sqrt();
    let pendulum = Pendulum::new(tilt);
    if !(t <= modes * pendulum.half_period() && cos > 1e-9) {
        return None;
    }
    let swing = pendulum.over_a_period(t);
    let (du, e) = (swing.du, swing.energy);
    let (sin_u, cos_u) = math::sin_cos(swing.u);
    let (sin_w, cos_w) = (sin_u * cos + cos_u * sin, cos_u * cos - sin_u * sin);
    let s = e + t * sin;
    let (half, per) = (0.5 / cos, 1.0 / t);
    let v = (2.0 * cos_w + du * e) * half;
    let c_beta = (e * cos_w - du * (sin_w + sin)) * half;
    let s_beta = (t - s * sin + du * cos_w + e * sin_w) * half;
    let (x, y) = ((du * cos_w + s * sin_w) * per, (du * sin_w - s * cos_w) * per);
    let moment = t * du;
    let by_t = 0.5 * (du + t * cos_w) * per;
    let size = 0.5 / q.abs();
    let sign = side * 1.0_f64.copysign(q);
    let to = |x: f64, y: f64| Vec2::new(x, y);
    Some(TipChart {
        position: to(x, side * y),
        slope: side * swing.u,
        moment: side * moment,
        by_force: TipRate {
            position: to(1.0 - x - moment * y, side * (moment * x - y)) * (size * 1.0_f64.copysign(q)),
            slope: sign * moment * size,
            moment: sign * by_t,
        },
        by_tilt: TipRate {
            position: to(
                side * (-v * y + (c_beta * cos_w + s_beta * sin_w) * per),
                v * x + (c_beta * sin_w - s_beta * cos_w) * per,
            ),
            slope: v - 1.0,
            moment: t * c_beta,
        },
    })
}

/// The series around the straight whisker, to second order in the force.
fn weak(q: f64, beta: f64) -> TipChart {
    let (s, c) = math::sin_cos(beta);
    TipChart {
        position: Vec2::new(1.0 - q * q * c * c / 15.0, q * c * (1.0 / 3.0 - q * s / 30.0)),
        slope: q * c * (0.5 - q * s / 24.0),
        moment: q * c * (1.0 - q * s / 6.0),
        by_force: TipRate {
            position: Vec2::new(-2.0 * q * c * c / 15.0, c * (1.0 / 3.0 - q * s / 15.0)),
            slope: c * (0.5 - q * s / 12.0),
            moment: c * (1.0 - q * s / 3.0),
        },
        by_tilt: TipRate {
            position: Vec2::new(2.0 * q * q * s * c / 15.0, -q * s / 3.0 - q * q * (c * c - s * s) / 30.0),
            slope: -0.5 * q * s - q * q * (c * c - s * s) / 24.0,
            moment: -q * s - q * q * (c * c - s * s) / 6.0,
        },
    }
}
