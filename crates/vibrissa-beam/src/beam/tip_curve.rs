//! All ways in which a tip contact can cause one base moment: the level curve of the moment over load tilt and force.
//!
//! With the contact at the tip, a uniform whisker's base moment `mu = M0 L / EI` depends on two numbers, the load's tilt
//! `beta` and `t = L sqrt(F / EI)`. The equilibria that cause one moment form a curve in that plane, which turns back in
//! `beta` where the moment is the largest that the tilt allows. It is followed by continuation, so that turning points
//! are nothing special, and cut where the direction of the force stops growing or shrinking: on each piece the
//! direction names the equilibrium.

use super::TipChart;
use super::pendulum::{Pendulum, Tilt};
use crate::math;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI};

/// Tilts beyond this are left out (rad): the force then all but pulls or pushes along the whisker.
pub(super) const STEEPEST_TILT: f64 = 1.45;
/// Slopes beyond this are left out (rad): a whisker that is wound up, and directions would repeat themselves.
const STEEPEST_SLOPE: f64 = PI;
/// Step along the curve in the plane of tilt and `t`; linear interpolation between steps errs by 2e-4 of the length.
const STEP: f64 = 0.02;
/// Sharp tips turn and travel further in such a step, so that for other whiskers it is cut: travel over the length, turn (rad).
const TRAVEL: f64 = 0.03;
/// More steps than any curve takes; a guard, never reached.
const MOST_STEPS: usize = 2000;
/// The end of the first mode is approached to this fraction: beyond, the moment changes sign.
const MODE_END: f64 = 0.995;

/// One equilibrium on the curve, lengths in units of the whisker's length, deflection positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipEquilibrium {
    /// Direction of the contact force in the whisker frame (rad), not wrapped.
    pub direction: f64,
    /// Slope at the tip (rad).
    pub slope: f64,
    /// Tip, first coordinate over the length.
    pub x: f64,
    /// Tip, second coordinate over the length.
    pub y: f64,
    /// `L sqrt(F / EI)`.
    pub t: f64,
}

impl TipEquilibrium {
    /// The force's tilt from the whisker's normal at the tip (rad).
    #[must_use]
    pub fn tilt(&self) -> f64 {
        self.direction - self.slope - FRAC_PI_2
    }
}

/// A point of the curve with the moment's slope there.
#[derive(Clone, Copy)]
struct CurveNode {
    beta: f64,
    t: f64,
    moment: f64,
    by_t: f64,
    end: f64,
    equilibrium: TipEquilibrium,
}

/// A whisker whose curves are followed.
struct Course<'a, N> {
    /// The load of this tilt and root; none beyond what is known.
    node: &'a N,
    /// The load of the largest moment at the steepest tilt, which every curve begins from: `t` and that moment.
    peak: (f64, f64),
    /// Largest travel of the tip over the length, and of its slope (rad), from one equilibrium to the next.
    travel: f64,
}

/// The uniform whisker.
fn uniform(beta: f64, t: f64) -> Option<CurveNode> {
    Some(node(beta, t))
}

fn node(beta: f64, t: f64) -> CurveNode {
    let pendulum = Pendulum::new(Tilt::new(math::sin(beta), math::cos(beta)));
    let swing = pendulum.at(t);
    let (x, y) = swing.contact();
    let equilibrium = TipEquilibrium { direction: beta + swing.u + FRAC_PI_2, slope: swing.u, x: x / t, y: y / t, t };
    let by_t = swing.du + t * math::cos(swing.u + beta);
    CurveNode { beta, t, moment: t * swing.du, by_t, end: pendulum.half_period(), equilibrium }
}

/// The equilibria with the dimensionless base moment `mu = M0 L / EI > 0` and the contact at the tip.
///
/// One list for each piece of the curve on which the force's direction is monotone, the piece of least bending first,
/// each in order of growing direction. Tilts within ±1.45 rad, slopes up to pi; the curve is followed from the least bent equilibrium at
/// the tilt -1.45 rad on. Where a moment is so small that even the tilt +1.45 rad allows it, the curve leaves the range
/// before it turns back, and its far side is left out: there the force all but runs through the base of a buckled
/// whisker. Empty when `mu` is not positive and finite, or when no
/// tip load causes so large a moment.
#[must_use]
pub fn tip_curve(mu: f64) -> Vec<Vec<TipEquilibrium>> {
    if !(mu > 0.0 && mu.is_finite()) {
        return Vec::new();
    }
    Course { node: &uniform, peak: STEEPEST_PEAK, travel: f64::INFINITY }.pieces(mu)
}

/// As [`tip_curve`], of a whisker that is known by a chart: `chart(q, beta)`, and `most(beta)` the root of the largest force that it
/// holds; `peak` as [`steepest_peak`] finds it.
pub(super) fn table_curve(
    mu: f64,
    peak: (f64, f64),
    chart: &dyn Fn(f64, f64) -> Option<TipChart>,
    most: &dyn Fn(f64) -> f64,
) -> Vec<Vec<TipEquilibrium>> {
    if !(mu > 0.0 && mu.is_finite()) {
        return Vec::new();
    }
    let node = |beta: f64, t: f64| {
        let tip = chart(t * t, beta)?;
        let direction = beta + tip.slope + FRAC_PI_2;
        let equilibrium = TipEquilibrium { direction, slope: tip.slope, x: tip.position.x, y: tip.position.y, t };
        Some(CurveNode {
            beta,
            t,
            moment: tip.moment,
            by_t: 2.0 * t * tip.by_force.moment,
            end: most(beta),
            equilibrium,
        })
    };
    Course { node: &node, peak, travel: TRAVEL }.pieces(mu)
}

impl<N: Fn(f64, f64) -> Option<CurveNode>> Course<'_, N> {
    fn pieces(&self, mu: f64) -> Vec<Vec<TipEquilibrium>> {
        self.first(mu).map_or_else(Vec::new, |first| pieces(&self.follow(first, mu)))
    }

    /// The least bent equilibrium at the steepest tilt, where the force pushes towards the base.
    fn first(&self, mu: f64) -> Option<CurveNode> {
        let (peak, largest) = self.peak;
        if mu > largest {
            return None;
        }
        let (mut lo, mut hi) = (0.0, peak);
        for _ in 0..60 {
            let middle = 0.5 * (lo + hi);
            if (self.node)(-STEEPEST_TILT, middle)?.moment < mu { lo = middle } else { hi = middle }
        }
        (self.node)(-STEEPEST_TILT, hi)
    }

    /// The derivative of the moment by the tilt, by a difference towards the middle: it only steers the continuation.
    fn by_beta(&self, at: &CurveNode) -> Option<f64> {
        let h = if at.beta > 0.0 { -1e-6 } else { 1e-6 };
        Some(((self.node)(at.beta + h, at.t)?.moment - at.moment) / h)
    }

    /// The curve from `first` on, until it leaves the range of tilts or the first mode.
    fn follow(&self, first: CurveNode, mu: f64) -> Vec<TipEquilibrium> {
        let mut curve = vec![first.equilibrium];
        let mut at = first;
        let (mut heading, mut speed) = ((1.0, 0.0), 0.0);
        while curve.len() < MOST_STEPS {
            let Some(by_beta) = self.by_beta(&at) else { break };
            let gradient = (by_beta, at.by_t);
            let norm = math::hypot(gradient.0, gradient.1);
            let sign = if -gradient.1 * heading.0 + gradient.0 * heading.1 > 0.0 { 1.0 } else { -1.0 };
            heading = (-sign * gradient.1 / norm, sign * gradient.0 / norm);
            // Small moments live at small t, where the step must not jump over the curve's bends.
            let step = STEP.min(0.2 * at.t).min(self.travel / speed);
            let next = self.correct(at.beta + step * heading.0, at.t + step * heading.1, mu, gradient);
            let Some(next) = next else { break };
            let inside = next.beta.abs() <= STEEPEST_TILT && next.t > 0.0 && next.t < MODE_END * next.end;
            if !(inside && next.equilibrium.slope <= STEEPEST_SLOPE) {
                break;
            }
            let (a, b) = (&at.equilibrium, &next.equilibrium);
            speed = math::hypot(a.x - b.x, a.y - b.y).max((a.slope - b.slope).abs()) / step;
            curve.push(next.equilibrium);
            at = next;
        }
        curve
    }

    /// The nearest point of the curve, by Newton steps along a gradient taken one step before.
    fn correct(&self, mut beta: f64, mut t: f64, mu: f64, gradient: (f64, f64)) -> Option<CurveNode> {
        let square = gradient.0 * gradient.0 + gradient.1 * gradient.1;
        let mut at = (self.node)(beta, t)?;
        for _ in 0..20 {
            let fault = mu - at.moment;
            if fault.abs() <= 1e-10 * mu {
                break;
            }
            beta += fault * gradient.0 / square;
            t += fault * gradient.1 / square;
            at = (self.node)(beta, t)?;
        }
        Some(at)
    }
}

/// The largest `t` at a tilt at which a uniform whisker is in its first mode and turned by less than pi.
pub(super) fn largest_root(beta: f64) -> f64 {
    let pendulum = Pendulum::new(Tilt::new(math::sin(beta), math::cos(beta)));
    (MODE_END * pendulum.half_period()).min(pendulum.time_of(STEEPEST_SLOPE))
}

/// The curve cut at the turning points of the direction.
pub(super) fn pieces(curve: &[TipEquilibrium]) -> Vec<Vec<TipEquilibrium>> {
    let mut pieces = Vec::new();
    let mut start = 0;
    for i in 1..curve.len() {
        let last = i + 1 == curve.len();
        let rising = curve[i].direction > curve[i - 1].direction;
        if last || (curve[i + 1].direction > curve[i].direction) != rising {
            let mut piece = curve[start..=i].to_vec();
            if !rising {
                piece.reverse();
            }
            pieces.push(piece);
            start = i;
        }
    }
    pieces
}

/// [`peak`] at the steepest tilt, which every curve begins from.
const STEEPEST_PEAK: (f64, f64) = (4.257_159_188_155_496, 8.483_239_697_979_752);

/// The largest dimensionless moment `M0 L / EI` that a load at the tip causes when its tilt is at most `steepest` (rad,
/// at least 0; steeper tilts than 1.45 rad are left out).
#[must_use]
pub fn largest_tip_moment(steepest: f64) -> f64 {
    peak(steepest.min(STEEPEST_TILT)).1
}

/// The `t` at which the moment is largest for a load tilted by `-tilt`, which pushes towards the base, and that moment; slopes up
/// to pi.
fn peak(tilt: f64) -> (f64, f64) {
    let pendulum = Pendulum::new(Tilt::new(-math::sin(tilt), math::cos(tilt)));
    steepest_peak(pendulum.time_of(STEEPEST_SLOPE), &|t: f64| t * pendulum.at(t).du)
}

/// Where a moment over `t` is largest up to `most`, and that moment: it has one maximum, found by ternary search.
pub(super) fn steepest_peak(most: f64, moment: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let (mut lo, mut hi) = (0.0, most);
    for _ in 0..100 {
        let (a, b) = (lo + (hi - lo) / 3.0, hi - (hi - lo) / 3.0);
        if moment(a) < moment(b) { lo = a } else { hi = b }
    }
    let t = 0.5 * (lo + hi);
    (t, moment(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steepest_peak_is_what_the_search_finds() {
        let found = peak(STEEPEST_TILT);
        std::println!("{found:?}");
        assert!((found.0 - STEEPEST_PEAK.0).abs() < 1e-7 && (found.1 - STEEPEST_PEAK.1).abs() < 1e-14, "{found:?}");
    }
}
