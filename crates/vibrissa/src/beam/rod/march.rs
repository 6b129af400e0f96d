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
use super::section::{Elastic, shifted};
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
    /// Cosine and sine of the slope.
    turn: Pairs,
}

/// Two series side by side, cosine and sine: what the processor multiplies in one go.
type Pairs = [[f64; 2]; ORDER + 1];

/// `sum_j a[j] b[k - j]` for `j <= k`, from the middle outwards, so that the newest coefficients come last and hold up least.
#[inline(always)]
fn convolve<const K: usize>(a: &Pairs, b: &Pairs) -> [f64; 2] {
    let middle = K / 2;
    let mut down = [a[middle][0] * b[K - middle][0], a[middle][1] * b[K - middle][1]];
    let mut up = [0.0; 2];
    for d in 1..=K - middle {
        for i in 0..2 {
            up[i] += a[middle + d][i] * b[K - middle - d][i];
        }
        if d <= middle {
            for i in 0..2 {
                down[i] += a[middle - d][i] * b[K - middle + d][i];
            }
        }
    }
    [up[0] + down[0], up[1] + down[1]]
}

/// The series of one step, coefficient by coefficient.
struct Expansion<'a> {
    force: Vec2,
    rest: &'a [f64; ORDER],
    elastic: Elastic,
    phi: [f64; ORDER + 1],
    moment: [f64; ORDER + 1],
    /// The derivative of the slope, twice.
    bend: Pairs,
    turn: Pairs,
}

impl Expansion<'_> {
    /// From the coefficients of order `K` to those of order `K + 1`.
    #[inline(always)]
    fn grow<const K: usize>(&mut self) {
        let n = INVERSE[K + 1];
        let bend = self.elastic.next(self.moment[K]) + self.rest[K];
        self.bend[K] = [bend; 2];
        self.phi[K + 1] = n * bend;
        let [cos, sin] = self.turn[K];
        self.moment[K + 1] = n * (self.force.x * sin - self.force.y * cos);
        let [with_cos, with_sin] = convolve::<K>(&self.bend, &self.turn);
        self.turn[K + 1] = [-n * with_sin, n * with_cos];
    }

    /// All coefficients. Written out, so that every length is known when this is compiled.
    fn fill(&mut self) {
        macro_rules! orders {
            ($($k:literal)*) => { $(self.grow::<$k>();)* };
        }
        orders!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19);
    }
}

impl Step {
    /// The series about `start`, and the step that they allow towards arc length `to`.
    fn new(rod: &Rod, start: State, force: Vec2, to: f64) -> Self {
        let backwards = to < start.s;
        let piece = rod.piece(start.s, backwards);
        let mut step = if rod.curvature.is_empty() {
            Self::expand(start, force, Elastic::new(&piece, start.s), &[0.0; ORDER])
        } else {
            let mut rest = [0.0; ORDER];
            shifted(&rod.curvature, start.s, &mut rest);
            Self::expand(start, force, Elastic::new(&piece, start.s), &rest)
        };
        let before = if backwards { rod.piece_start(start.s) } else { piece.end };
        let reach = if backwards { to.max(before) } else { to.min(before) } - start.s;
        step.h = step.allowed(reach);
        step
    }

    #[inline]
    fn expand(start: State, force: Vec2, elastic: Elastic, rest: &[f64; ORDER]) -> Self {
        let (zero, pairs) = ([0.0; ORDER + 1], [[0.0; 2]; ORDER + 1]);
        let mut series = Expansion { force, rest, elastic, phi: zero, moment: zero, bend: pairs, turn: pairs };
        let (sin, cos) = start.phi.sin_cos();
        (series.phi[0], series.moment[0], series.turn[0]) = (start.phi, start.moment, [cos, sin]);
        series.fill();
        Self { start, h: 0.0, phi: series.phi, moment: series.moment, turn: series.turn }
    }

    /// The longest step towards `reach` (m, signed) whose last terms stay below the tolerance.
    fn allowed(&self, reach: f64) -> f64 {
        let most = |a: [f64; 2]| a[0].abs().max(a[1].abs());
        // The last two terms of each series over the longest step, and what they may be: sine and cosine are judged by
        // one, the slope by its own first terms. Terms grow by the last power of the step.
        let h = reach.abs();
        let turn = (most(self.turn[ORDER]) * h).max(most(self.turn[ORDER - 1]));
        let phi = (self.phi[ORDER].abs() * h).max(self.phi[ORDER - 1].abs());
        let high = h.powi(ORDER as i32 - 1);
        let mut h = h;
        let first = |h: f64| (self.phi[1].abs() * h).max(self.phi[2].abs() * h * h).max(self.phi[3].abs() * h * h * h);
        for _ in 0..2 {
            // A shorter step has a smaller slope, too: the second round is judged by that.
            let error = high * (phi / first(h).max(1e-300)).max(turn);
            if error <= TOLERANCE {
                break;
            }
            h = reach.abs() * (TOLERANCE / error).powf(1.0 / (ORDER as f64 - 1.0)).min(1.0);
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
            x = x * tau + self.turn[k][0] * INVERSE[k + 1];
            y = y * tau + self.turn[k][1] * INVERSE[k + 1];
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
