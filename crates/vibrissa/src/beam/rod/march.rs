//! The rod as an initial value problem, solved by Taylor series of adaptive step.
//!
//! With arc length `s`, slope `phi`, moment of the force beyond `s` about the point at `s`, and the force `(F_x, F_y)`,
//!
//! | unknown | derivative by `s` |
//! | --- | --- |
//! | `phi` | `M / EI(s) + kappa_0(s)` |
//! | `M` | `F_x sin(phi) - F_y cos(phi)` |
//! | `x, y` | `cos(phi), sin(phi)` |
//!
//! Every right side is a product of series, so that all coefficients follow from one recurrence \[jorba2005software\].
//! The step is where the last coefficients fall below [`TOLERANCE`]; stretches end where stiffness jumps.

use super::Rod;
use super::section::shifted;
use crate::plane::Vec2;

/// Order of the method: the highest power of the slope's series.
pub(super) const ORDER: usize = 20;
/// Truncation error of one step, relative.
const TOLERANCE: f64 = 1e-11;
/// More steps than any shape within the limits takes.
const MOST_STEPS: usize = 4000;

const INVERSE: [f64; ORDER + 1] = {
    let mut table = [1.0; ORDER + 1];
    let mut k = 2;
    while k <= ORDER {
        table[k] = 1.0 / k as f64;
        k += 1;
    }
    table
};

/// The rod at one arc length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State {
    pub(super) s: f64,
    pub(super) phi: f64,
    pub(super) moment: f64,
    pub(super) position: Vec2,
}

/// One step: the series of everything about `start`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) start: State,
    /// Signed length of the step (m).
    pub(super) h: f64,
    phi: [f64; ORDER + 1],
    moment: [f64; ORDER + 1],
    cos: [f64; ORDER + 1],
    sin: [f64; ORDER + 1],
}

/// Room for series in whole groups of four.
pub(super) const ROOM: usize = 2 * ORDER + 4;

/// `sum_j a[j] b[k - j]` for `j <= k`, with `a` zero beyond `k` and `b[i]` stored at `reversed[ORDER - i]`.
#[inline(always)]
fn convolve(a: &[f64; ROOM], reversed: &[f64; ROOM], k: usize) -> f64 {
    let groups = k / 4 + 1;
    let (a, b) = (&a[..4 * groups], &reversed[ORDER - k..ORDER - k + 4 * groups]);
    let mut sums = [0.0; 4];
    for (p, q) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        for i in 0..4 {
            sums[i] += p[i] * q[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

impl Step {
    /// The series about `start`, and the step that they allow towards arc length `to`.
    fn new(rod: &Rod, start: State, force: Vec2, to: f64) -> Self {
        let backwards = to < start.s;
        let piece = rod.piece(start.s, backwards);
        let mut rest = [0.0; ORDER];
        shifted(&rod.curvature, start.s, &mut rest);
        let mut compliance = [0.0; ROOM];
        if piece.is_uniform() {
            compliance[0] = piece.compliance(start.s);
        } else {
            piece.compliance_series(start.s, &mut compliance);
        }
        let mut step = Self::expand(start, force, &compliance, &rest, piece.is_uniform());
        let before = if backwards { rod.piece_start(start.s) } else { piece.end };
        let reach = if backwards { to.max(before) } else { to.min(before) } - start.s;
        step.h = step.allowed(reach);
        step
    }

    #[inline]
    fn expand(start: State, force: Vec2, compliance: &[f64; ROOM], rest: &[f64; ORDER], uniform: bool) -> Self {
        let (sin0, cos0) = start.phi.sin_cos();
        let mut phi = [0.0; ORDER + 1];
        let mut moment = [0.0; ORDER + 1];
        let mut cos = [0.0; ORDER + 1];
        let mut sin = [0.0; ORDER + 1];
        let (mut cos_back, mut sin_back, mut compliance_back) = ([0.0; ROOM], [0.0; ROOM], [0.0; ROOM]);
        let mut moment_front = [0.0; ROOM];
        let mut bend = [0.0; ROOM];
        // The compliance is known in full, so it is what is read backwards.
        if !uniform {
            for k in 0..=ORDER {
                compliance_back[ORDER - k] = compliance[k];
            }
        }
        (phi[0], moment[0], cos[0], sin[0]) = (start.phi, start.moment, cos0, sin0);
        (cos_back[ORDER], sin_back[ORDER], moment_front[0]) = (cos0, sin0, start.moment);
        for k in 0..ORDER {
            let elastic =
                if uniform { compliance[0] * moment[k] } else { convolve(&moment_front, &compliance_back, k) };
            bend[k] = elastic + rest[k];
            let n = INVERSE[k + 1];
            phi[k + 1] = bend[k] * n;
            cos[k + 1] = -n * convolve(&bend, &sin_back, k);
            sin[k + 1] = n * convolve(&bend, &cos_back, k);
            moment[k + 1] = n * (force.x * sin[k] - force.y * cos[k]);
            let back = ORDER - k - 1;
            (cos_back[back], sin_back[back], moment_front[k + 1]) = (cos[k + 1], sin[k + 1], moment[k + 1]);
        }
        Self { start, h: 0.0, phi, moment, cos, sin }
    }

    /// The longest step towards `reach` (m, signed) whose last terms stay below the tolerance.
    fn allowed(&self, reach: f64) -> f64 {
        let mut h = reach.abs();
        for _ in 0..8 {
            let high = h.powi(ORDER as i32 - 2);
            let slope = (self.phi[1].abs() * h).max(self.phi[2].abs() * h * h).max(self.phi[3].abs() * h * h * h);
            let last = |a: &[f64; ORDER + 1]| (a[ORDER].abs() * h).max(a[ORDER - 1].abs()) * high * h;
            // What the slope misses is judged by the slope; sine and cosine by one.
            let error = (last(&self.phi) / slope.max(1e-300)).max(last(&self.cos)).max(last(&self.sin));
            if error <= 2.0 * TOLERANCE {
                break;
            }
            h *= (TOLERANCE / error).powf(1.0 / (ORDER as f64 - 1.0)).min(0.95);
        }
        h.copysign(reach)
    }

    /// The state at signed distance `tau` (m) from the start of the step.
    #[inline]
    pub(super) fn at(&self, tau: f64) -> State {
        let (mut phi, mut moment, mut x, mut y) = (self.phi[ORDER], self.moment[ORDER], 0.0, 0.0);
        for k in (0..ORDER).rev() {
            phi = phi * tau + self.phi[k];
            moment = moment * tau + self.moment[k];
            x = x * tau + self.cos[k] * INVERSE[k + 1];
            y = y * tau + self.sin[k] * INVERSE[k + 1];
        }
        let start = &self.start;
        State { s: start.s + tau, phi, moment, position: start.position + tau * Vec2::new(x, y) }
    }

    /// Whether the step holds arc length `s`.
    pub(super) fn holds(&self, s: f64) -> bool {
        (s - self.start.s) * self.h.signum() <= self.h.abs()
    }
}

/// Marches from `start` to arc length `to` under `force` (N, frame of the state), showing each step to `look`, which may stop
/// the march by returning false. `None` when stopped or when the steps grow too small.
#[inline]
pub(super) fn march(
    rod: &Rod,
    start: State,
    force: Vec2,
    to: f64,
    mut look: impl FnMut(&Step, &State) -> bool,
) -> Option<State> {
    let mut state = start;
    for _ in 0..MOST_STEPS {
        let step = Step::new(rod, state, force, to);
        if step.h.abs() <= 0.0 || !step.h.is_finite() {
            return None;
        }
        let whole = step.h + state.s;
        state = step.at(step.h);
        let arrived = (to - whole).abs() <= 1e-14 * to.abs().max(start.s.abs());
        if arrived {
            state.s = to;
        } else {
            state.s = rod.snapped(state.s);
        }
        if !look(&step, &state) {
            return None;
        }
        if arrived {
            return Some(state);
        }
    }
    None
}
