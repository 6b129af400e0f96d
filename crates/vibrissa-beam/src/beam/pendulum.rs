//! The pendulum that Kirchhoff found in the elastica: the loaded part of a whisker, made dimensionless.
//!
//! Let arc length run backwards from the contact, `t = (s_a - s) sqrt(|F| / EI)`, and let `u(t) >= 0` be the slope at the
//! contact less the slope at `t`. Then `w = u + beta` is a pendulum let go at rest, `w'' = cos w`, and with
//! `m = (1 - sin beta)/2`, `k k' = cos(beta)/2` and elliptic functions of `(t | m)`
//!
//! | quantity | closed form |
//! | --- | --- |
//! | `u` | `2 atan2(k k' (1 - cn), 1 - m + m cn)` |
//! | `u'` (curvature) | `cos(beta) sn/dn` |
//! | `∫0^t cos w` | `u'` |
//! | `∫0^t sin w` | `2 E(t) - t - 2 m sn cn/dn` |
//!
//! The first mode, without an inflection between base and contact, is half a swing: `0 <= t <= 2 K(m)`.

use super::jacobi::Jacobi;
use crate::math;
use core::f64::consts::PI;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Below this argument the power series replaces the closed form, whose integrals cancel there.
const SERIES_BELOW: f64 = 0.25;
/// Terms of the series; the nearest singularity is never nearer than `|t| = pi/2`, so the last term is below 1e-18.
const TERMS: usize = 12;

/// A load's tilt, canonical: the deflection is positive and `cos(beta) >= 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tilt {
    /// sin(beta).
    pub(super) sin: f64,
    /// cos(beta), not negative.
    pub(super) cos: f64,
    m: f64,
    m1: f64,
}

impl Tilt {
    /// The tilt with these sine and cosine.
    pub(super) fn new(sin: f64, cos: f64) -> Self {
        let major = 0.5 * (1.0 + sin.abs());
        let minor = 0.25 * cos * cos / major;
        let (m, m1) = if sin > 0.0 { (minor, major) } else { (major, minor) };
        Self { sin, cos, m, m1 }
    }

    /// The tilt `beta = gap - pi/2`, exact where the force all but pulls along the whisker.
    pub(super) fn from_gap(gap: f64) -> Self {
        let (half_sin, half_cos) = math::sin_cos(0.5 * gap);
        let (sin, cos) = math::sin_cos(gap);
        Self { sin: -cos, cos: sin, m: half_cos * half_cos, m1: half_sin * half_sin }
    }
}

/// The dimensionless whisker at one argument, deflection positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Swing {
    /// The argument: arc length from the contact back, times `sqrt(|F|/EI)`.
    pub(super) t: f64,
    /// Slope at the contact less the slope at `t` (rad).
    pub(super) u: f64,
    /// The derivative of `u`: dimensionless curvature and moment at `t`.
    pub(super) du: f64,
    /// `∫0^t cos u`: how far the contact lies ahead of `t`, along the tangent at the contact.
    pub(super) along: f64,
    /// `∫0^t sin u`: how far it lies to the right, across that tangent.
    pub(super) across: f64,
    /// `∫0^t u'²/2`: dimensionless energy.
    pub(super) energy: f64,
}

impl Swing {
    /// The contact seen from the base, when the base is at this argument.
    pub(super) fn contact(&self) -> (f64, f64) {
        let (sin, cos) = math::sin_cos(self.u);
        (self.along * cos + self.across * sin, self.along * sin - self.across * cos)
    }

    /// The polar angle of the contact seen from the base, in \[0, 2 pi).
    pub(super) fn polar_angle(&self) -> f64 {
        let (x, y) = self.contact();
        let angle = math::atan2(y, x);
        if angle < 0.0 { angle + 2.0 * PI } else { angle }
    }
}

/// A tilt with the elliptic functions that belong to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pendulum {
    pub(super) tilt: Tilt,
    jacobi: Jacobi,
}

impl Pendulum {
    pub(super) fn new(tilt: Tilt) -> Self {
        Self { tilt, jacobi: Jacobi::new(tilt.m, tilt.m1) }
    }

    /// The end of the first mode, `2 K(m)`.
    pub(super) fn half_period(&self) -> f64 {
        2.0 * self.jacobi.quarter_period()
    }

    /// The whisker at `t` in \[0, 2 K\].
    pub(super) fn at(&self, t: f64) -> Swing {
        if t < SERIES_BELOW { series(self.tilt, t) } else { self.closed_form(t) }
    }

    /// The whisker at `t` in \[0, 4 K\]: beyond the first mode the pendulum swings back as it came.
    pub(super) fn over_a_period(&self, t: f64) -> Swing {
        if t <= self.half_period() {
            return self.at(t);
        }
        let Tilt { sin, cos, .. } = self.tilt;
        let (back, turn) = (self.at(2.0 * self.half_period() - t), self.turn());
        let (du, energy) = (-back.du, 2.0 * turn.energy - back.energy);
        let sin_integral = energy + sin * t;
        Swing { t, u: back.u, du, along: cos * du + sin * sin_integral, across: cos * sin_integral - sin * du, energy }
    }

    /// The whisker at the end of the first mode, where it stands still.
    pub(super) fn turn(&self) -> Swing {
        let Tilt { sin, cos, .. } = self.tilt;
        let (t, integral) = self.jacobi.half_period_integral();
        let energy = 2.0 * integral;
        let sin_integral = energy + sin * t;
        Swing {
            t,
            u: 2.0 * math::atan2(cos, sin),
            du: 0.0,
            along: sin * sin_integral,
            across: cos * sin_integral,
            energy,
        }
    }

    fn closed_form(&self, t: f64) -> Swing {
        let Tilt { sin, cos, m, m1 } = self.tilt;
        let e = self.jacobi.at(t);
        let u = 2.0 * math::atan2(0.5 * cos * e.one_minus_cn, m1 + m * e.cn);
        let du = cos * e.sn / e.dn;
        let energy = 2.0 * (e.m_cn2_integral - m * e.sn * e.cn / e.dn);
        let sin_integral = energy + sin * t;
        Swing { t, u, du, along: cos * du + sin * sin_integral, across: cos * sin_integral - sin * du, energy }
    }

    /// The first argument at which the slope difference is `u` in \[0, pi - 2 beta\]; the inverse of `at(t).u`.
    pub(super) fn time_of(&self, u: f64) -> f64 {
        let Tilt { cos, m, m1, .. } = self.tilt;
        let (s, c) = math::sin_cos(0.5 * u);
        let numerator = 0.5 * cos * c - s * m1;
        let denominator = 0.5 * cos * c + s * m;
        let one_minus_cn = s / denominator;
        let sn = (one_minus_cn * (2.0 - one_minus_cn)).max(0.0).sqrt();
        let cn = numerator / denominator;
        let t = self.jacobi.inverse_tangent(sn / cn.abs());
        if cn < 0.0 { self.half_period() - t } else { t }
    }
}

/// The whisker near the contact, by the power series of the pendulum in `t²`.
fn series(tilt: Tilt, t: f64) -> Swing {
    let mut a = [0.0; TERMS];
    let mut cos_u = [0.0; TERMS];
    let mut sin_u = [0.0; TERMS];
    cos_u[0] = 1.0;
    for j in 1..TERMS {
        let n = 2.0 * j as f64;
        a[j] = (tilt.cos * cos_u[j - 1] - tilt.sin * sin_u[j - 1]) / (n * (n - 1.0));
        let (mut c, mut s) = (0.0, 0.0);
        for i in 1..=j {
            c -= i as f64 * a[i] * sin_u[j - i];
            s += i as f64 * a[i] * cos_u[j - i];
        }
        cos_u[j] = c / j as f64;
        sin_u[j] = s / j as f64;
    }
    let q = t * t;
    let (mut u, mut du, mut lag, mut across) = (0.0, 0.0, 0.0, 0.0);
    for j in (1..TERMS).rev() {
        let n = 2.0 * j as f64;
        u = u * q + a[j];
        du = du * q + n * a[j];
        lag = lag * q - cos_u[j] / (n + 1.0);
        across = across * q + sin_u[j] / (n + 1.0);
    }
    let (u, du, lag, across) = (u * q, du * t, lag * q * t, across * q * t);
    Swing { t, u, du, along: t - lag, across, energy: tilt.cos * across - tilt.sin * lag }
}
