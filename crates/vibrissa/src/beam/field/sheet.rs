//! The contact sheet: every contact of a rod as a table, from all but the base to the tip and to the end of the first mode.
//!
//! Contact sets ask for hundreds of contacts along a curve. The chart is that of the search for them: the contact's place,
//! and `v = asinh(2q)` with the load number `q`, the slope that small-angle theory gives the load, as a share of where the first
//! mode ends. Over it the slope and
//! what is left of place and moment without their units (`x / s_a`, `y / s_a`, `M0` over that of the unit of load) are smooth all
//! the way to the base.

extern crate alloc;
use super::axis::Axis;
use super::chart::Bend;
use super::errors;
use super::panels::Layout;
use super::table::{MOMENT, Node, SLOPE, Table, X, Y};
use crate::beam::rod::Rod;
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Ends of the panels along the whisker, as shares of its length: a base that turns changes everything on a short way.
const BREAKS: [f64; 9] = [0.001, 0.004, 0.016, 0.064, 0.2, 0.4, 0.6, 0.8, 1.0];
/// A panel over which the compliance changes more than this is halved, down to this share of the length.
const MOST_CHANGE: f64 = 16.0;
const NARROWEST: f64 = 0.02;
/// Panels over the load, and cells of a panel along each side.
const PANELS: usize = 8;
const CELLS: [usize; 2] = [8, 12];
/// How often the cells along the whisker are halved at most.
const MOST_REFINED: usize = 1;
/// Loads that are tried for the end of the first mode, on one side.
const TRIED: usize = 48;
/// Largest error of a place, as a share of the length, with which a sheet is of use.
const COARSEST: f64 = 2e-5;
/// Knots along each side of a block, whose range of readings is known.
pub(crate) const BLOCK: usize = 8;
/// What is kept of a knot: slope, x, y and moment.
const KEPT: usize = 4;

/// What a level curve is a curve of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Read {
    /// The slope at the contact.
    Slope,
    /// The moment about the base.
    Moment,
}

/// A cell of the sheet: its number along the whisker and its number along the loads.
pub(crate) type Cell = (usize, usize);

/// One contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    /// Force (N).
    pub(crate) force: f64,
    /// Arc length from the base (m).
    pub(crate) s_a: f64,
    /// Slope at the contact (rad).
    pub(crate) phi_a: f64,
    /// The contact, whisker frame (m).
    pub(crate) contact: Vec2,
    /// Moment about the base (N m).
    pub(crate) moment: f64,
}

/// All first-mode contacts of a rod whose force has one tilt from the normal, by arc length and load.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    /// The rod on a clamped base. An elastic one turns it as a whole, which is done with what is read.
    rod: Rod,
    /// How far the base turns under a unit of moment (rad/(N m)).
    compliance: f64,
    tilt: f64,
    u: Axis,
    /// Along the loads: `v` as a share of where the first mode ends.
    w: Axis,
    /// By kind (value, derivatives by `u`, `w` and both) and quantity, those of one `u` in a row.
    nodes: Vec<[[f64; KEPT]; 4]>,
    /// At each `u` the slope that a unit of force causes in small angles, over the arc length, and its derivative (1/(N m)).
    gains: Vec<[f64; 2]>,
    /// At each `u` where the loads end, in `v`, and the derivative.
    ends: Vec<[f64; 2]>,
    /// Slope (rad) and moment (N m) at the knots.
    readings: [Vec<f64>; 2],
    /// Their ranges over each block of knots.
    blocks: [Vec<[f64; 2]>; 2],
    places: Vec<Vec2>,
    /// Cells with a knot in the first mode, a word for each `u`.
    live: Vec<u128>,
    /// Cells all around which the first mode goes on.
    sure: Vec<u128>,
    /// Compliance and curvature at rest at the base.
    base: [f64; 2],
    /// Bounds on the errors of the four, in their own units, and on that of the gains as a share.
    errors: [f64; KEPT],
    gain_error: f64,
    /// The furthest that two neighbouring knots' places are apart (m).
    reach: f64,
}

impl Sheet {
    /// The sheet of contacts whose force is tilted by `tilt` (rad) from the rod's normal, for load numbers up to `most`.
    ///
    /// `None` for a rod that cannot be tabulated well or whose first mode does not end where its moment says so.
    pub(crate) fn new(rod: &Rod, tilt: f64, most: f64) -> Option<Self> {
        let clamped = rod.clone().with_base_stiffness(f64::INFINITY).ok()?;
        let ends = Ends::new(&clamped, tilt, (2.0 * most).asinh())?;
        let sheet = |refinement| Self::refined(rod, &clamped, tilt, &ends, CELLS[0] << refinement);
        (0..=MOST_REFINED).find_map(sheet)
    }

    /// The sheet with so many cells along each panel; `None` when these are too few, or when moments do not tell its end.
    fn refined(sprung: &Rod, rod: &Rod, tilt: f64, ends: &Ends, cells: usize) -> Option<Self> {
        let length = rod.length();
        let exact = |u: f64, w: f64| {
            let (s, gain) = (u * length, gain(rod, u * length));
            let (contact, slope, moment) = rod.contact_under(force(gain, s, w * ends.at(u)[0]), s, tilt)?;
            Some([slope, contact.x / s, contact.y / s, moment * gain, 0.0])
        };
        let w_breaks = (0..=PANELS).map(|k| 2.0 * k as f64 / PANELS as f64 - 1.0).collect();
        let u_breaks = ends.breaks.clone();
        let layout = Layout { u_breaks, v_breaks: w_breaks, u_cells: cells, v_cells: CELLS[1], bends: [Bend::Same; 2] };
        let samples = layout.sample(exact)?;
        let (u, w, nodes) = layout.knots(&samples);
        let mut sheet = Self {
            rod: rod.clone(),
            tilt,
            compliance: sprung.base_angle(1.0),
            nodes: nodes.iter().map(|node| node.map(|row| [row[SLOPE], row[X], row[Y], row[MOMENT]])).collect(),
            gains: u.knots.iter().map(|u| gain_and_rate(rod, *u)).collect(),
            ends: u.knots.iter().map(|u| ends.at(*u)).collect(),
            readings: [Vec::new(), Vec::new()],
            blocks: [Vec::new(), Vec::new()],
            places: Vec::new(),
            live: Vec::new(),
            sure: Vec::new(),
            errors: [0.0; KEPT],
            gain_error: 0.0,
            reach: 0.0,
            base: [rod.compliance(0.0), rod.rest_curvature(0.0)],
            u,
            w,
        };
        let inside = sheet.knots_in_first_mode();
        let kept: Vec<u128> = inside.iter().map(|word| run(*word, PANELS * CELLS[1] / 2)).collect();
        (sheet.live, sheet.sure) = cells_of(&kept, sheet.w.cells());
        sheet.tell_knots();
        sheet.measure(&layout, &samples, nodes, exact);
        (sheet.position_error() <= COARSEST * length && sheet.ends_by_moment(&inside)).then_some(sheet)
    }

    /// Slope, moment and place at every knot, and how far apart places are.
    fn tell_knots(&mut self) {
        let columns = self.columns();
        for (n, node) in self.nodes.iter().enumerate() {
            let (s, [gain, _]) = (self.u.knots[n / columns] * self.rod.length(), self.gains[n / columns]);
            let [slope, x, y, scaled] = node[0];
            let moment = scaled / gain;
            self.readings[0].push(slope + self.compliance * moment);
            self.readings[1].push(moment);
            self.places.push((s * Vec2::new(x, y)).rotated(self.compliance * moment));
        }
        self.blocks = [0, 1].map(|k| blocks(&self.readings[k], columns));
        let cells = (0..self.u.cells()).flat_map(|i| (0..self.w.cells()).map(move |j| (i, j)));
        let apart = |(i, j): Cell| {
            let corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j), (i, j)].map(|(i, j)| self.place(i, j));
            corners.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f64::max)
        };
        self.reach = cells.filter(|cell| self.is_live(*cell)).map(apart).fold(0.0, f64::max);
    }

    /// The bounds on the errors.
    fn measure(
        &mut self,
        layout: &Layout,
        samples: &super::panels::Samples,
        nodes: Vec<Node>,
        exact: impl Fn(f64, f64) -> Option<super::table::Row>,
    ) {
        let table = Table::new(self.u.clone(), self.w.clone(), nodes);
        let held = |i: usize, j: usize| self.is_live((i, j));
        let bounds = errors::measured(layout, samples, &table, held, exact).value;
        self.errors = [bounds.slope, bounds.position, bounds.position, bounds.moment];
        for i in 0..self.u.cells() {
            for share in [0.211, 0.5, 0.789] {
                let u = self.u.knots[i] + share * self.u.width(i);
                let off = self.gain_in(i, share)[0] / gain(&self.rod, u * self.rod.length()) - 1.0;
                self.gain_error = self.gain_error.max(1.25 * off.abs());
            }
        }
    }

    /// Whether each knot is in the first mode, a word for each `u`.
    fn knots_in_first_mode(&self) -> Vec<u128> {
        let row = |(u, [end, _]): (&f64, &[f64; 2])| {
            let (s, gain) = (u * self.rod.length(), gain(&self.rod, u * self.rod.length()));
            let inside = |w: f64| self.rod.touched(force(gain, s, w * end), s, self.tilt).is_some();
            self.w.knots.iter().enumerate().fold(0, |word, (k, w)| word | u128::from(inside(*w)) << k)
        };
        self.u.knots.iter().zip(&self.ends).map(row).collect()
    }

    /// Whether the moment tells knots `inside` the first mode from those beyond, in all cells that have some of either.
    fn ends_by_moment(&self, inside: &[u128]) -> bool {
        let told = |(i, j): Cell, p: usize, q: usize| {
            let (row, column) = (i + p, j + q);
            let scaled = self.nodes[row * self.columns() + column][0][3];
            let (s, inside) = (self.u.knots[row] * self.rod.length(), inside[row] >> column & 1 == 1);
            let at = |slack: f64| self.in_first_mode(s, self.gains[row][0], self.w.knots[column], scaled, slack);
            at(1e-4) >= inside && at(-1e-4) <= inside
        };
        let cells = (0..self.u.cells()).flat_map(|i| (0..self.w.cells()).map(move |j| (i, j)));
        cells.filter(|cell| self.is_live(*cell)).all(|cell| (0..4).all(|k| told(cell, k / 2, k % 2)))
    }

    /// Whether a contact is in the first mode: moment or curvature have at the base the sign that they have at the contact.
    fn in_first_mode(&self, s: f64, gain: f64, w: f64, scaled_moment: f64, slack: f64) -> bool {
        let moment = scaled_moment / gain;
        let rest = self.rod.rest_curvature(s);
        // The tilt is less than a right angle: the force pushes to its own side.
        let by_moment = w.signum() * scaled_moment >= -slack;
        let bent = moment * self.base[0] + self.base[1];
        // Where the force bends the rod against its rest, only the moment can have one sign.
        let by_bend = rest * w > 0.0 && rest.signum() * bent >= -slack * self.base[0] / gain;
        by_moment || by_bend
    }

    /// Knots along the whisker.
    pub(crate) fn rows(&self) -> usize {
        self.u.knots.len()
    }

    /// Knots along the loads.
    pub(crate) fn columns(&self) -> usize {
        self.w.knots.len()
    }

    /// The readings at all knots, those of one arc length in a row (SI).
    pub(crate) fn readings(&self, read: Read) -> &[f64] {
        &self.readings[usize::from(read == Read::Moment)]
    }

    /// The least and the largest reading of each block of [`BLOCK`] by as many knots, those of one run of rows together.
    pub(crate) fn blocks(&self, read: Read) -> &[[f64; 2]] {
        &self.blocks[usize::from(read == Read::Moment)]
    }

    /// The same place as seen from the cell that holds it, when it is further than `out` shares from its own.
    #[inline]
    pub(crate) fn settled(&self, (i, j): Cell, [a, b]: [f64; 2], out: f64) -> (Cell, [f64; 2]) {
        let inside = |x: f64| (-out..=1.0 + out).contains(&x);
        if inside(a) && inside(b) {
            return ((i, j), [a, b]);
        }
        let u = self.u.place(self.u.knots[i] + a * self.u.width(i));
        let v = self.w.place(self.w.knots[j] + b * self.w.width(j));
        ((u.cell, v.cell), [u.share, v.share])
    }

    /// The contact at a knot, whisker frame (m).
    pub(crate) fn place(&self, row: usize, column: usize) -> Vec2 {
        self.places[row * self.columns() + column]
    }

    /// The cells of one row that hold first-mode contacts, a bit each.
    pub(crate) fn live(&self, row: usize) -> u128 {
        self.live[row]
    }

    fn is_live(&self, (row, column): Cell) -> bool {
        self.live[row] >> column & 1 == 1
    }

    /// Bound on the distance of a spot from the contact with the same force and arc length (m).
    pub(crate) fn position_error(&self) -> f64 {
        // The force belongs to a load number that is known as well as the gain.
        let own = core::f64::consts::SQRT_2 * self.errors[1] + 2.0 * self.gain_error;
        let lever = |(u, [gain, _]): (&f64, &[f64; 2])| u * self.turn_of(*gain);
        (own + self.u.knots.iter().zip(&self.gains).map(lever).fold(0.0, f64::max)) * self.rod.length()
    }

    /// How far the base may be turned wrongly (rad).
    fn turn_of(&self, gain: f64) -> f64 {
        self.compliance * self.errors[3] / gain
    }

    /// How far (m) a level curve may be from where it is traced, when over a cell the reading rises by `rise` (slope in rad, moment by
    /// the unit of load) and the last step of the search was a share `step` of the cell.
    pub(crate) fn level_error(&self, read: Read, value: f64, rise: f64, step: f64, row: usize) -> f64 {
        let off = match read {
            Read::Slope => self.errors[0] + self.turn_of(self.gains[row][0].min(self.gains[row + 1][0])),
            Read::Moment => self.errors[3] + self.gain_error * (value * self.gains[row][0]).abs(),
        };
        // Newton's method leaves the square of its last step, times what the rise changes over a cell. Beyond a cell nothing linear
        // is left.
        self.reach * (off / rise + step * step).min(1.0)
    }

    fn gain_in(&self, row: usize, share: f64) -> [f64; 2] {
        weights(share, self.u.width(row)).map(|w| between(&self.gains, row, w))
    }

    /// How much more than `value` is read at the place with these shares of a cell, and its derivatives by the shares: slopes in rad,
    /// moments by the unit of load.
    #[inline]
    pub(crate) fn excess(&self, read: Read, value: f64, (i, j): Cell, [a, b]: [f64; 2]) -> [f64; 3] {
        let ([wu, ru], [wv, rv]) = (weights(a, self.u.width(i)), weights(b, self.w.width(j)));
        let jet = |k: usize| self.jet(k, (i, j), [wu, ru], [wv, rv]);
        let gain = || [between(&self.gains, i, wu), between(&self.gains, i, ru)];
        match read {
            Read::Moment => {
                let ([moment, by_a, by_b], [gain, rate]) = (jet(3), gain());
                [moment - value * gain, by_a - value * rate, by_b]
            }
            Read::Slope if self.compliance > 0.0 => {
                let ([slope, by_a, by_b], [moment, m_a, m_b], [gain, rate]) = (jet(0), jet(3), gain());
                let turn = self.compliance / gain;
                let turned = turn * moment;
                [slope + turned - value, by_a + turn * m_a - turned * rate / gain, by_b + turn * m_b]
            }
            Read::Slope => {
                let [slope, by_a, by_b] = jet(0);
                [slope - value, by_a, by_b]
            }
        }
    }

    /// One quantity and its derivatives by the shares, from Hermite's weights and their rates.
    #[inline(always)]
    fn jet(&self, k: usize, (i, j): Cell, [wu, ru]: [[f64; 4]; 2], [wv, rv]: [[f64; 4]; 2]) -> [f64; 3] {
        let columns = self.columns();
        let (mut along, mut rates) = ([0.0; 4], [0.0; 4]);
        for q in 0..2 {
            let (near, far) = (&self.nodes[i * columns + j + q], &self.nodes[(i + 1) * columns + j + q]);
            for kind in 0..2 {
                let line = [near[2 * kind][k], near[2 * kind + 1][k], far[2 * kind][k], far[2 * kind + 1][k]];
                along[2 * q + kind] = dot(wu, line);
                rates[2 * q + kind] = dot(ru, line);
            }
        }
        [dot(wv, along), dot(wv, rates), dot(rv, along)]
    }

    /// The contact at the place with these shares of a cell; `None` beyond the first mode.
    #[inline]
    pub(crate) fn spot(&self, (i, j): Cell, [a, b]: [f64; 2]) -> Option<Spot> {
        let ([wu, _], [wv, _]) = (weights(a, self.u.width(i)), weights(b, self.w.width(j)));
        let mut sum = [0.0; KEPT];
        for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let node = &self.nodes[(i + p) * self.columns() + j + q];
            let w = [
                wu[2 * p] * wv[2 * q],
                wu[2 * p + 1] * wv[2 * q],
                wu[2 * p] * wv[2 * q + 1],
                wu[2 * p + 1] * wv[2 * q + 1],
            ];
            for k in 0..KEPT {
                sum[k] += (w[0] * node[0][k] + w[1] * node[1][k]) + (w[2] * node[2][k] + w[3] * node[3][k]);
            }
        }
        let w = self.w.knots[j] + b * self.w.width(j);
        let s_a = (self.u.knots[i] + a * self.u.width(i)) * self.rod.length();
        let gain = between(&self.gains, i, wu);
        let sure = self.sure[i] >> j & 1 == 1;
        if !(sure || self.is_live((i, j)) && self.in_first_mode(s_a, gain, w, sum[3], self.errors[3])) {
            return None;
        }
        let [mut phi_a, x, y, scaled] = sum;
        let (mut contact, moment) = (s_a * Vec2::new(x, y), scaled / gain);
        if self.compliance > 0.0 {
            let turned = self.compliance * moment;
            (phi_a, contact) = (phi_a + turned, contact.rotated(turned));
            if turned.abs() > PI {
                return None;
            }
        }
        Some(Spot { force: force(gain, s_a, w * between(&self.ends, i, wu)), s_a, phi_a, contact, moment })
    }

    /// The contact under `force` (N) at `s_a` (m); `None` beyond the first mode and off the sheet.
    pub(crate) fn contact(&self, force: f64, s_a: f64) -> Option<Spot> {
        let place = self.u.place(s_a / self.rod.length());
        let [at, _] = weights(place.share, place.width);
        let (gain, end) = (between(&self.gains, place.cell, at), between(&self.ends, place.cell, at));
        let load = (2.0 * force * gain * s_a).asinh() / end;
        self.loaded(place.cell, place.share, load).map(|spot| Spot { force, s_a, ..spot })
    }

    /// The contact at `s_a` (m) and at the place `w` along the loads, which go from -1 to 1.
    pub(crate) fn contact_at(&self, s_a: f64, w: f64) -> Option<Spot> {
        let place = self.u.place(s_a / self.rod.length());
        self.loaded(place.cell, place.share, w).map(|spot| Spot { s_a, ..spot })
    }

    fn loaded(&self, row: usize, share: f64, w: f64) -> Option<Spot> {
        let place = self.w.place(w);
        (w.abs() <= 1.0 && (-1e-9..=1.0 + 1e-9).contains(&share))
            .then(|| self.spot((row, place.cell), [share, place.share]))
            .flatten()
    }
}

/// What is kept with its derivative at the knots along the whisker, between two of them.
#[inline(always)]
fn between(line: &[[f64; 2]], row: usize, w: [f64; 4]) -> f64 {
    let [a, b] = [line[row], line[row + 1]];
    dot(w, [a[0], a[1], b[0], b[1]])
}

fn dot(w: [f64; 4], x: [f64; 4]) -> f64 {
    (w[0] * x[0] + w[1] * x[1]) + (w[2] * x[2] + w[3] * x[3])
}

/// Hermite's weights of value and derivative at the start and at the end of a cell, and their rates by the share.
#[inline(always)]
fn weights(a: f64, width: f64) -> [[f64; 4]; 2] {
    let (rest, square) = (1.0 - a, a * a);
    let end = square * (3.0 - 2.0 * a);
    let turn = 6.0 * a * rest;
    [
        [1.0 - end, a * rest * rest * width, end, -square * rest * width],
        [-turn, rest * (1.0 - 3.0 * a) * width, turn, a * (3.0 * a - 2.0) * width],
    ]
}

/// The force (N) at a place along the loads.
fn force(gain: f64, s: f64, v: f64) -> f64 {
    // The difference of the two exponentials is known to one unit in the last place of one, which is what a load counts by.
    let grown = v.exp();
    0.25 * (grown - 1.0 / grown) / (gain * s)
}

fn gain(rod: &Rod, s: f64) -> f64 {
    rod.slope_compliance(s) / s
}

/// The gain at a share of the length, and its derivative by that share.
fn gain_and_rate(rod: &Rod, u: f64) -> [f64; 2] {
    // Smooth but for jumps of the second derivative at joints: before these and at the tip from one side.
    let (length, h) = (rod.length(), 2e-3 * u);
    let at = |k: f64| gain(rod, (u + k * h) * length);
    let mut joints = rod.joints().map(|s| s / length);
    let beyond = u + 2.0 * h > 1.0 || joints.any(|joint| joint >= u - 1e-9 && joint < u + 2.0 * h);
    let rate = if beyond {
        (25.0 * at(0.0) - 48.0 * at(-1.0) + 36.0 * at(-2.0) - 16.0 * at(-3.0) + 3.0 * at(-4.0)) / (12.0 * h)
    } else {
        (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h)
    };
    [at(0.0), rate]
}

/// Where along the loads a sheet ends, by the place: a cubic over each panel, once continuously differentiable.
struct Ends {
    breaks: Vec<f64>,
    values: Vec<f64>,
}

impl Ends {
    /// The panels, broken at joints and where the rod becomes thin, with ends as far as there are first-mode shapes from rest on.
    fn new(rod: &Rod, tilt: f64, most: f64) -> Option<Self> {
        let (length, step) = (rod.length(), most / TRIED as f64);
        let last = |u: f64| {
            let (s, gain) = (u * length, gain(rod, u * length));
            let inside = |v: f64| rod.touched(force(gain, s, v), s, tilt).is_some();
            let side = |sign: f64| (1..=TRIED).take_while(|k| inside(sign * *k as f64 * step)).last().unwrap_or(0);
            // Where the step was too long, one more holds it.
            (side(1.0).max(side(-1.0)) + 1) as f64 * step
        };
        let breaks = panels(rod);
        let mut ends = Self { values: breaks.iter().map(|u| last(*u)).collect(), breaks };
        for _ in 0..3 {
            for k in 0..ends.values.len() - 1 {
                for share in [0.25, 0.5, 0.75] {
                    let u = ends.breaks[k] + share * (ends.breaks[k + 1] - ends.breaks[k]);
                    let missing = (last(u) - ends.at(u)[0]).max(0.0);
                    ends.values[k] += missing;
                    ends.values[k + 1] += missing;
                }
            }
        }
        ends.values.iter().all(|v| v.is_finite() && *v > step).then_some(ends)
    }

    /// The end and its derivative by `u`. Between breaks it neither rises beyond both nor falls below.
    fn at(&self, u: f64) -> [f64; 2] {
        let k = self.breaks.partition_point(|b| *b <= u).clamp(1, self.breaks.len() - 1) - 1;
        let width = self.breaks[k + 1] - self.breaks[k];
        let nodes = [k, k + 1].map(|k| [self.values[k], self.slope(k)]);
        let [value, rate] = weights((u - self.breaks[k]) / width, width).map(|w| between(&nodes, 0, w));
        [value, rate / width]
    }

    /// The slope at a break: none at the ends and where the values turn, else the harmonic mean of both sides'.
    fn slope(&self, k: usize) -> f64 {
        if k == 0 || k + 1 == self.breaks.len() {
            return 0.0;
        }
        let side = |k: usize| (self.values[k + 1] - self.values[k]) / (self.breaks[k + 1] - self.breaks[k]);
        let (a, b) = (side(k - 1), side(k));
        if a * b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 }
    }
}

/// The ends of the panels along a rod, as shares of its length.
fn panels(rod: &Rod) -> Vec<f64> {
    let length = rod.length();
    let mut breaks = BREAKS.to_vec();
    for joint in rod.joints().map(|s| s / length).filter(|u| *u > BREAKS[0] && *u < 1.0) {
        breaks.retain(|u| *u <= BREAKS[0] || *u >= 1.0 || (u - joint).abs() > NARROWEST);
        breaks.push(joint);
    }
    breaks.sort_by(f64::total_cmp);
    let mut i = 0;
    while i + 1 < breaks.len() {
        let (a, b) = (breaks[i], breaks[i + 1]);
        let inside = [a + 1e-6 * (b - a), b - 1e-6 * (b - a)].map(|u| rod.compliance(u * length));
        if inside[1] > MOST_CHANGE * inside[0] && b - a > NARROWEST {
            breaks.insert(i + 1, 0.5 * (a + b));
        } else {
            i += 1;
        }
    }
    breaks
}

/// The range of the readings of each block of knots.
fn blocks(readings: &[f64], columns: usize) -> Vec<[f64; 2]> {
    let mut ranges = Vec::new();
    for rows in readings.chunks(BLOCK * columns) {
        for column in (0..columns).step_by(BLOCK) {
            let of_row = |row: &[f64]| row[column..(column + BLOCK).min(columns)].to_vec();
            let range = rows.chunks(columns).flat_map(of_row);
            ranges.push(range.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)]));
        }
    }
    ranges
}

/// The bits of a word that are set without a gap from `middle` on.
fn run(word: u128, middle: usize) -> u128 {
    let (mut below, mut above) = (middle, middle);
    let is_set = |k: usize| word >> k & 1 == 1;
    while below > 0 && is_set(below - 1) {
        below -= 1;
    }
    while above + 1 < 128 && is_set(above + 1) {
        above += 1;
    }
    (below..=above).filter(|k| is_set(*k)).fold(0, |bits, k| bits | 1 << k)
}

/// The cells that have a knot in the first mode, and those of which all knots and all neighbours' knots are.
fn cells_of(kept: &[u128], cells: usize) -> (Vec<u128>, Vec<u128>) {
    let most = (1u128 << cells) - 1;
    let live = |pair: &[u128]| {
        let any = pair[0] | pair[1];
        (any | any >> 1) & most
    };
    let all = |i: usize| {
        let rows = &kept[i.saturating_sub(1)..(i + 3).min(kept.len())];
        let row = rows.iter().fold(u128::MAX, |all, word| all & word);
        row & row << 1 & row >> 1 & row >> 2 & most
    };
    (kept.windows(2).map(live).collect(), (0..kept.len().saturating_sub(1)).map(all).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;
    use crate::beam::rod::Segment;
    use crate::beam::whisker::Whisker;

    fn rods() -> Vec<(Rod, f64)> {
        let plain = Whisker::default();
        let rod = |whisker: Whisker| Rod::new(&whisker).unwrap();
        let wire = |length: f64, second_moment: f64| Segment { length, young_modulus: 52e9, second_moment };
        vec![
            (rod(plain), 0.3),
            (rod(Whisker { tip_ratio: 0.4, base_stiffness: 0.3, ..plain }), 0.0),
            (rod(Whisker { tip_ratio: 0.05, ..plain }), 0.0),
            (rod(Whisker { curvature: -8.0, base_stiffness: 0.02, ..plain }), 0.0),
            (Rod::from_segments(&[wire(0.03, 9e-15), wire(0.04, 2e-15)]).unwrap(), 0.0),
        ]
    }

    /// Every contact that the march finds in the first mode is on the sheet, within what the sheet says of its error.
    #[test]
    fn a_sheet_holds_the_contacts_of_the_march() {
        let mut state = 5u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for (rod, tilt) in rods() {
            let sheet = Sheet::new(&rod, tilt, 80.0).unwrap();
            let bound = sheet.position_error();
            let (mut inside, mut lost) = (0, 0);
            for _ in 0..1500 {
                let s = rod.length() * (0.001 + 0.999 * unit() * unit());
                let force = (if unit() < 0.5 { -8.0 } else { 8.0 }) * unit() * rod.unit_force(s);
                let (want, got) = (rod.touched(force, s, tilt), sheet.contact(force, s));
                let Some(want) = want else { continue };
                inside += 1;
                let Some(got) = got else {
                    lost += 1;
                    continue;
                };
                let off = got.contact.distance(want.contact);
                assert!(off <= bound, "{off:e} beyond {bound:e} at {s} {force} of {rod:?}");
                assert!(
                    (got.phi_a - want.phi_a).abs() < 2e-3 && (got.moment - want.moment).abs() * sheet.gains[0][0] < 1.0
                );
            }
            // At the very end of the first mode rounding decides.
            assert!(inside > 800 && lost * 200 <= inside, "{lost} of {inside}: {rod:?}");
        }
    }
}
