//! Every way in which one wall can bend a whisker, tabulated once, with bounds on what lies between the nodes.
//!
//! A wall of normal direction `psi` (whisker frame) that is pressed against a uniform whisker first holds its tip, then
//! its side. With `u` the slope at the contact, tip contacts are the pairs `(psi, u)` with
//! `max(0, 2 (psi - pi)) <= u <= psi - pi/2`: at the upper end the force is normal to the whisker, at the lower end the
//! whisker is straight, or its base moment vanishes. Beyond the upper end the contact moves along the side, where
//! `u = psi - pi/2` and the moment names the arc length. So `(psi, share of the range of u)` is one smooth sheet of tip
//! contacts without folds, and `psi` alone names all side contacts up to scale. With friction the force leaves the
//! normal by up to the friction angle, which widens both.
//!
//! All is dimensionless: lengths over the whisker's, moments times length over flexural rigidity. Bending towards +y;
//! the other side is the mirror image. Equilibria with an inflection between base and contact are not in here, as
//! nowhere in [`crate::beam`].

mod slice;

pub use slice::{PressEntry, PressSlice, Span};

use super::pendulum::{Pendulum, Tilt};
use crate::plane::Vec2;
use core::f64::consts::{FRAC_PI_2, PI};

/// The deviation measured between the nodes is multiplied by this to bound it: twice what a smooth sheet needs.
const SAFETY: f64 = 3.0;
/// What rounding may add to a bound.
const ROUNDING: f64 = 1e-9;

/// A tip contact: moment and tip.
#[derive(Clone, Copy, Debug)]
struct Node {
    moment: f64,
    tip: Vec2,
}

/// How far a sheet leaves its bilinear interpolation within one cell.
#[derive(Clone, Copy, Debug)]
struct Gap {
    moment: f64,
    tip: f64,
}

/// The side contacts for one direction of the wall: at the arc length `reach / mu` the contact is `scaled / mu`.
#[derive(Clone, Copy, Debug)]
struct Side {
    reach: f64,
    scaled: Vec2,
}

/// The side contacts of one column over their arc length: `center + along (psi - middle)` up to `gap`; smooth where the
/// moment vanishes, too.
#[derive(Clone, Copy, Debug)]
struct Outline {
    center: Vec2,
    along: Vec2,
    gap: f64,
}

/// One whisker's contacts with walls of every direction.
#[derive(Clone, Debug)]
pub struct PressTable {
    /// Friction angle (rad).
    slack: f64,
    /// Largest slope (rad).
    steepest: f64,
    /// Columns of the table: directions (rad).
    directions: Vec<f64>,
    /// The direction in the middle of each column, as a vector.
    middles: Vec<Vec2>,
    rows: usize,
    nodes: Vec<Node>,
    gaps: Vec<Gap>,
    /// Least and largest moment of each cell.
    ranges: Vec<(f64, f64)>,
    sides: Vec<Side>,
    side_gaps: Vec<Gap>,
    /// The largest deviation of a side contact by friction, for each column.
    side_slack: Vec<Gap>,
    outlines: Vec<Outline>,
}

impl PressTable {
    /// The table with `columns` directions for each quarter turn and `rows` steps of bending, for walls with this
    /// friction angle (rad, below 1) and contacts with slopes up to `steepest` (rad, up to pi).
    #[must_use]
    pub fn new(columns: usize, rows: usize, friction_angle: f64, steepest: f64) -> Self {
        let (slack, steepest) = (friction_angle.clamp(0.0, 1.0), steepest.clamp(0.1, PI));
        let step = (FRAC_PI_2 + slack) / columns as f64;
        // The half turn, where the sheet has an edge, is a column; beyond it the slope is twice the turn at least.
        let beyond = (0.5 * steepest / step).ceil().max((steepest - FRAC_PI_2) / step).ceil() as usize;
        let all = columns + beyond;
        let directions: Vec<f64> = (0..=all).map(|i| PI + (i as f64 - columns as f64) * step).collect();
        // The moment grows like the root of the slope where it starts from nothing.
        let share = |row: f64| (row / rows as f64).powi(2);
        let mut table = Self {
            slack,
            steepest,
            rows,
            nodes: Vec::with_capacity(directions.len() * (rows + 1)),
            gaps: Vec::with_capacity(all * rows),
            ranges: Vec::with_capacity(all * rows),
            sides: directions.iter().map(|&d| side(d, 0.0)).collect(),
            side_gaps: Vec::new(),
            side_slack: directions.iter().map(|&d| side_slack(d, slack)).collect(),
            outlines: directions.windows(2).map(|d| outline(d[0], d[1], slack)).collect(),
            middles: directions.windows(2).map(|d| Vec2::from_angle(0.5 * (d[0] + d[1]))).collect(),
            directions,
        };
        for &direction in &table.directions {
            table.nodes.extend((0..=rows).map(|row| tip(direction, share(row as f64), slack, steepest)));
        }
        for column in 0..all {
            let middle = 0.5 * (table.directions[column] + table.directions[column + 1]);
            for row in 0..rows {
                let gap = table.measure(column, row, middle, &share);
                table.gaps.push(gap);
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(c, r)| table.node(column + c, row + r).moment);
                let (least, most) = corners.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &m| (a.min(m), b.max(m)));
                table.ranges.push((least - gap.moment, most + gap.moment));
            }
            let at = side(middle, 0.0);
            let (a, b) = (table.sides[column], table.sides[column + 1]);
            table.side_gaps.push(Gap {
                moment: SAFETY * (at.reach - 0.5 * (a.reach + b.reach)).abs() + ROUNDING,
                tip: SAFETY * (at.scaled - (a.scaled + b.scaled) * 0.5).norm() + ROUNDING,
            });
        }
        table
    }

    /// The friction angle (rad).
    #[must_use]
    pub fn friction_angle(&self) -> f64 {
        self.slack
    }

    fn node(&self, column: usize, row: usize) -> Node {
        self.nodes[column * (self.rows + 1) + row]
    }

    /// The gap of one cell, from the sheet at the cell's middle and at the middles of its edges.
    fn measure(&self, column: usize, row: usize, middle: f64, share: &impl Fn(f64) -> f64) -> Gap {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(c, r)| self.node(column + c, row + r));
        let (left, right) = (self.directions[column], self.directions[column + 1]);
        let (low, half, high) = (share(row as f64), share(row as f64 + 0.5), share(row as f64 + 1.0));
        let probes = [
            (middle, half, [0.25; 4]),
            (middle, low, [0.5, 0.5, 0.0, 0.0]),
            (middle, high, [0.0, 0.0, 0.5, 0.5]),
            (left, half, [0.5, 0.0, 0.5, 0.0]),
            (right, half, [0.0, 0.5, 0.0, 0.5]),
        ];
        let mut gap = Gap { moment: 0.0, tip: 0.0 };
        for (direction, share, weights) in probes {
            let at = tip(direction, share, self.slack, self.steepest);
            let moment: f64 = corners.iter().zip(weights).map(|(n, w)| w * n.moment).sum();
            let place = corners.iter().zip(weights).fold(Vec2::ZERO, |sum, (n, w)| sum + n.tip * w);
            gap.moment = gap.moment.max((at.moment - moment).abs());
            gap.tip = gap.tip.max(at.tip.distance(place));
        }
        Gap { moment: SAFETY * gap.moment + ROUNDING, tip: SAFETY * gap.tip + ROUNDING }
    }
}

/// The tip contact with the force in `direction` (rad), at this share of the range of slopes.
fn tip(direction: f64, share: f64, slack: f64, steepest: f64) -> Node {
    let least = (2.0 * (direction - PI)).max(0.0);
    let most = (direction - FRAC_PI_2 + slack).min(steepest).max(least);
    let u = least + share * (most - least);
    swing(direction - FRAC_PI_2 - u, u)
}

/// The tip contact with the tilt `beta` and the slope `u`; the straight whisker where that is no load at all.
fn swing(beta: f64, u: f64) -> Node {
    const STRAIGHT: Node = Node { moment: 0.0, tip: Vec2::new(1.0, 0.0) };
    let beta = beta.clamp(-FRAC_PI_2, FRAC_PI_2);
    let u = u.min(PI - 2.0 * beta);
    if u < 1e-12 {
        return STRAIGHT;
    }
    let pendulum = Pendulum::new(Tilt::from_gap(beta + FRAC_PI_2));
    let at = pendulum.at(pendulum.time_of(u).min(pendulum.half_period()));
    let (x, y) = at.contact();
    if at.t > 0.0 { Node { moment: at.t * at.du, tip: Vec2::new(x / at.t, y / at.t) } } else { STRAIGHT }
}

/// The side contacts where the whisker's normal at the contact has this direction, and the force is tilted by `beta`.
fn side(direction: f64, beta: f64) -> Side {
    let u = (direction - FRAC_PI_2).clamp(0.0, PI);
    let Node { moment, tip } = swing(beta, u);
    Side { reach: moment, scaled: tip * moment }
}

fn outline(left: f64, right: f64, slack: f64) -> Outline {
    let shape = |direction: f64, beta: f64| swing(beta, (direction - FRAC_PI_2).clamp(0.0, PI)).tip;
    let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
    let (a, b) = (shape(left, 0.0), shape(right, 0.0));
    let (center, along) = ((a + b) * 0.5, (b - a) * (0.5 / half));
    let off = [left, middle, right].into_iter().flat_map(|d| [-1.0, -0.5, 0.0, 0.5, 1.0].map(|s| (d, s * slack)));
    let gap = off.map(|(d, beta)| (shape(d, beta) - center - along * (d - middle)).norm()).fold(0.0, f64::max);
    Outline { center, along, gap: SAFETY * gap }
}

fn side_slack(direction: f64, slack: f64) -> Gap {
    let mut gap = Gap { moment: 0.0, tip: 0.0 };
    if slack > 0.0 {
        let middle = side(direction, 0.0);
        for share in [-1.0, -0.5, 0.5, 1.0] {
            let at = side(direction, share * slack);
            gap.moment = gap.moment.max((at.reach - middle.reach).abs());
            gap.tip = gap.tip.max(at.scaled.distance(middle.scaled));
        }
        gap = Gap { moment: 1.2 * gap.moment, tip: 1.2 * gap.tip };
    }
    gap
}
