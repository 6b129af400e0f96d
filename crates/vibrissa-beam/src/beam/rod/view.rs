//! Shapes and energies of bent rods, from a march that keeps its steps.

use super::super::bend::{Bend, Body, ShapePoint};
use super::super::load::Line;
use super::Rod;
use super::march::{MarchStep, RodState, march};
use super::shot::{Shot, Trial, gap_of};
use crate::plane::Vec2;
use crate::platform::Shared;
use alloc::vec::Vec;

/// Nodes and weights of Gauss's quadrature of order 16 on \[-1, 1\], the positive half.
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_26],
];

/// A rod in equilibrium, ready to be asked anywhere.
pub(in crate::beam) struct BentRod<'a> {
    rod: &'a Rod,
    /// From the contact back to the base, frame of the tangent at the contact.
    loaded: Vec<MarchStep>,
    /// From the contact on to the tip, free.
    free: Vec<MarchStep>,
    phi_a: f64,
    contact: Vec2,
}

impl Rod {
    /// The equilibria that the shots found.
    pub(super) fn bends(&self, shots: Vec<Shot>, line: Line) -> Vec<Bend> {
        if shots.is_empty() {
            return Vec::new();
        }
        let rod = Shared::new(self.clone());
        let bend = |shot: Shot| Bend {
            force: shot.trial.force,
            s_a: shot.trial.s_a,
            phi_a: shot.phi_a,
            beta: line.beta(shot.phi_a),
            contact: shot.contact,
            moment: shot.moment,
            body: Body::Rod(Shared::clone(&rod)),
        };
        shots.into_iter().map(bend).collect()
    }

    /// The rod without load.
    pub(super) fn at_rest(&self, s_a: f64, line: Line) -> Bend {
        let rest = RodState { s: 0.0, phi: 0.0, moment: 0.0, position: Vec2::ZERO };
        let end = march(self, rest, Vec2::ZERO, s_a, |_, _| true).unwrap_or(rest);
        Bend {
            force: 0.0,
            s_a,
            phi_a: end.phi,
            beta: line.beta(end.phi),
            contact: end.position,
            moment: 0.0,
            body: Body::Rod(Shared::new(self.clone())),
        }
    }

    /// The rod in the equilibrium `bend`.
    pub(in crate::beam) fn bent(&self, bend: &Bend) -> BentRod<'_> {
        let trial = Trial { force: bend.force, s_a: bend.s_a, gap: gap_of(bend.beta) };
        let (mut loaded, mut free) = (Vec::new(), Vec::new());
        let _ = march(self, trial.start(), trial.vector(), 0.0, |step, _| {
            loaded.push(*step);
            true
        });
        if bend.s_a < self.length {
            let _ = march(self, trial.start(), Vec2::ZERO, self.length, |step, _| {
                free.push(*step);
                true
            });
        }
        BentRod { rod: self, loaded, free, phi_a: bend.phi_a, contact: bend.contact }
    }
}

impl BentRod<'_> {
    /// The rod at arc length `s` (m); straight before the base and beyond the tip.
    pub(in crate::beam) fn point_at(&self, s: f64) -> ShapePoint {
        let on_rod = s.clamp(0.0, self.rod.length);
        let steps =
            if self.loaded.first().is_none_or(|step| on_rod > step.start.s) { &self.free } else { &self.loaded };
        let Some(step) = steps.iter().find(|step| step.holds(on_rod)).or(steps.last()) else {
            return ShapePoint { position: self.contact, slope: self.phi_a, curvature: 0.0 };
        };
        let state = step.at(on_rod - step.start.s);
        let slope = self.phi_a + state.phi;
        let position = self.contact + state.position.rotated(self.phi_a);
        let beyond = s - on_rod;
        if beyond.abs() > 0.0 {
            return ShapePoint { position: position + beyond * Vec2::from_angle(slope), slope, curvature: 0.0 };
        }
        let curvature = state.moment * self.rod.compliance(on_rod) + self.rod.rest_curvature(on_rod);
        ShapePoint { position, slope, curvature }
    }

    /// `∫ M² / (2 EI) ds`, without the base's share (J).
    pub(in crate::beam) fn energy(&self) -> f64 {
        self.loaded.iter().map(|step| self.rod.strain_energy(step)).sum()
    }
}

impl Rod {
    /// `∫ M² / (2 EI) ds` over a step (J).
    pub(super) fn strain_energy(&self, step: &MarchStep) -> f64 {
        let middle = 0.5 * step.h;
        let at = |tau: f64| {
            let state = step.at(tau);
            state.moment * state.moment * self.compliance_within(step, tau)
        };
        let pairs = GAUSS.iter().map(|[x, w]| w * (at(middle * (1.0 - x)) + at(middle * (1.0 + x))));
        0.5 * middle.abs() * pairs.sum::<f64>()
    }

    /// `1 / EI` inside a step, by the stretch that the step is in.
    fn compliance_within(&self, step: &MarchStep, tau: f64) -> f64 {
        self.piece(step.start.s, step.h < 0.0).compliance(step.start.s + tau)
    }
}
