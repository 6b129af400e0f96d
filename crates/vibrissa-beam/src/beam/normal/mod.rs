//! The uniform whisker under a normal load, at the speed of a few polynomials.
//!
//! All its shapes are one family, so each mode is a look-up and no search: nothing here iterates or allocates, and the batch functions give the bits of the single ones.
//!
//! | mode | one | many |
//! | --- | --- | --- |
//! | force | [`by_force`] | [`by_force_batch`] |
//! | moment | [`by_moment`] | [`by_moment_batch`] |
//! | point | [`by_point`] | [`by_point_batch`] |
//!
//! Accuracy: 2e-13 of `s_a`, of the slope, and of `EI / s_a` for the moment, over the whole first mode, and relative to
//! themselves while they are small; measured over the whole range by the tests. At a fold the inverse modes lose half
//! the digits of their input, as any method does.
//!
//! Numbers that no shape has (a force beyond the first mode, a contact that is out of reach, input that is not finite)
//! give `None`, in batches a shape of NaN. A shape whose force, moment or contact is beyond the range of `f64` is none, either; in
//! batches that number is infinite or NaN.

mod inverse;
mod series;

use crate::math;
use crate::plane::Vec2;
use crate::platform::vector_level;
use fearless_simd::dispatch;
use inverse::{ALONG, BY_ANGLE, BY_MOMENT, LAST_Q, MORE_BY_ANGLE, Q, REACH, SINE, contact};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;
use series::{B, C, FORWARD, P, STORED, forward, forward_wide};

/// Which of the two shapes that share a moment, or a direction of the contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// The less bent one, which grows from the undeflected whisker.
    Least,
    /// The one beyond the fold, curled up.
    Curled,
}

/// A uniform whisker under a normal load; signs as in [`Bend`](super::Bend).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NormalBend {
    /// Force along the whisker's normal at the contact (N).
    pub force: f64,
    /// Arc length of the contact (m).
    pub s_a: f64,
    /// Slope at the contact (rad).
    pub phi_a: f64,
    /// The direction of the whisker at the contact, `(cos phi_a, sin phi_a)`.
    pub tangent: Vec2,
    /// The contact point, whisker frame (m).
    pub contact: Vec2,
    /// Moment about the base (N m).
    pub moment: f64,
}

impl NormalBend {
    /// The tip of a whisker of `length` (m), whisker frame (m).
    #[inline]
    #[must_use]
    pub fn tip(&self, length: f64) -> Vec2 {
        self.contact + (length - self.s_a) * self.tangent
    }

    /// The force as a vector, whisker frame (N).
    #[inline]
    #[must_use]
    pub fn force_vector(&self) -> Vec2 {
        self.force * self.tangent.perp()
    }

    /// The elastic energy (J): the force times how far the contact lies across its tangent.
    #[inline]
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.force * self.contact.cross(self.tangent)
    }

    /// The shape at `q`, which has the sign of the force, where the four functions are these.
    #[inline(always)]
    fn new(force: f64, s_a: f64, q: f64, [p, a, c, b]: [f64; 4]) -> Self {
        let (x, y) = contact(a, b, c, q * q);
        Self {
            force,
            s_a,
            phi_a: q * p,
            tangent: Vec2::new(c, q * a * a),
            contact: Vec2::new(s_a * x, s_a * q * y),
            moment: force * s_a * a,
        }
    }

    /// No shape.
    const NONE: Self = {
        let nowhere = Vec2::new(f64::NAN, f64::NAN);
        let nan = f64::NAN;
        Self { force: nan, s_a: nan, phi_a: nan, tangent: nowhere, contact: nowhere, moment: nan }
    };

    /// The shape, where there is one and it is within the range of numbers.
    fn some(self) -> Option<Self> {
        let whole = !self.phi_a.is_nan() && self.force.is_finite() && self.moment.is_finite();
        (whole && self.contact.is_finite()).then_some(self)
    }
}

/// Points that are looked at together.
const BLOCK: usize = 64;
/// The end of the first mode, with room for the rounding of `q`.
const END: f64 = LAST_Q * (1.0 + 4.0 * f64::EPSILON);

/// Stiffness in the forms that the modes divide by; one for each batch.
#[derive(Clone, Copy)]
struct Stiffness {
    double: f64,
    by_double: f64,
    by_largest_moment: f64,
}

impl Stiffness {
    #[inline]
    fn new(flexural_rigidity: f64) -> Self {
        // What is not positive must refuse every shape.
        let ei = if flexural_rigidity > 0.0 { flexural_rigidity } else { f64::NAN };
        Self { double: 2.0 * ei, by_double: 0.5 / ei, by_largest_moment: 1.0 / (ei * BY_MOMENT.top) }
    }

    /// With the functions at `y` from `functions`.
    #[inline(always)]
    fn under_force(self, force: f64, s_a: f64, functions: impl Fn(f64) -> [f64; STORED]) -> NormalBend {
        let q = force * (s_a * s_a) * self.by_double;
        // Written so that what is not a number is refused too.
        if !(q.abs() <= END && s_a > 0.0) {
            return NormalBend::NONE;
        }
        NormalBend::new(force, s_a, q, functions(q * q))
    }

    #[inline(always)]
    fn under_moment(self, moment: f64, s_a: f64, branch: Branch) -> NormalBend {
        let share = moment.abs() * s_a * self.by_largest_moment;
        if !(share <= 1.0 && s_a > 0.0) {
            return NormalBend::NONE;
        }
        let delta = delta(1.0 - share, branch);
        let f = BY_MOMENT.at(delta);
        // 1 - delta, without cancellation where the moment is small.
        let away = match branch {
            Branch::Least => share / (1.0 + delta),
            Branch::Curled => 1.0 - delta,
        };
        let q = (away * f[Q]).copysign(moment);
        // The least bent shape without a moment is the straight one; the curled one has its force through the base.
        let a = if q.abs() > 1e-300 { 0.5 * BY_MOMENT.top * share / q.abs() } else { 1.0 };
        let functions = [f[P], a, f[C], f[B]];
        NormalBend { moment, ..NormalBend::new(self.double * q / (s_a * s_a), s_a, q, functions) }
    }

    #[inline(always)]
    fn at_point(self, length: f64, point: Vec2, sight: Sight, functions: impl Fn(f64) -> [f64; STORED]) -> NormalBend {
        let Sight { distance, w, delta } = sight;
        let (f, more) = (functions(delta), MORE_BY_ANGLE.at(delta));
        let s_a = distance * f[REACH];
        // Written so that what is not a number is refused too; a contact at the very tip must not be lost to rounding.
        if !(s_a <= length * (1.0 + 1e-12) && self.double > 0.0) {
            return NormalBend::NONE;
        }
        let q = (w * f[Q]).copysign(point.y);
        let tangent = Vec2::new(f[C], q * more[SINE]);
        let force = self.double * q / (s_a * s_a);
        let moment = force * s_a * more[ALONG];
        NormalBend { force, s_a: s_a.min(length), phi_a: q * f[P], tangent, contact: point, moment }
    }
}

/// What the place of a point alone tells.
#[derive(Clone, Copy, Default)]
struct Sight {
    /// From the base (m).
    distance: f64,
    /// Tangent of half the polar angle.
    w: f64,
    /// Coordinate of the shape; not a number where there is none.
    delta: f64,
}

impl Sight {
    #[inline(always)]
    fn new(point: Vec2, sign: f64) -> Self {
        let distance = (point.x * point.x + point.y * point.y).sqrt();
        // Behind the base the complement's half angle, upside down, keeps its digits.
        let (y, sum) = (point.y.abs(), distance + point.x.abs());
        let (above, below) = if point.x > 0.0 { (y, sum) } else { (sum, y) };
        let w = above / below;
        // The curled branch begins at a right angle; the root of a negative number is none.
        let rest = if sign > 0.0 || w >= 1.0 { BY_ANGLE.top - w } else { -1.0 };
        Self { distance, w, delta: sign * rest.sqrt() }
    }
}

impl Branch {
    fn sign(self) -> f64 {
        match self {
            Self::Least => 1.0,
            Self::Curled => -1.0,
        }
    }
}

/// `sqrt(rest)` with the sign of the branch.
#[inline(always)]
fn delta(rest: f64, branch: Branch) -> f64 {
    match branch {
        Branch::Least => rest.sqrt(),
        Branch::Curled => -rest.sqrt(),
    }
}

/// The whisker of E I = `flexural_rigidity` (N m²) under `force` (N) at arc length `s_a` (m); `None` beyond the first mode.
#[inline]
#[must_use]
pub fn by_force(flexural_rigidity: f64, force: f64, s_a: f64) -> Option<NormalBend> {
    Stiffness::new(flexural_rigidity).under_force(force, s_a, |y| forward(&FORWARD, y)).some()
}

/// The whisker with `moment` (N m) about the base and contact at arc length `s_a` (m); `None` above 2.944 EI / `s_a`.
#[inline]
#[must_use]
pub fn by_moment(flexural_rigidity: f64, moment: f64, s_a: f64, branch: Branch) -> Option<NormalBend> {
    Stiffness::new(flexural_rigidity).under_moment(moment, s_a, branch).some()
}

/// The whisker of `length` (m) that is touched at `point` (m, whisker frame); `None` beyond 99.6 degrees, for the curled
/// branch below 90 degrees, and where the whisker is too short.
#[inline]
#[must_use]
pub fn by_point(flexural_rigidity: f64, length: f64, point: Vec2, branch: Branch) -> Option<NormalBend> {
    let sight = Sight::new(point, branch.sign());
    Stiffness::new(flexural_rigidity).at_point(length, point, sight, |delta| BY_ANGLE.at(delta)).some()
}

/// [`by_force`] for each pair of `forces` and `arc_lengths`, as far as the shortest slice goes.
pub fn by_force_batch(flexural_rigidity: f64, forces: &[f64], arc_lengths: &[f64], out: &mut [NormalBend]) {
    let stiffness = Stiffness::new(flexural_rigidity);
    dispatch!(vector_level(), simd => for ((slot, &force), &s_a) in out.iter_mut().zip(forces).zip(arc_lengths) {
        *slot = stiffness.under_force(force, s_a, |y| forward_wide(simd, y));
    });
}

/// [`by_moment`] for each pair of `moments` and `arc_lengths`, as far as the shortest slice goes.
pub fn by_moment_batch(
    flexural_rigidity: f64,
    moments: &[f64],
    arc_lengths: &[f64],
    branch: Branch,
    out: &mut [NormalBend],
) {
    let stiffness = Stiffness::new(flexural_rigidity);
    // As it is: compiled for wide registers, as the others are, this loop takes three times as long.
    for ((slot, &moment), &s_a) in out.iter_mut().zip(moments).zip(arc_lengths) {
        *slot = stiffness.under_moment(moment, s_a, branch);
    }
}

/// [`by_point`] for each of `points`, as far as the shortest slice goes.
pub fn by_point_batch(flexural_rigidity: f64, length: f64, points: &[Vec2], branch: Branch, out: &mut [NormalBend]) {
    let stiffness = Stiffness::new(flexural_rigidity);
    let sign = branch.sign();
    // In two passes: the roots of the first fill the processor's vectors.
    let mut sights = [Sight::default(); BLOCK];
    dispatch!(vector_level(), simd => for (out, points) in out.chunks_mut(BLOCK).zip(points.chunks(BLOCK)) {
        for (sight, &point) in sights.iter_mut().zip(points) {
            *sight = Sight::new(point, sign);
        }
        for ((slot, &point), &sight) in out.iter_mut().zip(points).zip(&sights) {
            *slot = stiffness.at_point(length, point, sight, |delta| BY_ANGLE.at_wide(simd, delta));
        }
    });
}

/// The largest `M0 s_a / EI` under a normal load, about 2.944.
#[must_use]
pub fn largest_moment() -> f64 {
    BY_MOMENT.top
}

/// The largest polar angle of a contact under a normal load (rad), about 99.6 degrees.
#[must_use]
pub fn largest_angle() -> f64 {
    2.0 * math::atan(BY_ANGLE.top)
}
