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
//! Towards a sharp tip the rigidity falls with the fourth power of the radius, and shapes change over ever shorter lengths.
//! A step therefore counts length by the radius: with `r` the radius over that at the step's start, `r = 1 - w (s - s_0)`, and
//! `dt = ds / r`, so that `r = exp(-w t)`, the unknowns
//!
//! | unknown | derivative by `t` |
//! | --- | --- |
//! | `phi` | `m + r kappa_0` |
//! | `m = M / (EI(s_0) r^3)` | `3 w m + (F_x S - F_y C) / EI(s_0)` |
//! | `C, S = cos(phi) / r^2, sin(phi) / r^2` | `2 w C - phi' S, 2 w S + phi' C` |
//! | `X, Y = (x - x_0) / r^3, (y - y_0) / r^3` | `3 w X + C, 3 w Y + S` |
//!
//! obey equations in which neither the radius nor the place occurs: only the pendulum's own poles limit the step, and a
//! taper to one twentieth takes three or four steps. Every right side is a product of series, so that all coefficients follow from
//! one recurrence \[jorba2005software\]. The step is where the last coefficients fall below [`TOLERANCE`]; stretches end where
//! stiffness jumps.

use super::super::pair::Pair;
use super::Rod;
use super::section::{rest_series, shifted};
use crate::plane::Vec2;

/// Order of the method: the highest power of the slope's series.
pub(super) const ORDER: usize = 20;
/// Truncation error of one step, relative.
const TOLERANCE: f64 = 5e-11;
/// Longest step in `w t`: the radius grows by e at most, for what is divided by its powers must not lose digits, and a taper to
/// one twentieth takes three steps.
const LONGEST: f64 = 1.0;
/// More steps than any shape within the limits takes.
const MOST_STEPS: usize = 4000;

/// One over the index.
pub(super) const INVERSE: [f64; ORDER + 1] = {
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
    /// How fast the radius falls, as a share of that at the start (1/m).
    narrowing: f64,
    /// EI at the start (N m²).
    rigidity: f64,
    /// The force over the rigidity at the start (1/m²).
    force: Vec2,
    /// `r kappa_0`.
    rest: [f64; ORDER],
    phi: [f64; ORDER + 1],
    /// `m`.
    moment: [f64; ORDER + 1],
    /// The derivative of the slope, twice.
    bend: Pairs,
    /// `C` and `S`.
    turn: Pairs,
    /// `X` and `Y`.
    place: Pairs,
}

/// Two series side by side: what the processor multiplies in one go.
type Pairs = [Pair; ORDER + 1];

/// `sum_j a[j] b[k - j]` for `0 < j < k`, from the middle outwards, so that the newest coefficients come last and hold up least.
#[inline(always)]
fn convolve_inner<const K: usize>(a: &Pairs, b: &Pairs) -> Pair {
    let (mut down, mut up) = (Pair::both(0.0), Pair::both(0.0));
    let middle = K / 2;
    if middle > 0 {
        down = a[middle].by(b[K - middle]);
        for d in 1..K - middle {
            up = up.plus(a[middle + d].by(b[K - middle - d]));
            if d < middle {
                down = down.plus(a[middle - d].by(b[K - middle + d]));
            }
        }
    }
    up.plus(down)
}

impl Step {
    /// A step that leads nowhere yet.
    fn at_rest(start: State) -> Self {
        let (zero, pairs) = ([0.0; ORDER + 1], [Pair::default(); ORDER + 1]);
        Self {
            start,
            h: 0.0,
            narrowing: 0.0,
            rigidity: 1.0,
            force: Vec2::ZERO,
            rest: [0.0; ORDER],
            phi: zero,
            moment: zero,
            bend: pairs,
            turn: pairs,
            place: pairs,
        }
    }

    /// From the coefficients of order `K` to those of order `K + 1`.
    #[inline(always)]
    fn grow<const K: usize>(&mut self) {
        let n = INVERSE[K + 1];
        let (turn, place) = (self.turn[K], self.place[K]);
        // The newest coefficients hold up all that follows: they are multiplied once and added last.
        let inner = convolve_inner::<K>(&self.bend, &self.turn).times(n);
        let oldest = if K > 0 { self.bend[0].times(n).by(turn) } else { Pair::both(0.0) };
        let bend = self.moment[K] + self.rest[K];
        self.bend[K] = Pair::both(bend);
        self.phi[K + 1] = n * bend;
        let [with_cos, with_sin] = inner.plus(oldest).plus(self.turn[0].times(n).times(bend)).array();
        let turned = Pair::new(-with_sin, with_cos);
        let push = (n * self.force.x) * turn.second() - (n * self.force.y) * turn.first();
        let (two, three) = (n * 2.0 * self.narrowing, n * 3.0 * self.narrowing);
        self.moment[K + 1] = three * self.moment[K] + push;
        self.turn[K + 1] = turn.times(two).plus(turned);
        self.place[K + 1] = place.times(three).plus(turn.times(n));
    }

    /// All coefficients. Written out, so that every length is known when this is compiled.
    fn fill(&mut self) {
        macro_rules! orders {
            ($($k:literal)*) => { $(self.grow::<$k>();)* };
        }
        orders!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19);
    }

    /// Becomes the series about `start`, and the step that they allow towards arc length `to`, which is returned as the step
    /// counts it. In place, since copies take longer than sums.
    fn lead(&mut self, rod: &Rod, start: State, force: Vec2, to: f64) -> f64 {
        let backwards = to < start.s;
        let piece = rod.piece(start.s, backwards);
        let compliance = piece.compliance(start.s);
        self.start = start;
        self.narrowing = piece.narrowing / piece.radius(start.s);
        self.rigidity = 1.0 / compliance;
        self.force = compliance * force;
        if !rod.curvature.is_empty() {
            shifted(&rod.curvature, start.s, &mut self.rest);
            rest_series(&mut self.rest, rod.curvature.len(), self.narrowing);
        }
        let (sin, cos) = start.phi.sin_cos();
        (self.phi[0], self.moment[0], self.turn[0]) = (start.phi, compliance * start.moment, Pair::new(cos, sin));
        self.fill();
        let before = if backwards { rod.piece_start(start.s) } else { piece.end };
        let reach = if backwards { to.max(before) } else { to.min(before) } - start.s;
        let whole = self.counted(reach);
        let t = self.allowed(whole);
        // All the way is all the way, whatever is lost in between.
        self.h = if t.abs() < whole.abs() { self.length_of(t) } else { reach };
        t
    }

    /// Signed length from the start as the step counts it.
    #[inline]
    fn counted(&self, length: f64) -> f64 {
        let w = self.narrowing;
        if w.abs() > 0.0 { -(-w * length).ln_1p() / w } else { length }
    }

    /// The inverse of [`Step::counted`].
    #[inline]
    fn length_of(&self, t: f64) -> f64 {
        let w = self.narrowing;
        if w.abs() > 0.0 { -(-w * t).exp_m1() / w } else { t }
    }

    /// The longest step towards `reach` (counted, signed) whose last terms stay below the tolerance.
    fn allowed(&self, reach: f64) -> f64 {
        // The last two terms of each series over the longest step, and what they may be: the cosine is judged by one, slope and
        // sine by the slope where that is small, so that all but straight shapes keep their digits, too. Terms grow by the last
        // power of the step.
        let longest = reach.abs().min(LONGEST / self.narrowing.abs());
        let mut h = longest;
        let tail = |a: f64, b: f64| (a.abs() * longest).max(b.abs());
        let (last, before) = (self.turn[ORDER].array(), self.turn[ORDER - 1].array());
        let along = tail(last[0], before[0]);
        let slope = tail(last[1], before[1]).max(tail(self.phi[ORDER], self.phi[ORDER - 1]));
        let high = h.powi(ORDER as i32 - 1);
        let first = |h: f64| (self.phi[1].abs() * h).max(self.phi[2].abs() * h * h).max(self.phi[3].abs() * h * h * h);
        for _ in 0..2 {
            // A shorter step has a smaller slope, too: the second round is judged by that.
            let error = high * (slope / first(h).max(self.phi[0].abs()).clamp(1e-300, 1.0)).max(along);
            if error <= TOLERANCE {
                break;
            }
            h = longest * rough_root(TOLERANCE / error);
        }
        h.copysign(reach)
    }

    /// The state at signed distance `tau` (m) from the start of the step.
    #[inline]
    pub(super) fn at(&self, tau: f64) -> State {
        self.at_both(tau, self.counted(tau))
    }

    /// The state at a distance, given as a length (m) and as the step counts it.
    #[inline]
    fn at_both(&self, length: f64, t: f64) -> State {
        // Even and odd powers apart: half as many sums wait for one another.
        let square = t * t;
        let all = |k: usize| [self.phi[k], self.moment[k], self.place[k].first(), self.place[k].second()];
        let (mut even, mut odd) = (all(ORDER), all(ORDER - 1));
        for k in (0..ORDER / 2).rev() {
            let (more, less) = (all(2 * k), if k > 0 { all(2 * k - 1) } else { [0.0; 4] });
            for i in 0..4 {
                even[i] = even[i] * square + more[i];
                if k > 0 {
                    odd[i] = odd[i] * square + less[i];
                }
            }
        }
        let [phi, moment, x, y] = [0, 1, 2, 3].map(|i| even[i] + t * odd[i]);
        let start = &self.start;
        let r = 1.0 - self.narrowing * length;
        let cube = r * r * r;
        let moment = moment * (self.rigidity * cube);
        State { s: start.s + length, phi, moment, position: start.position + cube * Vec2::new(x, y) }
    }

    /// Whether the step holds arc length `s`.
    pub(super) fn holds(&self, s: f64) -> bool {
        (s - self.start.s) * self.h.signum() <= self.h.abs()
    }
}

/// At most the root of degree `ORDER - 1` of a number between 0 and 1, and at least 0.9 of it: by the exponent, whose linear
/// continuation is never further than 6 % from the power of two.
fn rough_root(x: f64) -> f64 {
    const ONE: u64 = 1.0_f64.to_bits();
    let below = ONE.saturating_sub(x.to_bits());
    0.94 * f64::from_bits(ONE - below / (ORDER as u64 - 1))
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
    let mut step = Step::at_rest(start);
    for _ in 0..MOST_STEPS {
        let t = step.lead(rod, state, force, to);
        if step.h.abs() <= 0.0 || !step.h.is_finite() {
            return None;
        }
        let whole = step.h + state.s;
        state = step.at_both(step.h, t);
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
