//! Rods for tests: random whiskers and loads, and the physics of a rod told to an oracle.
#![allow(dead_code, reason = "not every test asks for all of it")]

use super::extrapolation::integrate;
use super::random::Random;
use std::f64::consts::PI;
use vibrissa_beam::beam::{Bend, Load, Whisker};
use vibrissa_beam::plane::Vec2;

pub(crate) const EI: f64 = 2.8886e-4;

/// The physics of a rod, told to the oracle and to the library apart.
pub(crate) struct Wire {
    pub(crate) length: f64,
    /// Joints and, in between, base rigidity and narrowing.
    pub(crate) stretches: Vec<(f64, f64, f64)>,
    pub(crate) curvature: Vec<f64>,
    pub(crate) base_compliance: f64,
}

impl Wire {
    pub(crate) fn whisker(w: &Whisker) -> Self {
        Self {
            length: w.length,
            stretches: vec![(w.length, w.flexural_rigidity, (1.0 - w.tip_ratio) / w.length)],
            curvature: vec![w.curvature],
            base_compliance: 1.0 / w.base_stiffness,
        }
    }

    /// How far the equilibrium misses when integrated from the base, relative to how far it bends.
    pub(crate) fn miss(&self, b: &Bend) -> f64 {
        let force = b.force_vector();
        let mut state = [self.base_compliance * b.moment, 0.0, 0.0];
        let mut s = 0.0;
        for &(end, rigidity, narrowing) in &self.stretches {
            let end = end.min(b.s_a);
            if end <= s {
                break;
            }
            let rhs = |s: f64, v: [f64; 3]| {
                let lever = b.contact - Vec2::new(v[1], v[2]);
                let kappa = self.curvature.iter().rev().fold(0.0, |sum, c| sum * s + c);
                [lever.cross(force) / (rigidity * (1.0 - narrowing * s).powi(4)) + kappa, v[0].cos(), v[0].sin()]
            };
            state = integrate(&rhs, state, s, end, 32);
            s = end;
        }
        let [phi, x, y] = state;
        ((phi - b.phi_a) / b.phi_a.abs().clamp(1e-12, 1.0))
            .abs()
            .max((x - b.contact.x).abs() / b.s_a)
            .max((y - b.contact.y).abs() / b.s_a / b.phi_a.abs().clamp(1e-12, 1.0))
    }
}

pub(crate) fn random_whisker(random: &mut Random) -> Whisker {
    let tip_ratio = if random.unit() < 0.3 { 1.0 } else { random.between(0.05, 1.0) };
    let curvature = if random.unit() < 0.3 { 0.0 } else { random.between(-12.0, 12.0) };
    let base_stiffness = if random.unit() < 0.3 { f64::INFINITY } else { 10f64.powf(random.between(-2.0, 1.0)) };
    Whisker { tip_ratio, curvature, base_stiffness, flexural_rigidity: EI, ..Whisker::default() }
}

pub(crate) fn random_load(random: &mut Random, i: usize) -> Load {
    match i % 4 {
        0 => Load::Normal,
        1 => Load::Vertical,
        2 => Load::Tilted(random.between(-PI, PI)),
        _ => Load::Directed(random.between(-PI, PI)),
    }
}

pub(crate) fn balanced(b: &Bend) -> bool {
    (b.moment - b.contact.cross(b.force_vector())).abs() <= 1e-9 * b.force.abs() * b.s_a
}

/// The small-angle slope per force of a tapered whisker, by its own quadrature: the scale of forces.
pub(crate) fn softness(w: &Whisker, s_a: f64) -> f64 {
    let g = (1.0 - w.tip_ratio) / w.length;
    let at = |s: f64| (s_a - s) / (w.flexural_rigidity * (1.0 - g * s).powi(4));
    (0..2000).map(|i| at(s_a * (i as f64 + 0.5) / 2000.0)).sum::<f64>() * s_a / 2000.0
}
