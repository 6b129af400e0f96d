//! Jacobi elliptic functions of a real argument over one half period, and their inverse.

use crate::math;
use core::f64::consts::PI;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Most levels that the arithmetic-geometric mean takes: 8 at k' = 1e-16, 18 at k' = 1e-140.
const LEVELS: usize = 24;

/// One level of the arithmetic-geometric mean.
#[derive(Clone, Copy, Debug, Default)]
struct Level {
    /// Arithmetic mean.
    a: f64,
    /// Geometric mean.
    g: f64,
    /// `a - g`, kept apart because it would cancel.
    gap: f64,
}

/// The functions of one parameter, with the table that all of them share.
///
/// Everything comes from one descending Landen ladder in the scaled tangent `T = sn / (a cn)`, in which no step subtracts:
/// `T_n = T_{n+1} sqrt((1 + a² T²) / (1 + g² T²))` with `a, g, T` of level `n + 1`.
#[derive(Clone, Copy, Debug)]
pub struct Jacobi {
    m: f64,
    m1: f64,
    levels: [Level; LEVELS],
    last: usize,
}

/// The functions at one argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elliptic {
    /// sn(t | m).
    pub sn: f64,
    /// cn(t | m).
    pub cn: f64,
    /// dn(t | m).
    pub dn: f64,
    /// `1 - cn`, without cancellation.
    pub one_minus_cn: f64,
    /// `m ∫0^t cn² = E(t) - (1 - m) t`, where `E(t) = ∫0^t dn²` is Jacobi's epsilon function.
    pub m_cn2_integral: f64,
}

impl Jacobi {
    /// The functions of parameter `m = k²` in \[0, 1), given with its complement `m1 = 1 - m` so that neither end loses digits.
    #[must_use]
    pub fn new(m: f64, m1: f64) -> Self {
        let m1 = m1.max(1e-280);
        let mut levels = [Level::default(); LEVELS];
        let g = m1.sqrt();
        let mut level = Level { a: 1.0, g, gap: m / (1.0 + g) };
        let mut last = 0;
        for (i, slot) in levels.iter_mut().enumerate() {
            *slot = level;
            last = i;
            if level.gap <= 1e-17 * level.a {
                break;
            }
            let roots = level.a.sqrt() + level.g.sqrt();
            level = Level {
                a: 0.5 * (level.a + level.g),
                g: (level.a * level.g).sqrt(),
                gap: 0.5 * (level.gap / roots) * (level.gap / roots),
            };
        }
        Self { m, m1, levels, last }
    }

    /// The parameter m.
    #[must_use]
    pub fn m(&self) -> f64 {
        self.m
    }

    /// The complementary parameter 1 - m.
    #[must_use]
    pub fn m1(&self) -> f64 {
        self.m1
    }

    /// The quarter period K(m).
    #[must_use]
    pub fn quarter_period(&self) -> f64 {
        0.5 * PI / self.levels[self.last].a
    }

    /// The half period `2 K` with `m ∫0^2K cn²`, which takes no more than the means.
    pub(super) fn half_period_integral(&self) -> (f64, f64) {
        let t = 2.0 * self.quarter_period();
        let each = self.levels[..self.last].iter().rev();
        (t, each.fold(0.0, |integral, upper| 2.0 * integral + upper.gap * upper.g * t))
    }

    /// The functions at `t` in \[0, 2 K\], to a few units in the last place.
    #[must_use]
    pub fn at(&self, t: f64) -> Elliptic {
        let a = self.levels[self.last].a;
        let sign = if a * t <= 0.5 * PI { 1.0 } else { -1.0 };
        let mut tangent = math::tan(a * t).abs() / a;
        let mut integral = 0.0;
        for n in (0..self.last).rev() {
            let (upper, lower) = (self.levels[n], self.levels[n + 1]);
            let (at, gt) = (lower.a * tangent, lower.g * tangent);
            tangent *= (1.0 + at * at).sqrt() / (1.0 + gt * gt).sqrt();
            let sn_lower = at / (1.0 + at * at).sqrt();
            let ut = upper.a * tangent;
            let cn_upper = sign / (1.0 + ut * ut).sqrt();
            integral = 2.0 * integral + upper.gap * (upper.g * t + sn_lower * cn_upper);
        }
        // Tangents of doubles are far from where squares overflow.
        let h = (1.0 + tangent * tangent).sqrt();
        let (sn, cn) = (tangent / h, sign / h);
        let dn = (1.0 + self.m1 * tangent * tangent).sqrt() / h;
        let one_minus_cn = if sign > 0.0 { sn * sn / (1.0 + cn) } else { 1.0 - cn };
        Elliptic { sn, cn, dn, one_minus_cn, m_cn2_integral: integral }
    }

    /// The argument in \[0, K\] at which `sn / cn` is `tangent >= 0`.
    #[must_use]
    pub fn inverse_tangent(&self, tangent: f64) -> f64 {
        let mut t = tangent.min(1e140);
        for level in self.levels.iter().take(self.last + 1).skip(1) {
            let gt = level.g * t;
            let b = 1.0 - gt * gt;
            let r = math::hypot(b, 2.0 * level.a * t);
            t = if b > 0.0 { t * (2.0 / (b + r)).sqrt() } else { (0.5 * (r - b)).sqrt() / level.a };
        }
        let a = self.levels[self.last].a;
        math::atan(a * t) / a
    }
}
