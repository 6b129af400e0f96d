//! A whisker under two forces, one at its side and one at its tip: its shape by integration, with all derivatives.
//!
//! In units of `L` and `EI / L²`, with the sum of the forces beyond `s` as `N`, the curvature obeys
//! `k' = N_x sin(theta) - N_y cos(theta)`; `N` jumps at the side contact by the force there, which is normal to the whisker.

use crate::plane::{Pose2, Vec2};

/// Steps of Runge and Kutta's method for a whole whisker, and fewest on either side of the contact.
const STEPS: f64 = 16.0;
const FEWEST: f64 = 3.0;

/// What is chosen: moment at the base, sum of the forces, arc length of the side contact, force there (to the left).
pub(super) const UNKNOWNS: usize = 5;

/// A place along the whisker and its derivatives by the unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    pub(super) slope: f64,
    pub(super) curvature: f64,
    pub(super) position: Vec2,
    /// For each unknown: slope, curvature, x, y.
    pub(super) by: [[f64; 4]; UNKNOWNS],
}

/// The contact at the side, the tip, and the force on the tip with its derivatives.
pub(super) struct Shape {
    pub(super) side: Place,
    pub(super) tip: Place,
    pub(super) force: Vec2,
    pub(super) force_by: [Vec2; UNKNOWNS],
}

/// The shape for `[moment, force x, force y, arc length, side force]`.
pub(super) fn shape(load: [f64; UNKNOWNS]) -> Shape {
    let [moment, x, y, s, push] = load;
    let root = Place { curvature: moment, by: core::array::from_fn(first), ..Place::default() };
    let whole = Vec2::new(x, y);
    let unit = [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0), Vec2::ZERO, Vec2::ZERO];
    let mut side = along(root, s, whole, &unit);
    side.by[3] = rates(&side, whole);
    let (sin, cos) = side.slope.sin_cos();
    let (normal, tangent) = (Vec2::new(-sin, cos), Vec2::new(cos, sin));
    let force = whole - normal * push;
    let mut force_by: [Vec2; UNKNOWNS] = core::array::from_fn(|k| unit[k] + tangent * (push * side.by[k][0]));
    force_by[4] = force_by[4] - normal;
    let mut tip = along(side, 1.0 - s, force, &force_by);
    let end = rates(&tip, force);
    (0..4).for_each(|i| tip.by[3][i] -= end[i]);
    Shape { side, tip, force, force_by }
}

/// Places along a whisker under one force, evenly spaced up to it: position and slope, the last one where it acts.
pub(super) fn outline(moment: f64, force: Vec2, length: f64, places: &mut [Pose2]) {
    let h = length / places.len() as f64;
    let (mut slope, mut curvature, mut position) = (0.0_f64, moment, Vec2::ZERO);
    let bend = |slope: f64| force.x * slope.sin() - force.y * slope.cos();
    for place in places {
        // Nyström's method of fourth order; the position by Simpson's rule.
        let a = bend(slope);
        let middle = slope + 0.5 * h * curvature + 0.125 * h * h * a;
        let b = bend(middle);
        let end = slope + h * curvature + 0.5 * h * h * b;
        let c = bend(end);
        let next = slope + h * curvature + h * h / 6.0 * (a + 2.0 * b);
        position += (Vec2::from_angle(slope) + Vec2::from_angle(middle) * 4.0 + Vec2::from_angle(next)) * (h / 6.0);
        (slope, curvature) = (next, curvature + h / 6.0 * (a + 4.0 * b + c));
        *place = Pose2 { x: position.x, y: position.y, theta: slope };
    }
}

fn first(unknown: usize) -> [f64; 4] {
    [0.0, if unknown == 0 { 1.0 } else { 0.0 }, 0.0, 0.0]
}

/// Derivatives by the arc length.
fn rates(at: &Place, force: Vec2) -> [f64; 4] {
    let (sin, cos) = at.slope.sin_cos();
    [at.curvature, force.x * sin - force.y * cos, cos, sin]
}

/// All that is integrated: the derivatives by the unknowns, and slope, curvature, x and y with sine and cosine of the
/// slope, which are cheaper to carry along than to ask for.
#[derive(Clone, Copy)]
struct State {
    own: [f64; 6],
    by: [[f64; 4]; UNKNOWNS],
}

fn derivative(y: &State, force: Vec2, by: &[Vec2; UNKNOWNS]) -> State {
    let [_, curvature, _, _, sin, cos] = y.own;
    let own = [curvature, force.x * sin - force.y * cos, cos, sin, cos * curvature, -sin * curvature];
    let stiff = force.x * cos + force.y * sin;
    let one = |k: usize| {
        let d = &y.by[k];
        [d[1], stiff * d[0] + by[k].x * sin - by[k].y * cos, -sin * d[0], cos * d[0]]
    };
    State { own, by: core::array::from_fn(one) }
}

fn plus(y: &State, d: &State, step: f64) -> State {
    State {
        own: core::array::from_fn(|i| y.own[i] + step * d.own[i]),
        by: core::array::from_fn(|k| core::array::from_fn(|i| y.by[k][i] + step * d.by[k][i])),
    }
}

/// From a place on by `length` under this force.
fn along(from: Place, length: f64, force: Vec2, by: &[Vec2; UNKNOWNS]) -> Place {
    let count = (STEPS * length.abs()).clamp(FEWEST, STEPS).ceil();
    let step = length / count;
    let (sin, cos) = from.slope.sin_cos();
    let own = [from.slope, from.curvature, from.position.x, from.position.y, sin, cos];
    let mut y = State { own, by: from.by };
    for _ in 0..count as usize {
        let a = derivative(&y, force, by);
        let b = derivative(&plus(&y, &a, 0.5 * step), force, by);
        let c = derivative(&plus(&y, &b, 0.5 * step), force, by);
        let d = derivative(&plus(&y, &c, step), force, by);
        for (share, part) in [(1.0, a), (2.0, b), (2.0, c), (1.0, d)] {
            y = plus(&y, &part, share * step / 6.0);
        }
    }
    Place { slope: y.own[0], curvature: y.own[1], position: Vec2::new(y.own[2], y.own[3]), by: y.by }
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
            let found = shape([chart.moment, force.x, force.y, 0.4, 0.0]);
            assert!((found.tip.position - chart.position).norm() < 1e-5, "{q} {beta}: {:?}", found.tip);
            assert!((found.tip.slope - chart.slope).abs() < 1e-5 && found.tip.curvature.abs() < 1e-4);
            let mut places = [Pose2::IDENTITY; 10];
            outline(chart.moment, force, 1.0, &mut places);
            assert!((places[9].position() - chart.position).norm() < 2e-4, "{q} {beta}: {:?}", places[9]);
        }
    }

    #[test]
    fn small_forces_add_up_as_in_a_beam_table() {
        // Deflections of a cantilever by hand: a load P at a gives P a² (3 - a) / 6 at the tip and P a³ / 3 at a.
        let (s, push, tip) = (0.6, 1e-3, -4e-4);
        let found = shape([push * s + tip, 0.0, push + tip, s, push]);
        let at_tip = push * s * s * (3.0 - s) / 6.0 + tip / 3.0;
        let at_side = push * s * s * s / 3.0 + tip * s * s * (3.0 - s) / 6.0;
        assert!((found.tip.position.y - at_tip).abs() < 1e-9, "{} {at_tip}", found.tip.position.y);
        assert!((found.side.position.y - at_side).abs() < 1e-9 && found.tip.curvature.abs() < 1e-9);
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let load = [1.8, -0.7, 2.1, 0.55, 3.0];
        let here = shape(load);
        for k in 0..UNKNOWNS {
            let (mut more, mut less) = (load, load);
            (more[k], less[k]) = (load[k] + 1e-5, load[k] - 1e-5);
            let (a, b) = (shape(more), shape(less));
            for (own, x, y) in [(here.side, a.side, b.side), (here.tip, a.tip, b.tip)] {
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
