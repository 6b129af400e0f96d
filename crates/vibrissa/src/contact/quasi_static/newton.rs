//! The whisker in contact at one place: Newton's method on its response.

use super::flex::{Flex, Load, Rate, State};
use super::foothold::Foothold;
use crate::plane::{Pose2, Vec2, wrap_angle};
use crate::world::Map;
use core::f64::consts::FRAC_PI_2;

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
pub(super) struct Stance<'a> {
    pub(super) map: &'a Map,
    pub(super) flex: &'a Flex,
    pub(super) map_from_whisker: Pose2,
}

/// What must hold on a piece of a boundary besides the contact being there.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    /// The tip slides: the force is this far off the normal (rad).
    Slide { offset: f64 },
    /// The side slides along the piece, tangent to it; `lay` is 0 when the force is along the whisker's left normal, pi
    /// when along its right one, and the load's tilt stays as it is.
    Flank { lay: f64 },
    /// The side rolls on the piece: arc lengths along whisker and piece change together from these values on.
    Roll { lay: f64, s: f64, at: f64 },
}

/// Where Newton's method on a piece ended.
pub(super) enum OnPiece {
    /// An equilibrium, maybe on the continuation of the piece; stable when the flag is set.
    Found { load: Load, state: State, foothold: Foothold, stable: bool },
    /// The place left the piece before an equilibrium was found.
    Lost(Foothold),
    /// No equilibrium near.
    Failed,
}

/// Which of two unknowns joins the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unknown {
    Tilt,
    ArcLength,
}

impl Stance<'_> {
    /// The direction of a force on the whisker (rad, map frame).
    pub(super) fn direction(&self, load: Load, state: &State) -> f64 {
        wrap_angle(self.map_from_whisker.theta + state.slope + load.beta + FRAC_PI_2)
    }

    /// The direction of the whisker at the contact (rad, map frame).
    pub(super) fn heading(&self, state: &State) -> f64 {
        self.map_from_whisker.theta + state.slope
    }

    /// The contact, map frame (m).
    pub(super) fn place(&self, state: &State) -> Vec2 {
        self.map_from_whisker.transform_point(state.p * self.flex.beam.length)
    }

    /// A place of the map as the whisker sees it, over its length.
    pub(super) fn seen(&self, place: Vec2) -> Vec2 {
        self.map_from_whisker.inverse_transform_point(place) * (1.0 / self.flex.beam.length)
    }

    /// The equilibrium on the piece of `foothold` under this rule, from this start.
    pub(super) fn on_piece(&self, rule: Rule, mut load: Load, mut foothold: Foothold) -> OnPiece {
        let heading = self.map_from_whisker.theta;
        let per_length = 1.0 / self.flex.beam.length;
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let ground = foothold.ground(self.map);
            let velocity = ground.velocity.rotated(-heading) * per_length;
            if let Rule::Roll { s, at, .. } = rule {
                load.s = s + (foothold.at - at) * self.rolling(rule, load, velocity).unwrap_or(0.0);
            }
            let Some(state) = self.flex.at(load) else { return OnPiece::Failed };
            let gap = state.p - self.seen(ground.position);
            let tilt = match rule {
                Rule::Slide { offset } => load.beta - offset,
                Rule::Flank { lay } | Rule::Roll { lay, .. } => lay,
            };
            let aslant = wrap_angle(heading + state.slope + tilt + FRAC_PI_2 - ground.normal);
            let Some(columns) = self.columns(rule, load, &state, velocity, ground.turning) else {
                return OnPiece::Failed;
            };
            let rows = [columns.map(|c| c.p.x), columns.map(|c| c.p.y), columns.map(|c| c.slope)];
            let residual = gap.norm().max(aslant.abs());
            if residual < FOUND || (residual < self.flex.accuracy() && residual >= 0.5 * last) {
                // Weak forces have a negative determinant and are stable; the sign changes where the branch folds.
                let stable = !matches!(rule, Rule::Slide { .. }) || determinant(rows) * foothold.side < 0.0;
                return OnPiece::Found { load, state, foothold, stable };
            }
            let Some([dq, d2, dat]) = solve(rows, [gap.x, gap.y, aslant]) else { return OnPiece::Failed };
            let unknown = if matches!(rule, Rule::Flank { .. }) { Unknown::ArcLength } else { Unknown::Tilt };
            let damp = moved(&mut load, unknown, dq, d2);
            foothold.at -= damp * dat;
            if foothold.is_lost(self.map) {
                return OnPiece::Lost(foothold);
            }
            last = residual;
        }
        OnPiece::Failed
    }

    /// How fast the contact moves along a rolling whisker, over L for each unit of the piece's parameter.
    fn rolling(&self, rule: Rule, load: Load, velocity: Vec2) -> Option<f64> {
        let Rule::Roll { .. } = rule else { return None };
        let state = self.flex.at(load)?;
        Some(velocity.norm().copysign(velocity.dot(Vec2::from_angle(state.slope))))
    }

    fn columns(&self, rule: Rule, load: Load, state: &State, velocity: Vec2, turning: f64) -> Option<[Rate; 3]> {
        let by_force = self.flex.by_force(load, state)?;
        let ground = Rate { p: -velocity, slope: -turning };
        let columns = match rule {
            Rule::Slide { .. } => {
                let by_tilt = self.flex.by_tilt(load, state)?;
                [by_force, Rate { slope: by_tilt.slope + 1.0, ..by_tilt }, ground]
            }
            Rule::Flank { .. } => [by_force, self.flex.by_arc_length(load, state)?, ground],
            Rule::Roll { .. } => {
                let (longer, rolls) = (self.flex.by_arc_length(load, state)?, self.rolling(rule, load, velocity)?);
                let along = Rate { p: ground.p + longer.p * rolls, slope: ground.slope + longer.slope * rolls };
                [by_force, self.flex.by_tilt(load, state)?, along]
            }
        };
        Some(columns)
    }

    /// The equilibrium with the contact at this place of the map, from this start; stable when the flag is set.
    pub(super) fn at_place(&self, unknown: Unknown, mut load: Load, place: Vec2) -> Option<(Load, State, bool)> {
        let target = self.seen(place);
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS_AT_PLACE {
            let state = self.flex.at(load)?;
            let gap = state.p - target;
            let residual = gap.norm();
            let a = self.flex.by_force(load, &state)?.p;
            let b = match unknown {
                Unknown::Tilt => self.flex.by_tilt(load, &state)?.p,
                Unknown::ArcLength => self.flex.by_arc_length(load, &state)?.p,
            };
            let det = a.cross(b);
            if residual < FOUND || (residual < self.flex.accuracy() && residual >= 0.5 * last) {
                let push = load.beta.cos();
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
fn moved(load: &mut Load, unknown: Unknown, dq: f64, d2: f64) -> f64 {
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

fn determinant(m: [[f64; 3]; 3]) -> f64 {
    let minor = |a: usize, b: usize| m[1][a] * m[2][b] - m[1][b] * m[2][a];
    m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
}

/// The solution of three equations by Cramer's rule; none when it is not finite.
fn solve(rows: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let det = determinant(rows);
    let mut solution = [0.0; 3];
    for (k, value) in solution.iter_mut().enumerate() {
        let mut replaced = rows;
        for (row, r) in replaced.iter_mut().zip(right) {
            row[k] = r;
        }
        *value = determinant(replaced) / det;
    }
    solution.iter().all(|v| v.is_finite()).then_some(solution)
}
