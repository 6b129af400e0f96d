//! From a position, or from a direction and a moment, back to every equilibrium of the chart.
use super::cells::TargetSearch;
use super::image::Image;
use super::state::TipState;
use super::tip::{STEEPEST_TILT, TipField};
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, TAU};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Most Newton steps along a branch.
const MOST_STEPS: usize = 24;
/// Largest step along a branch, as a share of the steepest tilt and of the largest load.
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
        let (scale, most) = (self.scale(), self.load.to);
        let mut state = *hint;
        // The hint knows its own derivatives.
        let mut aim = image.of_state(hint, scale);
        let first = aim.det();
        for _ in 0..MOST_STEPS {
            let [turn, more] = aim.step(target)?;
            let size = (turn.abs() * (1.0 / STEEPEST_TILT)).max(more.abs() * self.per_load);
            let share = if size > LONGEST { LONGEST / size } else { 1.0 };
            let (tilt, force) = (state.tilt + share * turn, state.force + share * more);
            if tilt.abs() > 1.02 * STEEPEST_TILT || force.abs() > 1.02 * most {
                return None;
            }
            let last = size < 1e-6 || aim.is_at(target);
            state = self.state(tilt, force);
            if last {
                // Convergence is quadratic: the step just taken was the last that matters.
                let held = self.holds(tilt, force) && (aim.det() > 0.0) == (first > 0.0);
                return held.then_some(state);
            }
            aim = image.of_state(&state, scale);
        }
        None
    }

    /// Sizes by which residuals are judged: length (m) and moment (N m).
    fn scale(&self) -> [f64; 2] {
        [self.rod.length(), self.load.to * self.rod.length()]
    }

    /// The states at tilts and forces, those beyond the field left out, none twice, least energy first.
    fn states(&self, found: Vec<[f64; 2]>) -> Vec<TipState> {
        let mut kept: Vec<[f64; 2]> = Vec::with_capacity(found.len());
        for [u, v] in found {
            if !kept.iter().any(|[a, b]| (a - u).abs() < 1e-8 && (b - v).abs() * self.per_load < 1e-8) {
                kept.push([u, v]);
            }
        }
        let mut states: Vec<TipState> = kept.into_iter().map(|[u, v]| self.state(u, v)).collect();
        states.retain(|state| self.holds(state.tilt, state.force));
        states.sort_by(|a, b| a.energy.total_cmp(&b.energy));
        states
    }

    /// The tilts and forces, in the tabulated half, at which the image is `target`.
    fn solutions(&self, image: Image, target: [f64; 2], of_side: impl Fn(f64) -> bool) -> Vec<[f64; 2]> {
        let index = match image {
            Image::Position => &self.positions,
            Image::Reading => &self.readings,
        };
        TargetSearch { table: &self.table, image, target, scale: self.scale() }.all(index, of_side)
    }
}
