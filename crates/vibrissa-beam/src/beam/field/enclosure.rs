//! Boxes that hold what a box of loads, or a box of readings, may mean.
use super::image::Image;
use super::index::Held;
use super::table::{ENERGY, MOMENT, SLOPE, X, Y, restricted};
use super::tip::{STEEPEST_TILT, TipField};
use crate::sets::Interval;
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, TAU};
#[cfg(not(feature = "std"))]
use num_traits::Float as _;

/// Halvings of a cell along each side when a reading is enclosed.
const HALVINGS: usize = 3;

/// Bounds of a whisker's quantities, the field's errors included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipBox {
    /// First coordinate of the tip (m).
    pub x: Interval,
    /// Second coordinate of the tip (m).
    pub y: Interval,
    /// Slope at the tip (rad).
    pub slope: Interval,
    /// Base moment (N m).
    pub moment: Interval,
    /// Elastic energy (J).
    pub energy: Interval,
}

impl TipBox {
    const EMPTY: Self = Self {
        x: Interval::EMPTY,
        y: Interval::EMPTY,
        slope: Interval::EMPTY,
        moment: Interval::EMPTY,
        energy: Interval::EMPTY,
    };

    fn hull(&self, other: &Self) -> Self {
        Self {
            x: self.x.hull(other.x),
            y: self.y.hull(other.y),
            slope: self.slope.hull(other.slope),
            moment: self.moment.hull(other.moment),
            energy: self.energy.hull(other.energy),
        }
    }

    fn mirrored(&self) -> Self {
        let flip = |i: Interval| Interval::new(-i.hi(), -i.lo());
        Self { y: flip(self.y), slope: flip(self.slope), moment: flip(self.moment), ..*self }
    }
}

impl TipField {
    /// Bounds of all quantities over a box of loads: tilts (rad) and forces (N).
    ///
    /// Holds every equilibrium of the beam with such a load, as far as the field holds the load. `None` when it holds none.
    #[must_use]
    pub fn enclosure(&self, tilts: Interval, forces: Interval) -> Option<TipBox> {
        let positive = Interval::new(if self.mirrored { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY);
        let mut hull = self.over(tilts, forces.intersection(positive));
        if self.mirrored {
            let flip = |i: Interval| Interval::new(-i.hi(), -i.lo());
            hull = hull.hull(&self.over(flip(tilts), flip(forces).intersection(positive)).mirrored());
        }
        (!hull.x.is_empty()).then_some(hull)
    }

    /// Bounds of all quantities for a box of readings: directions of the push (rad, whisker frame) and base moments (N m).
    ///
    /// One box for each group of neighbouring loads that may explain the reading: for each branch, or for branches that meet.
    #[must_use]
    pub fn enclosures_of_reading(&self, directions: Interval, moments: Interval) -> Vec<TipBox> {
        let mut boxes = Vec::new();
        if !(directions.lo().is_finite() && directions.hi().is_finite()) {
            return boxes;
        }
        let flip = |i: Interval| Interval::new(-i.hi(), -i.lo());
        for force in [1.0, -1.0] {
            let mirror = self.mirrored && force < 0.0;
            let shifted = Interval::new(directions.lo() - FRAC_PI_2 * force, directions.hi() - FRAC_PI_2 * force);
            let (turned, moments) = if mirror { (flip(shifted), flip(moments)) } else { (shifted, moments) };
            let (lo, hi) = self.readings.first_range();
            let mut turn = ((lo - turned.hi()) / TAU).ceil();
            while turned.lo() + TAU * turn <= hi {
                let low = [turned.lo() + TAU * turn - self.errors.value.slope, moments.lo() - self.errors.value.moment];
                let high =
                    [turned.hi() + TAU * turn + self.errors.value.slope, moments.hi() + self.errors.value.moment];
                let side = if mirror { 1.0 } else { force };
                let found = self.groups(low, high, side);
                boxes.extend(found.into_iter().map(|b| if mirror { b.mirrored() } else { b }));
                turn += 1.0;
            }
        }
        boxes
    }

    /// The hull over a box of loads in the tabulated half.
    fn over(&self, tilts: Interval, forces: Interval) -> TipBox {
        let mut hull = TipBox::EMPTY;
        if tilts.is_empty() || forces.is_empty() {
            return hull;
        }
        let u = tilts.intersection(Interval::new(-STEEPEST_TILT, STEEPEST_TILT));
        let v = forces.intersection(Interval::new(-self.load.to, self.load.to));
        if u.is_empty() || v.is_empty() {
            return hull;
        }
        for i in self.table.u.cell(u.lo())..=self.table.u.cell(u.hi()) {
            for j in self.table.v.cell(v.lo())..=self.table.v.cell(v.hi()) {
                let share =
                    |knots: &[f64], k: usize, x: f64| ((x - knots[k]) / (knots[k + 1] - knots[k])).clamp(0.0, 1.0);
                let (uk, vk) = (&self.table.u.knots, &self.table.v.knots);
                let s = (share(uk, i, u.lo()), share(uk, i, u.hi()));
                let t = (share(vk, j, v.lo()), share(vk, j, v.hi()));
                hull = hull.hull(&self.bounds(i, j, s, t));
            }
        }
        hull
    }

    /// The bounds over a part of a cell.
    fn bounds(&self, i: usize, j: usize, s: (f64, f64), t: (f64, f64)) -> TipBox {
        let hull = |k: usize, error: f64| {
            let (lo, hi) = range(&restricted(self.table.bernstein(i, j, k), s, t));
            Interval::new(lo - error, hi + error)
        };
        let e = &self.errors.value;
        TipBox {
            x: hull(X, e.position),
            y: hull(Y, e.position),
            slope: hull(SLOPE, e.slope),
            moment: hull(MOMENT, e.moment),
            energy: hull(ENERGY, e.energy),
        }
    }

    /// Boxes for the groups of neighbouring cells whose image may meet `[lo, hi]`.
    fn groups(&self, lo: [f64; 2], hi: [f64; 2], side: f64) -> Vec<TipBox> {
        let mut groups: Vec<(Vec<(usize, usize)>, TipBox)> = Vec::new();
        for cell in self.readings.meeting(lo, hi) {
            if self.table.v.knots[cell.j] + self.table.v.knots[cell.j + 1] < 0.0 && side > 0.0
                || self.table.v.knots[cell.j] + self.table.v.knots[cell.j + 1] > 0.0 && side < 0.0
            {
                continue;
            }
            let Some(here) = self.part_of(cell, lo, hi) else { continue };
            let near = |&(i, j): &(usize, usize)| i.abs_diff(cell.i) <= 1 && j.abs_diff(cell.j) <= 1;
            let (touching, mut rest): (Vec<_>, Vec<_>) =
                groups.into_iter().partition(|(cells, _)| cells.iter().any(near));
            let mut joined = (alloc::vec![(cell.i, cell.j)], here);
            for (cells, hull) in touching {
                joined.0.extend(cells);
                joined.1 = joined.1.hull(&hull);
            }
            rest.push(joined);
            groups = rest;
        }
        groups.into_iter().map(|(_, hull)| hull).collect()
    }

    /// The hull of those parts of a cell whose image may meet `[lo, hi]`.
    fn part_of(&self, cell: &Held, lo: [f64; 2], hi: [f64; 2]) -> Option<TipBox> {
        let nets = Image::Reading.nets(&self.table, cell.i, cell.j);
        let parts = 1 << HALVINGS;
        let mut hull = TipBox::EMPTY;
        for p in 0..parts {
            for q in 0..parts {
                let piece = |k: usize| (k as f64 / f64::from(parts), (k + 1) as f64 / f64::from(parts));
                let (s, t) = (piece(p as usize), piece(q as usize));
                let meets = (0..2).all(|k| {
                    let (low, high) = range(&restricted(nets[k], s, t));
                    // Rounding is a little off.
                    low - 1e-7 * (high - low) <= hi[k] && high + 1e-7 * (high - low) >= lo[k]
                });
                if meets {
                    hull = hull.hull(&self.bounds(cell.i, cell.j, s, t));
                }
            }
        }
        (!hull.x.is_empty()).then_some(hull)
    }
}

fn range(net: &[[f64; 4]; 4]) -> (f64, f64) {
    net.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(*x), hi.max(*x)))
}
