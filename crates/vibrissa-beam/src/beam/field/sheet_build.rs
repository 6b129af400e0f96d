//! How a contact sheet is made of a rod, and how far it is from it.
use super::bicubic::{Bicubics, coefficients, powers};
use super::chart::BendKind;
use super::ends::{LoadEnd, force, gain, gain_and_rate};
use super::errors;
use super::panels::{Layout, Samples};
use super::sheet::{BLOCK, ContactSheet, KEPT, SheetCell};
use super::table::{MOMENT, Row, SLOPE, Table, TableNode, X, Y};
use crate::beam::pair::Pair;
use crate::beam::rod::Rod;
use crate::math;
use crate::plane::Vec2;
use crate::platform::vector_level;
use alloc::vec::Vec;

/// Panels over the load, and cells of a panel along each side.
const PANELS: usize = 8;
const CELLS: [usize; 2] = [8, 12];
/// How often the cells along the whisker are halved at most.
const MOST_REFINED: usize = 1;
/// Largest error of a place, as a share of the length, with which a sheet is of use.
const COARSEST: f64 = 2e-5;

impl ContactSheet {
    /// The sheet of contacts whose force is tilted by `tilt` (rad) from the rod's normal, for load numbers up to `most`.
    ///
    /// `None` for a rod that cannot be tabulated well or whose first mode does not end where its moment says so.
    #[must_use]
    pub fn new(rod: &Rod, tilt: f64, most: f64) -> Option<Self> {
        let clamped = rod.clone().with_base_stiffness(f64::INFINITY).ok()?;
        let ends = LoadEnd::new(&clamped, tilt, math::asinh(2.0 * most))?;
        let sheet = |refinement| Self::refined(rod, &clamped, tilt, &ends, CELLS[0] << refinement);
        (0..=MOST_REFINED).find_map(sheet)
    }

    /// The sheet with so many cells along each panel; `None` when these are too few, or when moments do not tell its end.
    fn refined(sprung: &Rod, rod: &Rod, tilt: f64, ends: &LoadEnd, cells: usize) -> Option<Self> {
        let length = rod.length();
        let exact = |u: f64, w: f64| {
            let (s, gain) = (u * length, gain(rod, u * length));
            let (contact, slope, moment) = rod.contact_under(force(gain, s, w * ends.at(u)[0]), s, tilt)?;
            Some([slope, contact.x / s, contact.y / s, moment * gain, 0.0])
        };
        let w_breaks = (0..=PANELS).map(|k| 2.0 * k as f64 / PANELS as f64 - 1.0).collect();
        let u_breaks = ends.breaks.clone();
        let layout =
            Layout { u_breaks, v_breaks: w_breaks, u_cells: cells, v_cells: CELLS[1], bends: [BendKind::Same; 2] };
        let samples = layout.sample(exact)?;
        let (u, w, nodes) = layout.knots(&samples);
        let mut sheet = Self {
            rod: rod.clone(),
            tilt,
            compliance: sprung.base_angle(1.0),
            nodes: nodes.iter().map(|node| node.map(|row| [row[SLOPE], row[X], row[Y], row[MOMENT]])).collect(),
            gains: u.knots.iter().map(|u| gain_and_rate(rod, *u)).collect(),
            ends: u.knots.iter().map(|u| ends.at(*u)).collect(),
            patches: Vec::new(),
            level: vector_level(),
            lines: Vec::new(),
            readings: [Vec::new(), Vec::new()],
            blocks: [Vec::new(), Vec::new()],
            places: Vec::new(),
            live: Vec::new(),
            sure: Vec::new(),
            errors: [0.0; KEPT],
            gain_error: 0.0,
            reach: 0.0,
            per_length: 1.0 / length,
            base: [rod.compliance(0.0), rod.rest_curvature(0.0)],
            u,
            w,
        };
        let inside = sheet.knots_in_first_mode();
        let kept: Vec<u128> = inside.iter().map(|word| run(*word, PANELS * CELLS[1] / 2)).collect();
        (sheet.live, sheet.sure) = cells_of(&kept, sheet.w.cells());
        sheet.tell_knots();
        sheet.tell_cells();
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
        let apart = |(i, j): SheetCell| {
            let corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j), (i, j)].map(|(i, j)| self.place(i, j));
            corners.windows(2).map(|w| w[0].distance(w[1])).fold(0.0, f64::max)
        };
        self.reach = cells.filter(|cell| self.is_live(*cell)).map(apart).fold(0.0, f64::max);
    }

    /// The polynomials between knots.
    fn tell_cells(&mut self) {
        let (columns, cells) = (self.columns(), self.w.cells());
        for i in 0..self.u.cells() {
            let h = self.u.width(i);
            let line =
                |knots: &[[f64; 2]]| powers([knots[i][0], knots[i][1] * h, knots[i + 1][0], knots[i + 1][1] * h]);
            let (gain, end) = (line(&self.gains), line(&self.ends));
            self.lines.push([0, 1, 2, 3].map(|k| Pair::new(gain[k], end[k])));
            for j in 0..cells {
                let at = |p: usize, q: usize, k: usize| self.nodes[(i + p) * columns + j + q].map(|row| row[k]);
                let of =
                    |k: usize| coefficients([at(0, 0, k), at(0, 1, k), at(1, 0, k), at(1, 1, k)], (h, self.w.width(j)));
                self.patches.push(Bicubics::new([0, 3, 1, 2].map(of)));
            }
        }
    }

    /// The bounds on the errors.
    fn measure(
        &mut self,
        layout: &Layout,
        samples: &Samples,
        nodes: Vec<TableNode>,
        exact: impl Fn(f64, f64) -> Option<Row>,
    ) {
        let table = Table::new(self.u.clone(), self.w.clone(), nodes);
        let held = |i: usize, j: usize| self.is_live((i, j));
        let bounds = errors::measured(layout, samples, &table, held, exact).value;
        self.errors = [bounds.slope, bounds.position, bounds.position, bounds.moment];
        for i in 0..self.u.cells() {
            for share in [0.211, 0.5, 0.789] {
                let u = self.u.knots[i] + share * self.u.width(i);
                let off = self.gain_in(i, share) / gain(&self.rod, u * self.rod.length()) - 1.0;
                self.gain_error = self.gain_error.max(1.25 * off.abs());
            }
        }
    }

    /// Whether each knot is in the first mode, a word for each `u`.
    fn knots_in_first_mode(&self) -> Vec<u128> {
        let row = |(u, [end, _]): (&f64, &[f64; 2])| {
            let (s, gain) = (u * self.rod.length(), gain(&self.rod, u * self.rod.length()));
            let inside = |w: f64| self.rod.keeps_one_sign(force(gain, s, w * end), s, self.tilt);
            self.w.knots.iter().enumerate().fold(0, |word, (k, w)| word | u128::from(inside(*w)) << k)
        };
        self.u.knots.iter().zip(&self.ends).map(row).collect()
    }

    /// Whether the moment tells knots `inside` the first mode from those beyond, in all cells that have some of either.
    fn ends_by_moment(&self, inside: &[u128]) -> bool {
        let told = |(i, j): SheetCell, p: usize, q: usize| {
            let (row, column) = (i + p, j + q);
            let scaled = self.nodes[row * self.columns() + column][0][3];
            let (s, inside) = (self.u.knots[row] * self.rod.length(), inside[row] >> column & 1 == 1);
            let margin = self.in_first_mode(s, self.gains[row][0], self.w.knots[column], scaled);
            (margin >= -1e-4) >= inside && (margin >= 1e-4) <= inside
        };
        let cells = (0..self.u.cells()).flat_map(|i| (0..self.w.cells()).map(move |j| (i, j)));
        cells.filter(|cell| self.is_live(*cell)).all(|cell| (0..4).all(|k| told(cell, k / 2, k % 2)))
    }
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
