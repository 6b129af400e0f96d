//! The tip's chart as a table: what [`tip_chart`] says, interpolated in a tenth of the time.

use super::{TipChart, TipRate, tip_chart};
use crate::plane::{Vec2, wrap_angle};
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

/// One node: x, y, slope and moment, each with its derivatives by cell of force, of tilt, and of both.
type Node = [[f64; 4]; 4];

/// A whisker's tip over force and tilt, by bicubic interpolation of values and derivatives.
///
/// The table is dimensionless and so the same for every uniform whisker. Where it does not reach (forces above 11,
/// tilts within 0.07 rad of the whisker's direction, beyond the first mode) it computes.
#[derive(Clone, Debug)]
pub struct TipTable {
    nodes: Vec<Option<Node>>,
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

fn node(q: f64, beta: f64) -> Option<Node> {
    let here = tip_chart(q, beta)?;
    let (left, right) = (tip_chart(q, beta - DIFFERENCE)?, tip_chart(q, beta + DIFFERENCE)?);
    let mixed = |of: fn(&TipRate) -> f64| (of(&right.by_force) - of(&left.by_force)) / (2.0 * DIFFERENCE);
    let entry = |value: f64, of: fn(&TipRate) -> f64| {
        [value, of(&here.by_force) * FORCE_STEP, of(&here.by_tilt) * TILT_STEP, mixed(of) * FORCE_STEP * TILT_STEP]
    };
    Some([
        entry(here.position.x, |r| r.position.x),
        entry(here.position.y, |r| r.position.y),
        entry(here.slope, |r| r.slope),
        entry(here.moment, |r| r.moment),
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

/// Bicubic in the cell of these nodes: (force, tilt) = (0, 0), (0, 1), (1, 0), (1, 1).
fn interpolate(nodes: [&Node; 4], s: f64, t: f64) -> TipChart {
    let (f, df) = hermite(s);
    let (g, dg) = hermite(t);
    let mut out = [[0.0; 3]; 4];
    for (k, out) in out.iter_mut().enumerate() {
        for (n, node) in nodes.iter().enumerate() {
            let (i, j) = (2 * (n / 2), 2 * (n % 2));
            let [value, by_force, by_tilt, both] = node[k];
            let (here, turn) = (value * g[j] + by_tilt * g[j + 1], value * dg[j] + by_tilt * dg[j + 1]);
            let (grow, twist) = (by_force * g[j] + both * g[j + 1], by_force * dg[j] + both * dg[j + 1]);
            out[0] += f[i] * here + f[i + 1] * grow;
            out[1] += df[i] * here + df[i + 1] * grow;
            out[2] += f[i] * turn + f[i + 1] * twist;
        }
    }
    let rate = |k: usize, per: f64| TipRate {
        position: Vec2::new(out[0][k] * per, out[1][k] * per),
        slope: out[2][k] * per,
        moment: out[3][k] * per,
    };
    TipChart {
        position: Vec2::new(out[0][0], out[1][0]),
        slope: out[2][0],
        moment: out[3][0],
        by_force: rate(1, 1.0 / FORCE_STEP),
        by_tilt: rate(2, 1.0 / TILT_STEP),
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
