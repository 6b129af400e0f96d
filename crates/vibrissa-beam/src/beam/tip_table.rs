//! The tip's chart as a table: what [`tip_chart`] says, interpolated in a tenth of the time.

use super::{TipChart, TipRate, tip_chart};
use crate::plane::{Vec2, wrap_angle};
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, PI};

/// Range and cells of the dimensionless force.
const LEAST_FORCE: f64 = -0.2;
const FORCE_STEP: f64 = 0.1;
const FORCES: usize = 112;
/// Range and cells of the tilt (rad).
const STEEPEST: f64 = 1.5;
const TILTS: usize = 100;
const TILT_STEP: f64 = 2.0 * STEEPEST / TILTS as f64;
/// Step of the differences that give the mixed derivatives (rad).
const DIFFERENCE: f64 = 1e-4;

/// x, y, slope and moment.
type Values = [f64; 4];

/// One node: the values, and their derivatives by cell of force, of tilt, and of both.
type TipNode = [Values; 4];

/// A whisker's tip over force and tilt, by bicubic interpolation of values and derivatives.
///
/// The table is dimensionless and so the same for every uniform whisker. Where it does not reach (forces above 11,
/// tilts within 0.07 rad of the whisker's direction, beyond the first mode) it computes.
#[derive(Clone, Debug)]
pub struct TipTable {
    nodes: Vec<Option<TipNode>>,
}

impl Default for TipTable {
    fn default() -> Self {
        Self::new()
    }
}

impl TipTable {
    /// Fills the table; takes a few milliseconds.
    #[must_use]
    pub fn new() -> Self {
        let at = |i: usize, j: usize| node(LEAST_FORCE + i as f64 * FORCE_STEP, -STEEPEST + j as f64 * TILT_STEP);
        let nodes = (0..=FORCES).flat_map(|i| (0..=TILTS).map(move |j| at(i, j))).collect();
        Self { nodes }
    }

    /// The tip under the dimensionless force `q` tilted by `beta` (rad), as [`tip_chart`] gives it.
    ///
    /// Error about 1e-6 of the length (and rad) for ordinary tilts, up to 1e-3 near the buckling force of a push along
    /// the whisker; derivatives are those of the interpolation.
    #[must_use]
    pub fn at(&self, q: f64, beta: f64) -> Option<TipChart> {
        let beta = wrap_angle(beta);
        // A force from the other side is its mirror image.
        let mirrored = beta.abs() > FRAC_PI_2;
        let tilt = if mirrored { wrap_angle(PI - beta) } else { beta };
        let (u, v) = ((q - LEAST_FORCE) / FORCE_STEP, (tilt + STEEPEST) / TILT_STEP);
        if !(u >= 0.0 && v >= 0.0 && u < FORCES as f64 && v < TILTS as f64) {
            return tip_chart(q, beta);
        }
        let (i, j) = (u as usize, v as usize);
        let first = i * (TILTS + 1) + j;
        let corner = |k: usize| self.nodes[first + k].as_ref();
        let corners = [corner(0), corner(1), corner(TILTS + 1), corner(TILTS + 2)];
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return tip_chart(q, beta) };
        let chart = interpolate([a, b, c, d], u - i as f64, v - j as f64);
        Some(if mirrored { mirror(chart) } else { chart })
    }
}

fn node(q: f64, beta: f64) -> Option<TipNode> {
    let here = tip_chart(q, beta)?;
    let (left, right) = (tip_chart(q, beta - DIFFERENCE)?, tip_chart(q, beta + DIFFERENCE)?);
    let rates = |rate: &TipRate| [rate.position.x, rate.position.y, rate.slope, rate.moment];
    let mixed = |k: usize| (rates(&right.by_force)[k] - rates(&left.by_force)[k]) / (2.0 * DIFFERENCE);
    Some([
        [here.position.x, here.position.y, here.slope, here.moment],
        rates(&here.by_force).map(|rate| rate * FORCE_STEP),
        rates(&here.by_tilt).map(|rate| rate * TILT_STEP),
        [0, 1, 2, 3].map(|k| mixed(k) * FORCE_STEP * TILT_STEP),
    ])
}

/// Hermite's cubics for value and derivative at both ends, and their derivatives.
fn hermite(s: f64) -> ([f64; 4], [f64; 4]) {
    let r = 1.0 - s;
    (
        [(1.0 + 2.0 * s) * r * r, s * r * r, s * s * (3.0 - 2.0 * s), -s * s * r],
        [-6.0 * s * r, r * (1.0 - 3.0 * s), 6.0 * s * r, s * (3.0 * s - 2.0)],
    )
}

/// The sum of these values by their weights.
#[inline]
fn weighed(weights: [f64; 4], values: [&Values; 4]) -> Values {
    let mut sum = [0.0; 4];
    for (k, sum) in sum.iter_mut().enumerate() {
        *sum = (weights[0] * values[0][k] + weights[1] * values[1][k])
            + (weights[2] * values[2][k] + weights[3] * values[3][k]);
    }
    sum
}

/// Bicubic in the cell of these nodes: (force, tilt) = (0, 0), (0, 1), (1, 0), (1, 1).
fn interpolate(nodes: [&TipNode; 4], s: f64, t: f64) -> TipChart {
    let (f, df) = hermite(s);
    let (g, dg) = hermite(t);
    // Across the tilt at either force: values and their derivative by force.
    let across = |weights: [f64; 4]| {
        let at =
            |a: &TipNode, b: &TipNode, kind: usize| weighed(weights, [&a[kind], &a[kind + 2], &b[kind], &b[kind + 2]]);
        [at(nodes[0], nodes[1], 0), at(nodes[0], nodes[1], 1), at(nodes[2], nodes[3], 0), at(nodes[2], nodes[3], 1)]
    };
    let along = |weights: [f64; 4], [a, b, c, d]: &[Values; 4]| weighed(weights, [a, b, c, d]);
    let (here, turned) = (across(g), across(dg));
    let (value, by_force, by_tilt) = (along(f, &here), along(df, &here), along(f, &turned));
    let rate = |[x, y, slope, moment]: Values, per: f64| TipRate {
        position: Vec2::new(x * per, y * per),
        slope: slope * per,
        moment: moment * per,
    };
    TipChart {
        position: Vec2::new(value[0], value[1]),
        slope: value[2],
        moment: value[3],
        by_force: rate(by_force, 1.0 / FORCE_STEP),
        by_tilt: rate(by_tilt, 1.0 / TILT_STEP),
    }
}

/// The whisker mirrored at its axis, under the mirrored force.
fn mirror(chart: TipChart) -> TipChart {
    let flip = |v: Vec2| Vec2::new(v.x, -v.y);
    let by_force = TipRate {
        position: flip(chart.by_force.position),
        slope: -chart.by_force.slope,
        moment: -chart.by_force.moment,
    };
    let by_tilt = TipRate { position: Vec2::new(-chart.by_tilt.position.x, chart.by_tilt.position.y), ..chart.by_tilt };
    TipChart { position: flip(chart.position), slope: -chart.slope, moment: -chart.moment, by_force, by_tilt }
}
