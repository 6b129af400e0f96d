//! The contact sheet: every contact of a rod as a table, from all but the base to the tip and to the end of the first mode.
//!
//! Contact sets ask for hundreds of contacts along a curve. The chart: the contact's place, and `v = asinh(2q)` with the load
//! number `q`, the slope that small-angle theory gives the load, as a share of where the first mode ends. Over it the slope
//! and what is left of place and moment without their units (`x / s_a`, `y / s_a`, `M0` over that of the unit of load) are
//! smooth all the way to the base.

extern crate alloc;
use super::axis::Axis;
use super::ends::{between, dot, force, weights};
use crate::beam::rod::Rod;
use crate::plane::Vec2;
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Knots along each side of a block, whose range of readings is known.
pub(crate) const BLOCK: usize = 8;
/// What is kept of a knot: slope, x, y and moment.
pub(super) const KEPT: usize = 4;

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
    pub(super) rod: Rod,
    /// How far the base turns under a unit of moment (rad/(N m)).
    pub(super) compliance: f64,
    pub(super) tilt: f64,
    pub(super) u: Axis,
    /// Along the loads: `v` as a share of where the first mode ends.
    pub(super) w: Axis,
    /// By kind (value, derivatives by `u`, `w` and both) and quantity, those of one `u` in a row.
    pub(super) nodes: Vec<[[f64; KEPT]; 4]>,
    /// At each `u` the slope that a unit of force causes in small angles, over the arc length, and its derivative (1/(N m)).
    pub(super) gains: Vec<[f64; 2]>,
    /// At each `u` where the loads end, in `v`, and the derivative.
    pub(super) ends: Vec<[f64; 2]>,
    /// Slope (rad) and moment (N m) at the knots.
    pub(super) readings: [Vec<f64>; 2],
    /// Their ranges over each block of knots.
    pub(super) blocks: [Vec<[f64; 2]>; 2],
    pub(super) places: Vec<Vec2>,
    /// Cells with a knot in the first mode, a word for each `u`.
    pub(super) live: Vec<u128>,
    /// Cells all around which the first mode goes on.
    pub(super) sure: Vec<u128>,
    /// Compliance and curvature at rest at the base.
    pub(super) base: [f64; 2],
    /// Bounds on the errors of the four, in their own units, and on that of the gains as a share.
    pub(super) errors: [f64; KEPT],
    pub(super) gain_error: f64,
    /// The furthest that two neighbouring knots' places are apart (m).
    pub(super) reach: f64,
}

impl Sheet {
    /// Whether a contact is in the first mode: moment or curvature have at the base the sign that they have at the contact.
    pub(super) fn in_first_mode(&self, s: f64, gain: f64, w: f64, scaled_moment: f64, slack: f64) -> bool {
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

    pub(super) fn is_live(&self, (row, column): Cell) -> bool {
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

    pub(super) fn gain_in(&self, row: usize, share: f64) -> [f64; 2] {
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
    pub(crate) fn spot(&self, cell: Cell, at: [f64; 2]) -> Option<Spot> {
        let ([wu, _], w) = (weights(at[0], self.u.width(cell.0)), self.w.knots[cell.1] + at[1] * self.w.width(cell.1));
        let s_a = (self.u.knots[cell.0] + at[0] * self.u.width(cell.0)) * self.rod.length();
        let (gain, end) = (between(&self.gains, cell.0, wu), between(&self.ends, cell.0, wu));
        self.spot_under(force(gain, s_a, w * end), cell, at)
    }

    /// As [`Sheet::spot`], the force there known.
    #[inline]
    fn spot_under(&self, force: f64, (i, j): Cell, [a, b]: [f64; 2]) -> Option<Spot> {
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
        Some(Spot { force, s_a, phi_a, contact, moment })
    }

    /// The contact under `force` (N) at `s_a` (m); `None` beyond the first mode and off the sheet.
    pub(crate) fn contact(&self, force: f64, s_a: f64) -> Option<Spot> {
        let place = self.u.place(s_a / self.rod.length());
        let [at, _] = weights(place.share, place.width);
        let (gain, end) = (between(&self.gains, place.cell, at), between(&self.ends, place.cell, at));
        let doubled = 2.0 * (force * gain * s_a).abs();
        // The inverse of the hyperbolic sine, as well as a place on the chart needs it.
        let load = (doubled + (1.0 + doubled * doubled).sqrt()).ln().copysign(force) / end;
        let column = self.w.place(load);
        let inside = load.abs() <= 1.0 && (-1e-9..=1.0 + 1e-9).contains(&place.share);
        let spot = inside.then(|| self.spot_under(force, (place.cell, column.cell), [place.share, column.share]))?;
        spot.map(|spot| Spot { s_a, ..spot })
    }

    /// The contact at `s_a` (m) and at the place `w` along the loads, which go from -1 to 1.
    pub(crate) fn contact_at(&self, s_a: f64, w: f64) -> Option<Spot> {
        let (place, column) = (self.u.place(s_a / self.rod.length()), self.w.place(w));
        let inside = w.abs() <= 1.0 && (-1e-9..=1.0 + 1e-9).contains(&place.share);
        let spot = inside.then(|| self.spot((place.cell, column.cell), [place.share, column.share]))?;
        spot.map(|spot| Spot { s_a, ..spot })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

    use super::*;
    use crate::beam::rod::Segment;
    use crate::beam::whisker::Whisker;
    use alloc::vec;

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
                let want = rod.touched(force, s, tilt).filter(|_| rod.keeps_one_sign(force, s, tilt));
                let got = sheet.contact(force, s);
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
