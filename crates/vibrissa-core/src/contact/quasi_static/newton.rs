//! The whisker in contact at one place: Newton's method on its response.

use super::loaded::{LoadedRate, LoadedState, LoadedWhisker, PointLoad};
use crate::contact::{Boundaries, Push, Stance};
use crate::linear_algebra::determinant;
use crate::math;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::Map;

/// Newton steps before it is given up.
const MOST_STEPS: usize = 40;
/// The same for a contact whose place is given: what sticks is found at once or not at all.
const MOST_STEPS_AT_PLACE: usize = 20;
/// Residual (whisker lengths, rad) at which an equilibrium is found.
const FOUND: f64 = 2e-13;
/// Largest change of the tilt in one Newton step (rad).
const LARGEST_TURN: f64 = 0.3;
/// Largest change of the arc length in one Newton step, over L.
const LARGEST_SHIFT: f64 = 0.1;

/// One whisker on its base: what all equilibria share.
#[derive(Clone, Copy, Debug)]
pub struct WhiskerOnMap<'a> {
    /// The map.
    pub map: &'a Map,
    /// Its boundaries.
    pub boundaries: &'a Boundaries,
    /// The whisker.
    pub whisker: &'a LoadedWhisker,
    /// Where its base stands.
    pub stance: Stance,
}

/// What must hold on a piece of a boundary besides the contact being there.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    /// The tip slides: the force is this far off the normal (rad).
    Slide { offset: f64 },
    /// The side slides along the piece, tangent to it and pushed this way; the load's tilt stays as it is.
    Flank { push: Push },
    /// The side rolls on the piece: arc lengths along whisker and piece change together from these values on.
    Roll { push: Push, s: f64, at: f64 },
}

/// Where Newton's method on a piece ended.
pub(super) enum PieceSolution {
    /// An equilibrium, maybe on the continuation of the piece; stable when the flag is set.
    Found { load: PointLoad, state: LoadedState, at: f64, stable: bool },
    /// The place left the piece before an equilibrium was found.
    Lost(f64),
    /// No equilibrium near.
    Failed,
}

/// Which of two unknowns joins the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unknown {
    Tilt,
    ArcLength,
}

impl<'a> WhiskerOnMap<'a> {
    /// The whisker with its base at this pose.
    #[must_use]
    pub fn new(map: &'a Map, boundaries: &'a Boundaries, whisker: &'a LoadedWhisker, map_from_whisker: Pose2) -> Self {
        Self { map, boundaries, whisker, stance: Stance::new(map_from_whisker, whisker.beam.length) }
    }

    /// The direction of a force on the whisker (rad, map frame).
    #[must_use]
    pub fn direction(&self, load: PointLoad, state: &LoadedState) -> f64 {
        wrap_angle(self.stance.direction(state.slope, load.beta))
    }

    /// The contact, map frame (m).
    #[must_use]
    pub fn place(&self, state: &LoadedState) -> Vec2 {
        self.stance.map_from_whisker().transform_point(state.p * self.whisker.beam.length)
    }

    /// The equilibrium on a piece under this rule, from this load and parameter on.
    pub(super) fn on_piece(&self, rule: Rule, mut load: PointLoad, (piece, mut at): (u32, f64)) -> PieceSolution {
        let here = self.boundaries.piece(piece);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let spot = here.spot(at);
            let velocity = self.stance.turned(spot.velocity);
            if let Rule::Roll { s, at: start, .. } = rule {
                load.s = s + (at - start) * self.rolling(rule, load, velocity).unwrap_or(0.0);
            }
            let Some(state) = self.whisker.at(load) else { return PieceSolution::Failed };
            let gap = state.p - self.stance.seen(spot.position);
            let tilt = match rule {
                Rule::Slide { offset } => load.beta - offset,
                Rule::Flank { push } | Rule::Roll { push, .. } => push.tilt(),
            };
            let aslant = wrap_angle(self.stance.direction(state.slope, tilt) - spot.normal);
            let Some(columns) = self.columns(rule, load, &state, velocity, spot.turning) else {
                return PieceSolution::Failed;
            };
            let rows = [columns.map(|c| c.p.x), columns.map(|c| c.p.y), columns.map(|c| c.slope)];
            let residual = gap.norm().max(aslant.abs());
            if residual < FOUND || (residual < self.whisker.accuracy() && residual >= 0.5 * last) {
                // Weak forces have a negative determinant and are stable; the sign changes where the branch folds.
                let stable = !matches!(rule, Rule::Slide { .. }) || determinant(&rows) * here.side() < 0.0;
                return PieceSolution::Found { load, state, at, stable };
            }
            let Some([dq, d2, dat]) = solve(rows, [gap.x, gap.y, aslant]) else { return PieceSolution::Failed };
            let unknown = if matches!(rule, Rule::Flank { .. }) { Unknown::ArcLength } else { Unknown::Tilt };
            let damp = moved(&mut load, unknown, dq, d2);
            at -= damp * dat;
            if here.is_lost(at) {
                return PieceSolution::Lost(at);
            }
            last = residual;
        }
        PieceSolution::Failed
    }

    /// How fast the contact moves along a rolling whisker, over L for each unit of the piece's parameter.
    fn rolling(&self, rule: Rule, load: PointLoad, velocity: Vec2) -> Option<f64> {
        let Rule::Roll { .. } = rule else { return None };
        let state = self.whisker.at(load)?;
        Some(velocity.norm().copysign(velocity.dot(Vec2::from_angle(state.slope))))
    }

    fn columns(
        &self,
        rule: Rule,
        load: PointLoad,
        state: &LoadedState,
        velocity: Vec2,
        turning: f64,
    ) -> Option<[LoadedRate; 3]> {
        let by_force = self.whisker.by_force(load, state)?;
        let ground = LoadedRate { p: -velocity, slope: -turning };
        let columns = match rule {
            Rule::Slide { .. } => {
                let by_tilt = self.whisker.by_tilt(load, state)?;
                [by_force, LoadedRate { slope: by_tilt.slope + 1.0, ..by_tilt }, ground]
            }
            Rule::Flank { .. } => [by_force, self.whisker.by_arc_length(load, state)?, ground],
            Rule::Roll { .. } => {
                let (longer, rolls) = (self.whisker.by_arc_length(load, state)?, self.rolling(rule, load, velocity)?);
                let along = LoadedRate { p: ground.p + longer.p * rolls, slope: ground.slope + longer.slope * rolls };
                [by_force, self.whisker.by_tilt(load, state)?, along]
            }
        };
        Some(columns)
    }

    /// The equilibrium with the contact at this place of the map, from this start; stable when the flag is set.
    pub(super) fn at_place(
        &self,
        unknown: Unknown,
        mut load: PointLoad,
        place: Vec2,
    ) -> Option<(PointLoad, LoadedState, bool)> {
        let target = self.stance.seen(place);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS_AT_PLACE {
            let state = self.whisker.at(load)?;
            let gap = state.p - target;
            let residual = gap.norm();
            let a = self.whisker.by_force(load, &state)?.p;
            let b = match unknown {
                Unknown::Tilt => self.whisker.by_tilt(load, &state)?.p,
                Unknown::ArcLength => self.whisker.by_arc_length(load, &state)?.p,
            };
            let det = a.cross(b);
            if residual < FOUND || (residual < self.whisker.accuracy() && residual >= 0.5 * last) {
                let push = math::cos(load.beta);
                return Some((load, state, unknown == Unknown::Tilt || det * push < 0.0));
            }
            moved(&mut load, unknown, gap.cross(b) / det, a.cross(gap) / det);
            if !(load.q.is_finite() && load.beta.is_finite() && load.s > 0.0 && load.s < 3.0) {
                return None;
            }
            last = residual;
        }
        None
    }
}

/// Takes a Newton step off the load, cut to where the linear picture may hold; returns the share taken.
fn moved(load: &mut PointLoad, unknown: Unknown, dq: f64, d2: f64) -> f64 {
    let most = if unknown == Unknown::Tilt { LARGEST_TURN } else { LARGEST_SHIFT };
    // Division by a zero step gives infinity, which leaves 1.
    let damp = (most / d2.abs()).min((0.5 + 0.5 * load.q.abs()) / dq.abs()).min(1.0);
    load.q -= damp * dq;
    match unknown {
        Unknown::Tilt => load.beta -= damp * d2,
        Unknown::ArcLength => load.s -= damp * d2,
    }
    damp
}

/// The solution of three equations by Cramer's rule; none when it is not finite. Not by pivots: simulated logs keep their last bits.
fn solve(rows: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let det = determinant(&rows);
    let mut solution = [0.0; 3];
    for (k, value) in solution.iter_mut().enumerate() {
        let mut replaced = rows;
        for (row, r) in replaced.iter_mut().zip(right) {
            row[k] = r;
        }
        *value = determinant(&replaced) / det;
    }
    solution.iter().all(|v| v.is_finite()).then_some(solution)
}
