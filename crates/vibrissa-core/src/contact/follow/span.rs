//! A whisker under two forces, one at its side and one further out: its shape by integration, with all derivatives.
//!
//! In units of `L` and `EI / L²`, with the sum of the forces beyond `s` as `N`, the curvature obeys `k' = N_x
//! sin(theta) - N_y cos(theta)`; `N` jumps at the side contact by the force there, which is normal to the whisker.

use crate::math;
use crate::plane::Vec2;

/// Steps of Runge and Kutta's method for a whole whisker, and fewest on either side of the contact: where a shape is
/// wanted to 1e-5 of the length, and where 1e-4 do. Those grow with the root of the force, as the shape's own waves get
/// shorter.
const STEPS: f64 = 16.0;
const STEPS_PER_WAVE: f64 = 6.0;
const FEWEST: f64 = 3.0;
const QUICK_STEPS: [f64; 2] = [6.0, 3.0];
const QUICK_FEWEST: f64 = 2.0;

/// What is chosen: moment at the base, sum of the forces, arc length of the side contact, force there (to the left).
pub(super) const UNKNOWNS: usize = 5;

/// A place along the whisker and its derivatives by the unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Section {
    pub(super) slope: f64,
    pub(super) curvature: f64,
    pub(super) position: Vec2,
    /// For each unknown: slope, curvature, x, y.
    pub(super) by: [[f64; 4]; UNKNOWNS],
}

/// The inner contact, the outer one, and the force there with its derivatives.
pub(super) struct Shape {
    pub(super) inner: Section,
    pub(super) outer: Section,
    pub(super) force: Vec2,
    pub(super) force_by: [Vec2; UNKNOWNS],
}

/// The shape for `[moment, force x, force y, arc length, side force]` up to the outer contact at this arc length, in steps for one of two
/// errors.
pub(super) fn shape(load: [f64; UNKNOWNS], length: f64, quick: bool) -> Shape {
    let [moment, x, y, s, push] = load;
    let root = Section { curvature: moment, by: core::array::from_fn(first), ..Section::default() };
    let whole = Vec2::new(x, y);
    let unit = [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0), Vec2::ZERO, Vec2::ZERO];
    // Up to the contact only moment and sum of the forces bend the whisker.
    let mut inner = along::<3>(root, s, whole, &[unit[0], unit[1], unit[2]], quick);
    inner.by[3] = inner.rates(whole);
    let (sin, cos) = math::sin_cos(inner.slope);
    let (normal, tangent) = (Vec2::new(-sin, cos), Vec2::new(cos, sin));
    let force = whole - normal * push;
    let mut force_by: [Vec2; UNKNOWNS] = core::array::from_fn(|k| unit[k] + tangent * (push * inner.by[k][0]));
    force_by[4] = force_by[4] - normal;
    let mut outer = along(inner, length - s, force, &force_by, quick);
    let end = outer.rates(force);
    (0..4).for_each(|i| outer.by[3][i] -= end[i]);
    Shape { inner, outer, force, force_by }
}

/// Places along a whisker under one force, evenly spaced up to where it acts: the first, third and so on in the middle
/// of the steps that lead to the others, where a cubic has the slopes of both ends.
pub(super) fn outline(moment: f64, force: Vec2, length: f64, places: &mut [Vec2]) {
    let h = length / (places.len() / 2) as f64;
    let mut y = Integrated::<0> { own: [0.0, moment, 0.0, 0.0, 0.0, 1.0], by: [] };
    for pair in places.chunks_exact_mut(2) {
        let next = step(&y, force, &[], h);
        let ([_, _, ax, ay, asin, acos], [_, _, bx, by, bsin, bcos]) = (y.own, next.own);
        pair[0] = Vec2::new(0.5 * (ax + bx) + 0.125 * h * (acos - bcos), 0.5 * (ay + by) + 0.125 * h * (asin - bsin));
        pair[1] = Vec2::new(bx, by);
        y = next;
    }
}

fn first(unknown: usize) -> [f64; 4] {
    [0.0, if unknown == 0 { 1.0 } else { 0.0 }, 0.0, 0.0]
}

impl Section {
    /// Slope, curvature, x and y by the arc length, under this force beyond it.
    pub(super) fn rates(&self, force: Vec2) -> [f64; 4] {
        let (sin, cos) = math::sin_cos(self.slope);
        [self.curvature, force.x * sin - force.y * cos, cos, sin]
    }
}

/// All that is integrated: the derivatives by the first unknowns, and slope, curvature, x and y with sine and cosine of
/// the slope, which are cheaper to carry along than to ask for.
#[derive(Clone, Copy)]
struct Integrated<const N: usize> {
    own: [f64; 6],
    by: [[f64; 4]; N],
}

fn derivative<const N: usize>(y: &Integrated<N>, force: Vec2, by: &[Vec2; N]) -> Integrated<N> {
    let [_, curvature, _, _, sin, cos] = y.own;
    let own = [curvature, force.x * sin - force.y * cos, cos, sin, cos * curvature, -sin * curvature];
    let stiff = force.x * cos + force.y * sin;
    let one = |k: usize| {
        let d = &y.by[k];
        [d[1], stiff * d[0] + by[k].x * sin - by[k].y * cos, -sin * d[0], cos * d[0]]
    };
    Integrated { own, by: core::array::from_fn(one) }
}

fn plus<const N: usize>(y: &Integrated<N>, d: &Integrated<N>, step: f64) -> Integrated<N> {
    Integrated {
        own: core::array::from_fn(|i| y.own[i] + step * d.own[i]),
        by: core::array::from_fn(|k| core::array::from_fn(|i| y.by[k][i] + step * d.by[k][i])),
    }
}

/// One step of Runge and Kutta's method of fourth order.
fn step<const N: usize>(y: &Integrated<N>, force: Vec2, by: &[Vec2; N], h: f64) -> Integrated<N> {
    let a = derivative(y, force, by);
    let b = derivative(&plus(y, &a, 0.5 * h), force, by);
    let c = derivative(&plus(y, &b, 0.5 * h), force, by);
    let d = derivative(&plus(y, &c, h), force, by);
    let parts = [(1.0, a), (2.0, b), (2.0, c), (1.0, d)];
    parts.into_iter().fold(*y, |sum, (share, part)| plus(&sum, &part, share * h / 6.0))
}

/// From a place on by `length` under this force; the place does not depend on further unknowns than the first `N`.
fn along<const N: usize>(from: Section, length: f64, force: Vec2, by: &[Vec2; N], quick: bool) -> Section {
    let waves = force.norm_squared().sqrt().sqrt();
    let count = if quick {
        let [least, more] = QUICK_STEPS;
        ((least + more * waves) * length.abs()).max(QUICK_FEWEST).ceil()
    } else {
        (STEPS.max(STEPS_PER_WAVE * waves) * length.abs()).max(FEWEST).ceil()
    };
    let h = length / count;
    let (sin, cos) = math::sin_cos(from.slope);
    let own = [from.slope, from.curvature, from.position.x, from.position.y, sin, cos];
    let mut y = Integrated::<N> { own, by: core::array::from_fn(|k| from.by[k]) };
    for _ in 0..count as usize {
        y = step(&y, force, by, h);
    }
    let mut by = [[0.0; 4]; UNKNOWNS];
    by.iter_mut().zip(y.by).for_each(|(to, from)| *to = from);
    Section { slope: y.own[0], curvature: y.own[1], position: Vec2::new(y.own[2], y.own[3]), by }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::tip_chart;

    #[test]
    fn one_force_at_the_tip_gives_the_closed_form() {
        for (q, beta) in [(0.5, 0.2), (2.0, -0.6), (-1.0, 0.3), (3.0, 2.8)] {
            let Some(chart) = tip_chart(q, beta) else { unreachable!() };
            let force = Vec2::from_angle(chart.slope + beta + core::f64::consts::FRAC_PI_2) * q;
            let load = [chart.moment, force.x, force.y, 0.4, 0.0];
            let (found, quick) = (shape(load, 1.0, false), shape(load, 1.0, true));
            assert!((quick.outer.position - chart.position).norm() < 3e-4, "{q} {beta}: {:?}", quick.outer);
            assert!((found.outer.position - chart.position).norm() < 1e-5, "{q} {beta}: {:?}", found.outer);
            assert!((found.outer.slope - chart.slope).abs() < 1e-5 && found.outer.curvature.abs() < 1e-4);
            let mut places = [Vec2::ZERO; 12];
            outline(chart.moment, force, 1.0, &mut places);
            assert!((places[11] - chart.position).norm() < 2e-4, "{q} {beta}: {:?}", places[11]);
            for (k, place) in places.iter().enumerate() {
                let s = (k + 1) as f64 / 12.0;
                let part = shape([chart.moment, force.x, force.y, s, 0.0], 1.0, false).inner.position;
                assert!((*place - part).norm() < 4e-4, "{q} {beta} {k}: {place:?} {part:?}");
            }
        }
    }

    #[test]
    fn small_forces_add_up_as_in_a_beam_table() {
        // Deflections of a cantilever by hand: a load P at a gives P a² (3 - a) / 6 at the tip and P a³ / 3 at a.
        let (s, push, tip) = (0.6, 1e-3, -4e-4);
        let found = shape([push * s + tip, 0.0, push + tip, s, push], 1.0, false);
        let at_tip = push * s * s * (3.0 - s) / 6.0 + tip / 3.0;
        let at_side = push * s * s * s / 3.0 + tip * s * s * (3.0 - s) / 6.0;
        assert!((found.outer.position.y - at_tip).abs() < 1e-9, "{} {at_tip}", found.outer.position.y);
        assert!((found.inner.position.y - at_side).abs() < 1e-9 && found.outer.curvature.abs() < 1e-9);
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let load = [1.8, -0.7, 2.1, 0.55, 3.0];
        let here = shape(load, 1.0, false);
        for k in 0..UNKNOWNS {
            let (mut more, mut less) = (load, load);
            (more[k], less[k]) = (load[k] + 1e-5, load[k] - 1e-5);
            let (a, b) = (shape(more, 1.0, false), shape(less, 1.0, false));
            for (own, x, y) in [(here.inner, a.inner, b.inner), (here.outer, a.outer, b.outer)] {
                let difference = [
                    x.slope - y.slope,
                    x.curvature - y.curvature,
                    x.position.x - y.position.x,
                    x.position.y - y.position.y,
                ];
                for (own, d) in own.by[k].iter().zip(difference) {
                    let d = d / 2e-5;
                    assert!((own - d).abs() < 1e-3 * (1.0 + d.abs()), "{k}: {own} {d}");
                }
            }
            let d = (a.force - b.force) * (1.0 / 2e-5);
            assert!((here.force_by[k] - d).norm() < 1e-4 * (1.0 + d.norm()), "{k}");
        }
    }
}
