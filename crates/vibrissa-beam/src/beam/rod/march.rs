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
//! taper to one twentieth takes six steps under a weak load, ten under one that turns its tip by a radian. Every right side is a
//! product of series, so that all coefficients follow from one recurrence \[jorba2005software\]. `C` and `S` lead from step to step
//! like the other unknowns, brought back to length one: sine and cosine are asked for once a march, and so is the logarithm of how
//! far the radius changes. The step is where the last coefficients fall below [`TOLERANCE`]; stretches end where stiffness jumps.

use super::super::pair::Pair;
use super::Rod;
use super::section::{RodPiece, rest_series};
use crate::math;
use crate::plane::Vec2;
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Order of the method: the highest power of the slope's series.
pub(super) const ORDER: usize = 20;
/// Truncation error of one step, relative.
const TOLERANCE: f64 = 5e-11;
/// Longest step in `w t`: the radius grows by e at most, for what is divided by its powers must not lose digits, and a taper to
/// one twentieth takes three steps at least.
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
pub(super) struct RodState {
    pub(super) s: f64,
    pub(super) phi: f64,
    pub(super) moment: f64,
    pub(super) position: Vec2,
}

/// One step: the series of everything about `start`.
#[derive(Clone, Copy, Debug)]
pub(super) struct MarchStep {
    pub(super) start: RodState,
    /// Signed length of the step (m).
    pub(super) h: f64,
    /// How fast the radius falls, as a share of that at the start (1/m).
    narrowing: f64,
    /// EI at the start (N m²).
    rigidity: f64,
    /// The force over the rigidity at the start (1/m²).
    force: Vec2,
    /// `r kappa_0`, twice.
    rest: [Pair; ORDER],
    /// The derivative of the slope, twice.
    bend: Pairs,
    /// `C` and `S`.
    turn: Pairs,
    /// `C` and `S` turned by a quarter: `-S` and `C`.
    across: Pairs,
    /// `X` and `Y`.
    place: Pairs,
    /// `phi` and `m`.
    slope: Pairs,
}

/// Two series side by side: what the processor multiplies in one go.
type Pairs = [Pair; ORDER + 1];

/// `sum_j a[j] b[k - j]` for `0 < j < k`, where `k > 1`, from the middle outwards, so that the newest coefficients come last and hold
/// up least.
#[inline(always)]
fn convolve_inner<const K: usize>(a: &Pairs, b: &Pairs) -> Pair {
    let middle = K / 2;
    let mut down = a[middle].by(b[K - middle]);
    if K < 3 {
        return down;
    }
    let mut up = a[middle + 1].by(b[K - middle - 1]);
    for d in 1..middle {
        down = down.plus(a[middle - d].by(b[K - middle + d]));
    }
    for d in 2..K - middle {
        up = up.plus(a[middle + d].by(b[K - middle - d]));
    }
    up.plus(down)
}

/// What every order multiplies by.
struct Factors {
    /// `2 w`, twice.
    two: Pair,
    /// `3 w`, twice.
    three: Pair,
    /// `-F_y` and `F_x`, over the rigidity.
    push: Pair,
    /// The derivative of the slope at the start, twice.
    bend: Pair,
    /// `-sin(phi)` and `cos(phi)` at the start.
    across: Pair,
}

impl MarchStep {
    /// A step that leads nowhere yet.
    fn at_rest(start: RodState) -> Self {
        let pairs = [Pair::default(); ORDER + 1];
        Self {
            start,
            h: 0.0,
            narrowing: 0.0,
            rigidity: 1.0,
            force: Vec2::ZERO,
            rest: [Pair::default(); ORDER],
            bend: pairs,
            turn: pairs,
            across: pairs,
            place: pairs,
            slope: pairs,
        }
    }

    /// From the coefficients of order `K` to those of order `K + 1`; slope and moment twice each.
    #[inline(always)]
    fn grow<const K: usize>(&mut self, by: &Factors, [phi, moment]: [Pair; 2]) -> [Pair; 2] {
        let n = Pair::both(INVERSE[K + 1]);
        let (turn, place) = (self.turn[K], self.place[K]);
        let bend = moment.plus(self.rest[K]);
        self.bend[K] = bend;
        self.slope[K] = Pair::new(phi.first(), moment.first());
        // The newest coefficients hold up all that follows: they are multiplied once and added last.
        let mut old = turn.by(by.two);
        if K > 1 {
            old = old.plus(convolve_inner::<K>(&self.bend, &self.across));
        }
        old = old.plus(by.across.by(bend));
        let mut next = old.by(n);
        if K > 0 {
            next = next.plus(self.across[K].by(by.bend.by(n)));
        }
        self.turn[K + 1] = next;
        self.across[K + 1] = next.turned();
        self.place[K + 1] = place.by(by.three).plus(turn).by(n);
        let push = turn.by(by.push);
        [bend.by(n), moment.by(by.three).plus(push.plus(push.swapped())).by(n)]
    }

    /// All coefficients. Written out, so that every length is known when this is compiled.
    #[inline(always)]
    fn fill(&mut self, moment: f64) {
        let w = self.narrowing;
        let across = self.turn[0].turned();
        self.across[0] = across;
        let by = Factors {
            two: Pair::both(2.0 * w),
            three: Pair::both(3.0 * w),
            push: Pair::new(-self.force.y, self.force.x),
            bend: Pair::both(self.rest[0].first() + moment),
            across,
        };
        let mut newest = [Pair::both(self.start.phi), Pair::both(moment)];
        macro_rules! orders {
            ($($k:literal)*) => { $(newest = self.grow::<$k>(&by, newest);)* };
        }
        orders!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19);
        self.slope[ORDER] = Pair::new(newest[0].first(), newest[1].first());
    }

    /// Becomes the series about `start`. In place, since copies take longer than sums; one copy of this long code serves every march.
    #[inline(never)]
    fn lead(&mut self, stretch: &RodPiece, curvature: &[f64], start: RodState, turn: Pair, force: Vec2) {
        let radius = stretch.radius(start.s);
        let inverse = 1.0 / radius;
        let (square, over) = (radius * radius, inverse * inverse);
        self.start = start;
        self.narrowing = stretch.narrowing * inverse;
        self.rigidity = stretch.rigidity * (square * square);
        let compliance = over * over / stretch.rigidity;
        self.force = compliance * force;
        rest_series(curvature, start.s, self.narrowing, &mut self.rest);
        self.turn[0] = turn;
        self.fill(compliance * start.moment);
    }

    /// Signed length from the start as the step counts it.
    #[inline]
    fn counted(&self, length: f64) -> f64 {
        let w = self.narrowing;
        if w.abs() > 0.0 { -math::ln_1p(-w * length) / w } else { length }
    }

    /// The inverse of [`MarchStep::counted`].
    #[inline]
    fn length_of(&self, t: f64) -> f64 {
        let w = self.narrowing;
        if w.abs() > 0.0 { -math::exp_m1(-w * t) / w } else { t }
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
        let slope = tail(last[1], before[1]).max(tail(self.slope[ORDER].first(), self.slope[ORDER - 1].first()));
        let high = h.powi(ORDER as i32 - 1);
        let start = [0, 1, 2, 3].map(|k| self.slope[k].first().abs());
        let first = |h: f64| (start[1] * h).max(start[2] * h * h).max(start[3] * h * h * h);
        for _ in 0..2 {
            // A shorter step has a smaller slope, too: the second round is judged by that.
            let error = high * (slope / first(h).max(start[0]).clamp(1e-300, 1.0)).max(along);
            if error <= TOLERANCE {
                break;
            }
            h = longest * rough_root(TOLERANCE / error);
        }
        h.copysign(reach)
    }

    /// The state at signed distance `tau` (m) from the start of the step.
    #[inline]
    pub(super) fn at(&self, tau: f64) -> RodState {
        self.at_both(tau, self.counted(tau)).0
    }

    /// The state at a distance, given as a length (m) and as the step counts it, and the cosine and sine of its slope.
    #[inline(always)]
    fn at_both(&self, length: f64, t: f64) -> (RodState, Pair) {
        let [slope, place, turn] = sums([&self.slope, &self.place, &self.turn], t);
        let start = &self.start;
        let r = 1.0 - self.narrowing * length;
        let square = r * r;
        let cube = square * r;
        let [phi, moment] = slope.array();
        let [x, y] = place.array();
        let moment = moment * (self.rigidity * cube);
        let state = RodState { s: start.s + length, phi, moment, position: start.position + cube * Vec2::new(x, y) };
        (state, turn.times(square))
    }

    /// Whether the step holds arc length `s`.
    pub(super) fn holds(&self, s: f64) -> bool {
        (s - self.start.s) * self.h.signum() <= self.h.abs()
    }
}

/// The series at `t`: even and odd powers apart, so that half as many sums wait for one another.
#[inline(always)]
fn sums<const N: usize>(series: [&Pairs; N], t: f64) -> [Pair; N] {
    let square = Pair::both(t * t);
    let (mut even, mut odd) = (series.map(|s| s[ORDER]), series.map(|s| s[ORDER - 1]));
    for k in (1..ORDER / 2).rev() {
        for i in 0..N {
            even[i] = even[i].by(square).plus(series[i][2 * k]);
            odd[i] = odd[i].by(square).plus(series[i][2 * k - 1]);
        }
    }
    for i in 0..N {
        even[i] = even[i].by(square).plus(series[i][0]).plus(odd[i].times(t));
    }
    even
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
    start: RodState,
    force: Vec2,
    to: f64,
    mut look: impl FnMut(&MarchStep, &RodState) -> bool,
) -> Option<RodState> {
    let mut state = start;
    let (sin, cos) = math::sin_cos(start.phi);
    let mut turn = Pair::new(cos, sin);
    let mut step = MarchStep::at_rest(start);
    let (mut stretch, mut end, mut narrows) = enter(rod, start.s, to);
    for _ in 0..MOST_STEPS {
        step.lead(&stretch, &rod.curvature, state, turn, force);
        let reach = end - state.s;
        let w = step.narrowing;
        let whole = if w.abs() > 0.0 { narrows / w } else { reach };
        let t = step.allowed(whole);
        // All the way is all the way, whatever is lost in between.
        let last = t.abs() >= whole.abs();
        step.h = if last { reach } else { step.length_of(t) };
        if step.h.abs() <= 0.0 || !step.h.is_finite() {
            return None;
        }
        (state, turn) = step.at_both(step.h, t);
        // Back to length one, to second order in what is missing.
        let [cos, sin] = turn.array();
        turn = turn.times(1.5 - 0.5 * (cos * cos + sin * sin));
        narrows -= w * t;
        if last {
            state.s = end;
        }
        if !look(&step, &state) {
            return None;
        }
        if last {
            if (end - to).abs() <= 0.0 {
                return Some(state);
            }
            (stretch, end, narrows) = enter(rod, end, to);
        }
    }
    None
}

/// The stretch that a march from `s` to `to` enters, where it leaves it, and by how much the logarithm of the radius falls until then.
fn enter(rod: &Rod, s: f64, to: f64) -> (RodPiece, f64, f64) {
    let backwards = to < s;
    let piece = rod.piece(s, backwards);
    let end = if backwards { to.max(rod.piece_start(s)) } else { to.min(piece.end) };
    let narrows = -math::ln_1p(-piece.narrowing / piece.radius(s) * (end - s));
    (piece, end, narrows)
}
