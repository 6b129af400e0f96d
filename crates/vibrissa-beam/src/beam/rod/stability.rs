//! Whether an equilibrium of a rod may be observed: conjugate points of the second variation of its energy.
//!
//! A contact pushes the rod with the force `R`; the second variation of the energy is `∫ EI psi'² + (R · t) psi² ds` over all
//! changes `psi` of the slope that vanish at the base and that the hold allows. With changes that vanish up to the arc length
//! `sigma`, too, it has a zero where the linearised equations, started at the contact, leave slope and place at `sigma` as
//! they are \[manning2013catalogue\]; each such place between base and contact is a direction in which the energy falls.

use super::Rod;
use crate::math;
use crate::plane::Vec2;
use core::f64::consts::FRAC_PI_2;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Longest step as a phase `∫ sqrt(|R|/EI) ds` (rad), and as a share of the contact's arc length and of the rod's radius.
const PHASE: f64 = 0.3;
const SHARE: f64 = 0.12;
const TAPER: f64 = 0.3;
/// No conjugate point lies within this phase of the contact (rad): the least one is at a right angle.
const FIRST: f64 = 0.8;
/// More steps than any load that a table reaches takes.
const MOST_STEPS: usize = 20_000;

/// What a contact leaves the rod free to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::beam) enum Hold {
    /// The tip stays where it is.
    PinnedTip,
    /// The tip slides without friction on a boundary of this curvature towards free space (1/m).
    SlidingTip(f64),
    /// The side stays where it is, and keeps its slope.
    ClampedSide,
    /// The side slides along itself without friction, with this curvature (1/m): any boundary lets it.
    SlidingSide(f64),
}

/// A rod's state and three solutions of the linearised equations: slope, moment, place.
type Varied = ([f64; 2], [[f64; 4]; 3]);

impl Rod {
    /// Whether the rod under `force` (N) at `s_a` (m), tilted by `beta` (rad) from its normal there, lets its energy fall though
    /// it is held so, and keeps its shape up to `kept` (m).
    pub(in crate::beam) fn is_unstable(&self, (force, s_a, beta): (f64, f64, f64), hold: Hold, kept: f64) -> bool {
        let push = Vec2::from_angle(beta + FRAC_PI_2) * force;
        let normal = Vec2::from_angle(beta + FRAC_PI_2) * force.signum();
        let along = Vec2::new(normal.y, -normal.x);
        let forces = match hold {
            Hold::PinnedTip | Hold::ClampedSide => [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)],
            Hold::SlidingTip(c) => [Vec2::ZERO, normal, along * (-c * force.abs())],
            // What slides also turns: the couple that keeps its slope is in balance with a force along it.
            Hold::SlidingSide(c) => [along * -c, normal, along * (-c * force.abs())],
        };
        let mut all: Varied = ([0.0; 2], [[0.0; 4]; 3]);
        match hold {
            Hold::PinnedTip | Hold::SlidingTip(_) => all.1[0][0] = 1.0,
            Hold::ClampedSide | Hold::SlidingSide(_) => all.1[0][1] = 1.0,
        }
        if let Hold::SlidingTip(_) | Hold::SlidingSide(_) = hold {
            (all.1[2][2], all.1[2][3]) = (along.x, along.y);
        }
        if let Hold::SlidingSide(c) = hold {
            all.1[2][0] = c;
        }
        let (mut s, mut phase, mut sign) = (s_a, 0.0, 0.0);
        for _ in 0..MOST_STEPS {
            let h = self.varied_step(s, s_a, force.abs());
            let compliances = self.compliances(s, h);
            all = stepped(
                &all,
                -h,
                |share| (compliances[share], self.rest_curvature(s - 0.5 * h * share as f64)),
                (push, &forces),
            );
            phase += h * (force.abs() * compliances[1]).sqrt();
            s -= h;
            if s <= kept {
                return false;
            }
            let here = determinant(&all.1);
            if phase > FIRST {
                if sign * here < 0.0 {
                    return true;
                }
                sign = here.signum();
            }
        }
        false
    }

    /// A step from `s` towards the base that stays within one wire (m).
    fn varied_step(&self, s: f64, s_a: f64, force: f64) -> f64 {
        let piece = self.piece(s, true);
        let start = self.piece_start(s).max(0.0);
        let of = |s: f64| {
            let radius = piece.radius(s);
            let phase = PHASE / (force * piece.compliance(s)).sqrt().max(1e-300);
            let taper = TAPER * radius / piece.narrowing.abs().max(1e-300);
            phase.min(taper).min(SHARE * s_a)
        };
        let h = of(s).min(s - start);
        let h = h.min(of(s - h)).max(1e-6 * s_a);
        // To the joint exactly.
        if s - h - start < 1e-9 * s_a { s - start } else { h }
    }

    /// `1 / EI` at `s`, in the middle of a step towards the base and at its end (1/(N m²)).
    fn compliances(&self, s: f64, h: f64) -> [f64; 3] {
        let piece = self.piece(s, true);
        [0.0, 0.5, 1.0].map(|share| piece.compliance(s - share * h))
    }
}

/// One step of the classical Runge-Kutta method; `rod` has compliance and rest curvature after so many half steps.
fn stepped(from: &Varied, h: f64, rod: impl Fn(usize) -> (f64, f64), (push, forces): (Vec2, &[Vec2; 3])) -> Varied {
    let rate = |([phi, moment], varied): &Varied, at: usize| -> Varied {
        let (compliance, rest) = rod(at);
        let (sin, cos) = math::sin_cos(*phi);
        let with = |d: &[f64; 4], force: Vec2| {
            let turned = (push.x * cos + push.y * sin) * d[0];
            [compliance * d[1], force.x * sin - force.y * cos + turned, -sin * d[0], cos * d[0]]
        };
        let own = [compliance * moment + rest, push.x * sin - push.y * cos];
        (own, [0, 1, 2].map(|k| with(&varied[k], forces[k])))
    };
    let ahead = |by: &Varied, h: f64| -> Varied {
        let own = [0, 1].map(|i| from.0[i] + h * by.0[i]);
        (own, [0, 1, 2].map(|k| [0, 1, 2, 3].map(|i| from.1[k][i] + h * by.1[k][i])))
    };
    let a = rate(from, 0);
    let b = rate(&ahead(&a, 0.5 * h), 1);
    let c = rate(&ahead(&b, 0.5 * h), 1);
    let d = rate(&ahead(&c, h), 2);
    let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * (b + c) + d) / 6.0;
    let own = [0, 1].map(|i| mean(a.0[i], b.0[i], c.0[i], d.0[i]));
    let varied = [0, 1, 2].map(|k| [0, 1, 2, 3].map(|i| mean(a.1[k][i], b.1[k][i], c.1[k][i], d.1[k][i])));
    ahead(&(own, varied), h)
}

/// How slope and place change together.
fn determinant(v: &[[f64; 4]; 3]) -> f64 {
    let row = |i: usize| [v[0][i], v[1][i], v[2][i]];
    let ([a, b, c], [d, e, f], [g, h, i]) = (row(0), row(2), row(3));
    a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
}
