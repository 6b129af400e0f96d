//! From a position, or from a direction and a moment, back to every equilibrium of the chart.

extern crate alloc;
use super::cells::Search;
use super::image::Image;
use super::state::TipState;
use super::table::{ENERGY, Jet, QUANTITIES, X};
use super::tip::{TILTS, TipField};
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, TAU};

/// Most Newton steps along a branch.
const MOST_STEPS: usize = 24;
/// Largest step along a branch, in the chart's coordinates.
const LONGEST: f64 = 0.15;

impl TipField {
    /// Every equilibrium of the field whose tip is at `position` (m, whisker frame), least energy first.
    ///
    /// The answer is the table's: its tip is at `position` to rounding, its distance from the beam within the field's
    /// errors. Empty beyond the field.
    #[must_use]
    pub fn by_position(&self, position: Vec2) -> Vec<TipState> {
        let mut found = self.solutions(Image::Position, [position.x, position.y], |_| true);
        if self.mirrored {
            let other = self.solutions(Image::Position, [position.x, -position.y], |_| true);
            found.extend(other.into_iter().map(|[u, v]| [-u, -v]));
        }
        self.states(found)
    }

    /// Every equilibrium of the field whose force pushes in `direction` (rad, whisker frame, any turn) and whose base
    /// moment is `moment` (N m), least energy first.
    #[must_use]
    pub fn by_direction_and_moment(&self, direction: f64, moment: f64) -> Vec<TipState> {
        let mut found = Vec::new();
        if !(direction.is_finite() && moment.is_finite()) {
            return Vec::new();
        }
        for (force, mirror) in [(1.0, 1.0), (-1.0, if self.mirrored { -1.0 } else { 1.0 })] {
            let turned = mirror * (direction - FRAC_PI_2 * force);
            let (lo, hi) = self.readings.first_range();
            let (first, last) = (((lo - turned) / TAU).ceil(), ((hi - turned) / TAU).floor());
            let mut turn = first;
            while turn <= last {
                let target = [turned + TAU * turn, mirror * moment];
                let of_side = |v: f64| v * force * mirror >= 0.0;
                let all = self.solutions(Image::Reading, target, of_side);
                found.extend(all.into_iter().map(|[u, v]| [mirror * u, mirror * v]));
                turn += 1.0;
            }
        }
        self.states(found)
    }

    /// The equilibrium whose tip is at `position` (m) on the branch of `hint`, a state of this field nearby.
    ///
    /// `None` when the branch ends on the way: at a fold, where the whisker snaps, or at the limits of the field.
    #[must_use]
    pub fn by_position_from(&self, position: Vec2, hint: &TipState) -> Option<TipState> {
        self.along(Image::Position, [position.x, position.y], hint)
    }

    /// The equilibrium of this `direction` (rad, any turn) and `moment` (N m) on the branch of `hint`, a state of this field nearby.
    ///
    /// `None` when the branch ends on the way, see [`TipField::by_position_from`].
    #[must_use]
    pub fn by_direction_and_moment_from(&self, direction: f64, moment: f64, hint: &TipState) -> Option<TipState> {
        let here = hint.tilt + hint.slope;
        let turned = direction - FRAC_PI_2.copysign(hint.force);
        let turned = turned - TAU * ((turned - here) / TAU).round();
        self.along(Image::Reading, [turned, moment], hint)
    }

    /// Newton's method over the whole chart.
    fn along(&self, image: Image, target: [f64; 2], hint: &TipState) -> Option<TipState> {
        let (mut u, mut v) = (TILTS.at(hint.tilt), self.load.inverse(hint.force));
        let first = image.of(&self.signed_jet(u, v), u, self.scale());
        let mut aim = first;
        for _ in 0..MOST_STEPS {
            let [du, dv] = aim.step(target)?;
            let shorten = (LONGEST / du.abs().max(dv.abs())).min(1.0);
            (u, v) = (u + shorten * du, v + shorten * dv);
            if u.abs() > 1.02 || v.abs() > 1.02 {
                return None;
            }
            let small = du.abs().max(dv.abs()) < 1e-6 || aim.is_at(target);
            if small {
                // Convergence is quadratic: the step just taken was the last that matters.
                let state = self.state(u, v);
                let held = self.holds(state.tilt, state.force) && (aim.det() > 0.0) == (first.det() > 0.0);
                return held.then_some(state);
            }
            aim = image.of(&self.signed_jet(u, v), u, self.scale());
        }
        None
    }

    /// The table on both sides, mirrored where only one is kept.
    #[inline]
    pub(super) fn signed_jet(&self, u: f64, v: f64) -> Jet {
        if !(self.mirrored && v < 0.0) {
            return self.table.jet(u, v);
        }
        let mut jet = self.table.jet(-u, -v);
        for k in 0..QUANTITIES {
            if k == X || k == ENERGY {
                (jet.by_u[k], jet.by_v[k]) = (-jet.by_u[k], -jet.by_v[k]);
            } else {
                jet.value[k] = -jet.value[k];
            }
        }
        jet
    }

    /// Sizes by which residuals are judged: length (m) and moment (N m).
    fn scale(&self) -> [f64; 2] {
        [self.rod.length(), self.load.to * self.rod.length()]
    }

    /// The states at chart coordinates, those beyond the field left out, none twice, least energy first.
    fn states(&self, found: Vec<[f64; 2]>) -> Vec<TipState> {
        let mut kept: Vec<[f64; 2]> = Vec::with_capacity(found.len());
        for [u, v] in found {
            if !kept.iter().any(|[a, b]| (a - u).abs() < 1e-8 && (b - v).abs() < 1e-8) {
                kept.push([u, v]);
            }
        }
        let mut states: Vec<TipState> = kept.into_iter().map(|[u, v]| self.state(u, v)).collect();
        states.retain(|state| self.holds(state.tilt, state.force));
        states.sort_by(|a, b| a.energy.total_cmp(&b.energy));
        states
    }

    /// The chart coordinates, in the tabulated half, at which the image is `target`.
    fn solutions(&self, image: Image, target: [f64; 2], of_side: impl Fn(f64) -> bool) -> Vec<[f64; 2]> {
        let index = match image {
            Image::Position => &self.positions,
            Image::Reading => &self.readings,
        };
        Search { table: &self.table, image, target, scale: self.scale() }.all(index, of_side)
    }
}
