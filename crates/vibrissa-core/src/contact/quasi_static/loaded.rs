//! The whisker under one force, and its derivatives: from the closed form where there is one, by marches elsewhere.
//!
//! Dimensionless: lengths over the whisker's length L, `q = F L² / EI`, `m = M0 L / EI`. With the contact at `p`, arc
//! length `s` and fixed tilt, the derivatives for a uniform whisker are `dp/ds = (1 - m y, m x)`, `dphi/ds = m` and,
//! because a force only scales the shape, `dp/dq = (s dp/ds - p) / 2q`, `dphi/dq = s m / 2q`; those by the tilt are
//! differences.

use crate::Result;
use crate::beam::{Bend, Rod, Whisker, elastica, normal};
use crate::math;
use crate::plane::Vec2;
use core::f64::consts::PI;

/// Below this force the derivatives by force are replaced by their limits.
const WEAK: f64 = 1e-8;
/// Step of the differences by tilt (rad), and relative step of the others.
const STEP: f64 = 1e-7;
/// Beyond the first mode, with an inflection, shapes are marched up to this force (over `EI / L²`).
const STRONGEST: f64 = 400.0;
/// Points of the rest shape.
const REST_POINTS: usize = 33;

/// A force on the whisker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLoad {
    /// `F L² / EI`; negative would pull the whisker towards the boundary.
    pub q: f64,
    /// Arc length of the contact over L; 1 at the tip.
    pub s: f64,
    /// Tilt from the whisker's normal at the contact (rad); 0 or pi for a side contact without friction.
    pub beta: f64,
}

/// The loaded whisker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadedState {
    /// The contact, whisker frame, over L.
    pub p: Vec2,
    /// Slope at the contact (rad).
    pub slope: f64,
    /// `M0 L / EI`.
    pub m: f64,
}

/// Derivatives of contact and slope.
#[derive(Clone, Copy, Debug)]
pub(super) struct LoadedRate {
    /// Of the contact, whisker frame, over L.
    pub(super) p: Vec2,
    /// Of the slope at the contact.
    pub(super) slope: f64,
}

/// A whisker that can be loaded.
#[derive(Clone, Debug)]
pub struct LoadedWhisker {
    /// Its shape and stiffness.
    pub beam: Whisker,
    rod: Rod,
    uniform: bool,
    /// The whisker without load, whisker frame (m): two points when it is straight.
    pub rest: Vec<Vec2>,
}

impl LoadedWhisker {
    /// The whisker that can be loaded.
    ///
    /// # Errors
    ///
    /// Whiskers that make no sense, see [`Rod::new`].
    pub fn new(beam: &Whisker) -> Result<Self> {
        let rod = Rod::new(beam)?;
        let mut flex =
            Self { beam: *beam, rod, uniform: beam.is_uniform(), rest: vec![Vec2::ZERO, Vec2::new(beam.length, 0.0)] };
        if beam.curvature.abs() > 0.0
            && let Some(bend) = flex.bend(PointLoad { q: 0.0, s: 1.0, beta: 0.0 })
        {
            flex.rest = bend.shape(beam.length, REST_POINTS);
        }
        Ok(flex)
    }

    /// How small a residual rounding leaves.
    pub(super) fn accuracy(&self) -> f64 {
        if self.uniform { 1e-11 } else { 1e-9 }
    }

    /// `EI / L²` (N).
    #[must_use]
    pub fn unit(&self) -> f64 {
        self.beam.flexural_rigidity / (self.beam.length * self.beam.length)
    }

    /// The whisker in full; none where the closed form ends.
    #[must_use]
    pub fn bend(&self, load: PointLoad) -> Option<Bend> {
        let (force, s_a) = (load.q * self.unit(), load.s * self.beam.length);
        if self.uniform
            && let Some(bend) = elastica::bend(self.beam.flexural_rigidity, force, s_a, load.beta)
        {
            return Some(bend);
        }
        (load.q < STRONGEST).then(|| self.rod.pushed(force, s_a, load.beta)).flatten()
    }

    /// Contact, slope and moment.
    #[must_use]
    pub fn at(&self, load: PointLoad) -> Option<LoadedState> {
        if self.uniform
            && let Some(state) = Self::closed_form(load)
        {
            return Some(state);
        }
        if load.q > STRONGEST {
            return None;
        }
        let (force, s_a) = (load.q * self.unit(), load.s * self.beam.length);
        let (contact, slope, moment) = self.rod.contact_under(force, s_a, load.beta)?;
        let scale = 1.0 / self.beam.length;
        Some(LoadedState { p: contact * scale, slope, m: moment * scale / self.unit() })
    }

    /// The same for the uniform whisker, within the first mode.
    fn closed_form(load: PointLoad) -> Option<LoadedState> {
        let straight = load.beta.abs() <= 0.0;
        if straight || (load.beta - PI).abs() <= 0.0 {
            let bend = normal::by_force(1.0, if straight { load.q } else { -load.q }, load.s)?;
            return Some(LoadedState { p: bend.contact, slope: bend.phi_a, m: bend.moment });
        }
        let bend = elastica::bend(1.0, load.q, load.s, load.beta)?;
        Some(LoadedState { p: bend.contact, slope: bend.phi_a, m: bend.moment })
    }

    /// The side contact at `p` without friction where the closed form has it, nearest to the given slope.
    pub(super) fn touched_at(&self, p: Vec2, slope: f64) -> Option<Option<(PointLoad, LoadedState)>> {
        if !self.uniform {
            return None;
        }
        let found = [normal::Branch::Least, normal::Branch::Curled]
            .into_iter()
            // A contact beyond the tip must be seen to be there.
            .filter_map(|branch| normal::by_point(1.0, 2.0, p, branch))
            .min_by(|a, b| (a.phi_a - slope).abs().total_cmp(&(b.phi_a - slope).abs()));
        Some(found.map(|bend| {
            let load = PointLoad { q: bend.force, s: bend.s_a, beta: 0.0 };
            (load, LoadedState { p: bend.contact, slope: bend.phi_a, m: bend.moment })
        }))
    }

    /// Derivatives by the force.
    pub(super) fn by_force(&self, load: PointLoad, here: &LoadedState) -> Option<LoadedRate> {
        if !self.uniform {
            let step = STEP * (1.0 + load.q.abs());
            return self.difference(here, PointLoad { q: load.q + step, ..load }, step);
        }
        let PointLoad { q, s, beta } = load;
        if (q * s * s).abs() < WEAK {
            let across = math::cos(beta);
            return Some(LoadedRate { p: Vec2::new(0.0, across * s * s * s / 3.0), slope: 0.5 * across * s * s });
        }
        let longer = Self::longer(here);
        Some(LoadedRate { p: (longer.p * s - here.p) * (0.5 / q), slope: 0.5 * s * here.m / q })
    }

    /// Derivatives by the arc length.
    pub(super) fn by_arc_length(&self, load: PointLoad, here: &LoadedState) -> Option<LoadedRate> {
        if !self.uniform {
            return self.difference(here, PointLoad { s: load.s - STEP, ..load }, -STEP);
        }
        Some(Self::longer(here))
    }

    /// Derivatives by the tilt.
    pub(super) fn by_tilt(&self, load: PointLoad, here: &LoadedState) -> Option<LoadedRate> {
        self.difference(here, PointLoad { beta: load.beta + STEP, ..load }, STEP)
    }

    fn longer(here: &LoadedState) -> LoadedRate {
        LoadedRate { p: Vec2::new(1.0 - here.m * here.p.y, here.m * here.p.x), slope: here.m }
    }

    fn difference(&self, here: &LoadedState, load: PointLoad, step: f64) -> Option<LoadedRate> {
        let there = self.at(load)?;
        Some(LoadedRate { p: (there.p - here.p) * (1.0 / step), slope: (there.slope - here.slope) / step })
    }
}
